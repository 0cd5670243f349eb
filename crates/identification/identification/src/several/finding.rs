//! Reasons for and against a model of several inputs: findings as for one input, with the input's name.

use std::fmt;

use crate::analysis::Reason;

/// A finding, about one input if applicable.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The input's name.
    pub input: Option<String>,
    /// The finding.
    pub reason: Reason,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.input {
            Some(name) => write!(f, "{name}: {}", self.reason),
            None => self.reason.fmt(f),
        }
    }
}

impl From<Reason> for Finding {
    fn from(reason: Reason) -> Self {
        Self {
            input: None,
            reason,
        }
    }
}
