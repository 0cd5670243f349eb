//! `planesman design table`: the effect of each choice on a simulated depth step.
//!
//! Every combination of step, speed, actuator, feedback and gains flies the whole loop in one process, as `planesman
//! sim` does: vehicle with sensor errors, controller, actuator and identifier. A small pseudo-random test signal is on
//! in every flight, since adaptive gains need something to identify from. The depth cell is taken without its
//! end at 32.58 in (Fig. 38), which is shallower than the steps.

use anyhow::{Context as _, Result};
use clap::Args;
use planesman_linear::step_metrics;
use planesman_units::FOOT;

use super::subject::within;
use crate::compose::Loop;
use crate::scenario::Scenario;

/// The flights to simulate.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct TableArgs {
    /// A built-in vehicle or a vehicle file
    #[arg(default_value = "brunner")]
    vehicle: String,
    /// Speeds (ft/s), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.5,1,2,3", value_parser = within(0.01, 100.0))]
    speed: Vec<f64>,
    /// Depth steps (ft), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "3,5", value_parser = within(0.01, 1000.0))]
    step: Vec<f64>,
    /// Amplitude of the test signal (deg)
    #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 30.0))]
    signal: f64,
    /// Seed of every noise
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

/// One flight's choices.
struct Choice {
    step: f64,
    speed: f64,
    actuator: &'static str,
    feedback: &'static str,
    gains: &'static str,
}

/// The results of a flight.
struct Outcome {
    /// percent
    overshoot: f64,
    /// s to stay within 5 %
    settling: Option<f64>,
    /// m
    steady_error: f64,
    /// Of pitch as fed back, root mean square, rad.
    pitch_error: f64,
    /// Plane travel, rad/s.
    activity: f64,
}

/// Flies them all and prints a table in Markdown.
///
/// # Errors
/// A vehicle or parameter that is refused, or a flight that breaks off.
pub fn run(args: &TableArgs) -> Result<()> {
    planesman_node::say!(
        "{}, test signal {} deg, seed {}; one flight a row\n",
        args.vehicle,
        args.signal,
        args.seed
    )?;
    planesman_node::say!(
        "| step ft | speed ft/s | actuator | feedback | gains | overshoot % | settling (5 %) s | steady error mm | pitch error deg rms | plane travel deg/s |"
    )?;
    planesman_node::say!("|---|---|---|---|---|---|---|---|---|---|")?;
    for choice in choices(args) {
        let outcome = choice.fly(args).with_context(|| choice.text())?;
        let settling = outcome
            .settling
            .map_or("never".to_owned(), |t| format!("{t:.1}"));
        planesman_node::say!(
            "| {} | {} | {} | {} | {} | {:.1} | {settling} | {:+.1} | {:.2} | {:.2} |",
            choice.step,
            choice.speed,
            choice.actuator,
            choice.feedback,
            choice.gains,
            outcome.overshoot,
            1e3 * outcome.steady_error,
            outcome.pitch_error.to_degrees(),
            outcome.activity.to_degrees(),
        )?;
    }
    Ok(())
}

fn choices(args: &TableArgs) -> Vec<Choice> {
    let mut choices = Vec::new();
    for &step in &args.step {
        for &speed in &args.speed {
            for actuator in ["ideal", "dha"] {
                for feedback in ["truth", "integrator", "kalman"] {
                    for gains in ["fixed", "scheduled", "adaptive"] {
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

impl Choice {
    fn text(&self) -> String {
        let Self {
            step,
            speed,
            actuator,
            feedback,
            gains,
        } = self;
        format!("{step} ft at {speed} ft/s, {actuator}, {feedback}, {gains}")
    }

    /// A slow vehicle is given more time.
    fn duration(&self) -> f64 {
        120.0 / self.speed.min(1.0)
    }

    fn scenario(&self, args: &TableArgs) -> Result<Scenario> {
        Scenario::parse(&format!(
            "
description: {text}
duration: {duration}
seed: {seed}
parameters:
  plant_sim:
    vehicle: {vehicle}
    speed: {speed}
    sensors.depth.saturation: 0.0
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
            seed = args.seed,
            vehicle = args.vehicle,
            speed = self.speed * FOOT,
            step = self.step * FOOT,
            feedback = self.feedback,
            gains = self.gains,
            signal = if args.signal > 0.0 { "prbs" } else { "none" },
            amplitude = args.signal.to_radians(),
            actuator = self.actuator,
            // Ideal planes stand still over a tick, and have no first moment to learn from.
            moves_within = self.actuator != "ideal",
        ))
    }

    fn fly(&self, args: &TableArgs) -> Result<Outcome> {
        let scenario = self.scenario(args)?;
        let (mut times, mut depths) = (Vec::new(), Vec::new());
        let (mut travel, mut squares, mut stood) = (0.0, 0.0, 0.0);
        for tick in Loop::new(&scenario)? {
            let tick = tick?;
            let state = &tick.observation.state;
            times.push(times.len() as f64 * scenario.tick);
            depths.push(state.depth);
            let fed_back = tick.estimate.map_or(state.pitch, |e| e.pitch);
            squares += (fed_back - state.pitch).powi(2);
            for angle in &tick.actuator.motion.dive_planes {
                travel += f64::abs(angle - stood);
                stood = *angle;
            }
        }
        let metrics = step_metrics::of(&times, &depths, 0.0, self.step * FOOT)?;
        Ok(Outcome {
            overshoot: metrics.overshoot,
            settling: metrics.settling_time_5,
            steady_error: metrics.steady_error,
            pitch_error: (squares / times.len() as f64).sqrt(),
            activity: travel / self.duration(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(feedback: &'static str) -> Outcome {
        let args = TableArgs {
            vehicle: "brunner".to_owned(),
            speed: vec![1.0],
            step: vec![3.0],
            signal: 1.0,
            seed: 1,
        };
        let choice = Choice {
            step: 3.0,
            speed: 1.0,
            actuator: "ideal",
            feedback,
            gains: "fixed",
        };
        choice.fly(&args).expect("a flight")
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
        let args = TableArgs {
            vehicle: "brunner".to_owned(),
            speed: vec![0.5, 1.0, 2.0, 3.0],
            step: vec![3.0, 5.0],
            signal: 1.0,
            seed: 1,
        };
        assert_eq!(choices(&args).len(), 2 * 4 * 2 * 3 * 3);
        for choice in choices(&args) {
            choice.scenario(&args).expect("a scenario");
        }
    }
}
