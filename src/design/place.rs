//! `planesman design place`: gains by pole placement for the depth loop.
//!
//! The formula places the poles of a simplified loop: continuous, pitch only, ideal planes. The analysis printed below the gains applies
//! to the sampled loop with heave and the actuator.

use anyhow::Result;
use clap::Args;
use planesman_control::design::dive_loop::Memory;
use planesman_control::design::placement::{self, Poles};
use planesman_show::design::{described, gains_text, heading, speed_text, stability};

use super::arguments::{SubjectArgs, set_gains};
use crate::arguments::{speed, within};
use planesman_console::Outcome;

/// Arguments of `design place`.
#[derive(Args)]
#[command(next_help_heading = "Poles")]
pub struct PlaceArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    /// Speed through the water (m/s, or with its unit: 1ft/s)
    #[arg(long, default_value_t = 0.3048, value_parser = speed(1e-3, 100.0))]
    speed: f64,
    /// Decay rate of the real pole (1/s)
    #[arg(long, value_name = "RATE", value_parser = within(1e-4, 100.0))]
    real: f64,
    /// Natural frequency of the pole pair (rad/s)
    #[arg(long, value_name = "W", value_parser = within(1e-4, 100.0))]
    frequency: f64,
    /// Damping ratio of the pole pair
    #[arg(long, default_value_t = 0.7, value_parser = within(0.0, 10.0))]
    damping_ratio: f64,
    /// Kpy, which the three poles do not determine
    #[arg(long, default_value_t = 0.7, value_parser = within(1e-3, 1e3))]
    pitch_p: f64,
}

/// Prints the gains and their analysis.
///
/// # Errors
/// A refused vehicle or actuator, numerical overflow.
pub fn run(args: &PlaceArgs) -> Result<()> {
    let subject = args.subject.subject();
    let gains = placement::gains(
        &subject.body.pitch_model(args.speed)?,
        args.speed,
        &Poles {
            real: args.real,
            frequency: args.frequency,
            damping_ratio: args.damping_ratio,
        },
        args.pitch_p,
    );
    let drive = subject.drive()?;
    let dive_loop = subject.dive_loop(&drive, (gains, Memory::default()), args.speed)?;
    let judged = dive_loop.judge(120.0)?;
    let mut answer = format!(
        "{}\n{}: {}",
        gains_text(&gains),
        speed_text(args.speed),
        stability(&judged)
    );
    if gains.depth_d < 0.0 || gains.pitch_rate < 0.0 {
        answer += "\nA gain is negative: the requested poles are slower or less damped than the vehicle's own poles with this Kpy.";
    }
    let set = set_gains(&gains);
    Ok(Outcome::new(answer)
        .numbers(heading(&subject, &drive))
        .numbers(
            "The poles are those of the continuous loop without heave, and with ideal planes. With heave:",
        )
        .numbers(described(&judged))
        .next(format!("planesman dive{set}"), "fly with these gains")
        .print()?)
}
