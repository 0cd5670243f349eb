//! Declared, validated parameters with ROS 2's types, apart from any middleware.
//!
//! A node lists its [`Declaration`]s once; the same list gives the ROS parameter
//! services their descriptors, parameter files and scenario files their validation,
//! and the pure models their [`Values`]. Nothing else holds a default.
//!
//! - [`declaration`]: one parameter: name, default, unit, range.
//! - [`value`]: ROS 2's nine parameter types.
//! - [`values`]: a complete, valid set, changed as a whole or not at all.
//! - [`mod@file`]: ROS 2 parameter files (YAML).

pub mod declaration;
pub mod file;
pub mod value;
pub mod values;

pub use declaration::Declaration;
pub use value::Value;
pub use values::{Refusal, Values};
