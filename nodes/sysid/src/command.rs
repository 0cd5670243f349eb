//! The identifier's commands on recorded data, for the `sysid` program and for `planesman sysid`.

use anyhow::Result;
use clap::Subcommand;

use crate::fit_command::{self, FitArgs};
use crate::montecarlo_command::{self, MonteCarloArgs};
use crate::replay::{self, ReplayArgs};
use crate::topics_command::{self, TopicsArgs};
use crate::watch::{self, WatchArgs};

/// A command.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// List every numeric field of a bag or table, with rate, gaps, range and course
    Topics(TopicsArgs),
    /// Find a model between two signals of any bag or table, with its uncertainty, tests and a verdict
    Fit(Box<FitArgs>),
    /// Hold every estimator's claims against the truth, on five synthetic runs with many noises
    #[command(name = "montecarlo")]
    MonteCarlo(MonteCarloArgs),
    /// Identify from a bag what the node identifies live
    Replay(ReplayArgs),
    /// Watch what a running identifier learns
    Watch(WatchArgs),
}

impl Command {
    /// The words by which the commands are called.
    pub const NAMES: [&str; 5] = ["topics", "fit", "montecarlo", "replay", "watch"];

    /// Runs the command and prints what it found.
    ///
    /// # Errors
    /// One line for the terminal.
    pub fn run(&self) -> Result<()> {
        match self {
            Self::Topics(args) => topics_command::run(args),
            Self::Fit(args) => fit_command::run(args),
            Self::MonteCarlo(args) => montecarlo_command::run(args),
            Self::Replay(args) => replay::run(args),
            Self::Watch(args) => watch::run(args),
        }
    }
}
