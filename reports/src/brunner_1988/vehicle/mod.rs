//! The report's numbers of the vehicle and its instruments, computed again.
//!
//! `data/brunner_1988/vehicle.json` holds them with their pages. Each part recomputes some families of them with the
//! models of the vehicle.

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

/// The printed numbers that the instruments' models are made of.
#[must_use]
pub fn carried() -> Vec<(&'static str, f64)> {
    sensors::carried()
}
