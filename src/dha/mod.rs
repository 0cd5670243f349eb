//! `planesman dha`: the digital hydraulic actuator by itself.
//!
//! - [`mod@bench`]: the 1966 study's tables by simulation, beside the printed values.
//! - [`limit_cycles`]: what the actuator leaves of a dive.

use anyhow::Result;

pub mod bench;
pub mod limit_cycles;

/// What `planesman dha` can do.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum DhaCommand {
    /// Run the 1966 study's flight-control tests and print its tables beside the results
    Bench(bench::BenchArgs),
    /// Show what the actuator leaves of a dive: limit cycles of the AUV's depth loop, predicted and simulated
    LimitCycles(limit_cycles::LimitCyclesArgs),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &DhaCommand) -> Result<()> {
    match command {
        DhaCommand::Bench(args) => bench::run(args),
        DhaCommand::LimitCycles(args) => limit_cycles::run(args),
    }
}
