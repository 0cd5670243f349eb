// RustDDS 0.15.1 (Apache-2.0, Atostek Oy and its contributors) as published on
// crates.io, with the changes in ../patches applied by ../build.rs. Foreign code, so
// this workspace's lints do not judge it.
#![allow(warnings, clippy::all, clippy::unwrap_used, unsafe_code)]

include!(concat!(env!("OUT_DIR"), "/rustdds/src/lib.rs"));
