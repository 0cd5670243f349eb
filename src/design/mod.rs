//! `planesman design`: design of the depth and pitch loops, for any vehicle, speed, gains and actuator.
//!
//! - [`analyse`]: poles, margins and step response at each speed;
//! - [`locus`]: the poles as one gain, or the speed, varies;
//! - [`place`]: gains for given poles;
//! - [`optimise`]: gains for a range of speeds;
//! - [`table`]: depth steps simulated with every actuator, feedback and gain source.
//!
//! All commands analyse the sampled loop: the command is held between ticks, and the actuator has its own dynamics. The computations are in
//! [`planesman_show::design`].

pub mod analyse;
mod arguments;
pub mod locus;
pub mod optimise;
pub mod place;
pub mod table;

use anyhow::Result;
use clap::Subcommand;

/// The commands of `planesman design`.
#[derive(Subcommand)]
pub enum DesignCommand {
    /// Analyse poles, stability, margins and step response at one or more speeds
    #[command(
        after_help = "Example:\n  planesman design analyse brunner --speed 1ft/s,3ft/s --html loop.html"
    )]
    Analyse(analyse::AnalyseArgs),
    /// Print the root locus over a gain or the speed, as a table or a plot
    #[command(
        after_help = "Example:\n  planesman design locus brunner --vary depth_p --to 5 --html locus.html"
    )]
    Locus(locus::LocusArgs),
    /// Compute gains for given poles of the depth loop
    #[command(
        after_help = "Example:\n  planesman design place brunner --speed 1ft/s --real 0.4 --frequency 0.7"
    )]
    Place(place::PlaceArgs),
    /// Optimise gains for a range of speeds, with required margins
    #[command(
        after_help = "Example:\n  planesman design optimise brunner --speed 1ft/s,2ft/s --gain-margin 8"
    )]
    Optimise(optimise::OptimiseArgs),
    /// Simulate and compare depth steps with every actuator, feedback and gain source
    #[command(
        after_help = "Example:\n  planesman design table brunner --speed 1ft/s --step 3ft --html table.html"
    )]
    Table(table::TableArgs),
}

/// Runs the command and prints the result.
///
/// # Errors
/// A refused vehicle or actuator, numerical overflow, a page that cannot be written.
pub fn run(command: &DesignCommand) -> Result<()> {
    match command {
        DesignCommand::Analyse(args) => analyse::run(args),
        DesignCommand::Locus(args) => locus::run(args),
        DesignCommand::Place(args) => place::run(args),
        DesignCommand::Optimise(args) => optimise::run(args),
        DesignCommand::Table(args) => table::run(args),
    }
}
