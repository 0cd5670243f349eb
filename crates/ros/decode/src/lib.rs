#![doc = include_str!("../README.md")]
//!
//! A bag's channel holds the definition of its messages as text. From that text ([`schema`])
//! and the paths of the fields one wants ([`path`]), [`Decoder::compile`] makes a small program
//! that walks a payload just as far as it must and picks the numbers out; no message type is
//! compiled in.
//!
//! - [`schema`]: `ros2msg` and `ros2idl` texts, read.
//! - [`message_types`]: types by name, where no schema comes with them; [`standard`]: the definitions of ROS' own messages, for bags that hold none.
//! - [`path`]: `pose.position.x`, `rates[1]`, `position[shoulder]`.
//! - [`decoder`]: paths compiled, payloads read; roll, pitch and yaw of a quaternion, norm of a vector.
//! - [`difference`]: the fields in which two payloads of a type differ.
//! - [`json`]: the type of messages that are JSON objects.
//! - [`catalogue`]: every number a message type holds.
//!
//! Inside: `key` knows what a message is called, `layout` knows sizes and alignment, `program` what to do with a payload, `cursor` where one is in it.
//!
//! Nothing that comes from outside is believed: a schema is checked before use, a length costs no
//! more than the bytes that are there.

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
