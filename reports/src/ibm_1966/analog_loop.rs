//! The analog flight control of Phase I, which the digital one is compared with (Table 4-3).
//!
//! ```text
//! delta_c = K_g [K_a (e + K_i int e dt) - K_r psi'],   e = K_2 N_y - K_b psi
//! v'      = omega_a^2 (delta_c - delta) - 2 zeta omega_a v
//! delta'  = v, held within the rate limit
//! ```
//!
//! The missile and the gains are those of the digital loop. The actuator is of second order: its
//! valve opens as v says and passes no more than so much oil. The report prints none of its
//! constants. [`Surrogate`] has omega_a and the rate limit, calibrated on Table 4-3; zeta is taken as
//! 0.7, and K_i is that of the digital K = 2^-9, with which the report finds "similar performance and
//! transient characteristics" (Section IV.B.3).

use planesman_linear::runge_kutta_step;

use crate::ibm_1966::autopilot::{Gains, PULSE};
use crate::ibm_1966::missile::{Surrogate, Yaw, YawPlant};

/// zeta of the analog actuator.
const DAMPING: f64 = 0.7;

/// K_i, 1/s: K = 2^-9 at 82.5 Hz.
const INTEGRAL_GAIN: f64 = 82.5 / 512.0;

/// Integration step, s: a fortieth of 1/omega_a.
const STEP: f64 = 2e-4;

/// The loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalogLoop {
    gains: Gains,
    plant: YawPlant,
    frequency: f64,
    rate_limit: f64,
    state: State,
    steps: u32,
}

/// psi, psi', beta as in [`Yaw`], then int e dt (rad s), delta (rad) and v (rad/s).
type State = [f64; 6];

impl AnalogLoop {
    /// A loop at rest, psi_0 = `yaw`, rad, without sideslip. K of `gains` has no part in it.
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

    /// s from the start.
    #[must_use]
    pub fn time(&self) -> f64 {
        f64::from(self.steps) * STEP
    }

    /// The missile.
    #[must_use]
    pub fn yaw(&self) -> Yaw {
        let [angle, rate, sideslip, ..] = self.state;
        Yaw {
            angle,
            rate,
            sideslip,
        }
    }

    /// delta, rad.
    #[must_use]
    pub fn nozzle(&self) -> f64 {
        self.state[4]
    }

    /// delta', rad/s.
    #[must_use]
    pub fn nozzle_rate(&self) -> f64 {
        self.state[5].clamp(-self.rate_limit, self.rate_limit)
    }

    /// One integration step under `steering` pulses.
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
