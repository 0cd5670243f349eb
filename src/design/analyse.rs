//! `planesman design analyse`: poles, margins and step response of the loop at each speed.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::Args;
use depth_controller::design::dive_loop::Judgement;
use depth_controller::design::step;
use depth_controller::gains::LoopGains;
use maud::html;
use planesman_linear::{Complex, StepMetrics, unwrapped_phases};
use planesman_plot::{Plot, Style};

use super::subject::{GainArgs, Subject, gains_text, poles_text, speed_text};
use crate::arguments::{output_file, speed, within};
use crate::page::{document, figures};
use crate::sink::write_text;
use crate::table::print_wrapped;

/// The loop, the speeds and the observation time.
#[derive(Args)]
#[command(allow_negative_numbers = true, next_help_heading = "Analysis")]
pub struct AnalyseArgs {
    #[command(flatten)]
    subject: Subject,
    #[command(flatten)]
    gains: GainArgs,
    /// Speeds through the water (m/s, or with their unit: 1ft/s), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.3048", value_parser = speed(1e-3, 100.0))]
    speed: Vec<f64>,
    /// Duration of the step response (s)
    #[arg(long, default_value_t = 120.0, value_parser = within(1.0, 1e4))]
    duration: f64,
    /// Also draw frequency response, poles and depth step on an HTML page
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
}

/// Frequencies drawn: so many, and between which, rad/s.
const FREQUENCIES: u32 = 300;
const DECADES: (f64, f64) = (-3.0, 1.5);
/// Samples of a step that is drawn.
const SAMPLES: f64 = 1000.0;

/// Prints the analysis, and draws where that is asked for.
///
/// # Errors
/// A vehicle or actuator that is refused, numbers that overflow, a page that cannot be written.
pub fn run(args: &AnalyseArgs) -> Result<()> {
    print_wrapped(text(args)?)?;
    if let Some(file) = &args.html {
        write_text(file, page(args)?)?;
        planesman_node::say!("{}", file.display())?;
    }
    Ok(())
}

fn page(args: &AnalyseArgs) -> Result<String> {
    let gains = args.gains.gains();
    let title = format!(
        "Dive loop of {} behind {}",
        args.subject.vehicle, args.subject.actuator
    );
    let mut verdicts = Vec::new();
    let open = [LOOP_MAGNITUDE, LOOP_PHASE].map(|[title, y]| {
        Plot::new(title, ["frequency [rad/s]", y])
            .log_x()
            .linked("frequency")
    });
    let [mut magnitude, mut phase] = open;
    magnitude = magnitude.note("Broken at the planes.");
    phase = phase
        .note("The phase margin is its distance from -180 degrees where the magnitude is 0 dB.");
    let mut poles = Plot::new("Poles", ["real part [1/s]", "imaginary part [rad/s]"])
        .note("Of the closed loop. Those far to the left, of a dead time, are left out.")
        .from_zero()
        .one_scale();
    let mut step = Plot::new("Depth step", ["time [s]", "depth over setpoint"])
        .note("After a unit step of the setpoint.");
    for speed in &args.speed {
        let name = speed_text(*speed);
        let dive_loop = args.subject.dive_loop(gains, *speed)?;
        let judged = judged(&args.subject, gains, *speed, args.duration)?;
        verdicts.push(format!("{name}: {}", stability(&judged)));
        let open = dive_loop.open_loop()?;
        let (from, to) = DECADES;
        let share = |i: u32| f64::from(i) / f64::from(FREQUENCIES - 1);
        let omegas = (0..FREQUENCIES).map(|i| 10f64.powf(from + (to - from) * share(i)));
        let response: Vec<_> = omegas.map(|omega| (omega, open.at(omega))).collect();
        let phases = unwrapped_phases(response.iter().map(|it| it.1));
        let decibels = response.iter().map(|(w, l)| (*w, 20.0 * l.norm().log10()));
        magnitude = magnitude.line(name.clone(), decibels);
        let degrees = response.iter().zip(phases);
        phase = phase.line(name.clone(), degrees.map(|(it, p)| (it.0, p.to_degrees())));
        let far = nearest_poles(&judged.poles);
        poles = poles.with(Style::Crosses, name.clone(), far);
        if judged.is_stable() {
            let closed = dive_loop.closed_loop()?;
            step = step.line(
                name,
                step::samples(&closed, args.duration / SAMPLES, args.duration)?,
            );
        }
    }
    let ends = [DECADES.0, DECADES.1].map(|it| 10f64.powf(it));
    magnitude = magnitude.with(Style::Bound, "0 dB", ends.map(|w| (w, 0.0)));
    phase = phase.with(Style::Bound, "-180 deg", ends.map(|w| (w, -180.0)));
    step = step.with(
        Style::Bound,
        "setpoint",
        [0.0, args.duration].map(|t| (t, 1.0)),
    );
    let body = html! {
        h1 { (title) }
        p.lead { (gains_text(&gains)) }
        ul.verdict { @for verdict in verdicts { li { (verdict) } } }
        (figures(&[magnitude, phase, step, poles]))
        details open { summary { "All numbers" } pre { (text(args)?) } }
    };
    Ok(document(&title, "", &body, ""))
}

const LOOP_MAGNITUDE: [&str; 2] = ["Magnitude of the open loop", "magnitude [dB]"];
const LOOP_PHASE: [&str; 2] = ["Phase of the open loop", "phase [deg]"];

/// The poles that a drawing can show together: not those of a dead time, far to the left.
fn nearest_poles(poles: &[Complex<f64>]) -> Vec<(f64, f64)> {
    let far = 4.0 * poles.iter().map(|s| s.norm()).fold(1.0, f64::min).max(1.0);
    let near = poles.iter().filter(|s| s.norm() < far);
    near.map(|s| (s.re, s.im)).collect()
}

/// Stability and margins in a sentence.
fn stability(judged: &Judgement) -> String {
    if !judged.is_stable() {
        return "UNSTABLE".to_owned();
    }
    let mut text = "stable".to_owned();
    if let Some(margin) = judged.phase_margin() {
        text += &format!(", phase margin {:.1} deg", margin.to_degrees());
    }
    if let (Some(factor), _) = judged.gain_limits() {
        text += &format!(", gain margin {:+.1} dB", 20.0 * factor.log10());
    }
    if let Some(step) = &judged.step {
        text += &format!(": {}", step_text(step));
    }
    text
}

fn text(args: &AnalyseArgs) -> Result<String> {
    let gains = args.gains.gains();
    let path = args.subject.path()?;
    let mut text = format!(
        "{} behind {}, dead time {:.1} ms\n{}\n",
        args.subject.vehicle,
        args.subject.actuator,
        1e3 * path.delay,
        gains_text(&gains)
    );
    for speed in &args.speed {
        let judged = judged(&args.subject, gains, *speed, args.duration)?;
        write!(
            text,
            "\nU = {}\n{}",
            speed_text(*speed),
            described(&judged)?
        )?;
    }
    Ok(text)
}

/// The loop at a speed, judged.
///
/// # Errors
/// A vehicle or actuator that is refused, numbers that overflow.
pub fn judged(subject: &Subject, gains: LoopGains, speed: f64, duration: f64) -> Result<Judgement> {
    subject
        .dive_loop(gains, speed)?
        .judge(duration)
        .with_context(|| format!("the loop at {speed} m/s"))
}

/// A judgement in lines.
///
/// # Errors
/// None in practice: writing to memory.
pub fn described(judged: &Judgement) -> Result<String> {
    let mut text = String::new();
    writeln!(text, "  poles         {}", poles_text(&judged.poles))?;
    let verdict = match judged.routh.unstable_roots() {
        Some(0) => "stable".to_owned(),
        Some(n) => format!("UNSTABLE, {n} poles to the right"),
        None => "at the limit of stability".to_owned(),
    };
    let column: Vec<String> = judged
        .routh
        .first
        .iter()
        .map(|c| format!("{c:.3e}"))
        .collect();
    writeln!(text, "  Routh         {verdict}: {}", column.join("  "))?;
    for margin in &judged.phase {
        let degrees = margin.margin.to_degrees();
        writeln!(
            text,
            "  phase margin  {degrees:.1} deg at {:.3} rad/s",
            margin.frequency
        )?;
    }
    let (above, below) = judged.gain_limits();
    for factor in [above, below].into_iter().flatten() {
        let decibel = 20.0 * factor.log10();
        writeln!(
            text,
            "  gain margin   {decibel:+.1} dB (factor {factor:.3})"
        )?;
    }
    if let Some(step) = &judged.step {
        writeln!(text, "  depth step    {}", step_text(step))?;
    }
    Ok(text)
}

fn step_text(step: &StepMetrics) -> String {
    let seconds = |time: Option<f64>| time.map_or("never".to_owned(), |t| format!("{t:.2} s"));
    format!(
        "rise {}, overshoot {:.2} %, settling (2 %) {}, ITAE {:.2} s^2",
        seconds(step.rise_time),
        step.overshoot,
        seconds(step.settling_time),
        step.itae
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_units::FOOT;

    fn args(vehicle: &str, depth_d: f64, feet_per_second: f64) -> AnalyseArgs {
        AnalyseArgs {
            subject: Subject {
                vehicle: vehicle.to_owned(),
                base: "brunner".to_owned(),
                actuator: "ideal".to_owned(),
                rate: 0.0,
            },
            gains: GainArgs {
                depth_p: Some(0.25 / FOOT),
                depth_d: Some(depth_d / FOOT),
                pitch_p: None,
                pitch_rate: None,
            },
            speed: vec![feet_per_second * FOOT],
            duration: 100.0,
            html: None,
        }
    }

    /// Brunner 1988, p. 20, as corrected: unstable above 2.27 ft/s.
    #[test]
    fn the_reports_loop_without_derivative_is_called_unstable_at_three_feet_per_second() {
        let slow = text(&args("table_3", 0.0, 1.0)).expect("text");
        let fast = text(&args("table_3", 0.0, 3.0)).expect("text");
        assert!(
            slow.contains("stable:") && !slow.contains("UNSTABLE"),
            "{slow}"
        );
        assert!(fast.contains("UNSTABLE, 2 poles"), "{fast}");
    }

    /// Kdz = 0.5: poles -0.2458, -0.1604 +- 0.3747j, damping ratio 0.39 (p. 13).
    #[test]
    fn the_reports_poles_are_printed() {
        let shown = text(&args("table_3", 0.5, 1.0)).expect("text");
        for digits in ["-0.2458", "-0.1604 ± 0.3747i (zeta 0.394)"] {
            assert!(shown.contains(digits), "{digits} is not in\n{shown}");
        }
    }

    #[test]
    fn a_vehicle_that_heaves_is_analysed_too_and_an_unknown_one_refused() {
        assert!(
            text(&args("brunner", 0.6, 1.0))
                .expect("text")
                .contains("phase margin")
        );
        assert!(text(&args("no/such", 0.6, 1.0)).is_err());
    }
}
