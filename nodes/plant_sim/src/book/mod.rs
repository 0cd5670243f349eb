//! The printed numbers of Brunner 1988, computed again.
//!
//! `data/brunner_1988.json` holds every number of the vehicle and its instruments with its page. Each
//! part here recomputes its families of numbers through this crate's models; `planesman reproduce`
//! goes through the book with all of them.

use std::sync::LazyLock;

use planesman_book::{Book, BookError, brunner_1988};

pub mod coefficients;
pub mod programs;
pub mod sensors;
pub mod transfer_functions;

const ENTRIES: &str = include_str!("../../data/brunner_1988.json");

/// The book for as long as the program runs, so that values may borrow the entries' names.
static BOOK: LazyLock<Option<Book>> = LazyLock::new(|| brunner_1988().ok());

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

/// The report's numbers of the vehicle and its instruments, and its errata.
///
/// # Errors
/// [`BookError`]; a test reads the files that are compiled in.
pub fn brunner_1988() -> Result<Book, BookError> {
    brunner_1988::share(ENTRIES)
}

/// What all parts come to.
#[must_use]
pub fn recomputed() -> Recomputed {
    PARTS.iter().flat_map(|(_, part)| part()).collect()
}
