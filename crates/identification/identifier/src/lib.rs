//! A discrete transfer function between any two signals, estimated while they arrive.
//!
//! ```text
//! messages -> TopicReader -> Pair: Aligner -> Learner (an estimator) -> Readout -> ModelEstimate
//! ```
//! - [`IdentifierParameters`]: every parameter, its default and unit.
//! - [`Identifier`]: messages in, estimates out, for all pairs. A replayed bag is processed in the same way.
//! - [`Pair`]: one pair of signals, from its messages to its estimates.
//! - [`replay`]: a bag processed by the identifier, compared with the estimates in the bag.
//! - [`TopicReader`]: reads the signals from the messages of a topic.

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
