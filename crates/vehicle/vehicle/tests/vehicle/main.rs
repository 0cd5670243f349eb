//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod dynamics_properties;
mod identified;
mod remus_100;
mod six_dof;
