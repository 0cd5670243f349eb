//! `planesman design optimise`: gains for a range of speeds, with their margins.

use anyhow::{Result, bail};
use clap::Args;
use planesman_control::design::optimise::Wishes;

use planesman_show::design::{described, gains_text, heading, speed_text, stability};

use super::arguments::{GainArgs, SubjectArgs, set_gains};
use crate::arguments::{length, speed, within};
use planesman_console::Outcome;

/// Arguments of `design optimise`.
#[derive(Args)]
#[command(next_help_heading = "Requirements")]
pub struct OptimiseArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    /// Gains to compare with; the integral gains and the filter are kept
    #[command(flatten)]
    gains: GainArgs,
    /// Speeds through the water (m/s, or with their unit: 1ft/s) for one set of gains, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.1524,0.3048,0.6096,0.9144", value_parser = speed(1e-3, 100.0))]
    speed: Vec<f64>,
    /// Minimum phase margin (deg)
    #[arg(long, default_value_t = 45.0, value_parser = within(0.0, 179.0))]
    phase_margin: f64,
    /// Minimum gain margin, upward and downward (dB)
    #[arg(long, default_value_t = 6.0, value_parser = within(0.0, 60.0))]
    gain_margin: f64,
    /// Maximum overshoot of a depth step (%)
    #[arg(long, default_value_t = 5.0, value_parser = within(0.0, 100.0))]
    overshoot: f64,
    /// Depth step whose first pitch and plane commands must stay within the limits (m, or with its unit: 3ft)
    #[arg(long, default_value_t = 0.9144, value_parser = length(1e-3, 1e4))]
    step: f64,
    /// Limit of the pitch command (deg)
    #[arg(long, default_value_t = 45.0, value_parser = within(1.0, 90.0))]
    pitch_limit: f64,
    /// Limit of the plane command (deg)
    #[arg(long, default_value_t = 30.0, value_parser = within(1.0, 90.0))]
    planes_limit: f64,
    /// Duration of the step response (s)
    #[arg(long, default_value_t = 120.0, value_parser = within(1.0, 1e4))]
    duration: f64,
}

/// Finds and prints the gains.
///
/// # Errors
/// A refused vehicle or actuator, numerical overflow, requirements that no gains meet.
pub fn run(args: &OptimiseArgs) -> Result<()> {
    let subject = args.subject.subject();
    let (gains, memory) = args.gains.law();
    let drive = subject.drive()?;
    let wishes = Wishes {
        plants: args
            .speed
            .iter()
            .map(|speed| Ok((*speed, subject.plant(&drive, *speed)?)))
            .collect::<Result<_>>()?,
        memory,
        path: drive.path,
        phase_margin: args.phase_margin.to_radians(),
        gain_margin: libm::pow(10_f64, args.gain_margin / 20.0),
        overshoot: args.overshoot,
        step: args.step,
        pitch_limit: args.pitch_limit.to_radians(),
        planes_limit: args.planes_limit.to_radians(),
        duration: args.duration,
    };
    let Some(found) = wishes.propose()? else {
        bail!(
            "no gains found with a phase margin of {} deg, gain margins of {} dB and an overshoot of {} % at \
             every speed",
            args.phase_margin,
            args.gain_margin,
            args.overshoot
        );
    };
    let compared = match wishes.worst(&gains)? {
        Some(worst) => {
            format!("{worst:.2} m^2 with the given gains (the other gains have the controller's defaults)")
        }
        None => "the given gains (the other gains have the controller's defaults) do not meet the requirements"
            .to_owned(),
    };
    let judged = args.speed.iter().zip(&found.judgements);
    let verdicts = judged
        .clone()
        .map(|(speed, judged)| format!("\n{}: {}", speed_text(*speed), stability(judged)));
    let numbers = judged
        .map(|(speed, judged)| format!("\nU = {}\n{}", speed_text(*speed), described(judged)));
    Ok(
        Outcome::new(gains_text(&found.gains) + &verdicts.collect::<String>())
            .numbers(format!(
                "Worst ITAE {:.2} m^2 (times the speed squared); {compared}.",
                found.worst
            ))
            .numbers(heading(&subject, &drive) + &numbers.collect::<String>())
            .next(
                format!("planesman dive{}", set_gains(&found.gains)),
                "fly them",
            )
            .print()?,
    )
}
