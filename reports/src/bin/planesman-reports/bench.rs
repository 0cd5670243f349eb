//! `planesman-reports bench`: simulates the 1966 study's tables and compares them with the printed values.

use anyhow::Result;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_console::{Format, print_wrapped};
use planesman_reports::ibm_1966::{self, Surrogate};
use planesman_reports::studies::bench::{COLUMNS, Table, flown, heading};

use planesman::arguments::{choice, format};

/// Arguments of `bench`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BenchArgs {
    /// Simulate only this table; may be repeated [default: all]
    #[arg(long, value_parser = choice(&Table::ALL, Table::described))]
    table: Vec<Table>,
    /// Surrogate of the lost missile
    #[arg(long, value_parser = choice(&[Surrogate::Ps2, Surrogate::Ps1], described), default_value = "ps-2")]
    plant: Surrogate,
    /// Print one table in this format, a row per number [default: the report's tables]
    #[arg(long, value_parser = format())]
    format: Option<Format>,
}

fn described(surrogate: Surrogate) -> (&'static str, &'static str) {
    match surrogate {
        Surrogate::Ps2 => ("ps-2", "No nozzle stop"),
        Surrogate::Ps1 => ("ps-1", "With a nozzle stop"),
    }
}

/// Simulates the requested tables and prints them.
///
/// # Errors
/// A built-in actuator or the book of numbers cannot be read.
pub(crate) fn run(args: &BenchArgs) -> Result<()> {
    let wanted = match args.table.as_slice() {
        [] => &Table::ALL,
        some => some,
    };
    let book = ibm_1966::book()?;
    end_with_reader();
    if args.format.is_none() {
        print_wrapped(heading(args.plant) + "\n")?;
    }
    let flown = on_all_cores("tables", wanted, |table| flown(*table, args.plant, &book));
    let flown = flown.into_iter().collect::<Result<Vec<_>, _>>()?;
    let Some(format) = args.format else {
        for table in flown {
            print_wrapped(table.text + "\n")?;
        }
        return Ok(());
    };
    let mut all = planesman_console::Table::new(COLUMNS);
    for row in flown.into_iter().flat_map(|table| table.numbers) {
        all.row(row);
    }
    Ok(planesman_console::print(all.text(format))?)
}
