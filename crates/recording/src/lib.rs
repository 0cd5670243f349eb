//! The loop's topics, and which topics a recorder writes into its bag.
//!
//! - [`parameters`]: where to, how compressed, how often flushed, how split, which topics.
//! - [`loop_topics`]: the loop's topics with their types and QoS.
//! - [`selection`]: which of the domain's topics.
//! - [`names`]: a bag's name from the time of day.

pub mod loop_topics;
pub mod names;
pub mod parameters;
pub mod selection;
