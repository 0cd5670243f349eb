//! The printed numbers of IBM 66-L03-005 (1966), computed again.
//!
//! `data/ibm_1966.json` holds them with their tables and sections. Each part here recomputes its
//! families through this crate's models; `planesman reproduce` goes through the book with all of
//! them. Ids begin with the table they stand in (`T3-1`, `T4-2`), with `chk` for what follows from
//! printed numbers, or with the surrogate (`PS-1`, `PS-2`) for what only the simulation says. Where
//! nothing else is said, a flight is that of PS-2.

use crate::bench::case::Case;
use crate::bench::missile::Surrogate;
use planesman_book::{Book, BookError, ibm_1966 as report};

pub mod actuators;
pub mod flights;
pub mod linear;
pub mod strokes;

const ENTRIES: &str = include_str!("../../data/ibm_1966.json");

/// Some of the book's numbers, computed again: name and value, in the entry's unit.
pub type Recomputed = Vec<(String, f64)>;

/// The report's numbers and its errata.
///
/// # Errors
/// [`BookError`]; a test reads the file that is compiled in.
pub fn ibm_1966() -> Result<Book, BookError> {
    report::share(ENTRIES)
}

/// What all parts come to. Nothing, should a built-in actuator not be readable; a test reads them.
#[must_use]
pub fn recomputed() -> Recomputed {
    let Ok(mut all) = actuators::recomputed() else {
        return Recomputed::new();
    };
    all.extend(strokes::recomputed().unwrap_or_default());
    all.extend(flights::recomputed().unwrap_or_default());
    if let Ok(case) = Case::table_4_1(Surrogate::Ps2) {
        all.extend(linear::recomputed(&case).unwrap_or_default());
    }
    all
}
