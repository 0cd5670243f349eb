//! The digital hydraulic actuator in the loops of both reports: what `planesman dha` prints.
//!
//! - [`mod@bench`], [`frequency`], [`sizes`]: tables of the 1966 study, frequency responses and sizes, as text.
//! - [`circuit_design`]: designs of a circuit of on/off valves over a load cycle.
//! - [`depth_loop`], [`limit_cycles`]: the thesis' depth loop through the actuator, and its limit cycles.

pub mod bench;
pub mod circuit_design;

pub mod depth_loop;
pub mod frequency;
pub mod limit_cycles;
pub mod sizes;
