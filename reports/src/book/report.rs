//! A report as `planesman reproduce` prints it.

use std::error::Error;

use planesman_show::plot::Plot;

use crate::book::{Book, BookError, Names};

/// Why a report's numbers or figures are not there.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// Its numbers.
    #[error(transparent)]
    Book(#[from] BookError),
    /// Its names are not JSON of the right form.
    #[error(transparent)]
    Names(#[from] serde_json::Error),
    /// What is computed anew.
    #[error(transparent)]
    Computed(Box<dyn Error + Send + Sync>),
}

impl ReportError {
    /// Of what was computed.
    pub fn computed(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Computed(error.into())
    }
}

/// Recomputed numbers: name and value, in the unit of the book's entry.
pub type Recomputed = Vec<(String, f64)>;

/// A report: its numbers as printed and as recomputed, and its lost figures.
#[derive(Clone, Copy)]
pub struct Report {
    /// Author and year.
    pub name: &'static str,
    /// Author, title, publisher, date.
    pub citation: &'static str,
    /// Its numbers and errata.
    pub book: fn() -> Result<Book, BookError>,
    /// Plain names of its numbers.
    pub names: fn() -> Result<Names, serde_json::Error>,
    /// Its numbers, computed again.
    pub recomputed: fn() -> Recomputed,
    /// A procedure of the report, done again, as text; `None` for none.
    pub procedure: Option<fn() -> Result<String, ReportError>>,
    /// Its lost figures.
    pub figures: fn() -> Result<Vec<Chapter>, ReportError>,
}

/// Figures that belong together.
pub struct Chapter {
    /// The heading.
    pub title: &'static str,
    /// A note on all of them.
    pub note: &'static str,
    /// The figures.
    pub figures: Vec<Plot<'static>>,
}
