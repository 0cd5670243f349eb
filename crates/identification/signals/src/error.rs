//! Reasons why data gives no record.

use std::{io, path::Path};

use planesman_bag::ReadError;
use thiserror::Error;

use crate::resample::GridError;
use crate::signal::SignalError;

/// Reasons why data gives no record, grouped by who can fix them.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The operating system cannot read the file.
    #[error("{path} cannot be read")]
    Unreadable {
        /// The given path.
        path: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The data has the wrong format, or cannot be read at all.
    #[error("{0}")]
    Data(String),
    /// The messages of a topic cannot be read.
    #[error("{topic}: {reason}")]
    Topic {
        /// Its name.
        topic: String,
        /// Why.
        reason: String,
    },
    /// The data does not contain the signal, or an option does not apply to the data.
    #[error("{0}")]
    Request(String),
    /// An invalid table.
    #[error(transparent)]
    Table(#[from] csv::Error),
    /// The bag is invalid.
    #[error(transparent)]
    Bag(#[from] ReadError),
    /// An invalid signal name.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// The samples do not form a record.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The samples do not form a record, and some could not be read.
    #[error("{0} ({1})")]
    GridOf(GridError, String),
}

impl SourceError {
    /// The error for a file that the operating system cannot read.
    pub(crate) fn unreadable(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |source| Self::Unreadable {
            path: path.display().to_string(),
            source,
        }
    }
}

/// The size of a regular file, checked before opening it: opening a pipe would wait.
///
/// # Errors
/// If the file does not exist or is not a regular file.
pub(crate) fn size(path: &Path) -> Result<u64> {
    let about = std::fs::metadata(path).map_err(SourceError::unreadable(path))?;
    match about.is_file() {
        true => Ok(about.len()),
        false => Err(SourceError::Data(format!(
            "{} is not a regular file",
            path.display()
        ))),
    }
}

/// Maximum number of names listed by [`listed`].
const LISTED: usize = 20;

/// The first of many names, for an error message.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let first: Vec<&str> = names.by_ref().take(LISTED).collect();
    match names.count() {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// A result of this crate.
pub(crate) type Result<T> = std::result::Result<T, SourceError>;
