//! Digital autopilot of Figure 2-5: computes changes of the nozzle angle from steering pulses and attitude.
//!
//! ```text
//! N_ye,n  = N_y,n - (K_b/K_2) psi_n
//! Input_n = K_g {K_a K_2 [(N_ye,n - N_ye,n-1) + K N_ye,n] - K_r (psi'_n - psi'_n-1)}
//! ```
//!
//! This is the first difference of delta_c = K_a (1 + K_i/s)(K_2 N_y - K_b psi) - K_r psi', with K = K_i T: the digital hydraulic actuator is the
//! integrator. The figure itself is missing in the copy; this form follows from the list of symbols and Section V. The report's list has
//! N_yFB = +(K_B/K_2) psi, but only negative feedback is stable.

use crate::ibm_1966::missile::Surrogate;
use planesman_units::DEGREE;

/// K_2, rad per pulse: 0.075 degrees, because 12 pulses compared with 11 are "0.075 degree larger, a difference of 8 percent" (Section IV.B.3).
pub const PULSE: f64 = 0.075 * DEGREE;

/// K of Tables 3-1 and 4-1.
pub(crate) const COMPENSATION: f64 = 1.0 / 128.0;

/// Gains of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// K_g: overall gain, raised to find the gain margin.
    pub overall: f64,
    /// Attitude gain K_a.
    pub attitude: f64,
    /// K_b: weight of the yaw angle.
    pub yaw: f64,
    /// Rate gain K_r, s.
    pub rate: f64,
    /// Integral compensation K = K_i T.
    pub compensation: f64,
}

impl Gains {
    /// Gains of a surrogate, with K as in the tables.
    #[must_use]
    pub fn new(surrogate: Surrogate) -> Self {
        Self {
            overall: 1.0,
            attitude: surrogate.attitude_gain(),
            yaw: 1.0,
            rate: surrogate.rate_gain(),
            compensation: COMPENSATION,
        }
    }
}

/// The autopilot, with its values of the last cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DigitalAutopilot {
    gains: Gains,
    error: f64,
    yaw_rate: f64,
}

impl DigitalAutopilot {
    /// An autopilot without history: the first error counts as a change from zero.
    #[must_use]
    pub(crate) fn new(gains: Gains) -> Self {
        Self {
            gains,
            error: 0.0,
            yaw_rate: 0.0,
        }
    }

    /// Input, rad: the change of the nozzle angle for `steering` pulses, psi, rad, and psi', rad/s.
    pub(crate) fn input(&mut self, steering: f64, yaw: f64, yaw_rate: f64) -> f64 {
        let g = &self.gains;
        let error = steering - g.yaw / PULSE * yaw;
        let input = g.overall
            * (g.attitude * PULSE * ((error - self.error) + g.compensation * error)
                - g.rate * (yaw_rate - self.yaw_rate));
        (self.error, self.yaw_rate) = (error, yaw_rate);
        input
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inputs_add_up_to_attitude_rate_and_integral_feedback() {
        let gains = Gains {
            overall: 1.5,
            ..Gains::new(Surrogate::Ps2)
        };
        let mut autopilot = DigitalAutopilot::new(gains);
        let (mut nozzle, mut integral) = (0.0, 0.0);
        for n in 0..100 {
            let t = f64::from(n) * 0.012;
            let (yaw, rate) = (0.01 * libm::sin(t), 0.01 * libm::cos(t));
            nozzle += autopilot.input(5.0, yaw, rate);
            let error = 5.0 * PULSE - yaw;
            integral += gains.compensation * error;
            let expected = 1.5 * (18.0 * (error + integral) - 2.8 * rate);
            assert!((nozzle - expected).abs() < 1e-12);
        }
    }
}
