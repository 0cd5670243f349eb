//! The node `plant_sim`: [`planesman_plant`] over DDS.
//!
//! `node`: messages, parameters and services between DDS and [`planesman_plant::Plant`]; [`main`].

mod node;

pub use node::{DONE, main};
