//! `planesman dha`: the digital hydraulic actuator by itself.
//!
//! - [`mod@bench`]: the 1966 study's tables by simulation, beside the printed values.

use anyhow::Result;

pub mod bench;

/// What `planesman dha` can do.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum DhaCommand {
    /// Run the 1966 study's flight-control tests and print its tables beside the results
    Bench(bench::BenchArgs),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &DhaCommand) -> Result<()> {
    match command {
        DhaCommand::Bench(args) => bench::run(args),
    }
}
