//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod common;
mod damage;
mod foreign_readers;
mod round_trip;
mod sqlite;
mod typed;
