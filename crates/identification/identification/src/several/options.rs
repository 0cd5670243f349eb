//! Options of the analysis.

use crate::selection::Kind;
use crate::structure::InitialState;

/// Options of the analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The order of every channel; with `None` each order is chosen.
    pub order: Option<usize>,
    /// The delay of every channel, samples; with `None` each delay is chosen.
    pub delay: Option<usize>,
    /// Output error or Box-Jenkins; with `None` cross-validation chooses.
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
