//! The roll and the heading regulator: proportional with rate feedback (Brunner, NPS thesis, 1988, ch. II.C and II.D, Fig. 19).
//!
//! ```text
//! roll:    beta    = Kpx (phi_c - phi) - Kdx p      bow planes, differentially; phi_c = 0
//! heading:  delta_r = Kpy (psi_c - psi) - Kdy r      rudder
//! ```
//! The report differentiates the error. For a constant setpoint that equals feeding back the rate, the alternative on p. 28, which causes
//! no impulse at a new heading. Kpx = 10 and Kdx = 10 s give the natural frequency 2.24 rad/s, not the 5.0 printed (erratum E5).

use crate::limits::{Limit, bounded};

/// A controller of one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AngleLoop {
    /// Plane angle per angle of error.
    pub p: f64,
    /// Plane angle per rate, s.
    pub rate: f64,
    /// The largest plane angle, rad.
    pub limit: Limit,
}

impl AngleLoop {
    /// The plane angle (rad) for an error (rad) and the angle's rate (rad/s), after the limit.
    #[must_use]
    pub(crate) fn evaluate(&self, error: f64, rate: f64) -> f64 {
        let command = bounded(self.p * error) - bounded(self.rate * rate);
        self.limit.apply(command).value
    }
}

/// The shorter rotation from `from` to `to` (rad), at most half a turn.
#[must_use]
pub(crate) fn short_way(from: f64, to: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let turn = bounded(to - from).rem_euclid(TAU);
    match turn > PI {
        true => turn - TAU,
        false => turn,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_to_starboard_is_answered_to_starboard_until_the_rate_suffices() {
        let heading = AngleLoop {
            p: 1.0,
            rate: 3.0,
            limit: Limit::new(0.5).unwrap(),
        };
        assert_eq!(heading.evaluate(0.2, 0.0), 0.2);
        assert!(heading.evaluate(0.2, 0.1) < 0.0);
        assert_eq!(heading.evaluate(2.0, 0.0), 0.5);
    }

    #[test]
    fn a_heading_is_taken_up_the_short_way_round() {
        for (from, to, way) in [
            (0.0, 1.0, 1.0),
            (3.0, -3.0, 0.283_185),
            (-3.0, 3.0, -0.283_185),
        ] {
            assert!((short_way(from, to) - way).abs() < 1e-6);
        }
        assert_eq!(short_way(0.3, 0.3), 0.0);
        assert!(short_way(f64::MAX, -f64::MAX).abs() <= std::f64::consts::PI);
    }
}
