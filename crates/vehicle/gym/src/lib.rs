//! Environments for reinforcement learning: many vehicles of six degrees of freedom, each with its own task and episode, stepped together.
//!
//! - `options`: the checked options of an environment.
//! - `task`: depth, heading, docking, station: initial state, observations, reward.
//! - `actions`: converts actions in -1 to 1 to the inputs of a vehicle.
//! - `environments`: the episodes, in parallel on all cores.
//!
//! An environment is a function of its options, seed and actions, bit for bit: alone and among any number of others, on any number of
//! cores. The Python package has them as Gymnasium environments (docs/gym.md).

mod actions;
mod environments;
mod options;
mod refused;
mod task;

pub use environments::{Environments, Stepped};
pub use options::Options;
pub use refused::Refused;
pub use task::{Outcome, Quantity, Task};
