//! The printed numbers of IBM 66-L03-005 (1966), computed again.
//!
//! `data/ibm_1966/ibm_1966.json` holds them with their tables and sections, `data/ibm_1966/errata.json` what is wrong with the
//! report or with the scan of it (I), and what the simulation leaves open (D). Ids begin with the table they
//! stand in (`T3-1`, `T4-2`), with `chk` for what follows from printed numbers, or with the surrogate (`PS-1`,
//! `PS-2`) for results of the simulation alone. Where nothing else is said, a flight is that of PS-2.

use crate::book::{Book, BookError, Recomputed};
use crate::ibm_1966::case::Case;
use crate::ibm_1966::missile::Surrogate;

mod actuators;
mod flights;
mod linear;
mod strokes;

/// The report's numbers and its errata.
///
/// # Errors
/// [`BookError`]; a test reads the files that are compiled in.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../../data/ibm_1966/ibm_1966.json"),
        include_str!("../../../data/ibm_1966/errata.json"),
    )
}

/// The numbers as this crate computes them. None, should a built-in actuator not be readable; a test reads them.
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
