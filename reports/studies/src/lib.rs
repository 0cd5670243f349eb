//! The digital hydraulic actuator in the loops of both reports: what `planesman dha` prints.
//!
//! - [`mod@bench`], [`frequency`], [`sizes`]: tables of the 1966 study, frequency responses and sizes, as text.
//! - [`circuit_design`]: designs of a circuit of on/off valves over a load cycle.
//! - [`depth_loop`], [`limit_cycles`]: the thesis' depth loop through the actuator, and its limit cycles.
//! - [`orbit`]: periodic orbits by shooting; [`watched`]: what a loop's motion is; [`branches`]: orbits from other places of the ram,
//!   and over a parameter; [`position_loop`], [`missile_loop`]: the actuator alone and in the 1966 missile.

pub mod bench;
pub mod branches;
pub mod circuit_design;
pub mod depth_loop;
mod dive;
pub mod frequency;
pub mod limit_cycles;
pub mod missile_loop;
pub mod orbit;
pub mod position_loop;
pub mod sizes;
pub mod watched;
