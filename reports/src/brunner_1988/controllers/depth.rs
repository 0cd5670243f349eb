//! The depth loop around the pitch loop (Brunner, NPS thesis, 1988, pp. 11 to 20 and 48).
//!
//! With `z' = U theta` for small angles (dive positive), `theta_c = Kpz e + Kdz e'`, `e = z_c - z`,
//! `k = Kpy Ky` and `B = By + Kr Ky`:
//!
//! ```text
//!  z                      k U (Kpz + Kdz s)
//! --- = ------------------------------------------------------
//! z_c    J s^3 + B s^2 + (k + Me + Kdz k U) s + Kpz k U
//! ```
//! With the derivative of the measured depth instead, `theta_c = Kpz e - Kdz z'`, the numerator has no term `Kdz s`, and the poles are the same.
//!
//! Routh: the loop is stable if and only if all coefficients are positive and
//! ```text
//! B (k + Me + Kdz k U) > J Kpz k U
//! ```
//! This gives the bounds below. For `Me = 0` they are `Kpz < B / (J U)` at `Kdz = 0`, printed as `Kpz < 2 / U`, and
//! `Kdz > (J Kpz U / B - 1) / U`.

use planesman_linear::{Complex, ComplexFunctions as _, Error, TransferFunction};

use super::axis::{DampedInertia, Gains};

/// A depth loop at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthDesign {
    /// Pitch dynamics of the vehicle.
    pub axis: DampedInertia,
    /// `Kpy` and `Kr` of the pitch loop.
    pub pitch: Gains,
    /// `U`, ft/s.
    pub speed: f64,
    /// `Kpz`, rad/ft.
    pub p: f64,
    /// `Kdz`, rad s/ft.
    pub d: f64,
}

/// `Kpz` for which a depth error of `error` commands the pitch limit `limit` (rad): rad/ft.
#[must_use]
pub fn p_for_limit(limit: f64, error: f64) -> f64 {
    limit / error
}

impl DepthDesign {
    /// Stiffness `k = Kpy Ky`, ft lbf/rad.
    fn stiffness(&self) -> f64 {
        self.pitch.p * self.axis.plane_moment
    }

    /// Damping `B = By + Kr Ky`, ft lbf s.
    fn damping(&self) -> f64 {
        self.axis.effective_damping(self.pitch.rate)
    }

    /// Characteristic polynomial `J s^3 + B s^2 + (k + Me + Kdz k U) s + Kpz k U`.
    #[must_use]
    pub fn characteristic(&self) -> [f64; 4] {
        let k = self.stiffness();
        [
            self.axis.inertia,
            self.damping(),
            k + self.axis.restoring + self.d * k * self.speed,
            self.p * k * self.speed,
        ]
    }

    /// Routh's criterion: whether all poles have a negative real part.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        let [a0, a1, a2, a3] = self.characteristic();
        [a0, a1, a2, a3].iter().all(|a| *a > 0.0) && a1 * a2 > a0 * a3
    }

    /// Upper stability bound of `Kpz`, rad/ft: `B (k + Me + Kdz k U) / (J k U)`.
    #[must_use]
    pub fn largest_p(&self) -> f64 {
        let [a0, a1, a2, _] = self.characteristic();
        a1 * a2 / (a0 * self.stiffness() * self.speed)
    }

    /// Lower stability bound of `Kdz`, rad s/ft: `(J Kpz U / B - 1 - Me / k) / U`.
    #[must_use]
    pub fn smallest_d(&self) -> f64 {
        let [a0, a1, ..] = self.characteristic();
        let needed = a0 * self.p * self.speed / a1;
        (needed - 1.0 - self.axis.restoring / self.stiffness()) / self.speed
    }

    /// Speed above which the loop is unstable, ft/s: `B (k + Me) / (k (J Kpz - B Kdz))`. `None` if it is stable at every speed.
    #[must_use]
    pub fn critical_speed(&self) -> Option<f64> {
        let [a0, a1, ..] = self.characteristic();
        let k = self.stiffness();
        let excess = a0 * self.p - a1 * self.d;
        (excess > 0.0).then(|| a1 * (k + self.axis.restoring) / (k * excess))
    }

    /// Closed loop `z / z_c` with the derivative of the error.
    ///
    /// # Errors
    /// Those of [`TransferFunction::new`].
    pub fn closed_loop_of_error_rate(&self) -> Result<TransferFunction, Error> {
        let num = [self.d, self.p].map(|gain| gain * self.stiffness() * self.speed);
        TransferFunction::new(num.to_vec(), self.characteristic().to_vec())
    }

    /// Closed loop `z / z_c` with the derivative of the measured depth.
    ///
    /// # Errors
    /// Those of [`TransferFunction::new`].
    pub fn closed_loop(&self) -> Result<TransferFunction, Error> {
        let characteristic = self.characteristic();
        TransferFunction::new(vec![characteristic[3]], characteristic.to_vec())
    }

    /// Damping ratio `-Re s / |s|` of the oscillation: that of the pole pair nearest to the imaginary axis. `None` if all poles are real.
    ///
    /// # Errors
    /// Those of [`TransferFunction::poles`].
    pub fn damping_ratio(&self) -> Result<Option<f64>, Error> {
        let poles = self.closed_loop()?.poles()?;
        let pair = poles.iter().find(|s| s.im != 0.0);
        Ok(pair.map(|s: &Complex<f64>| -s.re / s.modulus()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brunner_1988::controllers::pitch;
    use planesman_control::design::dive_loop::{DiveLoop, DivePlant, Memory, Path};
    use planesman_control::gains::LoopGains;

    fn design() -> DepthDesign {
        DepthDesign {
            axis: DampedInertia {
                restoring: pitch::RESTORING,
                ..pitch::AXIS
            },
            pitch: pitch::GAINS,
            speed: 2.0,
            p: 1.0,
            d: 0.1,
        }
    }

    fn slowest(design: &DepthDesign) -> f64 {
        let poles = design.closed_loop().and_then(|g| g.poles());
        poles.expect("poles")[0].re
    }

    /// Either side of a bound of Routh's the poles lie on either side of the imaginary axis.
    fn straddles(inside: &DepthDesign, outside: &DepthDesign) {
        assert!(inside.is_stable() && slowest(inside) < 0.0);
        assert!(!outside.is_stable() && slowest(outside) > 0.0);
    }

    #[test]
    fn at_each_of_rouths_bounds_a_pole_crosses_the_axis() {
        let at = design();
        let p = |p| DepthDesign { p, ..at };
        straddles(&p(at.largest_p() * 0.999), &p(at.largest_p() * 1.001));
        let d = |d| DepthDesign { d, ..at };
        straddles(&d(at.smallest_d() + 1e-3), &d(at.smallest_d() - 1e-3));
        let speed = |speed| DepthDesign { speed, ..at };
        let critical = at.critical_speed().expect("one");
        straddles(&speed(critical * 0.999), &speed(critical * 1.001));
        assert_eq!(DepthDesign { d: 5.0, ..at }.critical_speed(), None);
    }

    #[test]
    fn it_is_the_controllers_dive_loop_with_ideal_planes() {
        let design = DepthDesign {
            axis: pitch::AXIS,
            speed: 1.0,
            p: 0.25,
            d: 0.6,
            ..design()
        };
        let expected = design.closed_loop().expect("proper");
        let dive = DiveLoop {
            plant: DivePlant::of_pitch(&pitch::model(), 1.0).expect("finite"),
            gains: LoopGains {
                depth_p: 0.25,
                depth_d: 0.6,
                pitch_p: pitch::GAINS.p,
                pitch_rate: pitch::GAINS.rate,
            },
            memory: Memory::default(),
            path: Path::default(),
        };
        let found = dive.closed_loop().expect("proper");
        for point in [Complex::new(0.1, 0.7), Complex::new(-0.3, 2.0)] {
            assert!((expected.value_at(point) - found.value_at(point)).modulus() < 1e-12);
        }
    }
}
