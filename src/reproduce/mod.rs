//! `planesman reproduce`: every number of the two historical reports, compared with the recomputed value.
//!
//! - [`listing`]: the numbers as text.
//! - [`rows`]: the reports, and their numbers as rows, CSV or JSON, for other programs.

use std::path::PathBuf;

use anyhow::{Result, bail};
use planesman_book::{Line, Reckoning, Verdict};

use crate::arguments::output_file;
use planesman_console::print_wrapped;
use planesman_console::progress::{end_with_reader, spinner};
use planesman_flight::sink::write_text;

pub mod listing;
pub mod rows;

/// The output of `reproduce`.
#[derive(Clone, Debug, clap::Args)]
pub struct ReproduceArgs {
    /// Print every number and the identification step by step, not only the totals and what is contradicted
    #[arg(long)]
    all: bool,
    /// Also write numbers and redrawn figures as one HTML page
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

/// Prints the books of numbers, and writes what is asked for.
///
/// # Errors
/// When a verdict is not the one that stands in the book, when a number moved away from its reference,
/// or when a file cannot be written.
pub fn run(args: &ReproduceArgs) -> Result<()> {
    if !args.writes() {
        end_with_reader();
    }
    let mut page = planesman_pages::book::Page::default();
    let mut all_rows = Vec::new();
    let mut news = 0;
    for (report, values) in rows::REPORTS.iter().zip(rows::recomputed()) {
        let (book, names) = ((report.book)()?, (report.names)()?);
        let reckoning = Reckoning::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
        print_wrapped(format_args!("{}\n", report.citation))?;
        planesman_console::print(listing::totals(&reckoning))?;
        let told = |line: &&Line<'_>| {
            args.all || line.verdict == Some(Verdict::Contradicts) || line.news().is_some()
        };
        planesman_console::out!("{}", listing::text(&book, &reckoning, told)?)?;
        let account = match args.all || args.html.is_some() {
            true => report.account.map(|account| account()).transpose()?,
            false => None,
        };
        if let (true, Some(account)) = (args.all, &account) {
            print_wrapped(format_args!("{account}\n"))?;
        }
        news += reckoning.totals().news;
        all_rows.extend(rows::of(report, &book, &names, &reckoning));
        if args.html.is_some() {
            let _working = spinner("figures");
            page.add(
                report,
                &book,
                &names,
                &reckoning,
                &(report.figures)()?,
                account.as_deref(),
            );
        }
    }
    if !args.all {
        planesman_console::out!("Every number: --all, or --html, --json, --csv FILE.")?;
    }
    if let Some(path) = &args.html {
        write_text(path, page.text())?;
        planesman_console::out!("{}: the numbers and the redrawn figures", path.display())?;
    }
    if let Some(path) = &args.json {
        write_text(path, rows::json(&all_rows)?)?;
        planesman_console::out!("{}: {} numbers", path.display(), all_rows.len())?;
    }
    if let Some(path) = &args.csv {
        write_text(path, rows::csv(&all_rows)?)?;
        planesman_console::out!("{}: {} numbers", path.display(), all_rows.len())?;
    }
    match news {
        0 => Ok(()),
        1 => bail!("1 number differs from the book"),
        n => bail!("{n} numbers are not as they stand in the book"),
    }
}
