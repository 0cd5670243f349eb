//! The digital hydraulic actuator in the loops of both reports: output of `planesman-reports bench`, `frequency` and `limit-cycles`.
//!
//! - [`mod@bench`], [`frequency`]: tables of the 1966 study, and its flight control with sinusoidal inputs, as text.
//! - [`depth_loop`], [`limit_cycles`]: the thesis's depth loop with the actuator, and its limit cycles.
//! - [`orbit`]: periodic orbits by shooting; [`watched`]: kinds of motion of a loop; [`position_loop`]: the actuator alone.

pub mod bench;
pub mod depth_loop;
mod dive;
pub mod frequency;
pub mod limit_cycles;
pub mod orbit;
pub mod position_loop;
pub mod watched;
