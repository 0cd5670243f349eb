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

/// A result of this crate.
pub(crate) type Result<T> = std::result::Result<T, SourceError>;
