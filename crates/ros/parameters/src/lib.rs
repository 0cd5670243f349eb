#![doc = include_str!("../README.md")]
//!
//! A node's parameters are one struct that derives [`Parameters`]: each field has type, default, unit, range and description. From this struct
//! come the descriptors of the ROS services, the validation of parameter files and scenarios, and the values that the models read.
//!
//! - [`Parameters`], [`Choice`]: traits that a node derives.
//! - [`Declaration`], [`Value`]: a parameter as in ROS.
//! - [`Values`]: a complete, valid set by name, changed completely or not at all.
//! - [`mod@file`]: ROS 2 parameter files (YAML).

// The derive macros name this crate, in its own tests too.
#[cfg(test)]
extern crate self as planesman_parameters;

mod declaration;
pub mod file;
mod parameter_type;
mod refusal;
mod typed;
mod value;
mod values;

pub use declaration::Declaration;
pub use parameter_type::{Choice, ParameterType};
pub use planesman_parameters_derive::{Choice, Parameters};
pub use refusal::Refusal;
pub use typed::{Parameters, dotted};
pub use value::Value;
pub use values::{Values, probably_meant};
