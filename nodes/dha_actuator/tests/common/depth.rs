//! The AUV's depth loop through the digital hydraulic actuator.
//!
//! Vehicle and gains of program T6 (Brunner, NPS thesis, 1988, App. C), in feet, pounds and
//! radians: J theta'' = K_y delta - B_y theta', z' = U sin theta, with J = 0.6, B_y = 0.06,
//! K_y = 0.14 ft lb/rad, U = 1 ft/s; here theta and delta are positive to dive.

use dha_actuator::actuator_file::load;
use dha_actuator::dha::{Demand, Dha};
use dha_actuator::units::DEGREE;

/// What a dive of 3 ft leaves behind between 250 and 500 s.
#[derive(Debug)]
pub(crate) struct LimitCycle {
    /// Depth, peak to peak and mean error, in.
    pub(crate) depth: f64,
    pub(crate) error: f64,
    /// Plane angle, peak to peak, deg.
    pub(crate) planes: f64,
    /// Volumes commanded in a second.
    pub(crate) pulses: f64,
    /// When the depth stays within 5 % of the step, s.
    pub(crate) settled: f64,
    /// Percent of the step.
    pub(crate) overshoot: f64,
}

/// theta, q and z of the vehicle after `h` s with the plane at `delta`.
fn step([theta, q, z]: [f64; 3], delta: f64, h: f64) -> [f64; 3] {
    let rates = |theta: f64, q: f64| [q, (0.14 * delta - 0.06 * q) / 0.6, theta.sin()];
    let k1 = rates(theta, q);
    let k2 = rates(theta + h * k1[0], q + h * k1[1]);
    let mean = |i: usize| 0.5 * h * (k1[i] + k2[i]);
    [theta + mean(0), q + mean(1), z + mean(2)]
}

/// Dives with the actuator `name`; `asked` is how it is asked for the angle, by the time in s.
pub(crate) fn dive(name: &str, asked: impl Fn(f64) -> Demand) -> LimitCycle {
    const TICK: i64 = 50_000_000;
    const FT: f64 = 3.0;
    let mut dha = Dha::new(&load(name).expect("built in"));
    let mut vehicle = [0.0; 3];
    let mut before = 0.0;
    let (mut depths, mut planes, mut errors) = (Range::NONE, Range::NONE, 0.0);
    let (mut settled, mut deepest, mut pulses_before) = (0.0, 0.0f64, 0);
    for k in 0..10_000 {
        let [theta, q, z] = vehicle;
        let pitch_command =
            (0.25 * (FT - z) - 0.6 * theta.sin()).clamp(-45.0 * DEGREE, 45.0 * DEGREE);
        let angle = (0.7 * (pitch_command - theta) - 2.0 * q).clamp(-30.0 * DEGREE, 30.0 * DEGREE);
        let demand = Demand {
            angle,
            ..asked(k as f64 * 0.05)
        };
        if k == 5_000 {
            pulses_before = dha.pulses();
        }
        for j in 1..=50 {
            let nanos = k * TICK + j * 1_000_000;
            dha.advance_to(nanos, demand);
            let delta = dha.plane_angle(&dha.reading(nanos));
            vehicle = step(vehicle, 0.5 * (before + delta), 0.001);
            before = delta;
            let error = vehicle[2] - FT;
            if error.abs() > 0.05 * FT {
                settled = nanos as f64 * 1e-9;
            }
            deepest = deepest.max(vehicle[2]);
            if k >= 5_000 {
                depths.add(12.0 * error);
                planes.add(delta / DEGREE);
                errors += 12.0 * error;
            }
        }
    }
    LimitCycle {
        depth: depths.width(),
        error: errors / 250e3,
        planes: planes.width(),
        pulses: (dha.pulses() - pulses_before) as f64 / 250.0,
        settled,
        overshoot: 100.0 * (deepest / FT - 1.0),
    }
}

struct Range(f64, f64);

impl Range {
    const NONE: Self = Self(f64::INFINITY, f64::NEG_INFINITY);

    fn add(&mut self, value: f64) {
        *self = Self(self.0.min(value), self.1.max(value));
    }

    fn width(&self) -> f64 {
        self.1 - self.0
    }
}
