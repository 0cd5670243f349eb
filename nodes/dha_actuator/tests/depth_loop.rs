//! The AUV's depth loop through the digital hydraulic actuator: the limit cycle that its quantum
//! leaves behind. The expected numbers are from an independent simulation of the same loop.

mod common;

use common::depth::{LimitCycle, dive};
use dha_actuator::condition::Condition;
use dha_actuator::dha::Demand;
use dha_actuator::pulse_logic::Options;

/// Dives with the actuator `name` under `logic`, the position loop closed or not.
fn limit_cycle(name: &str, logic: Options, position_loop: bool, leakage_scale: f64) -> LimitCycle {
    dive(name, |_| Demand {
        position_loop,
        logic,
        condition: Condition {
            leakage_scale,
            ..Condition::SOUND
        },
        ..Demand::angle(0.0)
    })
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
    let cycle = limit_cycle("auv", Options::SINGLE_SPEED, true, 0.0);
    about(cycle.depth, 0.048_974, 0.01);
    about(cycle.planes, 0.770_817, 0.01);
    about(cycle.pulses, 0.512, 0.01);
    about(cycle.settled, 11.025, 0.01);
    about(cycle.overshoot, 0.1217, 0.01);
    assert!(cycle.error.abs() < 1e-3, "{}", cycle.error);
}

#[test]
fn leakage_takes_the_cycle_away_and_leaves_a_hundredth_of_an_inch() {
    let cycle = limit_cycle("auv", Options::SINGLE_SPEED, true, 1.0);
    assert!(cycle.depth < 0.005, "{}", cycle.depth);
    about(cycle.error, 0.007_151, 0.05);
    about(cycle.planes, 0.591, 0.05);
    about(cycle.pulses, 0.956, 0.05);
    about(cycle.settled, 11.025, 0.05);
    about(cycle.overshoot, 0.2843, 0.05);
}

#[test]
fn two_speeds_cut_the_ripple_without_leakage_to_help() {
    let cycle = limit_cycle("auv_two_speed", Options::TWO_SPEED, true, 0.0);
    about(cycle.depth, 0.017_601, 0.15);
    about(cycle.planes, 0.270_817, 0.15);
    about(cycle.pulses, 1.584, 0.15);
    about(cycle.settled, 10.85, 0.02);
    let open = limit_cycle("auv_two_speed", Options::TWO_SPEED, false, 0.0);
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
        let cycle = limit_cycle(name, logic, true, 1.0);
        assert_eq!(cycle.pulses, 0.0, "no volume moves in the limit cycle");
        assert!(cycle.depth < 0.002, "{}", cycle.depth);
        about(cycle.planes, 0.015_1, 0.15);
        about(cycle.settled, settled, 0.02);
    }
}

#[test]
fn the_open_loop_fails_with_leakage_that_the_position_loop_holds() {
    let drifting = limit_cycle("auv", Options::SINGLE_SPEED, false, 1.0);
    assert!(
        drifting.depth > 2.0 && drifting.error.abs() > 1.0,
        "{drifting:?}"
    );
}
