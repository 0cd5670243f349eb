//! A discrete transfer function between any two signals, estimated while they arrive.
//!
//! ```text
//! messages -> TopicReader -> Pair: Aligner -> Learner (an estimator) -> Readout -> ModelEstimate
//! ```
//! - [`IdentifierParameters`]: every parameter, its default and unit.
//! - [`Identifier`]: messages in, estimates out, of all pairs. A replayed bag goes through the same.
//! - [`Pair`]: one pair of signals, from its messages to its estimates.
//! - [`replay`]: a bag through the identifier, beside the estimates it holds.
//! - [`TopicReader`]: the signals out of the messages of a topic.

mod core;
mod error;
mod estimate;
mod learner;
pub mod pair;
pub mod parameters;
mod reader;
pub mod replay;

pub use crate::core::Identifier;
pub use error::Error;
pub use estimate::estimate_of;
pub use pair::{Account, Change, DueEstimate, Jump, Pair, Scheduled};
pub use parameters::IdentifierParameters;
pub use reader::{Reader, Sample, TopicReader};
