//! Actuators, vehicles and identified models as Functional Mock-up Units: FMI 3.0, co-simulation.
//!
//! The crate is built twice: as a Rust library that writes FMUs ([`fmu`]), and as a C library that is part of the FMUs and simulates the contents of
//! their `resources`. So a user needs no compiler, and one library runs every exported actuator, vehicle or model.
//!
//! - `export`, `description`, `unit`, `archive`: writing an FMU.
//! - `resources`: the contents of an FMU, read and checked by both libraries.
//! - `subject`: the simulated subjects: `actuator` and `vehicle`, each a `node`, and `model`; `numbers`: the numbers of an actuator's or a
//!   vehicle's file as parameters; `variable`: the table of all variables.
//! - `instance`: a simulation controlled by an importer; `interface`: its C functions, the only unsafe code.

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
