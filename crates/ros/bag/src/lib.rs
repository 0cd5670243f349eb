#![doc = include_str!("../README.md")]
//!
//! A bag is a folder `NAME/` with `NAME_0.mcap` (messages in chunks) and `metadata.yaml` (contents of the files, written last). The formats
//! are MCAP with the `ros2` profile, and version 9 of rosbag2's metadata. This crate handles only files and payload bytes; it does not depend on DDS,
//! nodes or vehicles.
//!
//! - [`topic`]: a recorded topic: name, type, schema text, type hash, offered QoS.
//! - [`qos`]: the QoS a publisher offered, in rosbag2's YAML.
//! - [`writer`]: [`BagWriter`]; its file is readable up to the last flushed chunk at any time.
//! - [`reader`]: [`BagReader`] reads complete and truncated bags as streams with bounded memory.
//! - [`metadata`]: contents of `metadata.yaml`.
//! - [`info`]: text summary.
//!
//! Internal: `records` splits bytes into MCAP records, `fields` reads a record's fields, `chunk` unpacks and checks a chunk, `input`
//! decompresses a file compressed as a whole, `definitions` collects a file's topics, `summary` reads the index at its end. With these modules,
//! `recording` finds out the contents of an `.mcap` file and `walk` reads it from front to back; `sqlite` does both for a `.db3` file; `typed` reads
//! and writes this project's message types.
//!
//! Times are signed nanoseconds of the clock used for recording.

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
