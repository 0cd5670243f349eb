//! The effect of each design choice on a simulated depth step.
//!
//! Every combination of step, speed, actuator, feedback and gains is simulated with the whole loop in one process, as `planesman sim` does:
//! vehicle with sensor errors, controller, actuator and identifier. Adaptive gains need excitation to identify from: only their flights have a
//! small pseudo-random test signal. The depth cell is assumed not to saturate at 32.58 in (Fig. 38), which is shallower than the steps.

use crate::pages::{document, figures};
use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_console::Table;
use planesman_control::design::dive_loop::Memory;
use planesman_control::gains::LoopGains;
use planesman_flight::During as _;
use planesman_flight::compose::Loop;
use planesman_flight::scenario::Scenario;
use planesman_hydraulics::ActuatorParameters;
use planesman_linear::StepMetrics;
use planesman_text::number;
use planesman_units::FOOT;

use crate::design::error::Result;
use crate::design::subject::{Body, Subject, default_gains};

/// The flights to simulate: every combination of these with each actuator, feedback and gain source.
#[derive(Clone, Debug)]
pub struct DepthSteps {
    /// A built-in vehicle or a vehicle file.
    pub vehicle: String,
    /// Speeds, m/s.
    pub speeds: Vec<f64>,
    /// Depth steps, m.
    pub steps: Vec<f64>,
    /// Amplitude of the test signal in flights with adaptive gains, deg.
    pub signal: f64,
    /// Seed of all noise.
    pub seed: u32,
}

const FEEDBACK: [&str; 3] = ["truth", "integrator", "kalman"];
const GAINS: [&str; 3] = ["fixed", "scheduled", "adaptive"];

/// The choices of one flight.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Depth step, m.
    step: f64,
    /// Speed, m/s.
    speed: f64,
    actuator: &'static str,
    feedback: &'static str,
    gains: &'static str,
}

/// The results of a flight.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Overshoot, percent.
    overshoot: f64,
    /// Settling time to 5 %, s.
    settling: Option<f64>,
    /// Steady-state error, m.
    steady_error: f64,
    /// Error of the pitch that is fed back, root mean square, rad.
    pitch_error: f64,
    /// Plane travel per time, rad/s.
    activity: f64,
    /// Gain margin of the sampled loop with the final gains, a factor; only for feedback of the true state, since that loop has no estimator.
    gain_margin: Option<f64>,
}

impl DepthSteps {
    /// Every combination.
    #[must_use]
    pub fn choices(&self) -> Vec<Choice> {
        let mut choices = Vec::new();
        for &step in &self.steps {
            for &speed in &self.speeds {
                for actuator in ["ideal", "dha"] {
                    for feedback in FEEDBACK {
                        for gains in GAINS {
                            choices.push(Choice {
                                step,
                                speed,
                                actuator,
                                feedback,
                                gains,
                            });
                        }
                    }
                }
            }
        }
        choices
    }

    /// Simulates one flight.
    ///
    /// # Errors
    /// A refused vehicle or parameter, or a flight that breaks off.
    pub fn fly(&self, choice: &Choice) -> Result<Outcome> {
        Ok(choice.fly(self).during(|| choice.text())?)
    }

    /// A table with one row per flight.
    #[must_use]
    pub fn table(&self, choices: &[Choice], outcomes: &[Outcome]) -> Table {
        let mut table = Table::new([
            "step ft",
            "speed ft/s",
            "actuator",
            "feedback",
            "gains",
            "overshoot %",
            "settling (5 %) s",
            "steady error mm",
            "pitch error deg rms",
            "plane travel deg/s",
            "test signal deg",
            "gain margin",
        ]);
        for (choice, outcome) in choices.iter().zip(outcomes) {
            let settling = outcome.settling;
            table.row([
                number(choice.step / FOOT),
                number(choice.speed / FOOT),
                choice.actuator.to_owned(),
                choice.feedback.to_owned(),
                choice.gains.to_owned(),
                format!("{:.1}", outcome.overshoot),
                settling.map_or("never".to_owned(), |t| format!("{t:.1}")),
                format!("{:+.1}", 1e3 * outcome.steady_error),
                format!("{:.2}", outcome.pitch_error.to_degrees()),
                format!("{:.2}", outcome.activity.to_degrees()),
                number(choice.signal(self)),
                outcome
                    .gain_margin
                    .map_or_else(String::new, |factor| format!("{factor:.2}")),
            ]);
        }
        table
    }

    /// A note on columns that apply only to some rows.
    #[must_use]
    pub fn explained(&self) -> String {
        format!(
            "Only the flights with adaptive gains have a test signal, of {} deg, for the identification. The gain margin is that of the sampled loop with the final gains; it is shown only for feedback of the true state.",
            self.signal
        )
    }

    /// The HTML page: settling time over plane travel, and the table.
    #[must_use]
    pub fn page(&self, choices: &[Choice], outcomes: &[Outcome], table: &Table) -> String {
        let never = outcomes.iter().filter(|it| it.settling.is_none()).count();
        // The speed is told beside each point.
        let plots = ["ideal", "dha"].map(|actuator| {
            let plot = Plot::new(
                format!("Settling time and plane travel, actuator {actuator}"),
                ["plane travel [deg/s]", "settling time (5 %) [s]"],
            );
            let series = FEEDBACK.iter().flat_map(|feedback| {
                GAINS.iter().map(move |gains| {
                    let flights = choices.iter().zip(outcomes).filter(|(choice, _)| {
                        (choice.actuator, choice.feedback, choice.gains)
                            == (actuator, feedback, gains)
                    });
                    let settled = flights.filter_map(|(choice, outcome)| {
                        let point = (outcome.activity.to_degrees(), outcome.settling?);
                        Some((point, choice.speed / FOOT))
                    });
                    let (points, speeds): (Vec<_>, Vec<_>) = settled.unzip();
                    Series {
                        at: Some(("ft/s".into(), speeds)),
                        ..Series::new(Style::Circles, format!("{feedback}, {gains}"), points)
                    }
                })
            });
            plot.plane().with_all(series)
        });
        let title = format!("Depth steps of {}", self.vehicle);
        let body = html! {
            h1 { (title) }
            ul.verdict { li { (choices.len()) " flights; " (never) " do not settle within 5 %." } }
            p.lead { (self.explained()) " Seed " (self.seed) "." }
            (figures(&plots))
            (table.html())
        };
        document(&title, "", &body, "")
    }
}

impl Choice {
    fn text(&self) -> String {
        let Self {
            step,
            speed,
            actuator,
            feedback,
            gains,
        } = self;
        let (feet, feet_per_second) = (number(step / FOOT), number(speed / FOOT));
        format!("{feet} ft at {feet_per_second} ft/s, {actuator}, {feedback}, {gains}")
    }

    /// Amplitude of the flight's test signal, deg.
    fn signal(&self, flights: &DepthSteps) -> f64 {
        match self.gains {
            "adaptive" => flights.signal,
            _ => 0.0,
        }
    }

    /// The gain margin of the sampled loop with these gains.
    fn gain_margin(&self, flights: &DepthSteps, gains: LoopGains) -> Result<Option<f64>> {
        if self.feedback != "truth" {
            return Ok(None);
        }
        let actuator = match self.actuator {
            "dha" => ActuatorParameters::default().actuator,
            other => other.to_owned(),
        };
        let subject = Subject {
            body: Body::vehicle(&flights.vehicle),
            actuator,
            ..Subject::default()
        };
        let drive = subject.drive()?;
        let dive_loop = subject.dive_loop(&drive, (gains, Memory::default()), self.speed)?;
        let (above, _) = dive_loop.margins()?.gain_limits();
        Ok(above.map(|it| it.factor))
    }

    /// Simulated duration, s; longer for a slow vehicle.
    fn duration(&self) -> f64 {
        120.0 / (self.speed / FOOT).min(1.0)
    }

    fn scenario(&self, flights: &DepthSteps) -> planesman_flight::Result<Scenario> {
        Scenario::parse(&format!(
            "
description: {text}
duration: {duration}
seed: {seed}
parameters:
  plant_sim:
    vehicle: {vehicle}
    speed: {speed}
  depth_controller:
    depth_setpoint: {step}
    feedback.source: {feedback}
    feedback.speed: {speed}
    gains.source: {gains}
    identification.signal: {signal}
    identification.amplitude: {amplitude}
  dha_actuator:
    model: {actuator}
  sysid:
    first_moment: {moves_within}
",
            text = self.text(),
            duration = self.duration(),
            seed = flights.seed,
            vehicle = flights.vehicle,
            speed = self.speed,
            step = self.step,
            feedback = self.feedback,
            gains = self.gains,
            signal = if self.signal(flights) > 0.0 {
                "prbs"
            } else {
                "none"
            },
            amplitude = self.signal(flights).to_radians(),
            actuator = self.actuator,
            // Ideal planes stand still over a tick, and have no first moment to learn from.
            moves_within = self.actuator != "ideal",
        ))
    }

    fn fly(&self, flights: &DepthSteps) -> Result<Outcome> {
        let scenario = self.scenario(flights)?;
        let (mut times, mut depths) = (Vec::new(), Vec::new());
        let (mut travel, mut squares, mut stood) = (0.0, 0.0, 0.0);
        let mut gains = default_gains();
        for tick in Loop::new(&scenario)? {
            let tick = tick?;
            let state = &tick.observation.state;
            times.push(times.len() as f64 * scenario.tick);
            depths.push(state.depth);
            let fed_back = tick.estimate.map_or(state.pitch, |e| e.pitch);
            gains = LoopGains {
                depth_p: tick.control.gain_depth_p,
                depth_d: tick.control.gain_depth_d,
                pitch_p: tick.control.gain_pitch_p,
                pitch_rate: tick.control.gain_pitch_rate,
            };
            squares += (fed_back - state.pitch).powi(2);
            for angle in &tick.actuator.motion().dive_planes {
                travel += f64::abs(angle - stood);
                stood = *angle;
            }
        }
        let metrics = StepMetrics::of(&times, &depths, 0.0, self.step)?;
        Ok(Outcome {
            overshoot: metrics.overshoot,
            settling: metrics.settling_time_5,
            steady_error: metrics.steady_error,
            pitch_error: (squares / times.len() as f64).sqrt(),
            activity: travel / self.duration(),
            gain_margin: self.gain_margin(flights, gains)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(feedback: &'static str) -> Outcome {
        let flights = DepthSteps {
            vehicle: "brunner".to_owned(),
            speeds: vec![FOOT],
            steps: vec![3.0 * FOOT],
            signal: 1.0,
            seed: 1,
        };
        let choice = Choice {
            step: 3.0 * FOOT,
            speed: FOOT,
            actuator: "ideal",
            feedback,
            gains: "fixed",
        };
        choice.fly(&flights).expect("a flight")
    }

    /// Brunner 1988, p. 90: the gyro's drift makes the integrated pitch useless; the filter learns it.
    #[test]
    fn the_filter_costs_a_centimetre_of_depth_and_the_integrator_decimetres() {
        let [truth, filter, integrator] = ["truth", "kalman", "integrator"].map(outcome);
        assert_eq!(truth.pitch_error, 0.0);
        assert!(filter.pitch_error.to_degrees() < 1.0);
        assert!(integrator.pitch_error.to_degrees() > 5.0);
        assert!(truth.steady_error.abs() < 0.006);
        assert!(filter.steady_error.abs() < 0.02);
        assert!(integrator.steady_error.abs() > 0.1);
        assert!(truth.activity > 0.0);
    }

    #[test]
    fn every_step_speed_actuator_feedback_and_gain_source_is_flown() {
        let flights = DepthSteps {
            vehicle: "brunner".to_owned(),
            speeds: [0.5, 1.0, 2.0, 3.0].map(|it| it * FOOT).to_vec(),
            steps: [3.0, 5.0].map(|it| it * FOOT).to_vec(),
            signal: 1.0,
            seed: 1,
        };
        assert_eq!(flights.choices().len(), 2 * 4 * 2 * 3 * 3);
        for choice in flights.choices() {
            choice.scenario(&flights).expect("a scenario");
        }
    }
}
