//! The effect of each fault on the ram.

use crate::common::{Bench, actuator};
use planesman_hydraulics::{Condition, Demand, Dha, FrictionState, StuckValve};
use planesman_units::{DEGREE, INCH, PSI};

const SOUND: Condition = Condition::SOUND;

/// Steps in a second of drift, the report's latch in place of exact friction.
fn stepping(sign: i8, stiffness: f64) -> f64 {
    let mut set = actuator("table_3_1", true, true);
    set.oil.stiffness = stiffness * PSI / (INCH * INCH * INCH);
    let latch = Condition {
        stepping: 0.05,
        ..SOUND
    };
    let mut bench = Bench::worn(set, latch, sign, &[]);
    let (mut slid_before, mut starts) = (false, Vec::new());
    for i in 0..30_000 {
        let t = f64::from(i) * 1e-4;
        let slides = matches!(bench.reading(t).mode.friction, FrictionState::Sliding(_));
        if slides && !slid_before {
            starts.push(t);
        }
        slid_before = slides;
    }
    (starts.len() - 1) as f64 / (starts[starts.len() - 1] - starts[0])
}

#[test]
fn the_reports_latch_steps_during_drift_faster_with_stiffer_oil() {
    for (stiffness, hertz) in [(13_300.0, 23.0), (26_600.0, 38.0), (100_000.0, 91.0)] {
        let found = stepping(-1, stiffness);
        assert!((found - hertz).abs() < 0.5, "{found} Hz for {hertz}");
    }
}

#[test]
fn exact_friction_creeps_without_a_step() {
    let set = actuator("table_3_1", true, true);
    let creep = set.creep(-1.0);
    let mut bench = Bench::settled(set, -1, &[]);
    for i in 0..2_000 {
        let speed = bench.reading(1.0 + f64::from(i) * 1e-3).ram.velocity;
        assert!((speed / creep - 1.0).abs() < 1e-3, "{speed} for {creep}");
    }
}

/// A plane angle, deg, `seconds` after 10 degrees were asked for.
fn angle_after(seconds: i64, demand: Demand) -> f64 {
    let mut dha = Dha::new(&actuator("auv", demand.position_loop, true));
    let nanos = seconds * 1_000_000_000;
    let demand = Demand {
        angle: 10.0 * DEGREE,
        ..demand
    };
    dha.advance_to(nanos, demand);
    dha.plane_angle(&dha.reading(nanos)) / DEGREE
}

fn looped(condition: Condition) -> Demand {
    Demand {
        condition,
        ..Demand::angle(0.0)
    }
}

fn open(condition: Condition) -> Demand {
    Demand {
        position_loop: false,
        ..looped(condition)
    }
}

#[test]
fn a_volume_short_by_a_fifth_leaves_the_open_loop_a_fifth_short_and_the_position_loop_right() {
    let short = Condition {
        short_volume: 0.2,
        ..SOUND
    };
    let open = angle_after(3, open(short));
    assert!((open - 8.0).abs() < 0.3, "{open}");
    let looped = angle_after(3, looped(short));
    assert!((looped - 10.0).abs() < 0.45, "{looped}");
}

#[test]
fn one_slow_latch_delays_every_second_volume() {
    let late = 0.004;
    let slow = Condition {
        slow_latch: late,
        ..SOUND
    };
    let set = actuator("auv", false, false);
    // Half of each volume has flowed at its time, or late.
    let half =
        |n: usize, late: f64| n as f64 * set.cycle() + set.delay() + 0.5 * set.flow_time + late;
    let mut bench = Bench::worn(set.clone(), slow, 1, &[1; 6]);
    for n in 0..6 {
        let late = if n % 2 == 0 { late } else { 0.0 };
        let volume = bench.reading(half(n, late)).ram.volume / set.volume;
        assert!((volume - (n as f64 + 0.5)).abs() < 1e-9, "{n}: {volume}");
    }
    let end = bench.reading(0.2).ram.volume / set.volume;
    assert!((end - 6.0).abs() < 1e-12, "none is lost: {end}");
}

#[test]
fn with_too_little_supply_pressure_the_ram_is_slow_and_then_does_not_move() {
    let slew = |lost_supply: f64| {
        let mut dha = Dha::new(&actuator("auv", false, true));
        let weak = Demand {
            angle: 30.0 * DEGREE,
            ..looped(Condition {
                lost_supply,
                ..SOUND
            })
        };
        let mut at = |nanos| {
            dha.advance_to(nanos, weak);
            dha.plane_angle(&dha.reading(nanos)) / DEGREE
        };
        let begin = at(200_000_000);
        (at(500_000_000) - begin) / 0.3
    };
    let [sound, weak, dead] = [0.0, 0.6, 0.9].map(slew);
    assert!((sound - 40.0).abs() < 1.0, "{sound}");
    // The clamped pressure sustains (20 psi A_L - Delta F)/C = 0.25 in/s, 28.6 degrees a second.
    assert!((weak - 28.6).abs() < 0.5, "{weak}");
    assert_eq!(dead, 0.0);
}

#[test]
fn air_in_the_oil_softens_the_column() {
    let aerated = Condition { air: 0.9, ..SOUND };
    let set = actuator("table_4_1", false, true);
    // Where it rests after a volume, off that volume, in stiction bands of sound oil.
    let rests_off = |condition| {
        let ram = Bench::worn(set.clone(), condition, 1, &[1])
            .reading(1.0)
            .ram;
        (ram.position - ram.volume / set.area).abs() / set.stiction_band()
    };
    assert!(rests_off(SOUND) <= 1.0);
    let off = rests_off(aerated);
    assert!(off > 2.0 && off <= 10.0, "{off}");
}

#[test]
fn a_stuck_actuating_valve_only_drifts() {
    let stuck = Condition {
        stuck: Some(StuckValve::Actuating),
        ..SOUND
    };
    // Asked for 10 degrees, it only drifts: three seconds of 0.35 degrees.
    let moved = angle_after(3, looped(stuck));
    assert!(moved > 0.0 && moved < 2.0, "{moved}");
}
