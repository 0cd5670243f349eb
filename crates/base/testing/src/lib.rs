//! What the tests of several crates share. Only a dev-dependency: no program contains it.
//!
//! - [`near`]: two numbers within a tolerance.
//! - [`content`]: what a page says, without the scripts that draw it.
//! - [`allocations`]: a run that takes no memory from the heap.
//! - [`mcap`]: MCAP files put together byte by byte, so that they may lie.
//! - [`ulog`], [`dataflash`], [`telemetry`]: logs of PX4, ArduPilot and MAVLink, likewise.
//! - [`hostile`]: bags, schemas, payloads, tables and YAML made to hurt, the same for every layer that reads them, and
//!   [`hostile::mutated`] bytes.

#![allow(clippy::unwrap_used)]

pub mod allocations;
pub mod dataflash;
pub mod hostile;
pub mod mcap;
pub mod telemetry;
pub mod ulog;

/// Checks that a number is within `tolerance` of the expected one.
///
/// # Panics
/// When it is not, or is not a number.
#[track_caller]
pub fn near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} is not within {tolerance} of {expected}"
    );
}

/// What a page of results says: its text and data, without style and without the scripts that draw it.
///
/// # Panics
/// When it is no such page.
#[must_use]
pub fn content(page: &str) -> &str {
    let (_, body) = page.split_once("<body>").unwrap();
    body.split_once("<noscript>").unwrap().0
}
