//! `planesman design analyse`: poles, margins and step response of the loop at each speed.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use planesman_console::called;
use planesman_flight::sink::write_text;
use planesman_show::design::Analysis;

use super::arguments::{GainArgs, SubjectArgs};
use crate::arguments::{page_file, speed, within};

/// Arguments of `design analyse`.
#[derive(Args)]
#[command(next_help_heading = "Analysis")]
pub struct AnalyseArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    #[command(flatten)]
    gains: GainArgs,
    /// Speeds through the water (m/s, or with their unit: 1ft/s), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.3048", value_parser = speed(1e-3, 100.0))]
    speed: Vec<f64>,
    /// Duration of the step response (s)
    #[arg(long, default_value_t = 120.0, value_parser = within(1.0, 1e4))]
    duration: f64,
    /// Also write an HTML page with frequency response, poles and depth step
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    html: Option<PathBuf>,
    /// Also print the poles in z, Routh's column and the continuous approximation
    #[arg(long)]
    verbose: bool,
}

/// Prints the analysis, and writes the page of `--html`.
///
/// # Errors
/// A refused vehicle or actuator, numerical overflow, a page that cannot be written.
pub fn run(args: &AnalyseArgs) -> Result<()> {
    let analysis = Analysis {
        subject: args.subject.subject(),
        law: args.gains.law(),
        speeds: args.speed.clone(),
        duration: args.duration,
    };
    let outcome = analysis.outcome(args.verbose)?;
    Ok(match &args.html {
        Some(file) => {
            write_text(file, analysis.page()?)?;
            outcome.file("Page", file)
        }
        None => outcome.next(
            format!("{} --html loop.html", called()),
            "frequency response, poles and depth step",
        ),
    }
    .print()?)
}
