//! Reference quantities of nondimensional coefficients (Brunner 1988, Table 2, p. 42).
//!
//! ```text
//! m0 = rho L^2 T / 2     F0 = m0 U^2 / L     M0 = F0 L
//! ```

use crate::Vehicle;

/// `m0` \[kg\] for water of density `rho` \[kg/m^3\], the length `l` and the height `t` \[m\] of the hull.
#[must_use]
pub fn reference_mass(rho: f64, l: f64, t: f64) -> f64 {
    0.5 * rho * l * l * t
}

/// The reference quantities of a vehicle at a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// `m0` \[kg\].
    pub mass: f64,
    /// `L` \[m\].
    pub length: f64,
    /// `U` \[m/s\].
    pub speed: f64,
}

impl Reference {
    /// Reference quantities of `vehicle` at `speed` \[m/s\].
    #[must_use]
    pub fn new(vehicle: &Vehicle, speed: f64) -> Self {
        Self {
            mass: vehicle.reference_mass,
            length: vehicle.reference_length,
            speed,
        }
    }

    /// `F0` \[N\], for forces per angle.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.mass * self.speed * self.speed / self.length
    }

    /// `M0` \[N m\], for moments per angle.
    #[must_use]
    pub fn moment(&self) -> f64 {
        self.force() * self.length
    }

    /// `m0 U / L` \[N s/m\], for forces per velocity.
    #[must_use]
    pub fn force_per_velocity(&self) -> f64 {
        self.mass * self.speed / self.length
    }

    /// `m0 U` \[N s\], for moments per velocity and forces per rate.
    #[must_use]
    pub fn impulse(&self) -> f64 {
        self.mass * self.speed
    }

    /// `m0 L U` \[N m s\], for moments per rate.
    #[must_use]
    pub fn moment_per_rate(&self) -> f64 {
        self.impulse() * self.length
    }

    /// `m0 L^2` \[kg m^2\], for moments of inertia.
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.mass * self.length * self.length
    }
}
