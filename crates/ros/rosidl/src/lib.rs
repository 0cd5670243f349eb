#![doc = include_str!("../README.md")]
//!
//! | module | what it holds |
//! |---|---|
//! | [`definition`] | messages, services and actions as data |
//! | [`parse`] | their texts, read |
//! | [`library`] | definitions that refer to each other, and the types ROS derives from them |
//! | [`description`] | fields as `type_description_interfaces` describes them |
//! | [`hash`] | the type hash, RIHS01 |
//! | [`schema`] | the `ros2msg` schema text that bags carry, written and read |
//! | [`idl`] | the `ros2idl` schema text, read |
//! | [`rust`] | Rust source for a library |

pub mod definition;
pub mod description;
pub mod error;
pub mod hash;
pub mod idl;
pub mod library;
pub mod parse;
pub mod rust;
pub mod schema;

pub use definition::{Action, Message, Service, TypeName};
pub use description::{FieldDescription, described_fields};
pub use error::{Error, MAX_DEPTH, Rule};
pub use idl::parse_idl_schema;
pub use library::Library;
pub use parse::{parse_action, parse_message, parse_service};
pub use schema::parse_schema;
