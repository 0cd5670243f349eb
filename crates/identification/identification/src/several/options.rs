//! What is asked of the analysis.

use crate::selection::Kind;
use crate::structure::InitialState;

/// Options of the analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The order of every channel; `None` for each to have its own.
    pub order: Option<usize>,
    /// The delay of every channel, samples; `None` for each to have its own.
    pub delay: Option<usize>,
    /// Output error or Box-Jenkins; `None` for cross-validation to choose.
    pub kind: Option<Kind>,
    /// Seek an offset of the output.
    pub offset: bool,
    /// How each segment begins.
    pub start: InitialState,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            order: None,
            delay: None,
            kind: None,
            offset: true,
            start: InitialState::Estimated,
        }
    }
}
