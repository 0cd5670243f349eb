//! Records the loop into a rosbag2 bag.
//!
//! - [`parameters`]: where to, how compressed, how often flushed, how split, which topics.
//! - [`loop_topics`]: the loop's topics with their types and QoS.
//! - [`selection`]: which of the domain's topics.
//! - [`ring`]: the latest messages, for snapshots.
//! - [`names`]: a bag's name from the time of day.

pub mod loop_topics;
pub mod names;
pub mod node;
pub mod parameters;
pub mod ring;
pub mod selection;
