//! `planesman dha limit-cycles`: limit cycles of the depth loop with the digital hydraulic actuator, predicted
//! and simulated, in one table.

use std::path::PathBuf;

use anyhow::Result;
use planesman_console::Format;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_flight::sink::write_text;
use planesman_studies::depth_loop::cases;
use planesman_studies::limit_cycles::{Row, page, text};

use crate::arguments::output_file;

/// The arguments.
#[derive(Clone, Debug, clap::Args)]
pub struct LimitCyclesArgs {
    /// Only configurations whose name contains this
    pub name: Option<String>,
    /// Without the prediction by harmonic balance, which takes most of the time
    #[arg(long)]
    pub no_prediction: bool,
    /// How to print the table [default: table on a terminal, md elsewhere]
    #[arg(long, value_parser = crate::arguments::format())]
    pub format: Option<Format>,
    /// Also write an HTML page with plots
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    pub html: Option<PathBuf>,
}

/// Prints the table.
///
/// # Errors
/// When no configuration has such a name.
pub fn run(args: &LimitCyclesArgs) -> Result<()> {
    let wanted = args.name.as_deref().unwrap_or_default();
    let mut cases = cases()?;
    cases.retain(|case| case.name.contains(wanted));
    if cases.is_empty() {
        anyhow::bail!(
            "no configuration has '{wanted}' in its name; without a name all are printed"
        );
    }
    if args.html.is_none() {
        end_with_reader();
    }
    let row = |case: &_| Row::of(case, !args.no_prediction);
    let rows = on_all_cores("limit cycles", &cases, row);
    let rows = rows.into_iter().collect::<Result<Vec<_>, _>>()?;
    let format = Format::or_by_output(args.format);
    planesman_console::print(text(&rows, format))?;
    if let Some(file) = &args.html {
        write_text(file, page(&rows))?;
        if matches!(format, Format::Table | Format::Md) {
            planesman_console::out!("{}", file.display())?;
        }
    }
    Ok(())
}
