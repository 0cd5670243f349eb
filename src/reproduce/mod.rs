//! `planesman reproduce`: every number of the 1988 report beside what it comes to.
//!
//! - [`shares`]: which node recomputes which numbers.
//! - [`listing`]: the numbers as text.
//! - [`page`]: the numbers, errata and figures as one HTML page.
//! - [`figures`]: the lost figures B1 to B10, from the report's programs.
//! - [`root_loci`]: the root loci of Figs. 5 to 21.
//! - [`time_responses`]: the depth loop's, Figs. 11 to 16 and C2 to C9.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use planesman_book::Reckoning;

pub mod figures;
pub mod listing;
pub mod page;
pub mod root_loci;
pub mod shares;
pub mod time_responses;

/// What the command takes.
#[derive(Clone, Debug, clap::Args)]
pub struct ReproduceArgs {
    /// Also write the numbers and the redrawn figures as one HTML page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// Prints the book of numbers, and writes the page when one is asked for.
///
/// # Errors
/// When a verdict is not the one that stands in the book, when a number moved away from its reference,
/// or when the page cannot be written.
pub fn run(args: &ReproduceArgs) -> Result<()> {
    let book = shares::book()?;
    let reckoning = Reckoning::of(&book, shares::recomputed());
    print!("{}", listing::text(&book, &reckoning));
    if let Some(path) = &args.html {
        std::fs::write(path, page::page(&book, &reckoning)?)
            .with_context(|| format!("{}", path.display()))?;
        println!("{}: the numbers and the redrawn figures", path.display());
    }
    match reckoning.totals().news {
        0 => Ok(()),
        1 => bail!("1 number is not as it stands in the book"),
        n => bail!("{n} numbers are not as they stand in the book"),
    }
}
