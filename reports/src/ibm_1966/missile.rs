//! Yaw dynamics of the missile that the actuator steers: a surrogate.
//!
//! ```text
//! psi'' = mu_beta beta + mu_delta delta
//! beta' = psi' - Y_beta beta + Y_delta delta
//! ```
//!
//! The structure is that assumed in the report (IBM 66-L03-005, Section II): a rigid body, short period, small perturbations, no sideslip at rest.
//! The missile is aerodynamically unstable. **The report's own constants are lost.** The constants here are calibrated on a few printed results,
//! listed by [`Surrogate::calibrated_on`]; all other results of the bench are predictions. Only combinations are well determined (K_r mu_delta, K_a
//! times the rate limit), so other surrogates with the same combinations fit equally well.

use std::fmt;

use planesman_linear::{Error, TransferFunction, runge_kutta_step};

use planesman_hydraulics::ActuatorSet;
use planesman_units::{DEGREE, INCH};

/// Constants of the yaw dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YawPlant {
    /// mu_beta, 1/s^2: angular acceleration per sideslip. If positive, the missile is unstable.
    pub sideslip_moment: f64,
    /// mu_delta, 1/s^2: angular acceleration per nozzle angle.
    pub nozzle_moment: f64,
    /// Y_beta, 1/s: decay rate of sideslip by its side force.
    pub sideslip_force: f64,
    /// Y_delta, 1/s: sideslip rate per nozzle angle.
    pub nozzle_force: f64,
}

/// Yaw state of a missile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Yaw {
    /// Yaw angle psi, rad.
    pub angle: f64,
    /// Yaw rate psi', rad/s.
    pub rate: f64,
    /// Sideslip beta, rad: from the velocity to the axis.
    pub sideslip: f64,
}

impl Yaw {
    /// psi, psi' and beta as a state vector.
    pub(crate) fn state(self) -> [f64; 3] {
        [self.angle, self.rate, self.sideslip]
    }

    pub(crate) fn of_state([angle, rate, sideslip]: [f64; 3]) -> Self {
        Self {
            angle,
            rate,
            sideslip,
        }
    }
}

impl YawPlant {
    /// Derivatives of psi, psi' and beta for a `nozzle` angle, rad.
    #[must_use]
    pub fn rates(&self, [_, rate, sideslip]: [f64; 3], nozzle: f64) -> [f64; 3] {
        [
            rate,
            self.sideslip_moment * sideslip + self.nozzle_moment * nozzle,
            rate - self.sideslip_force * sideslip + self.nozzle_force * nozzle,
        ]
    }

    /// State `h` s later, with the nozzle angles, rad, at the beginning, middle and end of the step.
    #[must_use]
    pub fn step(&self, yaw: Yaw, [begin, middle, end]: [f64; 3], h: f64) -> Yaw {
        let nozzles = [&begin, &middle, &end];
        Yaw::of_state(runge_kutta_step(&yaw.state(), h, nozzles, |nozzle, x| {
            self.rates(*x, *nozzle)
        }))
    }

    /// Transfer function P = psi/delta.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn transfer_function(&self) -> Result<TransferFunction, Error> {
        let (mu_d, mu_b) = (self.nozzle_moment, self.sideslip_moment);
        let (y_b, y_d) = (self.sideslip_force, self.nozzle_force);
        TransferFunction::new(
            vec![mu_d, mu_d * y_b + mu_b * y_d],
            vec![1.0, y_b, -mu_b, 0.0],
        )
    }
}

/// A missile with the gains of its autopilot: one of the sets that fit the printed results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Surrogate {
    /// PS-2, the default: no nozzle stop.
    Ps2,
    /// PS-1: a higher attitude gain, and a nozzle stop.
    Ps1,
}

impl Surrogate {
    /// Yaw dynamics.
    #[must_use]
    pub fn plant(self) -> YawPlant {
        let nozzle_moment = match self {
            Self::Ps2 => 3.1,
            Self::Ps1 => 2.25,
        };
        YawPlant {
            sideslip_moment: 14.0,
            nozzle_moment,
            sideslip_force: 0.1,
            nozzle_force: 0.0035 * nozzle_moment,
        }
    }

    /// K_a: nozzle angle per attitude error.
    #[must_use]
    pub fn attitude_gain(self) -> f64 {
        match self {
            Self::Ps2 => 18.0,
            Self::Ps1 => 24.0,
        }
    }

    /// K_r, s: nozzle angle per yaw rate.
    #[must_use]
    pub fn rate_gain(self) -> f64 {
        match self {
            Self::Ps2 => 2.8,
            Self::Ps1 => 3.9,
        }
    }

    /// The actuator with this missile's nozzle stop, as a limit of the ram's oil volume.
    #[must_use]
    pub fn fitted(self, mut set: ActuatorSet) -> ActuatorSet {
        if self == Self::Ps1 {
            set.volume_limit = 3.0 * INCH * INCH * INCH;
        }
        set
    }

    /// omega_a, rad/s: natural frequency of the analog flight control's actuator.
    #[must_use]
    pub fn analog_frequency(self) -> f64 {
        match self {
            Self::Ps2 => 123.96,
            Self::Ps1 => 124.8,
        }
    }

    /// Largest nozzle rate of the analog actuator, rad/s.
    #[must_use]
    pub fn analog_rate_limit(self) -> f64 {
        match self {
            Self::Ps2 => 71.25 * DEGREE,
            Self::Ps1 => 89.5 * DEGREE,
        }
    }

    /// The printed results used for calibration; the others are predictions.
    #[must_use]
    pub fn calibrated_on(self) -> &'static str {
        match self {
            Self::Ps2 => {
                "Table 4-2, base row (10 stable, 11 not; K_g = 4 stable, 5 not): 104 points of a grid of round numbers reproduce this row, and the chosen point reproduces the whole Table 4-2 best; analog actuator: Table 4-3, runs C-13, C-14 and C-15"
            }
            Self::Ps1 => {
                "Table 4-2, base row (10 stable, 11 not; K_g = 4 stable, 5 not), with a nozzle stop; \
                 analog actuator: Table 4-3, run C-13, and the digital actuator's force-limited rate"
            }
        }
    }
}

impl fmt::Display for Surrogate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Ps2 => "PS-2",
            Self::Ps1 => "PS-1",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_alone_the_missile_diverges_with_three_to_four_radians_a_second() {
        // psi/delta has the poles of s (s^2 + Y_beta s - mu_beta).
        let plant = Surrogate::Ps2.plant();
        let pole = -0.05 + (0.05f64.powi(2) + plant.sideslip_moment).sqrt();
        let mut yaw = Yaw {
            angle: 0.0,
            rate: 1e-3 * (pole + plant.sideslip_force),
            sideslip: 1e-3,
        };
        let before = yaw.sideslip;
        for _ in 0..1000 {
            yaw = plant.step(yaw, [0.0; 3], 1e-3);
        }
        assert!((yaw.sideslip / before / libm::exp(pole) - 1.0).abs() < 1e-9);
    }
}
