//! Errors of identification.

use planesman_record::RecordError;
use thiserror::Error;

/// Reasons why there is no model, grouped by who can fix them.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum IdentificationError {
    /// An invalid structure or option.
    #[error("{0}")]
    Option(String),
    /// An invalid record: lists of different lengths, or non-finite numbers.
    #[error("{0}")]
    Record(String),
    /// There are fewer rows than parameters.
    #[error("{rows} rows of the regression cannot determine {parameters} parameters")]
    TooFewRows {
        /// Rows of the regression.
        rows: usize,
        /// Parameters sought.
        parameters: usize,
    },
    /// The rows are linearly dependent.
    #[error("the record determines only {rank} of {parameters} parameters")]
    Rank {
        /// The number of parameter directions that the rows determine.
        rank: usize,
        /// Parameters sought.
        parameters: usize,
    },
    /// The records do not determine the unknowns, for another reason.
    #[error("{0}")]
    Undetermined(&'static str),
    /// The coherence is too low in every band of frequencies.
    #[error("{0}")]
    NoBand(String),
    /// A search or a filter that does not converge.
    #[error("{0}")]
    Search(&'static str),
    /// A model that lacks a requested property.
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
