//! `sysid identify`: from a bag or a table to a model one can judge.

use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use clap::Parser;

use crate::analysis::{Analysis, Options, analyse};
use crate::estimators::Method;
use crate::fit_command::{SignalArgs, Taken, account};
use crate::record::Record;
use crate::structure::Start;

/// Find a model between two signals of any bag or table, with its uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid identify")]
pub struct IdentifyArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// least_squares, armax, output_error or instruments
    #[arg(long, default_value = "output_error")]
    method: Method,
    /// The model's order, known poles not counted [default: searched, 1 to 4]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=10))]
    order: Option<u8>,
    /// Samples from input to first effect [default: searched, 1 to 3]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=100))]
    delay: Option<u8>,
    /// Zeros known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    zeros_at_one: u8,
    /// Poles known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    integrators: u8,
    /// The output has no offset
    #[arg(long)]
    no_offset: bool,
    /// The data begins at rest [default: in motion, which is estimated]
    #[arg(long)]
    at_rest: bool,
    /// The vehicle's speed in the record (m/s), for the model file: plant_sim and depth_controller ask for it
    #[arg(long, value_name = "SPEED", value_parser = above_zero)]
    speed: Option<f64>,
    /// Write the model: *.json or *.yaml
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write a page: data, comparison, residual tests, poles and zeros, frequency response
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("a number above 0 is expected".to_owned()),
    }
}

/// Reads the data, prints the account and writes the model file; returns what was found.
///
/// # Errors
/// One line: data that cannot be read, a record that determines no model, a file that cannot be written.
pub fn identify(args: &IdentifyArgs) -> Result<(Analysis, Record)> {
    let Taken { record, reading } = args.signals.record()?;
    let options = Options {
        method: args.method,
        order: args.order.map(usize::from),
        delay: args.delay.map(usize::from),
        zeros_at_one: usize::from(args.zeros_at_one),
        integrators: usize::from(args.integrators),
        offset: !args.no_offset,
        start: if args.at_rest {
            Start::Rest
        } else {
            Start::Motion
        },
    };
    let analysis = analyse(&record, &options).map_err(|reason| anyhow!(reason))?;
    print!("{}\n{}", account(&record, &reading), analysis.text());
    if let Some(path) = &args.model {
        let mut file = analysis.file().map_err(|reason| anyhow!(reason))?;
        file.speed = args.speed;
        file.write(path)?;
        println!("{}: the model", path.display());
    }
    Ok((analysis, record))
}

/// Runs the command where no page can be drawn.
///
/// # Errors
/// As [`identify`]; when a page is asked for.
pub fn run(args: &IdentifyArgs) -> Result<()> {
    if args.html.is_some() {
        bail!("--html: pages are drawn by `planesman sysid identify`");
    }
    identify(args).map(drop)
}
