//! The node `depth_controller`: [`planesman_control`] over DDS.
//!
//! - `node`: messages, parameters, services and the action between DDS and [`planesman_control::Controller`]; [`main`].
//! - `waiting`: states that wait for the instruments' readings of their stamp.

mod node;
mod waiting;

pub use node::main;
