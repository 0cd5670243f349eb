//! An axis of the vehicle as a damped inertia (Brunner, NPS thesis, 1988, ch. II): the plant of the pitch, roll and heading loops.
//!
//! ```text
//! J x'' = K delta - B x' - Me x            x: angle, delta: plane angle
//! delta = Kp (xc - x) - Kd x'              proportional, rate feedback
//!
//!   x               Kp K
//!  --- = -----------------------------     B_eff = B + Kd K
//!   xc    J s^2 + B_eff s + Kp K + Me
//!
//! wn^2 = (Kp K + Me) / J,   2 zeta wn = B_eff / J
//! ```
//! If the rate of the error is fed back instead, `delta = Kp (xc - x) + Kd (xc - x)'`, the numerator is `Kp K + Kd K s` and the poles are the
//! same.

use planesman_linear::{Error, TransferFunction};

/// A damped inertia turned by planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedInertia {
    /// `J`, moment of inertia including added inertia, ft lbf s^2.
    pub inertia: f64,
    /// `B`, damping moment per rate, ft lbf s.
    pub damping: f64,
    /// `K`, moment per plane angle, ft lbf/rad.
    pub plane_moment: f64,
    /// `Me`, restoring moment per angle, ft lbf/rad; 0 if the report omits it.
    pub restoring: f64,
}

/// Gains of a loop around one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// `Kp`, plane angle per angle error.
    pub p: f64,
    /// `Kd`, plane angle per rate, s.
    pub rate: f64,
}

/// `B_eff` for the damping ratio `ratio` of a loop with natural frequency `frequency` (rad/s) around an inertia: `2 zeta wn J`.
#[must_use]
pub fn damping_for_ratio(inertia: f64, frequency: f64, ratio: f64) -> f64 {
    2.0 * ratio * frequency * inertia
}

/// Damping ratio `zeta = B_eff / (2 J wn)`.
#[must_use]
pub fn damping_ratio(inertia: f64, frequency: f64, effective_damping: f64) -> f64 {
    effective_damping / (2.0 * inertia * frequency)
}

impl DampedInertia {
    /// Effective damping `B_eff = B + Kd K`, ft lbf s.
    #[must_use]
    pub fn effective_damping(&self, rate_gain: f64) -> f64 {
        self.damping + rate_gain * self.plane_moment
    }

    /// Rate gain `Kd` for a `B_eff`, s.
    #[must_use]
    pub fn rate_gain_for_damping(&self, effective_damping: f64) -> f64 {
        (effective_damping - self.damping) / self.plane_moment
    }

    /// Natural frequency `wn` for a `Kp`, rad/s.
    #[must_use]
    pub fn natural_frequency(&self, p: f64) -> f64 {
        ((p * self.plane_moment + self.restoring) / self.inertia).sqrt()
    }

    /// Gain `Kp` for a natural frequency (rad/s).
    #[must_use]
    pub fn p_for_frequency(&self, frequency: f64) -> f64 {
        (self.inertia * frequency.powi(2) - self.restoring) / self.plane_moment
    }

    /// Gain `Kp` for a damping ratio with the rate gain `rate_gain`: `wn = B_eff / (2 zeta J)`.
    #[must_use]
    pub fn p_for_damping_ratio(&self, ratio: f64, rate_gain: f64) -> f64 {
        self.p_for_frequency(self.effective_damping(rate_gain) / (2.0 * ratio * self.inertia))
    }

    /// Rate gain `Kd` for a damping ratio with the gain `p`, s.
    #[must_use]
    pub fn rate_gain_for_ratio(&self, ratio: f64, p: f64) -> f64 {
        self.rate_gain_for_damping(damping_for_ratio(
            self.inertia,
            self.natural_frequency(p),
            ratio,
        ))
    }

    /// Damping ratio `zeta`.
    #[must_use]
    pub fn damping_ratio(&self, gains: Gains) -> f64 {
        damping_ratio(
            self.inertia,
            self.natural_frequency(gains.p),
            self.effective_damping(gains.rate),
        )
    }

    /// Settling time of an oscillation by the report's formula, `4 / (zeta wn) = 8 J / B_eff`, s.
    #[must_use]
    pub fn settling_time(&self, rate_gain: f64) -> f64 {
        8.0 * self.inertia / self.effective_damping(rate_gain)
    }

    /// Closed loop `x / xc` with feedback of the angle's rate.
    ///
    /// # Errors
    /// Those of [`TransferFunction::new`].
    pub fn closed_loop(&self, gains: Gains) -> Result<TransferFunction, Error> {
        let k = gains.p * self.plane_moment;
        TransferFunction::new(vec![k], self.characteristic(gains).to_vec())
    }

    /// Closed loop `x / xc` with feedback of the error's rate.
    ///
    /// # Errors
    /// Those of [`TransferFunction::new`].
    pub fn closed_loop_of_error_rate(&self, gains: Gains) -> Result<TransferFunction, Error> {
        let num = [gains.rate, gains.p].map(|gain| gain * self.plane_moment);
        TransferFunction::new(num.to_vec(), self.characteristic(gains).to_vec())
    }

    /// Characteristic polynomial `J s^2 + B_eff s + Kp K + Me`, highest power first.
    #[must_use]
    pub fn characteristic(&self, gains: Gains) -> [f64; 3] {
        [
            self.inertia,
            self.effective_damping(gains.rate),
            gains.p * self.plane_moment + self.restoring,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;

    const AXIS: DampedInertia = DampedInertia {
        inertia: 0.5,
        damping: 0.1,
        plane_moment: 0.2,
        restoring: 0.3,
    };

    #[test]
    fn gains_found_for_a_frequency_and_a_damping_ratio_give_poles_of_that_kind() {
        let p = AXIS.p_for_frequency(1.5);
        let rate = AXIS.rate_gain_for_ratio(0.6, p);
        let poles = AXIS
            .closed_loop(Gains { p, rate })
            .and_then(|g| g.poles())
            .expect("poles");
        for pole in poles {
            assert!((pole.modulus() - 1.5).abs() < 1e-12);
            assert!((pole.re / -1.5 - 0.6).abs() < 1e-12);
        }
        assert!((AXIS.p_for_damping_ratio(0.6, rate) - p).abs() < 1e-12);
    }
}
