//! Why environments were not made.

use planesman_vehicle::six_dof::{FileError, Unphysical};

/// Why environments were not made.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The vehicle was not taken.
    #[error(transparent)]
    Vehicle(#[from] FileError),
    /// No vehicle has such factors.
    #[error("randomise: {0}")]
    Randomise(#[from] Unphysical),
    /// An option breaks a rule.
    #[error("{entry}: {reason}")]
    Option {
        /// The option.
        entry: String,
        /// What was wrong, and what is expected.
        reason: String,
    },
}

impl Refused {
    pub(crate) fn option(entry: &str, reason: String) -> Self {
        let entry = entry.to_owned();
        Self::Option { entry, reason }
    }
}
