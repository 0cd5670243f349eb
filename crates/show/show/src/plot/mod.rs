//! Plots as data, and the style and script with which a page draws them. The drawing is done in the reader's browser, by uPlot
//! (`uplot/`) and `page/plots.js`; here stands what goes into the page.
//!
//! - [`Plot`], [`Series`], [`Style`]: lines, points, areas over x or in a plane.
//! - [`HeatMap`]: a number over two lists of values.
//! - [`THEME`], [`PAGE`], [`UPLOT_STYLE`]; [`UPLOT`], [`THEME_SCRIPT`], [`PLOTS`]: style and scripts, in the order in which a page
//!   has them.

mod error;
mod heat_map;
mod json;
mod series;

pub use error::PlotError;
pub use heat_map::HeatMap;
pub use series::{Plot, Series, Style};

/// Style: the colours of all pages, light and dark.
pub const THEME: &str = include_str!("../../page/theme.css");
/// Style: pages of results.
pub const PAGE: &str = include_str!("../../page/page.css");
/// Style: that of uPlot.
pub const UPLOT_STYLE: &str = include_str!("../../uplot/uPlot.min.css");
/// Script: uPlot, as a global of this name.
pub const UPLOT: &str = include_str!("../../uplot/uPlot.iife.min.js");
/// Script: the choice of the theme, and its colours for what draws on a canvas.
pub const THEME_SCRIPT: &str = include_str!("../../page/theme.js");
/// Script: draws every `<figure class="plot">` of a page from its data.
pub const PLOTS: &str = include_str!("../../page/plots.js");
