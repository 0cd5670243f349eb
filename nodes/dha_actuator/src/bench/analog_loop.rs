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

use super::autopilot::{Gains, PULSE};
use super::missile::{Surrogate, Yaw, YawPlant};

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

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct State {
    yaw: Yaw,
    /// int e dt, rad s.
    integral: f64,
    /// delta, rad.
    nozzle: f64,
    /// v, rad/s.
    valve: f64,
}

impl State {
    /// This plus `h` times `by`.
    fn plus(self, h: f64, by: Self) -> Self {
        Self {
            yaw: self.yaw.plus(h, by.yaw),
            integral: self.integral + h * by.integral,
            nozzle: self.nozzle + h * by.nozzle,
            valve: self.valve + h * by.valve,
        }
    }
}

impl AnalogLoop {
    /// A loop at rest, psi_0 = `yaw`, rad, without sideslip. K of `gains` has no part in it.
    #[must_use]
    pub fn new(surrogate: Surrogate, gains: Gains, yaw: f64) -> Self {
        Self {
            gains,
            plant: surrogate.plant(),
            frequency: surrogate.analog_frequency(),
            rate_limit: surrogate.analog_rate_limit(),
            state: State {
                yaw: Yaw {
                    angle: yaw,
                    ..Yaw::default()
                },
                ..State::default()
            },
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
        self.state.yaw
    }

    /// delta, rad.
    #[must_use]
    pub fn nozzle(&self) -> f64 {
        self.state.nozzle
    }

    /// delta', rad/s.
    #[must_use]
    pub fn nozzle_rate(&self) -> f64 {
        self.state.valve.clamp(-self.rate_limit, self.rate_limit)
    }

    /// One integration step under `steering` pulses.
    pub fn step(&mut self, steering: f64) {
        let h = STEP;
        let x = self.state;
        let k1 = self.rates(x, steering);
        let k2 = self.rates(x.plus(0.5 * h, k1), steering);
        let k3 = self.rates(x.plus(0.5 * h, k2), steering);
        let k4 = self.rates(x.plus(h, k3), steering);
        self.state = x
            .plus(h / 6.0, k1)
            .plus(h / 3.0, k2)
            .plus(h / 3.0, k3)
            .plus(h / 6.0, k4);
        self.steps += 1;
    }

    fn rates(&self, x: State, steering: f64) -> State {
        let g = &self.gains;
        let error = PULSE * steering - g.yaw * x.yaw.angle;
        let command =
            g.overall * (g.attitude * (error + INTEGRAL_GAIN * x.integral) - g.rate * x.yaw.rate);
        let omega = self.frequency;
        State {
            yaw: self.plant.rates(x.yaw, x.nozzle),
            integral: error,
            nozzle: x.valve.clamp(-self.rate_limit, self.rate_limit),
            valve: omega * omega * (command - x.nozzle) - 2.0 * DAMPING * omega * x.valve,
        }
    }
}
