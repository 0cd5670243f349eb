//! G. W. Scott, *Digital Hydraulic Actuator Study, Phase III Final Report*, IBM 66-L03-005, November 1966.

use crate::{Book, BookError};

/// What is wrong with the report or with the scan of it (I), and what the simulation leaves open (D):
/// text by number, as JSON.
const ERRATA: &str = include_str!("../../ibm_1966/data/errata.json");

/// The report's numbers, a JSON list of [entries](crate::Entry), with its errata.
///
/// # Errors
/// Those of [`Book::parse`].
pub fn share(entries: &str) -> Result<Book, BookError> {
    Book::parse(entries, ERRATA)
}
