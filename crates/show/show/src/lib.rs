//! Results as text and as self-contained HTML pages, and comparison of recordings.
//!
//! - [`plot`]: plots as data, with the style and scripts of all pages (`page/`) and uPlot (`uplot/`).
//! - [`diff`]: two recordings compared message by message.
//! - [`pages`]: flights, sweeps, models, gains and reviews on pages.
//! - [`design`]: the depth and pitch loops of a vehicle with its actuator, the actuator alone, circuits of on/off valves.

pub mod design;
pub mod diff;
pub mod pages;
pub mod plot;
