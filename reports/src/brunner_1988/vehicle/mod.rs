//! Recomputed numbers of the vehicle and its instruments.
//!
//! `data/brunner_1988/vehicle.json` contains the printed numbers with their pages. Each module recomputes some families of numbers with the vehicle's
//! models.

mod coefficients;
mod numbers;
mod programs;
mod rounding;
mod sensors;
mod structure;
mod transfer_functions;

pub use numbers::book;

/// All recomputed numbers: name and value, in the entry's unit.
#[must_use]
pub fn recomputed() -> Vec<(&'static str, f64)> {
    [
        coefficients::recomputed(),
        programs::recomputed(),
        sensors::recomputed(),
        transfer_functions::recomputed(),
    ]
    .concat()
}

/// Printed numbers used as constants of the instruments' models.
#[must_use]
pub fn carried() -> Vec<(&'static str, f64)> {
    sensors::carried()
}
