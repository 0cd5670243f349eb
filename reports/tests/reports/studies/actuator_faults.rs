//! The effect of each fault of the actuator on a dive: the AUV's depth loop through a faulty digital hydraulic
//! actuator, in inches and degrees.

use planesman_hydraulics::actuator_file::load;
use planesman_hydraulics::{Condition, Demand, Encoder, Options, StuckValve};
use planesman_reports::studies::depth_loop::Loop;
use planesman_units::{DEGREE, INCH};

const SOUND: Condition = Condition::SOUND;

/// The limit cycle between 250 and 500 s after a dive of 3 ft.
#[derive(Debug)]
struct LimitCycle {
    /// Depth, peak to peak and mean error, in.
    depth: f64,
    error: f64,
    /// Plane angle, peak to peak, deg.
    planes: f64,
    /// Volumes commanded in a second.
    pulses: f64,
}

/// Dives with the actuator `name`; `demand` is the demand but for the angle, by the time in s.
fn dive(name: &str, demand: impl Fn(f64) -> Demand) -> LimitCycle {
    let set = load(name).expect("built in");
    let dive = Loop::default().dive(&set, demand, 0.0).expect("in range");
    let cycle = dive.cycle;
    LimitCycle {
        depth: cycle.depth / INCH,
        error: cycle.error / INCH,
        planes: cycle.planes / DEGREE,
        pulses: cycle.pulses,
    }
}

fn looped(condition: Condition) -> Demand {
    Demand {
        condition,
        ..Demand::angle(0.0)
    }
}

#[test]
fn a_slow_latch_spoils_precision_mode_with_parasitic_volumes() {
    let precision = |slow_latch: f64| Demand {
        logic: Options::PRECISION,
        ..looped(Condition {
            slow_latch,
            ..SOUND
        })
    };
    let sound = dive("auv", |_| precision(0.0));
    let slow = dive("auv", |_| precision(0.003));
    assert!(sound.planes < 0.02, "{}", sound.planes);
    assert!(slow.planes > 10.0 * sound.planes, "{slow:?}");
}

/// A dive whose actuator falls ill after 60 s, the vehicle at its depth.
fn falls_ill(condition: Condition) -> LimitCycle {
    dive("auv", |t| looped(if t < 60.0 { SOUND } else { condition }))
}

#[test]
fn the_dive_bears_the_faults_that_only_weaken_the_actuator() {
    for condition in [
        Condition {
            short_volume: 0.3,
            ..SOUND
        },
        Condition {
            leakage_scale: 10.0,
            ..SOUND
        },
        Condition {
            lost_supply: 0.5,
            ..SOUND
        },
        Condition { air: 0.8, ..SOUND },
        Condition {
            slow_latch: 0.01,
            ..SOUND
        },
        Condition {
            stepping: 0.05,
            ..SOUND
        },
    ] {
        let dive = falls_ill(condition);
        assert!(
            dive.depth < 1.0 && dive.error.abs() < 1.0,
            "{condition:?}: {dive:?}"
        );
    }
}

#[test]
fn more_leakage_in_the_position_loop_is_more_pulses() {
    let leaking = |leakage_scale| {
        falls_ill(Condition {
            leakage_scale,
            ..SOUND
        })
        .pulses
    };
    let (sound, grown) = (leaking(1.0), leaking(10.0));
    assert!(grown > 5.0 * sound, "{sound} and {grown} pulses a second");
}

#[test]
fn with_the_direction_valve_stuck_the_planes_run_to_their_limit_and_the_depth_away() {
    let dive = falls_ill(Condition {
        stuck: Some(StuckValve::Direction),
        ..SOUND
    });
    assert_eq!(dive.planes, 0.0, "held at the stop");
    assert!(dive.error.abs() > 20.0, "{dive:?}");
}

#[test]
fn without_its_encoder_the_actuator_counts_and_leakage_takes_the_depth() {
    let dive = falls_ill(Condition {
        encoder: Encoder::Lost,
        ..SOUND
    });
    // A chaotic motion: how far it swings in its window is chance.
    assert!(dive.depth > 1.0 && dive.error.abs() > 1.0, "{dive:?}");
}

#[test]
fn a_frozen_encoder_makes_the_planes_bang_from_limit_to_limit() {
    let dive = falls_ill(Condition {
        encoder: Encoder::Frozen,
        ..SOUND
    });
    assert!(dive.planes > 55.0 && dive.pulses > 40.0, "{dive:?}");
}

#[test]
fn a_stuck_actuating_valve_does_not_show_at_depth() {
    let stuck = Condition {
        stuck: Some(StuckValve::Actuating),
        ..SOUND
    };
    // The limit cycle of a leaking actuator needs changes of direction only, which move a volume.
    let (sound, holding) = (falls_ill(SOUND), falls_ill(stuck));
    assert_eq!(holding.depth, sound.depth);
    assert_eq!(holding.pulses, sound.pulses);
}
