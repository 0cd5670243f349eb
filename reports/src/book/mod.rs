//! Compares the printed numbers of a report with recomputed ones.
//!
//! - [`entry`]: a quantity with its printed and recomputed values.
//! - [`verdict`]: agreement of a recomputed number with the printed one.
//! - [`mod@file`]: all entries of a report with its errata, read from JSON.
//! - [`names`]: plain names for a report's numbers.
//! - [`comparison`]: comparison of a book with newly recomputed numbers.
//! - [`report`]: a report with numbers and figures; [`rows`]: the numbers as rows, for other programs.
//!
//! This module does not compute any of the numbers.

pub mod comparison;
pub mod entry;
pub mod file;
pub mod names;
pub mod report;
pub mod rows;
pub mod verdict;

pub use comparison::{Comparison, Line, VERDICTS};
pub use entry::Entry;
pub use file::{Book, BookError};
pub use names::Names;
pub use report::{Chapter, Recomputed, Report, ReportError};
pub use verdict::Verdict;
