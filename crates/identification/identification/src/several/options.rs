//! Options of the analysis.

use crate::selection::Kind;
use crate::structure::InitialState;

/// Options of the analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The order of every channel; `None` to choose each.
    pub order: Option<usize>,
    /// The delay of every channel, samples; `None` to choose each.
    pub delay: Option<usize>,
    /// Output error or Box-Jenkins; `None` for cross-validation to choose.
    pub kind: Option<Kind>,
    /// Whether to estimate an offset of the output.
    pub offset: bool,
    /// The initial state of each segment.
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
