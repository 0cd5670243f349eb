//! `planesman design`: the depth and pitch loops on paper, for any vehicle, speed, gains and actuator.
//!
//! - [`analyse`]: poles, Routh's scheme, margins and step response at each speed;
//! - [`locus`]: where the poles go as one gain, or the speed, changes;
//! - [`place`]: gains for poles that are wanted;
//! - [`optimise`]: gains for a range of speeds;
//! - [`table`]: depth steps flown with every actuator, feedback and gain source.
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

/// What is to be designed.
#[derive(Subcommand)]
pub enum DesignCommand {
    /// Poles, stability, margins and the step response, at one speed or several
    Analyse(analyse::AnalyseArgs),
    /// The root locus over a gain or over the speed, as a table or a drawing
    Locus(locus::LocusArgs),
    /// Gains that put the depth loop's poles where they are wanted
    Place(place::PlaceArgs),
    /// Gains proposed for a range of speeds, with the margins they get
    Optimise(optimise::OptimiseArgs),
    /// Depth steps flown with every actuator, feedback and gain source: what each choice costs
    Table(table::TableArgs),
}

/// Designs what was asked for and prints it.
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
