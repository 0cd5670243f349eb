//! The Munk moment: an ellipsoid at an angle to an ideal flow tends to turn across it (p. 43).
//!
//! For a prolate spheroid with the semi-axes `a` and `b`, with `e^2 = 1 - b^2/a^2` (Lamb, *Hydrodynamics*, art. 114):
//!
//! ```text
//! alpha0 = 2 (1 - e^2) / e^3 (ln((1 + e) / (1 - e)) / 2 - e)
//! beta0  = 1 / e^2 - (1 - e^2) / (2 e^3) ln((1 + e) / (1 - e))
//! k1 = alpha0 / (2 - alpha0)     k2 = beta0 / (2 - beta0)
//! M'w = (k2 - k1) m'
//! ```

use std::f64::consts::PI;

/// Added mass of a spheroid, relative to the mass of displaced water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spheroid {
    /// Added mass along its axis.
    pub k1: f64,
    /// Added mass across its axis.
    pub k2: f64,
}

/// Diameter \[m\] of the circle with the area `section` \[m^2\].
#[must_use]
pub fn equivalent_diameter(section: f64) -> f64 {
    (4.0 * section / PI).sqrt()
}

impl Spheroid {
    /// Coefficients of a spheroid of `length` and `diameter` in the same unit; `None` unless the spheroid is longer than wide.
    #[must_use]
    pub fn new(length: f64, diameter: f64) -> Option<Self> {
        if !(diameter > 0.0 && length > diameter && length.is_finite()) {
            return None;
        }
        let e2 = 1.0 - (diameter / length).powi(2);
        let e = e2.sqrt();
        let log = libm::log((1.0 + e) / (1.0 - e));
        let alpha = 2.0 * (1.0 - e2) / (e2 * e) * (0.5 * log - e);
        let beta = 1.0 / e2 - (1.0 - e2) / (2.0 * e2 * e) * log;
        Some(Self {
            k1: alpha / (2.0 - alpha),
            k2: beta / (2.0 - beta),
        })
    }

    /// `M'w` of the ideal moment, for the nondimensional mass `m'`.
    #[must_use]
    pub fn m_w(&self, mass: f64) -> f64 {
        (self.k2 - self.k1) * mass
    }
}

#[cfg(test)]
mod tests {
    use super::Spheroid;

    #[test]
    fn a_needle_carries_no_water_along_and_its_own_across() {
        let needle = Spheroid::new(1000.0, 1.0).expect("long");
        assert!(needle.k1 < 1e-4 && (needle.k2 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_near_sphere_carries_half_either_way() {
        let ball = Spheroid::new(1.01, 1.0).expect("long");
        assert!((ball.k1 - 0.5).abs() < 0.01 && (ball.k2 - 0.5).abs() < 0.01);
        assert_eq!(Spheroid::new(1.0, 1.0), None);
    }
}
