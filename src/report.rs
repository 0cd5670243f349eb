//! `planesman report`: summarises a recorded flight, or compares several.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::arguments::{default_file, page_file};
use crate::run_folder::RunFolder;
use planesman_console::{Format, file_line};
use planesman_flight::sink::write_text;
use planesman_show::pages::flights::{FlightReport, comparison, difference_note, page};

/// Arguments of `report`.
#[derive(Args)]
pub struct ReportArgs {
    /// Folders written by `planesman dive`; several are compared
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// HTML page to write [default: report.html in the folder of one flight, flights.html here for several]
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    html: Option<PathBuf>,
    /// Print all numbers of one flight
    #[arg(long)]
    verbose: bool,
}

/// Prints the summary, and writes the page.
///
/// # Errors
/// A folder or bag that cannot be read, or a page that cannot be written.
pub fn run(args: &ReportArgs) -> Result<()> {
    if let ([folder], None) = (&args.folders[..], &args.html) {
        let run = RunFolder::open(folder)?;
        let file = run.scenario_file().display().to_string();
        return Ok(run.report(run.scenario()?, &file, args.verbose)?.print()?);
    }
    let path = match &args.html {
        Some(path) => path.clone(),
        None => default_file("flights.html")
            .map_err(|reason| anyhow::anyhow!("flights.html: {reason} with --html"))?,
    };
    let mut flights = Vec::new();
    for folder in &args.folders {
        let run = RunFolder::open(folder)?;
        flights.push(run.flown(run.scenario()?)?);
    }
    tell_apart(&mut flights, &args.folders);
    write_text(&path, page(&flights))?;
    planesman_console::print(comparison(&flights).text(Format::Table))?;
    if let Some(note) = difference_note(&flights) {
        planesman_console::out!("\n{note}")?;
    }
    Ok(planesman_console::out!("\n{}", file_line("Page", &path))?)
}

/// Names flights by their full path if their folders' own names are equal.
fn tell_apart(flights: &mut [FlightReport], folders: &[PathBuf]) {
    let names: Vec<String> = flights.iter().map(|it| it.name.clone()).collect();
    for (flown, folder) in flights.iter_mut().zip(folders) {
        if names.iter().filter(|name| **name == flown.name).count() > 1 {
            flown.name = folder.display().to_string();
        }
    }
}
