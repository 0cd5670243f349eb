//! `planesman design`: design of the depth and pitch loops, for any vehicle, speed, gains and actuator.
//!
//! - [`analyse`]: poles, Routh's scheme, margins and step response at each speed;
//! - [`locus`]: the poles as one gain, or the speed, varies;
//! - [`place`]: gains for given poles;
//! - [`optimise`]: gains for a range of speeds;
//! - [`table`]: depth steps simulated with every actuator, feedback and gain source.
//!
//! The tools are [`depth_controller::design`]; here they meet vehicles and actuators.

pub mod analyse;
pub mod locus;
pub mod optimise;
pub mod place;
pub mod subject;
pub mod table;

use anyhow::Result;
use clap::Subcommand;

/// The commands of `planesman design`.
#[derive(Subcommand)]
pub enum DesignCommand {
    /// Analyse poles, stability, margins and step response at one or several speeds
    Analyse(analyse::AnalyseArgs),
    /// Print the root locus over a gain or the speed, as a table or a drawing
    Locus(locus::LocusArgs),
    /// Compute gains for given poles of the depth loop
    Place(place::PlaceArgs),
    /// Optimise gains for a range of speeds, with given margins
    Optimise(optimise::OptimiseArgs),
    /// Simulate depth steps with every actuator, feedback and gain source, and compare them
    Table(table::TableArgs),
}

/// Runs the command and prints the result.
///
/// # Errors
/// A vehicle or actuator that is refused, numbers that overflow, a drawing that cannot be written.
pub fn run(command: &DesignCommand) -> Result<()> {
    match command {
        DesignCommand::Analyse(args) => analyse::run(args),
        DesignCommand::Locus(args) => locus::run(args),
        DesignCommand::Place(args) => place::run(args),
        DesignCommand::Optimise(args) => optimise::run(args),
        DesignCommand::Table(args) => table::run(args),
    }
}
