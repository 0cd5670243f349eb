//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod closed_loop;
mod ungridded;
