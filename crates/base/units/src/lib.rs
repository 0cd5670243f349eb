#![doc = include_str!("../README.md")]
//!
//! - [`Quantity`]: a quantity as a file or the command line writes it.
//! - [`Dimension`]: what a field measures; the units that it accepts.
//! - [`readers!`]: readers of a file's fields, each number in SI and checked by its [`Rule`].
//! - [`Unit`]: a unit's symbol and its size in SI; [`Error`]: why a quantity is rejected.
//! - [`FOOT`], [`INCH`], [`KNOT`], [`POUND_FORCE`], [`FOOT_POUND`], [`SLUG`], [`PSI`], [`DEGREE`]: imperial units and the degree in SI.
//!
//! Imperial values convert here and nowhere else.

mod dimension;
mod quantity;
pub mod read;

pub use dimension::{
    DEGREE, Dimension, FOOT, FOOT_POUND, INCH, KNOT, POUND_FORCE, PSI, SLUG, Unit,
};
pub use quantity::{Error, Quantity, Rule, within};
