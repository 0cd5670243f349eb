//! The `planesman-reports` program: recomputes the two historical reports and Hopsan's recorded validations. `planesman reproduce`,
//! `planesman dha bench` and other commands run it.
//!
//! - [`reproduce`]: compares every number with the recomputed one.
//! - [`mod@bench`], [`limit_cycles`]: the 1966 study's tables, and limit cycles of the thesis' depth loop.
//! - [`transfer_functions`]: those printed in the thesis.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use planesman::arguments::{ended, parsed, refused};
use planesman_console::print_wrapped;
use planesman_hydraulics::actuator_file;
use planesman_reports::studies::frequency;

mod bench;
mod limit_cycles;
mod reproduce;
mod transfer_functions;

/// Recomputes the two historical reports and Hopsan's recorded validations.
#[derive(Parser)]
#[command(
    name = "planesman-reports",
    version,
    max_term_width = 80,
    after_help = "Example:\n  planesman reproduce --all      runs planesman-reports reproduce --all"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Recompute the numbers of the two historical reports and of Hopsan's validations, and print which numbers agree
    #[command(after_help = "Example:\n  planesman reproduce --html book.html")]
    Reproduce(reproduce::ReproduceArgs),
    /// Simulate the 1966 study's flight-control tests and compare with its tables
    #[command(after_help = "Example:\n  planesman dha bench --table 4-2")]
    Bench(bench::BenchArgs),
    /// Print limit cycles of the AUV's depth loop with the actuator: simulated, as periodic orbits, and predicted
    #[command(
        after_help = "Examples:\n  planesman dha limit-cycles --html limit_cycles.html\n  planesman dha limit-cycles 'open loop' --format csv"
    )]
    LimitCycles(limit_cycles::LimitCyclesArgs),
    /// Compare the linear model and the full model of the 1966 study's flight control under sinusoids
    #[command(after_help = "Example:\n  planesman dha frequency auv")]
    Frequency {
        /// A built-in actuator or an actuator file
        #[arg(default_value = "table_4_1")]
        actuator: String,
    },
    /// Print the transfer functions of the thesis as printed there
    #[command(after_help = "Example:\n  planesman tf brunner --as-printed")]
    Tf(planesman::tf_command::TfArgs),
}

fn main() -> ExitCode {
    let cli = match parsed::<Cli>() {
        Ok(cli) => cli,
        Err(error) => return refused::<Cli>(&error),
    };
    planesman_node::file_size::limit_is_an_error();
    let outcome = match cli.command {
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::LimitCycles(args) => limit_cycles::run(&args),
        Command::Frequency { actuator } => frequency(&actuator),
        Command::Tf(args) => transfer_functions::run(&args),
    };
    ended("planesman-reports", outcome)
}

fn frequency(actuator: &str) -> anyhow::Result<()> {
    let set = actuator_file::load(actuator)?;
    Ok(print_wrapped(frequency::steered(&set)?)?)
}
