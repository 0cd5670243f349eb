//! A report as `planesman reproduce` prints it.

use planesman_plot::Plot;

use crate::{Book, BookError, Names};

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
    pub names: fn() -> anyhow::Result<Names>,
    /// Its numbers, computed again.
    pub recomputed: fn() -> Recomputed,
    /// A procedure of the report, done again, as text; `None` for none.
    pub account: Option<fn() -> anyhow::Result<String>>,
    /// Its lost figures.
    pub figures: fn() -> anyhow::Result<Vec<Chapter>>,
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
