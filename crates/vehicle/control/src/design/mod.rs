//! Design of the dive loops: linear, without limits.
//!
//! - [`dive_loop`]: any vehicle and actuator, sampled or continuous; stability, margins.
//! - [`step`]: the response to a step.
//! - [`placement`]: gains for given poles.
//! - [`optimise`]: gains for a range of speeds.

pub mod dive_loop;
pub mod optimise;
pub mod placement;
pub mod step;
