//! The report's numbers of the vehicle and its instruments, computed again.
//!
//! `data/vehicle.json` holds them with their pages. Each part recomputes some families of them with the
//! models of the vehicle.

use std::sync::LazyLock;

use planesman_book::{Book, BookError};

mod coefficients;
mod programs;
mod rounding;
mod sensors;
mod structure;
mod transfer_functions;

/// The book for as long as the program runs, so that values may borrow the entries' names.
static BOOK: LazyLock<Option<Book>> = LazyLock::new(|| book().ok());

/// Recomputed numbers: name and value, in the entry's unit.
type Recomputed = Vec<(&'static str, f64)>;

/// The numbers of the vehicle and its instruments, with the report's errata.
///
/// # Errors
/// [`BookError`]; a test reads the files that are compiled in.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../data/vehicle.json"),
        include_str!("../../data/errata.json"),
    )
}

/// All recomputed numbers: name and value, in the entry's unit.
#[must_use]
pub fn recomputed() -> Vec<(&'static str, f64)> {
    [
        coefficients::recomputed(),
        programs::recomputed(),
        sensors::recomputed(),
        transfer_functions::recomputed(),
    ]
    .concat()
}

/// The printed numbers that the instruments' models are made of.
#[must_use]
pub fn carried() -> Vec<(&'static str, f64)> {
    sensors::carried()
}
