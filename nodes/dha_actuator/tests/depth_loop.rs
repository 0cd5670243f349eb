//! The AUV's depth loop through the digital hydraulic actuator: the limit cycle that its quantum
//! leaves behind.
//!
//! Vehicle and gains of program T6 (Brunner, NPS thesis, 1988, App. C), in feet, pounds and
//! radians: J theta'' = K_y delta - B_y theta', z' = U sin theta, with J = 0.6, B_y = 0.06,
//! K_y = 0.14 ft lb/rad, U = 1 ft/s; here theta and delta are positive to dive. The expected
//! numbers are from an independent simulation of the same loop.

use dha_actuator::actuator_file::load;
use dha_actuator::dha::{Demand, Dha};
use dha_actuator::pulse_logic::Options;
use dha_actuator::units::DEGREE;

/// What a dive of 3 ft leaves behind between 250 and 500 s.
#[derive(Debug)]
struct LimitCycle {
    /// Depth, peak to peak and mean error, in.
    depth: f64,
    error: f64,
    /// Plane angle, peak to peak, deg.
    planes: f64,
    /// Volumes commanded in a second.
    pulses: f64,
    /// When the depth stays within 5 % of the step, s.
    settled: f64,
    /// Percent of the step.
    overshoot: f64,
}

/// theta, q and z of the vehicle after `h` s with the plane at `delta`.
fn step([theta, q, z]: [f64; 3], delta: f64, h: f64) -> [f64; 3] {
    let rates = |theta: f64, q: f64| [q, (0.14 * delta - 0.06 * q) / 0.6, theta.sin()];
    let k1 = rates(theta, q);
    let k2 = rates(theta + h * k1[0], q + h * k1[1]);
    let mean = |i: usize| 0.5 * h * (k1[i] + k2[i]);
    [theta + mean(0), q + mean(1), z + mean(2)]
}

/// Dives with the actuator `name` under `logic`, the position loop closed unless `open`.
fn dive(name: &str, logic: Options, position_loop: bool, leakage_scale: f64) -> LimitCycle {
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
            position_loop,
            logic,
            leakage_scale,
            ..Demand::angle(angle)
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

#[track_caller]
fn about(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found / expected - 1.0).abs() < tolerance,
        "{found} for {expected}"
    );
}

#[test]
fn a_tight_actuator_leaves_the_depth_cycling_within_a_twentieth_of_an_inch() {
    let cycle = dive("auv", Options::SINGLE_SPEED, true, 0.0);
    about(cycle.depth, 0.048_974, 0.01);
    about(cycle.planes, 0.770_817, 0.01);
    about(cycle.pulses, 0.512, 0.01);
    about(cycle.settled, 11.025, 0.01);
    about(cycle.overshoot, 0.1217, 0.01);
    assert!(cycle.error.abs() < 1e-3, "{}", cycle.error);
}

#[test]
fn leakage_takes_the_cycle_away_and_leaves_a_hundredth_of_an_inch() {
    let cycle = dive("auv", Options::SINGLE_SPEED, true, 1.0);
    assert!(cycle.depth < 0.005, "{}", cycle.depth);
    about(cycle.error, 0.007_151, 0.05);
    about(cycle.planes, 0.591, 0.05);
    about(cycle.pulses, 0.956, 0.05);
    about(cycle.settled, 11.025, 0.05);
    about(cycle.overshoot, 0.2843, 0.05);
}

#[test]
fn two_speeds_cut_the_ripple_without_leakage_to_help() {
    let cycle = dive("auv_two_speed", Options::TWO_SPEED, true, 0.0);
    about(cycle.depth, 0.017_601, 0.15);
    about(cycle.planes, 0.270_817, 0.15);
    about(cycle.pulses, 1.584, 0.15);
    about(cycle.settled, 10.85, 0.02);
    let open = dive("auv_two_speed", Options::TWO_SPEED, false, 0.0);
    about(open.depth, 0.105_911, 0.15);
    about(open.planes, 0.270_817, 0.15);
    about(open.pulses, 0.344, 0.15);
    about(open.settled, 10.837_5, 0.02);
}

#[test]
fn precision_mode_steers_by_the_drift_alone_and_leaves_a_fiftieth_of_the_ripple() {
    for (name, logic, settled) in [
        ("auv", Options::PRECISION, 11.025),
        ("auv_two_speed", Options::TWO_SPEED_PRECISION, 10.85),
    ] {
        let cycle = dive(name, logic, true, 1.0);
        assert_eq!(cycle.pulses, 0.0, "no volume moves in the limit cycle");
        assert!(cycle.depth < 0.002, "{}", cycle.depth);
        about(cycle.planes, 0.015_1, 0.15);
        about(cycle.settled, settled, 0.02);
    }
}

#[test]
fn the_open_loop_fails_with_leakage_that_the_position_loop_holds() {
    let drifting = dive("auv", Options::SINGLE_SPEED, false, 1.0);
    assert!(
        drifting.depth > 2.0 && drifting.error.abs() > 1.0,
        "{drifting:?}"
    );
}
