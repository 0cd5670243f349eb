//! The node `recorder`: records topics from DDS into a rosbag2 bag.
//!
//! - [`node`]: messages, parameters and services between DDS and the bag's writer.
//! - [`ring`]: the latest messages in memory, for snapshots.

pub mod node;
pub mod ring;
