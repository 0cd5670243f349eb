//! `planesman design table`: depth steps simulated with every actuator, feedback and gain source.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use planesman_console::Format;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_flight::sink::write_text;
use planesman_show::design::DepthSteps;

use crate::arguments::{length, page_file, speed, within};

/// Arguments of `design table`.
#[derive(Args)]
pub struct TableArgs {
    /// A built-in vehicle or a vehicle file
    #[arg(default_value = "brunner")]
    vehicle: String,
    /// Speeds (m/s, or with their unit), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.5ft/s,1ft/s,2ft/s,3ft/s", value_parser = speed(0.003, 30.0))]
    speed: Vec<f64>,
    /// Depth steps (m, or with their unit), separated by commas
    #[arg(long, value_delimiter = ',', default_value = "3ft,5ft", value_parser = length(0.003, 300.0))]
    step: Vec<f64>,
    /// Amplitude of the test signal in flights with adaptive gains (deg)
    #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 30.0))]
    signal: f64,
    /// Seed of all noise
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Format of the table [default: table on a terminal, md elsewhere]
    #[arg(long, value_parser = crate::arguments::format())]
    format: Option<Format>,
    /// Also write an HTML page with plots
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    html: Option<PathBuf>,
}

/// Simulates all flights and prints a table.
///
/// # Errors
/// A refused vehicle or parameter, or a flight that breaks off.
pub fn run(args: &TableArgs) -> Result<()> {
    let flights = DepthSteps {
        vehicle: args.vehicle.clone(),
        speeds: args.speed.clone(),
        steps: args.step.clone(),
        signal: args.signal,
        seed: args.seed,
    };
    let choices = flights.choices();
    if args.html.is_none() {
        end_with_reader();
    }
    let outcomes = on_all_cores("flights", &choices, |choice| flights.fly(choice));
    let outcomes = outcomes.into_iter().collect::<Result<Vec<_>, _>>()?;
    let table = flights.table(&choices, &outcomes);
    let format = Format::or_by_output(args.format);
    let is_for_people = matches!(format, Format::Table | Format::Md);
    if is_for_people {
        planesman_console::out!(
            "{}, seed {}; each row is one flight. {}\n",
            args.vehicle,
            args.seed,
            flights.explained()
        )?;
    }
    planesman_console::print(table.text(format))?;
    if let Some(file) = &args.html {
        write_text(file, flights.page(&choices, &outcomes, &table))?;
        if is_for_people {
            planesman_console::out!("\n{}", planesman_console::file_line("Page", file))?;
        }
    }
    Ok(())
}
