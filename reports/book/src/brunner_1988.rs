//! G. M. Brunner, *Experimental Verification of AUV Performance*, Naval Postgraduate School, March 1988.
//!
//! Each node holds the numbers of the part of the report that it models. What is wrong with some of them
//! is numbered for the whole report and held here once.

use crate::{Book, BookError};

/// The errors of the report (E) and of its scan (O): text by number, as JSON.
const ERRATA: &str = include_str!("../../brunner_1988/data/errata.json");

/// One share of the report's numbers, a JSON list of [entries](crate::Entry), with the report's errata.
///
/// # Errors
/// Those of [`Book::parse`].
pub fn share(entries: &str) -> Result<Book, BookError> {
    Book::parse(entries, ERRATA)
}
