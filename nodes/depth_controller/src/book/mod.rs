//! The printed numbers of Brunner 1988 on the controllers, computed again.
//!
//! `data/brunner_1988.json` holds them with their pages. Each part here recomputes its families through
//! this crate's loops and designs; `planesman reproduce` goes through the book with all of them.

use planesman_book::{Book, BookError, brunner_1988 as report};

pub mod design;
pub mod t6;

const ENTRIES: &str = include_str!("../../data/brunner_1988.json");

/// Some of the book's numbers, computed again: name and value, in the entry's unit.
pub type Recomputed = Vec<(&'static str, f64)>;

/// The report's numbers on the controllers, and its errata.
///
/// # Errors
/// [`BookError`]; a test reads the file that is compiled in.
pub fn brunner_1988() -> Result<Book, BookError> {
    report::share(ENTRIES)
}

/// What all parts come to.
#[must_use]
pub fn recomputed() -> Recomputed {
    let mut all = t6::recomputed();
    all.extend(design::recomputed());
    all
}

/// A number that could not be found agrees with nothing.
fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}
