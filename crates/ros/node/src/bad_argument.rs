//! Error for an invalid argument.

/// An invalid argument, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{argument}': {reason}")]
pub struct BadArgument {
    /// The argument, or the name in the argument.
    pub argument: String,
    /// The reason.
    pub reason: String,
}

impl BadArgument {
    pub(crate) fn new(argument: &str, reason: &str) -> Self {
        Self {
            argument: argument.to_owned(),
            reason: reason.to_owned(),
        }
    }
}
