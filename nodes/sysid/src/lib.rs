//! The identification node: a discrete transfer function between any two signals, estimated while they arrive.
//!
//! ```text
//! messages -> TopicReader -> Pair: Aligner -> Learner (an estimator) -> Readout -> ModelEstimate
//! ```
//! - [`IdentifierParameters`]: every parameter, its default and unit.
//! - [`Identifier`]: messages in, estimates out, of all pairs. A replayed bag goes through the same.
//! - [`Pair`]: one pair of signals, from its messages to its estimates.
//! - [`TopicReader`]: the signals out of the messages of a topic; their types, compiled in or of the ROS installation.
//! - [`Screen`]: estimates live in the terminal.
//! - [`main`]: the node around it, messages and parameters over DDS.

mod core;
mod error;
mod learner;
mod message_types;
mod node;
mod pair;
mod parameters;
mod reader;
mod screen;
mod sparkline;

pub use crate::core::Identifier;
pub use error::Error;
pub use node::main;
pub use pair::{Account, Change, Due, FIRST, Pair, Scheduled};
pub use parameters::IdentifierParameters;
pub use reader::{Reader, Sample, TopicReader};
pub use screen::{DRAW, Screen, estimate_of};
pub use sparkline::sparkline;
