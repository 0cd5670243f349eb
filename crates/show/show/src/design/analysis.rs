//! Poles, margins and step response of the loop at each speed.
//!
//! The sampled loop, as implemented, is analysed; the continuous approximation is printed for comparison.

use std::f64::consts::PI;

use crate::pages::cards::{Card, Tone, cards};
use crate::pages::{document, figures_with_first};
use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_console::Outcome;
use planesman_control::design::dive_loop::{DiveLoop, Judgement};
use planesman_flight::During as _;
use planesman_flight::summary::step_text;
use planesman_linear::frequency::{Response, grid};
use planesman_linear::{Complex, ComplexFunctions as _, unwrapped_phases};

use crate::design::error::{Error, Result};
use crate::design::subject::{
    Drive, Law, Subject, discrete_poles_text, law_text, poles_text, speed_text,
};

/// Input of an analysis: the loop, the speeds and the simulated duration.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// Vehicle and actuator.
    pub subject: Subject,
    /// The control law.
    pub law: Law,
    /// Speeds through the water, m/s.
    pub speeds: Vec<f64>,
    /// Duration of the step response, s.
    pub duration: f64,
}

/// Range of plotted frequencies, rad/s; for a sampled loop up to the Nyquist frequency.
const LOWEST: f64 = 1e-3;
const HIGHEST: f64 = 30.0;
/// Poles with `|z|` below this belong to the actuator's motion within a tick: at 20 Hz they decay within 25 ms.
pub(crate) const FAST: f64 = 0.3;
/// Largest magnitude shown in a Nyquist plot.
const NYQUIST_EXTENT: f64 = 3.0;

/// A loop with its margins and the plotted response.
struct Drawn {
    name: String,
    judged: Judgement,
    response: Response,
}

impl Drawn {
    /// The frequency response of a continuous loop up to `highest`, rad/s.
    fn new(dive_loop: &DiveLoop, name: String, highest: f64, duration: f64) -> Result<Self> {
        let continuous = || {
            let open = dive_loop.open_loop()?;
            let omegas = grid(LOWEST, highest).into_iter();
            Ok::<_, Error>(omegas.map(|omega| (omega, open.at(omega))).collect())
        };
        let response = match dive_loop.sampled_response() {
            Some(mut response) => {
                response.retain(|(omega, _)| *omega >= LOWEST);
                response
            }
            None => continuous()?,
        };
        Ok(Self {
            judged: dive_loop.judge(duration)?,
            response,
            name,
        })
    }

    fn decibels(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let points = self.response.iter();
        points.map(|(w, l)| (*w, decibels(l.modulus())))
    }

    fn degrees(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let phases = unwrapped_phases(self.response.iter().map(|it| it.1));
        let points = self.response.iter().zip(phases);
        points.map(|(it, phase)| (it.0, phase.to_degrees()))
    }

    /// The plotted phase at a frequency, degrees.
    fn degrees_at(&self, frequency: f64) -> f64 {
        let mut points = self.degrees().collect::<Vec<_>>();
        points.sort_by(|a, b| {
            let off = |it: &(f64, f64)| libm::log(it.0 / frequency).abs();
            off(a).total_cmp(&off(b))
        });
        points.first().map_or(f64::NAN, |point| point.1)
    }

    /// Points at which the margins are read, for the magnitude plot and for the phase plot.
    fn marks(&self) -> [Vec<(f64, f64)>; 2] {
        let (above, below) = self.judged.gain_limits();
        let gain = [above, below].into_iter().flatten();
        let phase = self.judged.phase.iter();
        [
            gain.map(|m| (m.frequency, -decibels(m.factor))).collect(),
            phase
                .map(|m| (m.frequency, self.degrees_at(m.frequency)))
                .collect(),
        ]
    }
}

fn decibels(factor: f64) -> f64 {
    20.0 * libm::log10(factor)
}

impl Analysis {
    /// The HTML page: one sentence on stability per speed, frequency response, poles, step response, and the text.
    ///
    /// # Errors
    /// A refused vehicle or actuator, numerical overflow.
    pub fn page(&self) -> Result<String> {
        let law = self.law;
        let drive = self.subject.drive()?;
        let title = format!("Dive loop of {}", self.subject.title());
        let mut verdicts = Vec::new();
        let open = [LOOP_MAGNITUDE, LOOP_PHASE].map(|[title, y]| {
            Plot::new(title, ["frequency [rad/s]", y])
                .log_x()
                .linked("frequency")
        });
        let [mut magnitude, mut phase] = open;
        magnitude = magnitude.note(
        "The loop is broken at the planes; shown up to the Nyquist frequency. A circle marks a gain margin: the magnitude where the phase is -180 degrees.",
    );
        phase = phase.note(
        "A circle marks a phase margin: the distance from -180 degrees where the magnitude is 0 dB.",
    );
        let mut nyquist = Plot::new("Nyquist plot", ["real part", "imaginary part"])
        .note("The open loop and the point -1. The smallest distance between the curve and this point is the inverse of the sensitivity peak.")
        .one_scale();
        let mut poles = Plot::new("Poles", ["real part [1/s]", "imaginary part [rad/s]"])
        .note("Poles of the closed loop; for the sampled loop ln(z)/T. Poles far to the left are not shown.")
        .from_zero()
        .one_scale();
        let mut step = Plot::new("Depth step", ["time [s]", "depth over setpoint"])
            .note("Response to a unit step of the setpoint.");
        let sampling = drive.sampling.as_ref();
        let highest = sampling.map_or(HIGHEST, |it| PI / it.tick);
        for speed in &self.speeds {
            let name = speed_text(*speed);
            let dive_loop = self.subject.dive_loop(&drive, law, *speed)?;
            let drawn = Drawn::new(&dive_loop, name.clone(), highest, self.duration)?;
            let (tone, words) = match drawn.judged.is_stable() {
                true => (Tone::Good, "stable"),
                false => (Tone::Bad, "UNSTABLE"),
            };
            let verdict = Card::new(name.clone(), words).toned(tone);
            verdicts.push(verdict.note(stability(&drawn.judged)));
            let [gain_marks, phase_marks] = drawn.marks();
            magnitude = magnitude.line(name.clone(), drawn.decibels()).with(
                Style::Circles,
                format!("gain margin at {name}"),
                gain_marks,
            );
            phase = phase.line(name.clone(), drawn.degrees()).with(
                Style::Circles,
                format!("phase margin at {name}"),
                phase_marks,
            );
            let near = drawn.response.iter();
            let near = near.filter(|(_, l)| l.modulus() < NYQUIST_EXTENT);
            let (points, frequencies): (Vec<_>, Vec<_>) =
                near.map(|(w, l)| ((l.re, l.im), *w)).unzip();
            nyquist = nyquist.with_all([Series {
                at: Some(("rad/s".into(), frequencies)),
                ..Series::new(Style::Line, name.clone(), points)
            }]);
            let s = drawn.judged.continuous_poles();
            poles = poles.with(Style::Crosses, name.clone(), nearest_poles(&s));
            if drawn.judged.is_stable() {
                step = step.line(drawn.name, dive_loop.step(self.duration)?);
            }
            if dive_loop.sampled_response().is_some() {
                let name = format!("continuous approximation at {name}");
                let drawn = Drawn::new(&dive_loop.continuous(), name, highest, self.duration)?;
                magnitude = magnitude.dashed(drawn.name.clone(), drawn.decibels());
                phase = phase.dashed(drawn.name.clone(), drawn.degrees());
            }
        }
        let ends = [LOWEST, highest];
        magnitude = magnitude.with(Style::Bound, "0 dB", ends.map(|w| (w, 0.0)));
        phase = phase.with(Style::Bound, "-180 deg", ends.map(|w| (w, -180.0)));
        nyquist = nyquist.with(Style::Crosses, "-1", [(-1.0, 0.0)]);
        step = step.with(
            Style::Bound,
            "setpoint",
            [0.0, self.duration].map(|t| (t, 1.0)),
        );
        poles = with_damping_lines(poles);
        let body = html! {
            h1 { (title) }
            p.lead { (law_text(&law.0, &law.1)) }
            (cards(&verdicts))
            (figures_with_first(&[step, magnitude, phase, nyquist, poles]))
            details open { summary { "All numbers" } pre { (self.text()?) } }
        };
        Ok(document(&title, "", &body, ""))
    }

    /// All results as text.
    ///
    /// # Errors
    /// Same as [`Analysis::page`].
    pub fn text(&self) -> Result<String> {
        Ok(self.outcome(true)?.to_string())
    }

    /// Stability and margins at each speed, with the numbers they follow from; with `verbose` also the poles in z, Routh's column, and the
    /// continuous approximation.
    ///
    /// # Errors
    /// Same as [`Analysis::page`].
    pub fn outcome(&self, verbose: bool) -> Result<Outcome> {
        let law = self.law;
        let drive = self.subject.drive()?;
        let mut verdicts = Vec::new();
        let mut text = law_text(&law.0, &law.1) + "\n" + &heading(&self.subject, &drive);
        for speed in &self.speeds {
            let dive_loop = self.subject.dive_loop(&drive, law, *speed)?;
            let judged = |dive_loop: &DiveLoop| {
                let judged = dive_loop.judge(self.duration);
                judged.during(|| format!("the loop at {speed} m/s"))
            };
            let sampled = judged(&dive_loop)?;
            verdicts.push(format!("{}: {}", speed_text(*speed), stability(&sampled)));
            text += &format!(
                "\nU = {}\n{}",
                speed_text(*speed),
                lines_of(&sampled, verbose)
            );
            if drive.sampling.is_some() && verbose {
                let delay = 1e3 * drive.path.delay;
                text += &format!(
                    "  continuous approximation: hold and actuator as a dead time of {delay:.1} ms; its fast poles come from the Pade approximation\n{}",
                    described(&judged(&dive_loop.continuous())?)
                );
            }
        }
        Ok(Outcome::new(verdicts.join("\n")).numbers(text))
    }
}

const LOOP_MAGNITUDE: [&str; 2] = ["Magnitude of the open loop", "magnitude [dB]"];
const LOOP_PHASE: [&str; 2] = ["Phase of the open loop", "phase [deg]"];

/// The poles that fit into one plot: poles far to the left, such as those of a dead time, are omitted.
fn nearest_poles(poles: &[Complex<f64>]) -> Vec<(f64, f64)> {
    let far = 4.0
        * poles
            .iter()
            .map(|s| s.modulus())
            .fold(1.0, f64::min)
            .max(1.0);
    let near = poles.iter().filter(|s| s.modulus() < far);
    near.map(|s| (s.re, s.im)).collect()
}

/// Damping ratios whose lines are plotted with the poles.
const DAMPING: [f64; 3] = [0.3, 0.5, 0.7];

/// Adds lines of equal damping ratio to a plot of poles, as long as the most distant pole.
fn with_damping_lines<'a>(poles: Plot<'a>) -> Plot<'a> {
    let points = poles.series.iter().flat_map(|it| &it.points);
    let far = points
        .map(|(re, im)| libm::hypot(*re, *im))
        .fold(0.0, f64::max);
    DAMPING.into_iter().fold(poles, |plot, damping| {
        let (re, im) = (-far * damping, far * libm::sqrt(1.0 - damping * damping));
        let line = [(re, -im), (0.0, 0.0), (re, im)];
        plot.with(Style::Bound, format!("damping ratio {damping}"), line)
    })
}

/// A sentence on stability and margins.
#[must_use]
pub fn stability(judged: &Judgement) -> String {
    if !judged.is_stable() {
        return "UNSTABLE".to_owned();
    }
    let mut parts = vec!["stable".to_owned()];
    if let Some(margin) = judged.phase_margin() {
        parts.push(format!("phase margin {:.1} deg", margin.to_degrees()));
    }
    if let (Some(above), _) = judged.gain_limits() {
        parts.push(format!("gain margin {:.1} dB", decibels(above.factor)));
    }
    if let Some(step) = &judged.step {
        let settled = step.settling_time.map_or_else(
            || "a depth step does not settle within 2 %".to_owned(),
            |t| format!("a depth step settles in {t:.1} s (2 %)"),
        );
        parts.push(settled);
        parts.push(format!("overshoot {:.1} %", step.overshoot));
    }
    parts.join(", ")
}

/// Vehicle, actuator and sampling, and the conditions under which the analysis is valid.
#[must_use]
pub fn heading(subject: &Subject, drive: &Drive) -> String {
    let note = drive.sampling.as_ref().map(|it| it.note.as_str());
    let mut text = subject.title() + "\n";
    if let Some(note) = note.filter(|note| !note.is_empty()) {
        text += note;
        text += "\n";
    }
    text
}

/// A judgement as text.
#[must_use]
pub fn described(judged: &Judgement) -> String {
    lines_of(judged, true)
}

/// Like [`described`]; without `verbose` the text contains only the poles in s, the margins and the step response.
fn lines_of(judged: &Judgement, verbose: bool) -> String {
    let mut text = String::new();
    let mut line = |line: String| {
        text += &line;
        text.push('\n');
    };
    match judged.tick {
        Some(tick) => {
            let (slow, fast): (Vec<Complex<f64>>, Vec<_>) =
                judged.poles.iter().partition(|z| z.modulus() >= FAST);
            let s: Vec<_> = slow.iter().map(|z| z.ln() / tick).collect();
            let more = match fast.len() {
                0 => String::new(),
                n => format!("  and {n} within {FAST} of z = 0"),
            };
            if verbose {
                line(format!(
                    "  poles in z    {}{more}",
                    discrete_poles_text(&slow)
                ));
            }
            line(format!("  poles in s    {}", poles_text(&s)));
        }
        None => line(format!("  poles         {}", poles_text(&judged.poles))),
    }
    match &judged.routh {
        _ if !verbose => {}
        Some(routh) => {
            let verdict = match routh.unstable_roots() {
                Some(0) => "stable".to_owned(),
                Some(n) => format!("UNSTABLE, {n} poles in the right half-plane"),
                None => "at the limit of stability".to_owned(),
            };
            let column: Vec<String> = routh.first.iter().map(|c| format!("{c:.3e}")).collect();
            line(format!("  Routh         {verdict}: {}", column.join("  ")));
        }
        None => {
            let verdict = match judged.unstable_poles() {
                0 => "stable".to_owned(),
                1 => "UNSTABLE, a pole outside the unit circle".to_owned(),
                n => format!("UNSTABLE, {n} poles outside the unit circle"),
            };
            line(format!("  sampled loop  {verdict}"));
        }
    }
    for margin in &judged.phase {
        let degrees = margin.margin.to_degrees();
        line(format!(
            "  phase margin  {degrees:.1} deg at {:.3} rad/s",
            margin.frequency
        ));
    }
    let (above, below) = judged.gain_limits();
    for margin in [above, below].into_iter().flatten() {
        line(format!(
            "  gain margin   {:+.1} dB (factor {:.3}) at {:.3} rad/s",
            decibels(margin.factor),
            margin.factor,
            margin.frequency
        ));
    }
    if judged.is_stable() {
        if let Some(delay) = judged.delay_margin() {
            let ticks = judged
                .tick
                .map(|tick| format!(", {:.1} ticks", delay / tick));
            line(format!(
                "  delay margin  {delay:.3} s{}",
                ticks.unwrap_or_default()
            ));
        }
        if let Some(peak) = &judged.sensitivity {
            line(format!(
                "  sensitivity   at most {:.3}, at {:.3} rad/s",
                peak.value, peak.frequency
            ));
        }
    }
    if let Some(step) = &judged.step {
        line(format!("  depth step    {}", step_text(step)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::subject::{Body, TABLE_3, default_gains};
    use planesman_control::design::dive_loop::Memory;
    use planesman_control::gains::LoopGains;
    use planesman_units::FOOT;

    fn table_3() -> Body {
        Body::Pitch {
            name: "table_3",
            model: TABLE_3,
        }
    }

    fn analysis(body: Body, depth_d: f64, feet_per_second: f64) -> Analysis {
        Analysis {
            subject: Subject {
                body,
                actuator: "ideal".to_owned(),
                rate: 0.0,
                ..Subject::default()
            },
            law: (
                LoopGains {
                    depth_p: 0.25 / FOOT,
                    depth_d: depth_d / FOOT,
                    ..default_gains()
                },
                Memory::default(),
            ),
            speeds: vec![feet_per_second * FOOT],
            duration: 100.0,
        }
    }

    /// Brunner 1988, p. 20, as corrected: unstable above 2.27 ft/s.
    #[test]
    fn the_reports_loop_without_derivative_is_called_unstable_at_three_feet_per_second() {
        let slow = analysis(table_3(), 0.0, 1.0).text().expect("text");
        let fast = analysis(table_3(), 0.0, 3.0).text().expect("text");
        assert!(
            slow.contains("stable:") && !slow.contains("UNSTABLE"),
            "{slow}"
        );
        assert!(fast.contains("UNSTABLE, 2 poles"), "{fast}");
    }

    /// Kdz = 0.5: poles -0.2458, -0.1604 +- 0.3747j, damping ratio 0.39 (p. 13).
    #[test]
    fn the_reports_poles_are_printed() {
        let shown = analysis(table_3(), 0.5, 1.0).text().expect("text");
        for digits in ["-0.2458", "-0.1604 ± 0.3747i (zeta 0.394)"] {
            assert!(shown.contains(digits), "{digits} is not in\n{shown}");
        }
    }

    #[test]
    fn a_vehicle_that_heaves_is_analysed_too_and_an_unknown_one_refused() {
        assert!(
            analysis(Body::vehicle("brunner"), 0.6, 1.0)
                .text()
                .expect("text")
                .contains("phase margin")
        );
        assert!(analysis(Body::vehicle("no/such"), 0.6, 1.0).text().is_err());
    }

    /// Six times the default gains were "stable" by the continuous approximation alone, and swing in flight.
    #[test]
    fn a_loop_that_is_stable_on_the_continuous_paper_alone_is_called_unstable() {
        let mut args = analysis(Body::vehicle("brunner"), 0.6, 3.0);
        args.subject.rate = 20.0;
        (args.law.0.pitch_p, args.law.0.pitch_rate) = (6.0 * 0.7, 6.0 * 2.0);
        let shown = args.text().expect("text");
        let (sampled, continuous) = shown.split_once("continuous approximation").expect("both");
        assert!(
            sampled.contains("UNSTABLE, a pole outside the unit circle"),
            "{shown}"
        );
        assert!(continuous.contains("Routh         stable"), "{shown}");
    }

    #[test]
    fn a_command_that_moves_the_planes_for_ages_is_refused() {
        let mut args = analysis(Body::vehicle("brunner"), 0.6, 1.0);
        (args.subject.rate, args.subject.computing_delay) = (1e4, 10.0);
        let refusal = args.text().expect_err("100,000 ticks").to_string();
        assert!(refusal.contains("choose a lower rate"), "{refusal}");
    }
}
