//! A report for `planesman reproduce`.

use std::error::Error;

use planesman_show::plot::Plot;

use crate::book::{Book, BookError, Names};

/// The reason why a report's numbers or figures are not available.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// An error in its numbers.
    #[error(transparent)]
    Book(#[from] BookError),
    /// The names are not JSON of the expected form.
    #[error(transparent)]
    Names(#[from] serde_json::Error),
    /// An error of a computation.
    #[error(transparent)]
    Computed(Box<dyn Error + Send + Sync>),
}

impl ReportError {
    /// An error of a computation.
    pub fn computed(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Computed(error.into())
    }
}

/// Recomputed numbers: name and value in the unit of the book's entry.
pub type Recomputed = Vec<(String, f64)>;

/// A report: printed and recomputed numbers, and figures.
#[derive(Clone, Copy)]
pub struct Report {
    /// Author and year.
    pub name: &'static str,
    /// Author, title, publisher, date.
    pub citation: &'static str,
    /// Printed numbers and errata.
    pub book: fn() -> Result<Book, BookError>,
    /// Plain names of its numbers.
    pub names: fn() -> Result<Names, serde_json::Error>,
    /// Recomputed numbers.
    pub recomputed: fn() -> Recomputed,
    /// A procedure of the report carried out again, as text.
    pub procedure: Option<fn() -> Result<String, ReportError>>,
    /// Figures that are missing in the copy.
    pub figures: fn() -> Result<Vec<Chapter>, ReportError>,
}

/// A group of figures.
pub struct Chapter {
    /// The heading.
    pub title: &'static str,
    /// Note on all figures of the chapter.
    pub note: &'static str,
    /// The figures.
    pub figures: Vec<Plot<'static>>,
}
