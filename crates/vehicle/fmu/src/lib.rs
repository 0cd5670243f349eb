//! Actuators, vehicles and identified models as Functional Mock-up Units: FMI 3.0, co-simulation.
//!
//! The crate is built twice at once: as a Rust library it writes FMUs ([`fmu`]), as a C library it stands in them and runs what their `resources` hold. So a
//! user needs no compiler, and one library runs every subject.
//!
//! - `export`, `description`, `unit`, `archive`: an FMU written.
//! - `resources`: what an FMU holds, read and checked, on both sides.
//! - `subject`: what is simulated: `actuator` and `vehicle`, each a `node`, and `model`; `numbers`: those of an actuator's or a vehicle's file as parameters;
//!   `variable`: the one table of what can be set and read.
//! - `instance`: a simulation as an importer drives it; `interface`: its C functions, the only unsafe code.

mod actuator;
mod archive;
mod description;
mod error;
mod export;
mod instance;
mod interface;
mod model;
mod node;
mod numbers;
mod resources;
mod subject;
mod unit;
mod variable;
mod vehicle;

pub use error::Error;
pub use export::{Fmu, Options, fmu};
pub use subject::Kind;
