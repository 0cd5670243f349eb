//! `planesman-reports reproduce`: compares every number of the two historical reports, and of Hopsan's recorded validations, with the recomputed value.
//!
//! - [`listing`]: text output; [`page`]: HTML page.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use planesman_reports::book::rows::{self, Row};
use planesman_reports::book::{Comparison, Line, Report, Verdict};
use planesman_reports::{brunner_1988, hopsan, ibm_1966};

use planesman::arguments::output_file;
use planesman_console::print_wrapped;
use planesman_console::progress::{end_with_reader, on_all_cores, spinner};
use planesman_flight::sink::write_text;

mod listing;
mod page;

/// The reports.
const REPORTS: [Report; 3] = [brunner_1988::REPORT, ibm_1966::REPORT, hopsan::REPORT];

/// Arguments of `reproduce`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ReproduceArgs {
    /// Print every number, and the identification step by step, not only totals and contradictions
    #[arg(long)]
    all: bool,
    /// Also write an HTML page with the numbers and redrawn figures
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
    /// Also write the numbers as JSON
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    json: Option<PathBuf>,
    /// Also write the numbers as CSV
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    csv: Option<PathBuf>,
}

impl ReproduceArgs {
    fn writes(&self) -> bool {
        [&self.html, &self.json, &self.csv]
            .iter()
            .any(|it| it.is_some())
    }
}

/// Prints the numbers, and writes the requested files.
///
/// # Errors
/// A verdict differs from the book's, a number differs from its reference, or a file cannot be written.
pub(crate) fn run(args: &ReproduceArgs) -> Result<()> {
    if !args.writes() {
        end_with_reader();
    }
    let mut page = page::Page::default();
    let mut all_rows = Vec::new();
    let mut changes = 0;
    let recomputed = on_all_cores("reports", &REPORTS, |report| (report.recomputed)());
    for (report, values) in REPORTS.iter().zip(recomputed) {
        let (book, names) = ((report.book)()?, (report.names)()?);
        let comparison = Comparison::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
        print_wrapped(format_args!("{}\n", report.citation))?;
        planesman_console::print(listing::totals(&comparison))?;
        let told = |line: &&Line<'_>| {
            args.all || line.verdict == Some(Verdict::Contradicts) || line.change().is_some()
        };
        planesman_console::out!("{}", listing::text(&book, &comparison, told)?)?;
        let procedure = match args.all || args.html.is_some() {
            true => report.procedure.map(|text| text()).transpose()?,
            false => None,
        };
        if let (true, Some(procedure)) = (args.all, &procedure) {
            print_wrapped(format_args!("{procedure}\n"))?;
        }
        changes += comparison.changes().len();
        all_rows.extend(rows::of(report, &book, &names, &comparison));
        if args.html.is_some() {
            let _working = spinner("figures");
            page.add(
                report,
                &book,
                &names,
                &comparison,
                &(report.figures)()?,
                procedure.as_deref(),
            );
        }
    }
    if !args.all {
        planesman_console::out!("To see every number add --all, or --html, --json, --csv FILE.")?;
    }
    if let Some(path) = &args.html {
        write_text(path, page.text())?;
        planesman_console::out!("{}", planesman_console::file_line("Page", path))?;
    }
    if let Some(path) = &args.json {
        write_text(path, json(&all_rows)?)?;
        planesman_console::out!("{}", planesman_console::file_line("Numbers", path))?;
    }
    if let Some(path) = &args.csv {
        write_text(path, csv(&all_rows)?)?;
        planesman_console::out!("{}", planesman_console::file_line("Table", path))?;
    }
    match changes {
        0 => Ok(()),
        1 => bail!("1 number differs from the book"),
        n => bail!("{n} numbers differ from the book"),
    }
}

/// The rows as a JSON list of objects.
///
/// # Errors
/// None in practice: the text is written to memory.
fn json(rows: &[Row]) -> Result<String> {
    Ok(serde_json::to_string_pretty(rows)? + "\n")
}

/// The rows as CSV with a header row.
///
/// # Errors
/// None in practice: the text is written to memory.
fn csv(rows: &[Row]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().ok().context("a table in memory")?;
    Ok(String::from_utf8(bytes)?)
}
