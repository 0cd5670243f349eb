//! Environments for reinforcement learning: many vehicles of six degrees of freedom, each with a task and an episode of its own, stepped together.
//!
//! - `options`: what an environment is made of, checked.
//! - `task`: depth, heading, docking, station: where an episode begins, what is observed, the reward.
//! - `actions`: from actions in -1 to 1 to the inputs of a vehicle.
//! - `environments`: the episodes, in parts on all cores.
//!
//! An environment is a function of its options, seed and actions, to the last bit: the same alone and among any number of others, on any number of cores.
//! The Python package has them as Gymnasium's (docs/gym.md).

mod actions;
mod environments;
mod options;
mod refused;
mod task;

pub use environments::{Environments, Stepped};
pub use options::Options;
pub use refused::Refused;
pub use task::{Outcome, Quantity, Task};
