//! Reasons why equations are invalid, or cannot be fitted.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Reasons why equations are invalid, or cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum EquationsError {
    /// The file is not a valid file of equations.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason, with the line.
        reason: String,
    },
    /// An entry is invalid.
    #[error("{entry}: {reason}")]
    Entry {
        /// The place of the entry: `states: x2: derivative`.
        entry: String,
        /// The reason, and the allowed values.
        reason: String,
    },
    /// The model is not finite at the start of the search.
    #[error(
        "{entry} is not finite {when}, with {at}. Give another start value, or use min to avoid a division by 0"
    )]
    NotFinite {
        /// The equation.
        entry: String,
        /// When.
        when: String,
        /// The values of the variables there.
        at: String,
    },
    /// The simulation stops before the end of the data at the start of the search.
    #[error(
        "the simulation ends at t = {time:.6} s, with {at}: {}",
        if *.stiff {
            "a state changes within 1/10000 of a sampling interval. The equations are stiff, or a state grows without bound. Give start values with longer time constants (and a min that keeps them long), or replace the fast state by its steady-state value"
        } else {
            "a state or an output is no longer finite. Give another start value, or use min to avoid a division by 0"
        }
    )]
    Unfinished {
        /// s
        time: f64,
        /// Whether steps became too short first.
        stiff: bool,
        /// The values of the variables there.
        at: String,
    },
    /// Too little data.
    #[error(
        "{samples} samples of the outputs cannot determine {sought} parameters and initial states. Record more samples, or fix some parameters (fixed: VALUE)"
    )]
    TooFew {
        /// Number of samples of all outputs.
        samples: usize,
        /// Number of parameters and initial states.
        sought: usize,
    },
    /// A constant output.
    #[error("{0} is constant: it determines no parameter")]
    Constant(String),
    /// No parameter has an effect.
    #[error(
        "no parameter changes any output near the start values. Give other start values, or use an input with more variation"
    )]
    NoEffect,
    /// No parameter is to be estimated.
    #[error(
        "parameters: all are fixed, so nothing can be estimated. Give at least one parameter a start value"
    )]
    NothingSought,
    /// The covariance cannot be computed.
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
