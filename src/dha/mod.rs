//! `planesman dha`: the digital hydraulic actuator by itself.
//!
//! - [`mod@bench`]: the 1966 study's tables by simulation, beside the printed values.
//! - [`size`]: sizes and rates of an actuator, or an actuator for a load.
//! - [`frequency`]: the linear model beside the full one.
//! - [`depth_loop`]: the AUV's depth loop through the actuator.
//! - [`limit_cycles`]: its limit cycles, predicted and simulated.

use anyhow::Result;

pub mod bench;
pub mod depth_loop;
pub mod frequency;
pub mod limit_cycles;
pub mod size;

/// The commands of `planesman dha`.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum DhaCommand {
    /// Run the 1966 study's flight-control tests and print its tables beside the results
    Bench(bench::BenchArgs),
    /// Print an actuator's sizes, or size one for a load
    Size(Box<size::SizeArgs>),
    /// Print the linear model's frequency response beside the full model's
    Frequency(frequency::FrequencyArgs),
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
        DhaCommand::Size(args) => size::run(args),
        DhaCommand::Frequency(args) => frequency::run(args),
        DhaCommand::LimitCycles(args) => limit_cycles::run(args),
    }
}
