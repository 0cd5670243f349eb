//! `planesman reproduce`: every number of the two historical reports, compared with the recomputed value.
//!
//! - [`listing`]: the numbers as text.
//! - [`page`]: the numbers, errata and figures as one HTML page.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use planesman_book::{Reckoning, Recomputed, Report};

use crate::arguments::output_file;
use crate::progress::{end_with_reader, on_all_cores, spinner};
use crate::table::print_wrapped;

pub mod listing;
pub mod page;

/// The output of `reproduce`.
#[derive(Clone, Debug, clap::Args)]
pub struct ReproduceArgs {
    /// Also write numbers and redrawn figures as one HTML page
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
}

/// The reports.
pub const REPORTS: [Report; 2] = [brunner_1988::REPORT, ibm_1966::REPORT];

/// The recomputed numbers of each of the [`REPORTS`], by name.
#[must_use]
pub fn recomputed() -> Vec<Recomputed> {
    on_all_cores("reports", &REPORTS, |report| (report.recomputed)())
}

/// Prints the books of numbers, and writes the page when one is asked for.
///
/// # Errors
/// When a verdict is not the one that stands in the book, when a number moved away from its reference,
/// or when the page cannot be written.
pub fn run(args: &ReproduceArgs) -> Result<()> {
    if args.html.is_none() {
        end_with_reader();
    }
    let mut page = page::Page::default();
    let mut news = 0;
    for (report, values) in REPORTS.iter().zip(recomputed()) {
        let book = (report.book)()?;
        let reckoning = Reckoning::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
        print_wrapped(format_args!("{}\n\n", report.citation))?;
        planesman_node::say!("{}", listing::text(&book, &reckoning)?)?;
        let account = report.account.map(|account| account()).transpose()?;
        if let Some(account) = &account {
            print_wrapped(format_args!("{account}\n"))?;
        }
        news += reckoning.totals().news;
        if args.html.is_some() {
            let _working = spinner("figures");
            page.add(report, &book, &reckoning, account.as_deref())?;
        }
    }
    if let Some(path) = &args.html {
        std::fs::write(path, page.text()).with_context(|| format!("{}", path.display()))?;
        planesman_node::say!("{}: the numbers and the redrawn figures", path.display())?;
    }
    match news {
        0 => Ok(()),
        1 => bail!("1 number differs from the book"),
        n => bail!("{n} numbers are not as they stand in the book"),
    }
}
