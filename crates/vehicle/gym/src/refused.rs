//! Reasons why environments cannot be made.

use planesman_vehicle::six_dof::{FileError, Unphysical};

/// Reasons why environments cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The vehicle cannot be used.
    #[error(transparent)]
    Vehicle(#[from] FileError),
    /// No possible vehicle has such factors.
    #[error("randomise: {0}")]
    Randomise(#[from] Unphysical),
    /// An invalid option.
    #[error("{entry}: {reason}")]
    Option {
        /// The option.
        entry: String,
        /// The error, and the allowed values.
        reason: String,
    },
}

impl Refused {
    pub(crate) fn option(entry: &str, reason: String) -> Self {
        let entry = entry.to_owned();
        Self::Option { entry, reason }
    }
}
