//! Errors of identification.

use planesman_record::RecordError;
use thiserror::Error;

/// Why there is no model, by who can mend it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum IdentificationError {
    /// A structure or an option without meaning.
    #[error("{0}")]
    Option(String),
    /// A record that is none: lists that do not pair, numbers that are not finite.
    #[error("{0}")]
    Record(String),
    /// There are fewer rows than parameters.
    #[error("{rows} rows cannot determine {parameters} parameters")]
    TooFewRows {
        /// Rows of the regression.
        rows: usize,
        /// Parameters sought.
        parameters: usize,
    },
    /// The rows depend on each other.
    #[error("the record determines {rank} of {parameters} parameters")]
    Rank {
        /// Directions among the parameters that the rows determine.
        rank: usize,
        /// Parameters sought.
        parameters: usize,
    },
    /// The records do not determine the unknowns, in another way.
    #[error("{0}")]
    Undetermined(&'static str),
    /// The coherence holds in no band of frequencies.
    #[error("{0}")]
    NoBand(String),
    /// A search or a filter that settles nowhere.
    #[error("{0}")]
    Search(&'static str),
    /// A model without what was asked of it.
    #[error("{0}")]
    Model(String),
    /// The first of two stages failed.
    #[error("from the reference to the input: {0}")]
    FirstStage(Box<Self>),
}

impl From<planesman_linear::Error> for IdentificationError {
    fn from(error: planesman_linear::Error) -> Self {
        Self::Model(error.to_string())
    }
}

impl From<RecordError> for IdentificationError {
    fn from(error: RecordError) -> Self {
        Self::Record(error.to_string())
    }
}

/// A result of this crate.
pub(crate) type Result<T> = std::result::Result<T, IdentificationError>;
