//! The node `dha_actuator`: [`planesman_hydraulics`] over DDS.
//!
//! `node`: messages and parameters between DDS and [`planesman_hydraulics::Actuator`]; [`main`].

mod node;

pub use node::main;
