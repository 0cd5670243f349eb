//! Records the loop into a rosbag2 bag.
//!
//! - [`parameters`]: where to, how compressed, how often flushed, which topics.
//! - [`loop_topics`]: the loop's topics with their types and QoS.
//! - [`names`]: a bag's name from the time of day.

pub mod loop_topics;
pub mod names;
pub mod node;
pub mod parameters;
