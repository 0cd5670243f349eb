//! The numbers that a report prints, compared with recomputed ones.
//!
//! - [`entry`]: one quantity: as printed, as recomputed for reference, and what is known of it.
//! - [`verdict`]: whether a recomputed number agrees with the printed one.
//! - [`mod@file`]: all entries of a report and its errata, read from JSON.
//! - [`names`]: plain names of a report's numbers.
//! - [`comparison`]: a book gone through with freshly recomputed numbers.
//! - [`report`]: a report with its numbers and figures; [`rows`]: the numbers as rows, for other programs.
//!
//! Nothing here knows how a number is computed.

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
