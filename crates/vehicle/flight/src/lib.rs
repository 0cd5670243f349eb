//! Flies a vehicle in this process: scenario, loop, bag, summary, sweep.
//!
//! - [`Scenario`]: what is flown, from a file or a built-in one, checked as the nodes check it ([`nodes`]); as a parameter file ([`parameter_file()`](parameter_file::parameter_file)).
//! - [`compose`]: the loop of plant, controller, actuator and identifier, tick by tick. Its messages equal those of the nodes over DDS
//!   bit for bit.
//! - [`parts`]: a plant, law, actuator or estimator of one's own in their places.
//! - [`fly()`]: a scenario flown into a bag or a CSV file ([`sink`]).
//! - [`flight`], [`summary`]: what happened, from a bag.
//! - [`Error`]: what is refused, and what breaks off.
//! - [`titles`]: the names of quantities and columns for people.
//! - [`sweep`]: a scenario flown many times, with other parameters and seeds.

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
