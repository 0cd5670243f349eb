//! `planesman design analyse`: poles, margins and step response of the loop at each speed.

use std::fmt::Write as _;

use anyhow::{Context as _, Result};
use clap::Args;
use depth_controller::design::dive_loop::Judgement;
use depth_controller::gains::LoopGains;
use planesman_linear::StepMetrics;

use super::subject::{GainArgs, Subject, gains_text, poles_text, speed_text};
use crate::arguments::{speed, within};
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
}

/// Prints the analysis.
///
/// # Errors
/// A vehicle or actuator that is refused, numbers that overflow.
pub fn run(args: &AnalyseArgs) -> Result<()> {
    print_wrapped(text(args)?)?;
    Ok(())
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
