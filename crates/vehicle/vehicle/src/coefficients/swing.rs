//! Moments of inertia from a swing test, with their uncertainty (Brunner 1988, pp. 80-83).
//!
//! The vehicle is a pendulum `L` below its pivot that swings with the period `tau`:
//!
//! ```text
//! J0 = W L tau^2 / (4 pi^2)     J = J0 - (W/g) L^2
//! dJ/dtau = W L tau / (2 pi^2)  dJ/dL = W tau^2 / (4 pi^2) - 2 (W/g) L
//! u(J)^2 = (dJ/dtau u(tau))^2 + (dJ/dL u(L))^2
//! ```
//!
//! `J` is the small difference of two large terms. With strings as long as the vehicle, an uncertainty of 0.01 s in the period is a third
//! of `J`, and about the roll axis more than `J`.

use std::f64::consts::{PI, TAU};

/// One swing test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// `W` \[N\].
    pub weight: f64,
    /// `L` \[m\], from the pivot to the centre of mass.
    pub length: f64,
    /// `tau` \[s\].
    pub period: f64,
    /// `g` \[m/s^2\].
    pub gravity: f64,
}

impl Swing {
    /// `J0` \[kg m^2\], about the pivot.
    #[must_use]
    pub fn about_the_pivot(&self) -> f64 {
        self.weight * self.length * (self.period / TAU).powi(2)
    }

    /// `J` \[kg m^2\], about the centre of mass.
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.about_the_pivot() - self.weight / self.gravity * self.length * self.length
    }

    /// `dJ/dtau` \[N m s\].
    #[must_use]
    pub fn per_period(&self) -> f64 {
        self.weight * self.length * self.period / (2.0 * PI * PI)
    }

    /// `dJ/dL` \[kg m\].
    #[must_use]
    pub fn per_length(&self) -> f64 {
        self.weight * (self.period / TAU).powi(2) - 2.0 * self.weight / self.gravity * self.length
    }

    /// `u(J)` \[kg m^2\] from the standard uncertainties of period \[s\] and length \[m\].
    #[must_use]
    pub fn uncertainty(&self, period: f64, length: f64) -> f64 {
        libm::hypot(self.per_period() * period, self.per_length() * length)
    }
}

#[cfg(test)]
mod tests {
    use super::Swing;

    #[test]
    fn a_point_mass_has_no_inertia_about_itself_and_the_slopes_are_the_derivatives() {
        let mut swing = Swing {
            weight: 87.0,
            length: 0.8,
            period: std::f64::consts::TAU * (0.8_f64 / 9.81).sqrt(),
            gravity: 9.81,
        };
        assert!(swing.inertia().abs() < 1e-12);
        let (h, before) = (1e-6, swing.inertia());
        swing.period += h;
        assert!(((swing.inertia() - before) / h - swing.per_period()).abs() < 1e-4);
        swing.period -= h;
        swing.length += h;
        assert!(((swing.inertia() - before) / h - swing.per_length()).abs() < 1e-4);
    }
}
