//! Why there are no equations, or no fit of them.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Why there are no equations, or no fit of them.
#[derive(Debug, thiserror::Error)]
pub enum EquationsError {
    /// A file that is none of equations.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why, with the line.
        reason: String,
    },
    /// An entry that is refused.
    #[error("{entry}: {reason}")]
    Entry {
        /// Where it stands: `states: x2: derivative`.
        entry: String,
        /// Why, and what would be accepted.
        reason: String,
    },
    /// The model is no number where the search begins.
    #[error(
        "{entry} is not finite {when}, with {at}: give another start, or keep away from a division by 0 with min"
    )]
    NotFinite {
        /// The equation.
        entry: String,
        /// When.
        when: String,
        /// The values there.
        at: String,
    },
    /// The simulation does not come to the end of the data where the search begins.
    #[error(
        "the simulation ends at t = {time:.6} s, with {at}: {}",
        if *.stiff {
            "a state changes within 1/10000 of a sampling interval. The equations are stiff, or a state grows without bound: give a start with longer time constants (and a min that keeps them long), or replace the fast state by its steady value"
        } else {
            "a state or an output is no longer finite: give another start, or keep away from a division by 0 with min"
        }
    )]
    Unfinished {
        /// s
        time: f64,
        /// Whether steps became too short before.
        stiff: bool,
        /// The values there.
        at: String,
    },
    /// Too little data.
    #[error(
        "{samples} samples of the outputs cannot determine {sought} parameters and initial states; record more, or fix some: fixed: VALUE"
    )]
    TooFew {
        /// Samples of all outputs.
        samples: usize,
        /// Parameters and initial states.
        sought: usize,
    },
    /// An output that does not move.
    #[error("{0} is constant: it determines nothing")]
    Constant(String),
    /// The parameters do nothing.
    #[error(
        "no parameter changes any output near the start: give another start, or a richer input"
    )]
    NoEffect,
    /// Nothing is sought.
    #[error("parameters: none is to be found; give one a start")]
    NothingSought,
    /// The covariance cannot be found.
    #[error(transparent)]
    Identification(#[from] planesman_identification::IdentificationError),
}

impl EquationsError {
    pub(crate) fn file(path: &Path, reason: impl Display) -> Self {
        Self::File {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }

    pub(crate) fn entry(entry: impl Display, reason: impl Display) -> Self {
        Self::Entry {
            entry: entry.to_string(),
            reason: reason.to_string(),
        }
    }
}
