//! Plots as data, with the style and scripts that draw them. The reader's browser draws them with uPlot (`uplot/`) and `page/plots.js`; this
//! module makes their data.
//!
//! - [`Plot`], [`Series`], [`Style`]: lines, points, areas over x or in a plane.
//! - [`HeatMap`]: a number over two lists of values.
//! - [`THEME`], [`PAGE`], [`UPLOT_STYLE`]; [`UPLOT`], [`THEME_SCRIPT`], [`PLOTS`]: style and scripts, in the order of a page.

mod error;
mod heat_map;
mod json;
mod series;

pub use error::PlotError;
pub use heat_map::HeatMap;
pub use series::{Plot, Series, Style};

/// Style: the colours of all pages, light and dark.
pub const THEME: &str = include_str!("../../page/theme.css");
/// Style of pages of results.
pub const PAGE: &str = include_str!("../../page/page.css");
/// Style of uPlot.
pub const UPLOT_STYLE: &str = include_str!("../../uplot/uPlot.min.css");
/// Script of uPlot, which defines a global of this name.
pub const UPLOT: &str = include_str!("../../uplot/uPlot.iife.min.js");
/// Script that chooses the theme and gives its colours to canvases.
pub const THEME_SCRIPT: &str = include_str!("../../page/theme.js");
/// Script that draws every `<figure class="plot">` of a page from its data.
pub const PLOTS: &str = include_str!("../../page/plots.js");
