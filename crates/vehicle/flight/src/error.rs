//! What is refused, and what breaks off.

use std::io;

use planesman_bag::reader::ReadError;
use planesman_bag::writer::WriteError;
use planesman_parameters::Refusal;
use planesman_text::yaml;

/// Why a part refuses; the flight ends with it.
pub type PartError = Box<dyn std::error::Error + Send + Sync>;

/// A result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a scenario, a flight or a sweep is refused, or breaks off.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A name, a value or a combination of them that is refused, with the rule.
    #[error("{0}")]
    Refused(String),
    /// What was under way; the source says why it was not done.
    #[error("{what}")]
    During {
        /// A file, a node, a vehicle or an argument.
        what: String,
        /// Why not.
        source: PartError,
    },
    /// What a part of the loop refuses, with the node in whose place it is.
    #[error("{node}: {reason}")]
    Part {
        /// `plant_sim`, `depth_controller`, `dha_actuator` or `sysid`.
        node: &'static str,
        /// Why.
        reason: PartError,
    },
    /// A parameter's value that its declaration refuses, or a text that is no parameter file.
    #[error(transparent)]
    Parameter(#[from] Refusal),
    /// A text that is no YAML of the form.
    #[error(transparent)]
    Yaml(#[from] yaml::Error),
    /// A file that cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A file of a sweep that cannot be read or written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A bag that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A bag that cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Numbers of which no step response or model can be made.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
}

/// An [`Error::Refused`] of a format string.
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

/// Says what was under way.
pub trait During<T> {
    /// The error as the source of an [`Error::During`].
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
