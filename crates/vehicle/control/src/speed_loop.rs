//! The speed regulator: feed-forward of the commanded speed, plus a gain on its error (Brunner, NPS thesis, 1988, ch. II.E, Fig. 22).
//!
//! ```text
//! u = F V_c + Kp (V_c - V)
//! ```
//! With the steady-state gain g from u to V the loop settles at `V/V_c = g (F + Kp) / (1 + g Kp)`: without an offset if and only if
//! `F g = 1`. The report's motors and gains are lost.

use planesman_units::FOOT;

use crate::limits::bounded;

/// The speed at full thrust, m/s: 5 ft/s (Brunner 1988, p. 57).
const DESIGN_SPEED: f64 = 5.0 * FOOT;

/// The speed regulator: the parameters `speed.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct SpeedLoop {
    /// Whether the thrust controls the speed to speed_setpoint; a setpoint on the topic is always followed.
    #[parameter(default = false)]
    pub active: bool,
    /// Feed-forward gain of the speed loop: share of full thrust per speed setpoint; full thrust at 5 ft/s
    /// (Brunner 1988, p. 57).
    #[parameter(default = 1.0 / DESIGN_SPEED, unit = "s/m", range = 0.0..=1e3)]
    pub feed_forward: f64,
    /// Proportional gain of the speed loop: share of full thrust per speed error; assumed, the report's gain is
    /// lost.
    #[parameter(default = 2.0, unit = "s/m", range = 0.0..=1e3)]
    pub p: f64,
    /// Limit of the thrust command to either side, as a share of full thrust.
    #[parameter(default = 1.0, range = 0.0..=1.0)]
    pub limit: f64,
    /// Rate limit of the speed setpoint; 0: no limit.
    #[parameter(default = 0.0, unit = "m/s^2", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

impl SpeedLoop {
    /// The share of full thrust for a speed setpoint and a speed, m/s.
    #[must_use]
    pub(crate) fn evaluate(&self, setpoint: f64, speed: f64) -> f64 {
        let error = bounded(setpoint - speed);
        let thrust = bounded(self.feed_forward * setpoint) + bounded(self.p * error);
        thrust.clamp(-self.limit, self.limit)
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
                ..SpeedLoop::default()
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
            ..SpeedLoop::default()
        };
        assert_eq!(speed_loop.evaluate(9.0, 0.0), 0.8);
        assert_eq!(speed_loop.evaluate(0.0, f64::MAX), -0.8);
    }
}
