//! The depth law, the outer loop: depth PD to a pitch command (Brunner, NPS thesis, 1988,
//! program T6, App. C).
//!
//! The program's pitch T is dive-positive:
//! ```text
//! EZ = ZC - z                     depth error
//! TC = Kpz EZ + Kdz dEZ/dt        dive angle asked for
//! ```
//! Here pitch is bow-up positive, so the command is the dive angle with its sign changed:
//! ```text
//! e_z     = z_c - z
//! theta_c = -(Kpz e_z + Kdz de_z/dt),   |theta_c| <= pitch limit
//! ```
//! The derivative acts on the measured depth, `de_z/dt = -dz/dt`: the program's `DERIV(0, EZ)` starts at zero after the step, so a step of
//! the setpoint causes no impulse. (With the impulse the 5 ft step overshoots by 3.9 %; the thesis reports no overshoot.) [`crate::autopilot`]
//! computes the derivative of the error, the filter and the integral, and passes them as `rate` and `i`.

use crate::limits::{Limit, Limited, bounded};

/// Depth PD with its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthLoop {
    /// `Kpz`, rad/m: dive angle per metre of depth error.
    pub p: f64,
    /// `Kdz`, rad·s/m: dive angle per m/s of depth rate, subtracted.
    pub d: f64,
    /// The largest pitch command, rad.
    pub pitch_limit: Limit,
}

/// The terms of the depth loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthTerms {
    /// `e_z = z_c - z`, m, positive when the vehicle is too shallow.
    pub error: f64,
    /// `Kpz e_z`, rad, bow down positive.
    pub p: f64,
    /// `Kdz de_z/dt`, rad, bow down positive.
    pub d: f64,
    /// The commanded dive angle before the limit, rad, bow down positive.
    pub dive_angle: f64,
    /// `theta_c`, rad, bow up positive, after the limit.
    pub pitch_command: Limited,
}

impl DepthLoop {
    /// The pitch command for a depth setpoint (m) and a depth (m, down). `rate` is the rate of the depth, or of the depth minus its
    /// setpoint (m/s, down); `i` is an integral term (rad, bow down), 0 in the report.
    #[must_use]
    pub fn evaluate(&self, setpoint: f64, depth: f64, rate: f64, i: f64) -> DepthTerms {
        let error = bounded(setpoint - depth);
        let p = bounded(self.p * error);
        let d = bounded(-self.d * rate);
        let dive_angle = p + d + i;
        DepthTerms {
            error,
            p,
            d,
            dive_angle,
            pitch_command: self.pitch_limit.apply(-dive_angle),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth_loop() -> DepthLoop {
        DepthLoop {
            p: 0.8,
            d: 2.0,
            pitch_limit: Limit::new(0.7).unwrap(),
        }
    }

    #[test]
    fn too_shallow_asks_for_bow_down() {
        let terms = depth_loop().evaluate(1.0, 0.5, 0.0, 0.0);
        assert_eq!(terms.error, 0.5);
        assert!(terms.pitch_command.value < 0.0);
    }

    #[test]
    fn sinking_towards_the_setpoint_eases_the_dive() {
        let still = depth_loop()
            .evaluate(1.0, 0.5, 0.0, 0.0)
            .pitch_command
            .value;
        let sinking = depth_loop()
            .evaluate(1.0, 0.5, 0.1, 0.0)
            .pitch_command
            .value;
        assert!(sinking > still);
    }

    #[test]
    fn a_large_error_stands_at_the_limit() {
        let terms = depth_loop().evaluate(100.0, 0.0, 0.0, 0.0);
        assert_eq!(terms.pitch_command.value, -0.7);
        assert!(terms.pitch_command.at_limit);
    }
}
