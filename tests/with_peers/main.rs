//! Foreign peers: Cyclone DDS, rclpy, rosbags, colcon, python-control, FMPy, viewers.

#![allow(clippy::unwrap_used)]

mod colcon_builds_msgs;
mod colcon_builds_planesman;
mod fmu;
#[path = "../foreign/mod.rs"]
mod foreign;
mod foreign_bags;
mod foreign_peers;
mod margins;
mod model_files;
mod own_nodes;
#[path = "../recorded/mod.rs"]
mod recorded;
mod regulator;
mod sensors;
#[path = "../stage/mod.rs"]
mod stage;
mod sysid_foreign_bags;
mod tuned;
mod tutorials;
mod type_hashes;
mod viewers;
