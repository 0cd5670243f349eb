//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod analysis;
#[allow(dead_code)] // The unit tests have it too, and use all.
mod common;
mod nonlinearity;
mod process;
mod recursion;
mod selection;
mod step_response;
