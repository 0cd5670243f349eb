//! Printed numbers of IBM 66-L03-005 (1966), recomputed.
//!
//! `data/ibm_1966/ibm_1966.json` contains the numbers with their tables and sections; `data/ibm_1966/errata.json` contains errors of the report or of
//! its scan (I), and questions that the simulation leaves open (D). Ids begin with their table (`T3-1`, `T4-2`), with `chk` for numbers derived from
//! printed numbers, or with the surrogate (`PS-1`, `PS-2`) for simulation results only. Flights are those of PS-2 unless stated otherwise.

use crate::book::{Book, BookError, Recomputed};
use crate::ibm_1966::case::Case;
use crate::ibm_1966::missile::Surrogate;

mod actuators;
mod flights;
mod linear;
mod strokes;

/// Numbers of the report, with its errata.
///
/// # Errors
/// [`BookError`]; a test reads the compiled-in files.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../../data/ibm_1966/ibm_1966.json"),
        include_str!("../../../data/ibm_1966/errata.json"),
    )
}

/// Numbers recomputed by this crate; empty if a built-in actuator cannot be read, which a test excludes.
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
