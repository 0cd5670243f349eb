//! `planesman sysid`: lists signals and identifies models from bags or CSV files; [`replay`] is `planesman replay`.

use anyhow::Result;
use clap::Subcommand;

pub(crate) mod arguments;
pub mod compare;
pub mod fit;
mod history;
pub mod replay;
pub mod topics;

/// The commands of `planesman sysid`.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// List every numeric field of a bag or CSV file, with rate, gaps, range and time history
    #[command(
        after_help = "Examples:\n  planesman sysid topics runs/dive/bag --topic imu\n  planesman sysid topics log.csv --time-unit ms"
    )]
    Topics(topics::TopicsArgs),
    /// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict
    #[command(
        after_help = "Examples:\n  planesman sysid fit dive.csv -i dive_planes -o gyro_pitch_rate --window 20..90 --html model.html\n  planesman sysid fit bag -i plane_motion:dive_planes -o state:pitch_rate \\\n      --window 20..90 --order 3 --speed 1ft/s --model model.yaml\n  planesman sysid fit bag -i 'planes:position[ram]' -o imu:angular_velocity.y"
    )]
    Fit(Box<fit::FitArgs>),
    /// Compare model files on the same data: simulation, predictions, residual tests, poles, frequency response
    #[command(
        after_help = "Example:\n  planesman sysid compare first.yaml second.yaml bag --html compare.html"
    )]
    Compare(Box<compare::CompareArgs>),
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
        }
    }
}
