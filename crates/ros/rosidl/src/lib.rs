#![doc = include_str!("../README.md")]
//!
//! | module | contents |
//! |---|---|
//! | [`definition`] | messages, services and actions as data |
//! | [`parse`] | parsing of their texts |
//! | [`library`] | definitions that use each other, and the types ROS derives from them |
//! | [`description`] | fields in the form of `type_description_interfaces` |
//! | [`hash`] | the type hash, RIHS01 |
//! | [`schema`] | writing and reading of the `ros2msg` schema text of bags |
//! | [`idl`] | reading of the `ros2idl` schema text |
//! | [`rust`] | generation of Rust code |

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
