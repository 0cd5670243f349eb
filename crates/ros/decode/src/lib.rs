#![doc = include_str!("../README.md")]
//!
//! A bag's channel contains the definition of its messages as text. From that text ([`schema`]) and the paths of the requested fields
//! ([`path`]), [`Decoder::compile`] makes a small program that walks a payload as far as necessary and reads the numbers. No message type is
//! compiled in.
//!
//! - [`schema`]: reads `ros2msg` and `ros2idl` texts.
//! - [`message_types`]: types by name, if there is no schema; [`standard`]: definitions of ROS's own messages, for bags without them.
//! - [`path`]: `pose.position.x`, `rates[1]`, `position[shoulder]`.
//! - [`decoder`]: compiles paths and reads payloads; roll, pitch and yaw of a quaternion, norm of a vector.
//! - [`difference`]: fields in which two payloads of a type differ.
//! - [`json`]: type of messages that are JSON objects.
//! - [`catalogue`]: all numeric fields of a message type.
//!
//! Internal: `key` names messages, `layout` computes sizes and alignment, `program` walks a payload, `cursor` is a position in it.
//!
//! External data is not trusted: a schema is checked before use, and a wrong length costs no more than the bytes that exist.

pub mod catalogue;
mod cursor;
pub mod decoder;
pub mod difference;
pub mod json;
mod key;
mod layout;
pub mod message_types;
pub mod path;
mod program;
pub mod schema;
mod stamp;
pub mod standard;
mod values;

pub use catalogue::Catalogue;
pub use cursor::DecodeError;
pub use decoder::{CompileError, Decoder};
pub use key::{Name, NameKind, is_called};
pub use path::FieldPath;
pub use schema::Types;
pub use stamp::StampDecoder;
pub use values::Values;
