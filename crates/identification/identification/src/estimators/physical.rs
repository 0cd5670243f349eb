//! The coefficients of the vehicle's equations, estimated from records.

use nalgebra::{DMatrix, DVector};

/// The number of `kappa`, `beta`, `mu`, for which there is no prior knowledge.
pub const UNKNOWNS: usize = planesman_linear::pitch::PITCH;

/// The coefficients' names; the unknown coefficients come first.
pub const NAMES: [&str; 7] = [
    "K/J",
    "B/J",
    "M_theta/J",
    "heave to pitch",
    "heave damping",
    "heave from rate",
    "heave from input",
];

/// Estimated coefficients of the vehicle's equations.
#[derive(Clone, Debug, PartialEq)]
pub struct Physical {
    /// `kappa` (output unit per input unit per s), `beta` (1/s), `mu` (1/s^2), and the estimated coefficients of heave.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
}

impl Physical {
    /// Name, value and standard deviation of each.
    #[must_use]
    pub fn named(&self) -> Vec<(&'static str, f64, f64)> {
        NAMES
            .iter()
            .zip(self.values.iter().enumerate())
            .map(|(name, (i, value))| (*name, *value, self.deviation(i)))
            .collect()
    }

    /// `K`, `B`, `M_theta` for a given moment of inertia (a record determines only ratios): name, value and standard deviation.
    #[must_use]
    pub fn with_inertia(&self, inertia: f64) -> [(&'static str, f64, f64); UNKNOWNS] {
        let scaled = |i: usize| (self.values[i] * inertia, self.deviation(i) * inertia);
        [(0, "K"), (1, "B"), (2, "M_theta")].map(|(i, name)| {
            let (value, deviation) = scaled(i);
            (name, value, deviation)
        })
    }

    fn deviation(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt()
    }
}
