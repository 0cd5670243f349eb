//! The printed numbers of Brunner 1988, computed again.
//!
//! `data/brunner_1988.json` holds every number with its page, `data/brunner_1988_errata.json` what is
//! wrong with some of them. Each part here recomputes its families of numbers through this crate's
//! models; `planesman reproduce` goes through the book with all of them.

use planesman_book::{Book, BookError};

pub mod coefficients;
pub mod programs;
pub mod sensors;
pub mod transfer_functions;

const ENTRIES: &str = include_str!("../../data/brunner_1988.json");
const ERRATA: &str = include_str!("../../data/brunner_1988_errata.json");

/// Some of the book's numbers, computed again: name and value, in the entry's unit.
pub type Recomputed = Vec<(&'static str, f64)>;

/// A part by its name, and what recomputes it.
pub type Part = (&'static str, fn() -> Recomputed);

/// Every part.
pub const PARTS: &[Part] = &[
    ("coefficients", coefficients::recomputed),
    ("programs", programs::recomputed),
    ("sensors", sensors::recomputed),
    ("transfer_functions", transfer_functions::recomputed),
];

/// The report's numbers and errata.
///
/// # Errors
/// [`BookError`]; a test reads the files that are compiled in.
pub fn brunner_1988() -> Result<Book, BookError> {
    Book::parse(ENTRIES, ERRATA)
}

/// What all parts come to.
#[must_use]
pub fn recomputed() -> Recomputed {
    PARTS.iter().flat_map(|(_, part)| part()).collect()
}
