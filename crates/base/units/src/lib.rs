#![doc = include_str!("../README.md")]
//!
//! - [`Quantity`]: a quantity as written in a file or on the command line.
//! - [`Dimension`]: dimension of a field, with the accepted units.
//! - [`readers!`]: readers of a file's fields, each converted to SI and checked by its [`Rule`].
//! - [`Unit`]: symbol of a unit and its size in SI; [`Error`]: why a quantity is refused.
//! - [`FOOT`], [`INCH`], [`KNOT`], [`POUND_FORCE`], [`FOOT_POUND`], [`SLUG`], [`PSI`], [`DEGREE`]: imperial units and the degree in SI.
//!
//! Imperial units are converted only here.

mod dimension;
mod quantity;
pub mod read;

pub use dimension::{
    DEGREE, Dimension, FOOT, FOOT_POUND, INCH, KNOT, POUND_FORCE, PSI, SLUG, Unit,
};
pub use quantity::{Error, Quantity, Rule, within};
