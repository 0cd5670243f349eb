//! Why data gives no record.

use std::{io, path::Path};

use planesman_bag::ReadError;
use thiserror::Error;

use crate::resample::GridError;
use crate::signal::SignalError;

/// Why data gives no record, by who can mend it.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The system does not read the file.
    #[error("{path} cannot be read")]
    Unreadable {
        /// The file, as it was named.
        path: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The data is not of its kind, or none of it can be read.
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
    /// The data has no such signal, or the option does not apply to it.
    #[error("{0}")]
    Request(String),
    /// A table that is none.
    #[error(transparent)]
    Table(#[from] csv::Error),
    /// A bag that is none.
    #[error(transparent)]
    Bag(#[from] ReadError),
    /// A signal that is not written as one.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// Its samples make no record.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Its samples make no record, and some could not be read.
    #[error("{0} ({1})")]
    GridOf(GridError, String),
}

impl SourceError {
    /// Of a file that the system does not read.
    pub(crate) fn unreadable(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |source| Self::Unreadable {
            path: path.display().to_string(),
            source,
        }
    }
}

/// The size of a regular file, which is asked for before it is opened: a pipe would be waited for.
///
/// # Errors
/// No file, or none that is regular.
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

/// Names that [`listed`] lists at most.
const LISTED: usize = 20;

/// The first names of many, for an error.
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
