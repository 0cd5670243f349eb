//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod specific_force;
mod urdf;
