//! The node `plant_sim`: [`planesman_plant`] over DDS.
//!
//! `node`: messages, parameters and services between DDS and [`planesman_plant::Plant`]; [`main`]. `gates`: foreign topics that end a tick.

mod gates;
mod node;

pub use node::{DONE, main};
