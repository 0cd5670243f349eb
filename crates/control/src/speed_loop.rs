//! The speed regulator: the commanded speed itself, and its error times a gain (Brunner, NPS thesis,
//! 1988, ch. II.E, Fig. 22).
//!
//! ```text
//! u = F V_c + Kp (V_c - V)
//! ```
//! With the steady-state gain g from u to V this settles at `V/V_c = g (F + Kp) / (1 + g Kp)`: without an offset
//! if and only if `F g = 1`. The report's motors and gains are lost.

use crate::limits::bounded;

/// Feed-forward and proportional share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedLoop {
    /// `F`, share of full thrust per m/s asked for.
    pub feed_forward: f64,
    /// `Kp`, share of full thrust per m/s of error.
    pub p: f64,
    /// The largest share of full thrust, in [0, 1].
    pub limit: f64,
}

impl SpeedLoop {
    /// The share of full thrust for a speed setpoint and a speed, m/s.
    #[must_use]
    pub(crate) fn evaluate(&self, setpoint: f64, speed: f64) -> f64 {
        let error = bounded(setpoint - speed);
        let asked = bounded(self.feed_forward * setpoint) + bounded(self.p * error);
        asked.clamp(-self.limit, self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_offset_only_if_the_feed_forward_is_the_gains_inverse() {
        let settled = |feed_forward: f64| {
            let speed_loop = SpeedLoop {
                feed_forward,
                p: 0.5,
                limit: 1.0,
            };
            // A first-order vehicle with the steady-state gain 2 m/s, until nothing moves.
            (0..2000).fold(0.0, |v, _| {
                v + 0.01 * (2.0 * speed_loop.evaluate(0.6, v) - v)
            })
        };
        assert!((settled(0.5) - 0.6).abs() < 1e-9);
        assert!((settled(0.0) - 0.6 * 2.0 * 0.5 / 2.0).abs() < 1e-9);
    }

    #[test]
    fn thrust_stays_within_its_limit() {
        let speed_loop = SpeedLoop {
            feed_forward: 1.0,
            p: 1.0,
            limit: 0.8,
        };
        assert_eq!(speed_loop.evaluate(9.0, 0.0), 0.8);
        assert_eq!(speed_loop.evaluate(0.0, f64::MAX), -0.8);
    }
}
