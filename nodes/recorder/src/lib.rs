//! The node `recorder`: topics over DDS into a rosbag2 bag.
//!
//! - [`node`]: messages, parameters and services between DDS and the bag's writer.
//! - [`ring`]: the latest messages, for snapshots.

pub mod node;
pub mod ring;
