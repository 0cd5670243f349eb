//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod actuator;
mod common;
mod derived_values;
mod faults;
mod invariants;
mod logic_invariants;
mod open_loop_traces;
