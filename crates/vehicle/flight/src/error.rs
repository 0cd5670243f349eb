//! Errors of scenarios, flights and sweeps.

use std::io;

use planesman_bag::reader::ReadError;
use planesman_bag::writer::WriteError;
use planesman_parameters::Refusal;
use planesman_text::yaml;

/// Refusal by a part; it ends the flight.
pub type PartError = Box<dyn std::error::Error + Send + Sync>;

/// A result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Error of a scenario, a flight or a sweep.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A refused name, value or combination, with the rule.
    #[error("{0}")]
    Refused(String),
    /// An operation that failed; the source gives the reason.
    #[error("{what}")]
    During {
        /// The file, node, vehicle or argument concerned.
        what: String,
        /// The reason.
        source: PartError,
    },
    /// Refusal by a part of the loop, with the name of its node.
    #[error("{node}: {reason}")]
    Part {
        /// `plant_sim`, `depth_controller`, `dha_actuator` or `sysid`.
        node: &'static str,
        /// Why.
        reason: PartError,
    },
    /// A parameter's value is refused, or a text is not a parameter file.
    #[error(transparent)]
    Parameter(#[from] Refusal),
    /// A text is not valid YAML, or not of the expected form.
    #[error(transparent)]
    Yaml(#[from] yaml::Error),
    /// A file cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A file of a sweep cannot be read or written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A bag cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A bag cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// No step response or model can be computed from the numbers.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
}

/// Returns an [`Error::Refused`] from a format string.
macro_rules! refused {
    ($($text:tt)*) => {
        $crate::Error::Refused(format!($($text)*))
    };
}

/// Returns [`refused!`].
macro_rules! refuse {
    ($($text:tt)*) => {
        return Err($crate::error::refused!($($text)*))
    };
}

pub(crate) use {refuse, refused};

/// Adds the operation that failed to an error.
pub trait During<T> {
    /// Wraps the error as the source of an [`Error::During`].
    ///
    /// # Errors
    /// That one.
    fn during<S: Into<String>>(self, what: impl FnOnce() -> S) -> Result<T>;
}

impl<T, E: Into<PartError>> During<T> for Result<T, E> {
    fn during<S: Into<String>>(self, what: impl FnOnce() -> S) -> Result<T> {
        self.map_err(|source| Error::During {
            what: what().into(),
            source: source.into(),
        })
    }
}
