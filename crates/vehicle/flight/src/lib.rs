//! Simulates a vehicle in this process: scenario, loop, bag, summary, sweep.
//!
//! - [`Scenario`]: a scenario from a file or a built-in one, checked with the nodes' own checks ([`nodes`]);
//!   [`parameter_file()`](parameter_file::parameter_file) writes it as a parameter file.
//! - [`compose`]: the loop of plant, controller, actuator and identifier, tick by tick. The simulation's messages equal those of the nodes over DDS
//!   bit for bit.
//! - [`parts`]: traits for your own plant, law, actuator or estimator.
//! - [`fly()`]: simulates a scenario into a bag or a CSV file ([`sink`]).
//! - [`flight`], [`summary`]: the results of a flight from its bag.
//! - [`Error`]: refusals and failures.
//! - [`titles`]: display names of quantities and columns.
//! - [`sweep`]: many simulations of a scenario with different parameters and seeds.

pub mod compose;
mod error;
pub mod flight;
mod fly;
pub mod in_order;
pub mod model_summary;
pub mod nodes;
pub mod parameter_file;
pub mod parts;
pub mod scenario;
pub mod sink;
#[cfg(test)]
mod six_degrees;
pub mod summary;
pub mod sweep;
pub mod titles;
pub mod track;

pub use compose::Loop;
pub use error::{During, Error, Result};
pub use fly::{fly, fly_over};
pub use parts::Parts;
pub use scenario::Scenario;
