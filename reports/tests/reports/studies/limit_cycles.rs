//! The AUV's depth loop through the digital hydraulic actuator, against an independent simulation
//! of the same loop (`reports/data/studies/limit_cycles.json`): the limit cycles of the quantum.

use planesman_reports::brunner_1988::controllers::pitch;
use planesman_reports::studies::depth_loop::{Case, Leakage, Logic, cases};
use planesman_reports::studies::orbit::{Growth, Orbit};
use planesman_reports::studies::position_loop;
use planesman_reports::studies::watched::Motion;
use planesman_show::design::Describing;
use planesman_units::{DEGREE, INCH};

/// The row of the comparison with these options and M_theta = 0.
fn case(logic: Logic, position_loop: bool, leakage: Leakage) -> Case {
    cases()
        .unwrap()
        .into_iter()
        .find(|case| {
            case.logic == logic
                && case.position_loop == position_loop
                && case.leakage == leakage
                && case.friction
                && case.restoring == 0.0
        })
        .unwrap()
}

#[test]
fn the_cycles_are_those_of_the_independent_simulation() {
    let mut deviating = Vec::new();
    for case in cases().unwrap() {
        let found = case.run().unwrap().cycle;
        for figure in found.figures(&case.expected.unwrap_or_default()) {
            if !figure.agrees() {
                deviating.push(format!(
                    "{}, M_theta {}: {}",
                    case.name, case.restoring, figure.name
                ));
            }
        }
    }
    // The first drifts away, wherever its integral lets it; the valves of the other run through
    // the phases of the control computer, and its cycle hangs on the start.
    let lost = "open loop, single speed, leakage, K_i = 0.02, M_theta 0.163";
    assert_eq!(
        deviating,
        [
            format!("{lost}: depth, in"),
            format!("{lost}: error, in"),
            format!("{lost}: t95, s"),
            "Polaris set, open loop, single speed, no leakage, M_theta 0: error, in".to_owned(),
            "Polaris set, open loop, single speed, no leakage, M_theta 0: volumes/s".to_owned(),
        ]
    );
}

#[test]
fn precision_mode_steers_by_the_drift_alone() {
    let cycle = case(Logic::Precision, true, Leakage::Scaled)
        .run()
        .unwrap()
        .cycle;
    assert_eq!(cycle.pulses, 0.0, "no volume moves in the limit cycle");
    assert!(cycle.depth < 0.002 * INCH, "{cycle:?}");
}

#[test]
fn the_open_loop_fails_with_leakage_that_the_position_loop_holds() {
    let open = case(Logic::SingleSpeed, false, Leakage::Scaled);
    let drifting = open.run().unwrap().cycle;
    assert!(drifting.error.abs() > INCH, "{drifting:?}");
    let held = case(Logic::SingleSpeed, true, Leakage::Scaled)
        .run()
        .unwrap()
        .cycle;
    assert!(held.error.abs() < 0.01 * INCH, "{held:?}");
}

#[test]
fn harmonic_balance_predicts_the_tight_open_loops_cycle_within_half() {
    let case = case(Logic::SingleSpeed, false, Leakage::None);
    let (cycle, predicted) = (
        case.run().unwrap().cycle,
        case.predict(&Describing::default()).unwrap(),
    );
    assert!(predicted.residual < 0.1, "{predicted:?}");
    assert!((predicted.frequency / cycle.frequency - 1.0).abs() < 0.2);
    assert!((predicted.depth / cycle.depth - 1.0).abs() < 0.5);
}

/// The orbit that a configuration comes to.
fn orbit(case: &Case) -> Orbit {
    let mut dive = case.run().unwrap();
    match case.motion(&mut dive).unwrap() {
        Motion::Orbit(orbit) => orbit,
        other => panic!("{}: {other:?}", case.name),
    }
}

fn assert_near(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{what}: {found} for {expected}"
    );
}

/// Period, s; depth, in, and planes, deg, peak to peak; the largest multiplier. From scipy (`solve_ivp`, DOP853, rtol 1e-9): vehicle and
/// ram as one set of differential equations with halts, break-aways and the valves' edges as events, a volume each time the error of 25 ms
/// (the ram: 6.25 ms) before reaches the threshold, run forward from beside the orbit for 30 cycles until the period stood. The multiplier
/// is the ratio of successive changes of the period.
#[test]
fn orbit_and_multiplier_are_those_that_scipy_runs_into() {
    for (position_loop, [period, depth, planes, multiplier]) in [
        (false, [4.37569, 0.005667, 0.28945, 0.749]),
        (true, [13.51285, 0.16493, 0.32851, 0.447]),
    ] {
        let found = orbit(&case(Logic::SingleSpeed, position_loop, Leakage::Tight));
        assert_near(found.period, period, 1e-4, "period");
        assert_near(found.swing() / INCH, depth, 0.01, "depth");
        assert_near(found.stroke() / DEGREE, planes, 2e-3, "planes");
        assert_near(found.growth(), multiplier, 0.03, "multiplier");
    }
}

/// The simulated loop repeats itself every 1004 ticks; the orbit's instants are not bound to them.
#[test]
fn a_loop_on_its_samples_follows_the_orbit() {
    let restored = cases().unwrap().remove(1);
    let mut dive = restored.run().unwrap();
    let motion = restored.motion(&mut dive).unwrap();
    let Motion::Orbit(orbit) = motion else {
        panic!("{motion:?}");
    };
    let (frequency, stroke) = dive.watched.apart(&orbit);
    assert!(
        frequency.abs() < 5e-3 && stroke.abs() < 5e-3,
        "{frequency} {stroke}"
    );
    assert_near(
        orbit.swing(),
        dive.watched.swing(orbit.period),
        0.01,
        "depth",
    );
    assert!(orbit.stable());
}

/// Half a valve cycle is 2 % of the period where the small volume moves; else the loops follow their orbits.
#[test]
fn the_position_loops_alone_follow_their_orbits() {
    for row in position_loop::rows().unwrap() {
        match &row.motion {
            Motion::Orbit(orbit) => {
                let (turns, stroke) = row.simulated.unwrap();
                assert_near(orbit.turns(), turns, 0.02, row.actuator);
                assert_near(orbit.stroke(), stroke, 0.05, row.actuator);
                // The ram is stuck again before the next decision: hardly anything of a deviation is left.
                assert!(orbit.growth() < 0.1, "{} {}", row.actuator, row.logic);
            }
            _ => assert_ne!(row.logic, "single speed", "{}", row.actuator),
        }
    }
}

/// Deviations along a motion that follows an orbit grow as the orbit's largest multiplier says; its eigenvalue is found another way.
#[test]
fn deviations_along_an_orbit_grow_as_its_multiplier_says() {
    let case = case(Logic::SingleSpeed, false, Leakage::Tight);
    let mut dive = case.run().unwrap();
    let motion = case.motion(&mut dive).unwrap();
    let Motion::Orbit(orbit) = motion else {
        panic!("{motion:?}");
    };
    let watched = &dive.watched;
    let windows = case
        .actuation()
        .unwrap()
        .growth(&watched.decisions, &watched.before, 50.0);
    let grown = Growth::of(&windows).unwrap();
    let expected = libm::log(orbit.growth()) / orbit.period;
    assert!(
        (grown.rate - expected).abs() < 0.1 * expected.abs(),
        "{grown:?} {expected}"
    );
}

/// 0.130 +- 0.005 and 0.137 +- 0.005 1/s from two neighbouring simulations, renormalised each second over 4000 s: another program of the
/// same loop (Runge-Kutta, 0.05 and 0.25 ms), a volume each time the error of 25 ms before reaches the threshold.
#[test]
fn the_leaking_open_loop_is_chaotic_as_two_neighbouring_simulations_find() {
    let case = case(Logic::SingleSpeed, false, Leakage::Scaled);
    let watched = case.run().unwrap().watched;
    let windows = case
        .actuation()
        .unwrap()
        .growth(&watched.decisions, &watched.before, 50.0);
    let grown = Growth::of(&windows).unwrap();
    // Of five windows, which scatter by 0.05.
    assert!((grown.rate - 0.13).abs() < 0.05, "{grown:?}");
    assert!(grown.rate > 3.0 * grown.error, "{grown:?}");
}

/// With the integral and the righting moment the depth still settles from 250 to 500 s; an independent simulation swings by 0.052 in then and
/// by 0.007 to 0.008 in later, 0.0048 in in a period.
#[test]
fn a_depth_that_still_settles_is_said_to_and_the_orbit_is_compared_with_what_is_left() {
    let slow = cases()
        .unwrap()
        .into_iter()
        .find(|case| case.leakage == Leakage::Tight && case.integral > 0.0 && case.restoring > 0.0)
        .unwrap();
    let mut dive = slow.run().unwrap();
    let motion = slow.motion(&mut dive).unwrap();
    let Motion::Orbit(orbit) = motion else {
        panic!("{motion:?}");
    };
    assert!(dive.settles());
    assert_near(dive.cycle.depth / INCH, 0.052, 0.03, "250 to 500 s");
    let left = dive.watched.swing(orbit.period) / INCH;
    assert_near(left, 0.0048, 0.02, "500 to 1000 s");
}

#[test]
fn the_vehicle_of_table_3_that_is_designed_for_is_the_thesis_own() {
    let thesis = pitch::model();
    assert_eq!(thesis, planesman_show::design::TABLE_3);
}
