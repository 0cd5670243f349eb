#![doc = include_str!("../README.md")]
//!
//! A bag is a folder `NAME/` with `NAME_0.mcap` (the messages, in chunks) and `metadata.yaml`
//! (what the files hold, written last). The formats are the MCAP specification with its `ros2`
//! profile, and rosbag2's metadata version 9. This crate knows files and payload bytes; of
//! DDS, nodes and vehicles it knows nothing.
//!
//! - [`topic`]: a recorded topic: name, type, schema text, type hash, offered QoS.
//! - [`qos`]: the QoS a publisher offered, in rosbag2's YAML.
//! - [`writer`]: [`BagWriter`], readable up to the last flushed chunk at any moment.
//! - [`reader`]: [`BagReader`], whole bags and cut ones, streamed in bounded memory.
//! - [`metadata`]: the account in `metadata.yaml`.
//! - [`info`]: a summary for people.
//!
//! Inside: `records` splits bytes into MCAP records, `fields` splits records, `chunk` unpacks
//! and checks a chunk, `input` unpacks a file packed whole, `definitions` are a file's topics, `summary` is the index at its end. With them `recording` finds out
//! what one `.mcap` file holds and `walk` reads it front to back; `sqlite` does both of a `.db3` file; `typed` knows the project's message types.
//!
//! Times are signed nanoseconds on whatever clock the recording ran on, as ROS counts them.

mod chunk;
mod defect;
mod definitions;
mod fields;
mod files;
pub mod info;
mod input;
mod limits;
pub mod metadata;
pub mod qos;
mod read_error;
pub mod reader;
mod recording;
mod records;
mod sqlite;
mod summary;
pub mod topic;
mod typed;
mod walk;
pub mod writer;

pub use defect::Defect;
pub use files::is_bag_file;
pub use info::BagInfo;
pub use metadata::BagMetadata;
pub use qos::OfferedQos;
pub use reader::{BagReader, Completeness, Limits, Message, Order, ReadError, sorted_into_bags};
pub use topic::{Topic, TopicKind};
pub use writer::{BagWriter, Compression, Health, TopicId, WriteError, WriterOptions};
