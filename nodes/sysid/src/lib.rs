//! The node `sysid`: [`planesman_identifier`] over DDS.
//!
//! `node`: messages, parameters and services between DDS and [`planesman_identifier::Identifier`]; [`main`].

mod node;

pub use node::main;
