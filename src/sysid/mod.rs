//! `planesman sysid`: signals of a bag or CSV file, and models between them; [`replay`] is `planesman replay`.

use anyhow::Result;
use clap::Subcommand;

pub use arguments::Columns;

mod arguments;
pub mod compare;
mod compare_page;
pub mod compared;
pub mod fit;
pub mod model_file;
mod montecarlo;
mod page;
pub mod replay;
pub mod samples;
pub mod simulated;
pub mod topics;
mod trial;
mod watch;

/// Identify models from recorded data, or watch a running identifier.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// List every numeric field of a bag or CSV file, with rate, gaps, range and time history
    Topics(topics::TopicsArgs),
    /// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict
    Fit(Box<fit::FitArgs>),
    /// Judge model files on data, beside each other: simulation, predictions, residual tests, poles, frequency response
    Compare(Box<compare::CompareArgs>),
    /// Test every estimator by Monte Carlo simulation: bias, spread and coverage on five synthetic runs
    #[command(name = "montecarlo")]
    MonteCarlo(montecarlo::MonteCarloArgs),
    /// Watch the estimates of a running identifier
    Watch(watch::WatchArgs),
}

impl Command {
    /// Runs the command and prints its results.
    ///
    /// # Errors
    /// One line for the terminal.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Topics(args) => topics::run(args),
            Self::Fit(args) => fit::run(args),
            Self::Compare(args) => compare::run(args),
            Self::MonteCarlo(args) => montecarlo::run(args),
            Self::Watch(args) => watch::run(args),
        }
    }
}
