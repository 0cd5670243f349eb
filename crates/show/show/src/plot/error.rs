//! The reason why a plot cannot be drawn.

use thiserror::Error;

/// Largest magnitude that can be drawn: beyond any physical quantity, and small enough to compute with.
pub(crate) const LARGEST: f64 = 1e30;

/// The reason why a plot cannot be drawn.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlotError {
    /// The plot of this title has no points.
    #[error("plot '{0}': there is nothing to draw")]
    Empty(String),
    /// The plot of this title contains a number that is too large.
    #[error("plot '{0}': {1:e} cannot be drawn; numbers must be within ±{LARGEST:e}")]
    TooLarge(String, f64),
    /// The values of a heat map do not match its rows and columns.
    #[error("a heat map needs one entry for each row and column")]
    HeatMapShape,
    /// A heat map without any number.
    #[error("there is nothing to draw")]
    EmptyHeatMap,
}
