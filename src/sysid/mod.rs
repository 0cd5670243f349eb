//! `planesman sysid`: signals of any bag or table, and models between them; [`replay`] is `planesman replay`.

use anyhow::Result;
use clap::Subcommand;

mod arguments;
pub mod fit;
mod model_file;
mod montecarlo;
mod page;
pub mod replay;
pub mod topics;
mod watch;

/// A command on recorded data, or on an identifier that runs.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// List every numeric field of a bag or table, with rate, gaps, range and course
    Topics(topics::TopicsArgs),
    /// Find a model between two signals of any bag or table, with its uncertainty, tests and a verdict
    Fit(Box<fit::FitArgs>),
    /// Hold every estimator's claims against the truth, on five synthetic runs with many noises
    #[command(name = "montecarlo")]
    MonteCarlo(montecarlo::MonteCarloArgs),
    /// Watch what a running identifier learns
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
            Self::MonteCarlo(args) => montecarlo::run(args),
            Self::Watch(args) => watch::run(args),
        }
    }
}
