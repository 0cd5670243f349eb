//! `planesman dha`: analysis of the digital hydraulic actuator.
//!
//! - [`size`]: sizes and rates of an actuator, or an actuator for a load.
//! - [`frequency`]: the linear model compared with the full model.
//! - [`design`]: designs of a circuit of on/off valves over a load cycle.
//!
//! The computations are in [`planesman_show::design`]. The tables of the 1966 study and the limit cycles belong to `planesman-reports`.

use anyhow::Result;

use crate::reports_program::{self, PassedOn};

pub mod design;
pub mod frequency;
pub mod size;

/// The commands of `planesman dha`.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum DhaCommand {
    /// Simulate the 1966 study's flight-control tests and compare with its tables
    #[command(after_help = "Example:\n  planesman dha bench --table 4-2")]
    Bench(PassedOn),
    /// Print the sizes of an actuator, or size an actuator for a load
    #[command(
        after_help = "Examples:\n  planesman dha size auv_two_speed\n  planesman dha size --resolution '0.5 deg' --slew '60 deg/s'"
    )]
    Size(Box<size::SizeArgs>),
    /// Compare the frequency responses of the linear model and the full model
    #[command(after_help = "Example:\n  planesman dha frequency auv --alone")]
    Frequency(frequency::FrequencyArgs),
    /// Compare designs of a circuit of on/off valves over a load cycle
    #[command(
        after_help = "Examples:\n  planesman dha design dfcu --load-cycle cycle.csv --html designs.html\n  planesman dha design mine.yaml --load-cycle dive --codings pcm --valves 4..6"
    )]
    Design(design::DesignArgs),
    /// Print limit cycles of the AUV's depth loop with the actuator: simulated, as periodic orbits, and predicted
    #[command(
        after_help = "Examples:\n  planesman dha limit-cycles --html limit_cycles.html\n  planesman dha limit-cycles 'open loop' --format csv"
    )]
    LimitCycles(PassedOn),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &DhaCommand) -> Result<()> {
    match command {
        DhaCommand::Bench(_) => reports_program::run("bench", 2),
        DhaCommand::LimitCycles(_) => reports_program::run("limit-cycles", 2),
        DhaCommand::Size(args) => size::run(args),
        DhaCommand::Frequency(args) => frequency::run(args),
        DhaCommand::Design(args) => design::run(args),
    }
}
