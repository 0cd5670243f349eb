//! The node `depth_controller`: [`planesman_control`] over DDS.
//!
//! - `node`: messages, parameters, services and the action between DDS and [`planesman_control::Controller`]; [`main`].
//! - `waiting`: a state that waits for the sensor readings with its stamp.

mod node;
mod waiting;

pub use node::main;
