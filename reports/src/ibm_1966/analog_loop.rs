//! Analog flight control of Phase I, the reference for the digital one (Table 4-3).
//!
//! ```text
//! delta_c = K_g [K_a (e + K_i int e dt) - K_r psi'],   e = K_2 N_y - K_b psi
//! v'      = omega_a^2 (delta_c - delta) - 2 zeta omega_a v
//! delta'  = v, held within the rate limit
//! ```
//!
//! Missile and gains are the same as for the digital loop. The actuator is of second order: its valve opens in proportion to v, up to a maximum flow.
//! The report prints no constants of the analog actuator. [`Surrogate`] has omega_a and the rate limit, calibrated on Table 4-3; zeta is assumed to
//! be 0.7, and K_i equals that of the digital K = 2^-9, for which the report finds "similar performance and transient characteristics" (Section
//! IV.B.3).

use planesman_linear::runge_kutta_step;

use crate::ibm_1966::autopilot::{Gains, PULSE};
use crate::ibm_1966::missile::{Surrogate, Yaw, YawPlant};

/// Damping ratio zeta of the analog actuator.
const DAMPING: f64 = 0.7;

/// Integral gain K_i, 1/s: K = 2^-9 at 82.5 Hz.
const INTEGRAL_GAIN: f64 = 82.5 / 512.0;

/// Integration step, s: 1/40 of 1/omega_a.
const STEP: f64 = 2e-4;

/// The analog flight control with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalogLoop {
    gains: Gains,
    plant: YawPlant,
    frequency: f64,
    rate_limit: f64,
    state: State,
    steps: u32,
}

/// State: psi, psi', beta as in [`Yaw`], then the integral of e (rad s), delta (rad) and v (rad/s).
type State = [f64; 6];

impl AnalogLoop {
    /// A loop at rest with psi_0 = `yaw`, rad, without sideslip. K of `gains` is not used.
    #[must_use]
    pub fn new(surrogate: Surrogate, gains: Gains, yaw: f64) -> Self {
        Self {
            gains,
            plant: surrogate.plant(),
            frequency: surrogate.analog_frequency(),
            rate_limit: surrogate.analog_rate_limit(),
            state: [yaw, 0.0, 0.0, 0.0, 0.0, 0.0],
            steps: 0,
        }
    }

    /// Time from the start, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        f64::from(self.steps) * STEP
    }

    /// State of the missile.
    #[must_use]
    pub fn yaw(&self) -> Yaw {
        let [angle, rate, sideslip, ..] = self.state;
        Yaw {
            angle,
            rate,
            sideslip,
        }
    }

    /// Nozzle angle delta, rad.
    #[must_use]
    pub fn nozzle(&self) -> f64 {
        self.state[4]
    }

    /// Nozzle rate delta', rad/s.
    #[must_use]
    pub fn nozzle_rate(&self) -> f64 {
        self.state[5].clamp(-self.rate_limit, self.rate_limit)
    }

    /// One integration step with `steering` pulses.
    pub fn step(&mut self, steering: f64) {
        let held = [&steering; 3];
        self.state = runge_kutta_step(&self.state, STEP, held, |steering, x| {
            self.rates(x, *steering)
        });
        self.steps += 1;
    }

    fn rates(&self, x: &State, steering: f64) -> State {
        let [angle, rate, sideslip, integral, nozzle, valve] = *x;
        let g = &self.gains;
        let error = PULSE * steering - g.yaw * angle;
        let command = g.overall * (g.attitude * (error + INTEGRAL_GAIN * integral) - g.rate * rate);
        let omega = self.frequency;
        let [angle, rate, sideslip] = self.plant.rates([angle, rate, sideslip], nozzle);
        [
            angle,
            rate,
            sideslip,
            error,
            valve.clamp(-self.rate_limit, self.rate_limit),
            omega * omega * (command - nozzle) - 2.0 * DAMPING * omega * valve,
        ]
    }
}
