//! Why a plot cannot be drawn.

use thiserror::Error;

/// The largest magnitude drawn: beyond any quantity in any unit, and small enough to compute with.
pub(crate) const LARGEST: f64 = 1e30;

/// Why a plot cannot be drawn.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlotError {
    /// The plot of this title has no point.
    #[error("plot '{0}': there is nothing to draw")]
    Empty(String),
    /// The plot of this title has a number that a page cannot scale.
    #[error("plot '{0}': {1:e} cannot be drawn: it must lie within ±{LARGEST:e}")]
    TooLarge(String, f64),
    /// A heat map's values are not one for each row and column.
    #[error("a heat map needs a number, or none, for each row and column")]
    HeatMapShape,
    /// A heat map has no number.
    #[error("there is nothing to draw")]
    EmptyHeatMap,
}
