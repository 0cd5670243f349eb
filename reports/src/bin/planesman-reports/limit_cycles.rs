//! `planesman-reports limit-cycles`: table of limit cycles of the depth loop with the digital hydraulic actuator: simulated, as orbits found by
//! shooting, and predicted by harmonic balance.

use std::path::PathBuf;

use anyhow::Result;
use planesman_console::Format;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_flight::sink::write_text;
use planesman_reports::studies::depth_loop::{Case, cases};
use planesman_reports::studies::limit_cycles::{Row, page, text};
use planesman_reports::studies::position_loop;

use planesman::arguments::{format, output_file};

/// Arguments of `limit-cycles`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct LimitCyclesArgs {
    /// Only configurations whose name contains this text
    name: Option<String>,
    /// Omit the prediction by harmonic balance, which takes a third of the time
    #[arg(long)]
    no_prediction: bool,
    /// Format of the table [default: table on a terminal, md elsewhere]
    #[arg(long, value_parser = format())]
    format: Option<Format>,
    /// Also write an HTML page with plots
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
}

/// Prints the table.
///
/// # Errors
/// No configuration has such a name.
pub(crate) fn run(args: &LimitCyclesArgs) -> Result<()> {
    let wanted = args.name.as_deref().unwrap_or_default();
    let mut cases = cases()?;
    cases.retain(|case| case.name.contains(wanted));
    if cases.is_empty() {
        anyhow::bail!(
            "no configuration has '{wanted}' in its name; leave out the name to print all"
        );
    }
    if args.html.is_none() {
        end_with_reader();
    }
    let format = Format::or_by_output(args.format);
    let groups: Vec<_> = cases.chunk_by(Case::same_actuator).collect();
    let rows = on_all_cores("limit cycles", &groups, |group| {
        Row::of(group, !args.no_prediction)
    });
    let rows = rows.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
    planesman_console::print(text(&rows, format))?;
    if wanted.is_empty() && matches!(format, Format::Table | Format::Md) {
        let alone = position_loop::text(&position_loop::rows()?, format);
        planesman_console::print(format!("\n{alone}"))?;
    }
    if let Some(file) = &args.html {
        write_text(file, page(&rows))?;
        if matches!(format, Format::Table | Format::Md) {
            planesman_console::out!("{}", planesman_console::file_line("Page", file))?;
        }
    }
    Ok(())
}
