//! The tests of the crate from outside, as one program.

#![allow(clippy::unwrap_used)]

mod known_hashes;
mod payloads;
