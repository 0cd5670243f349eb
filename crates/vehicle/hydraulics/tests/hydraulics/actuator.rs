//! The actuator as the node uses it: plane commands in, plane motion out.

use std::sync::Arc;

use planesman_circuit::{Circuit, file as circuit_file};
use planesman_hydraulics::{
    Actuator, ActuatorFile, ActuatorParameters, ActuatorSet, Error, Output, actuator_file,
};
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::PlaneCommand;
use planesman_parameters::{Parameters as _, Value};

const TICK: i64 = 50_000_000;

fn with(changes: &[(&str, Value)]) -> ActuatorParameters {
    ActuatorParameters::default()
        .with(changes)
        .expect("declared")
}

fn actuator(changes: &[(&str, Value)]) -> Actuator {
    Actuator::new(&with(changes), TICK).expect("valid")
}

fn command(nanos: i64, angle: f64) -> PlaneCommand {
    let mut command = PlaneCommand {
        dive_planes: angle,
        ..PlaneCommand::default()
    };
    command.header.stamp = Time::from_nanos(nanos);
    command
}

fn answer(actuator: &mut Actuator, nanos: i64, angle: f64) -> Arc<Output> {
    actuator.on_command(&command(nanos, angle)).expect("finite")
}

#[test]
fn a_tick_of_motion_has_51_samples_and_the_next_goes_on_where_it_ends() {
    let mut actuator = actuator(&[]);
    let mut end = 0.0;
    for k in 0..40 {
        let output = answer(&mut actuator, k * TICK, 0.2);
        assert_eq!(output.motion.dive_planes.len(), 51);
        assert_eq!(output.motion.duration, Duration::from_nanos(TICK));
        assert_eq!(output.motion.dive_planes[0], end);
        assert_eq!(output.states()[0].plane_angle, end);
        assert_eq!(output.planes().position[0], end);
        assert_eq!(output.planes().name, ["dive_planes", "ram"]);
        end = output.motion.dive_planes[50];
    }
    assert!((end - 0.2).abs() < 0.01, "{end}");
}

/// What the flight of an actuator whose file is past every check ends by.
#[track_caller]
fn end_of_flight(file: ActuatorFile) -> Error {
    let parameters = ActuatorParameters::default();
    let of_file = Actuator::of_files(&parameters, TICK, |_| Ok(file.clone()));
    let mut actuator = of_file.expect("an actuator");
    let ends = |k: i64| {
        let angle = 0.1 * libm::sin(0.2 * k as f64);
        actuator.on_command(&command(k * TICK, angle)).err()
    };
    let end = (0..600).find_map(ends);
    end.expect("the flight ends")
}

#[test]
fn a_motion_that_cannot_be_solved_or_is_not_finite_is_an_error_with_time_and_field() {
    #[track_caller]
    fn metering(change: fn(&mut ActuatorSet)) -> Error {
        let mut set = actuator_file::load("auv").expect("built in");
        change(&mut set);
        end_of_flight(ActuatorFile::Metering(Box::new(set)))
    }
    #[track_caller]
    fn names(end: &Error, path: &str) {
        let by =
            format!("the search for the events of the motion does not end. The cause is {path}");
        assert!(end.to_string().ends_with(&by), "{end}");
    }
    names(&metering(|set| set.load.viscous = 1e20), "load.viscous");
    for change in [
        (|set| set.load.mass = 1e-310) as fn(&mut ActuatorSet),
        |set| set.rate_gain = 1e308,
    ] {
        let wild = metering(change);
        assert!(matches!(wild, Error::Motion { .. }), "{wild}");
        assert!(wild.to_string().contains(" s: "), "{wild}");
    }
    let circuit = |change: fn(&mut Circuit)| {
        let mut circuit = circuit_file::parse(circuit_file::BUILT_IN[0].1).expect("built in");
        change(&mut circuit);
        end_of_flight(ActuatorFile::Circuit(Arc::new(circuit)))
    };
    names(&circuit(|it| it.load.viscous = 1e30), "load.viscous");
    names(&circuit(|it| it.load.spring = 1e40), "load.spring");
    names(&circuit(|it| it.seal_leakage = 1e20), "seal_leakage");
    names(&circuit(|it| it.edges[0].valves[4] = 1e20), "edges.A-T");
}

#[test]
fn the_command_is_clipped_to_thirty_degrees() {
    let mut actuator = actuator(&[]);
    let mut last = None;
    for k in 0..60 {
        last = Some(answer(&mut actuator, k * TICK, -3.0));
    }
    let last = last.expect("answered");
    let thirty = 30f64.to_radians();
    assert!((last.states()[0].commanded_angle + thirty).abs() < 1e-12);
    assert!((last.states()[0].plane_angle + thirty).abs() < 0.5f64.to_radians());
}

#[test]
fn roll_rudder_and_thrust_pass_through_until_the_command_is_stale() {
    let mut actuator = actuator(&[]);
    let asked = PlaneCommand {
        roll_differential: 0.1,
        rudder: -3.0,
        thrust: 2.0,
        ..command(0, 0.0)
    };
    let motion = actuator.on_command(&asked).expect("finite").motion.clone();
    assert_eq!(motion.roll_differential, [0.1, 0.1]);
    assert_eq!(motion.rudder, [-std::f64::consts::FRAC_PI_6; 2]);
    assert_eq!(motion.thrust, [1.0, 1.0]);
    let held = actuator
        .on_silence(Time::from_nanos(TICK))
        .expect("answered")
        .motion
        .clone();
    assert_eq!(held.thrust, [1.0, 1.0]);
    let stale = actuator
        .on_silence(Time::from_nanos(100 * TICK))
        .expect("answered")
        .motion
        .clone();
    assert!(stale.thrust.is_empty() && stale.rudder.is_empty());
    assert!(stale.roll_differential.is_empty());
}

#[test]
fn the_same_stamp_gets_the_same_answer() {
    let mut actuator = actuator(&[]);
    answer(&mut actuator, 0, 0.1);
    let first = answer(&mut actuator, TICK, 0.1);
    assert_eq!(answer(&mut actuator, TICK, 0.1), first);
    assert_eq!(
        actuator
            .on_silence(Time::from_nanos(TICK))
            .expect("answered"),
        first
    );
    let mut undisturbed = actuator.clone();
    assert_eq!(
        answer(&mut actuator, 2 * TICK, 0.1),
        answer(&mut undisturbed, 2 * TICK, 0.1)
    );
}

#[test]
fn the_tick_before_can_be_told_again_until_a_new_run_begins() {
    let mut actuator = actuator(&[]);
    assert_eq!(actuator.before(), None);
    let first = answer(&mut actuator, 0, 0.1);
    assert_eq!(actuator.before(), None);
    let second = answer(&mut actuator, TICK, 0.1);
    assert_eq!(actuator.before(), Some(&first));
    answer(&mut actuator, TICK, 0.1);
    assert_eq!(actuator.before(), Some(&first), "a repeat changes nothing");
    answer(&mut actuator, 2 * TICK, 0.1);
    assert_eq!(actuator.before(), Some(&second));
    answer(&mut actuator, 0, 0.1);
    assert_eq!(actuator.before(), None, "a new run");
}

#[test]
fn left_out_ticks_are_caught_up_by_holding_the_command() {
    let (mut every, mut some) = (actuator(&[]), actuator(&[]));
    for k in 0..8 {
        answer(&mut every, k * TICK, 0.3);
    }
    answer(&mut some, 0, 0.3);
    assert_eq!(
        answer(&mut every, 8 * TICK, 0.1),
        answer(&mut some, 8 * TICK, 0.1)
    );
}

#[test]
fn a_stamp_within_the_tick_cuts_it_short() {
    let mut whole = Actuator::new(&with(&[]), TICK).expect("valid");
    let mut long = Actuator::new(&with(&[]), 10 * TICK).expect("valid");
    for k in 0..30 {
        let angle = 0.3 * libm::sin(k as f64);
        let a = answer(&mut whole, k * TICK, angle);
        let b = answer(&mut long, k * TICK, angle);
        assert_eq!(a.planes(), b.planes());
        assert_eq!(a.states()[0].volume, b.states()[0].volume);
    }
}

#[test]
fn without_commands_the_planes_hold_and_then_go_to_neutral_flagged() {
    let mut actuator = actuator(&[]);
    for k in 0..20 {
        answer(&mut actuator, k * TICK, 0.3);
    }
    let mut silent = |k: i64| {
        actuator
            .on_silence(Time::from_nanos(k * TICK))
            .expect("answered")
            .states()[0]
            .clone()
    };
    let held = (20..29).map(&mut silent).next_back().expect("answered");
    assert!(!held.command_stale && held.commanded_angle == 0.3);
    let stale = silent(29);
    assert!(stale.command_stale && stale.commanded_angle == 0.0);
    let neutral = (30..60).map(&mut silent).next_back().expect("answered");
    assert!(neutral.plane_angle.abs() < 0.5f64.to_radians());
    let back = answer(&mut actuator, 60 * TICK, 0.1).states()[0].clone();
    assert!(!back.command_stale && back.commanded_angle == 0.1);
}

#[test]
fn before_the_first_command_neutral_is_asked_for() {
    let mut actuator = actuator(&[]);
    let first = actuator
        .on_silence(Time::from_nanos(0))
        .expect("answered")
        .states()[0]
        .clone();
    assert!(first.command_stale && first.commanded_angle == 0.0);
}

#[test]
fn a_command_after_its_tick_was_answered_in_silence_acts_from_the_next_on() {
    let mut actuator = actuator(&[]);
    answer(&mut actuator, 0, 0.0);
    let silent = actuator
        .on_silence(Time::from_nanos(2 * TICK))
        .expect("answered");
    assert_eq!(answer(&mut actuator, TICK, 0.2), silent);
    let next = actuator
        .on_silence(Time::from_nanos(3 * TICK))
        .expect("answered");
    assert_eq!(next.states()[0].commanded_angle, 0.2);
}

#[test]
fn so_does_the_first_command_of_all_but_not_in_a_vehicle_that_was_set_back() {
    let mut actuator = actuator(&[]);
    let silence = |actuator: &mut Actuator, k: i64| {
        actuator
            .on_silence(Time::from_nanos(k * TICK))
            .expect("answered")
    };
    silence(&mut actuator, 5);
    let silent = silence(&mut actuator, 7);
    assert_eq!(answer(&mut actuator, 5 * TICK, 0.2), silent);
    assert_eq!(silence(&mut actuator, 8).states()[0].commanded_angle, 0.2);
    actuator.restart();
    let first = answer(&mut actuator, 6 * TICK, 0.2);
    assert_eq!(first.motion.header.stamp.nanos(), 6 * TICK);
}

#[test]
fn a_clock_set_back_or_far_on_begins_a_new_run() {
    let mut fresh = actuator(&[]);
    let first = answer(&mut fresh, 0, 0.2);
    let mut used = actuator(&[]);
    for k in 100..140 {
        answer(&mut used, k * TICK, 0.3);
    }
    assert_eq!(answer(&mut used, 0, 0.2), first);
    let far = answer(&mut used, 3_600_000_000_000, 0.2);
    assert_eq!(far.motion.dive_planes, first.motion.dive_planes);
    assert_eq!(far.states()[0].pulses, first.states()[0].pulses);
}

#[test]
fn what_is_not_finite_is_refused_and_changes_nothing() {
    let mut actuator = actuator(&[]);
    answer(&mut actuator, 0, 0.2);
    let before = format!("{actuator:?}");
    for bad in [f64::NAN, f64::INFINITY] {
        let error = actuator
            .on_command(&command(TICK, bad))
            .expect_err("refused");
        assert!(error.to_string().contains("dive_planes"), "{error}");
    }
    assert_eq!(format!("{actuator:?}"), before);
}

#[test]
fn no_stamp_is_beyond_it() {
    let mut actuator = actuator(&[]);
    let seconds = 1_000_000_000 * i64::from(i32::MAX);
    for stamp in [0, seconds, -seconds, 1, seconds - 1, seconds] {
        let output = answer(&mut actuator, stamp, 0.1);
        assert!(
            output
                .motion
                .dive_planes
                .iter()
                .all(|angle| angle.is_finite())
        );
    }
}

#[test]
fn the_ideal_actuator_is_at_its_command_at_once() {
    let mut actuator = actuator(&[("model", Value::from("ideal"))]);
    let output = answer(&mut actuator, 0, 0.25);
    assert!(output.motion.dive_planes.iter().all(|angle| *angle == 0.25));
    assert_eq!(output.states()[0].plane_angle, 0.25);
}

#[test]
fn the_first_order_actuator_slews_and_settles() {
    let mut actuator = actuator(&[("model", Value::from("first_order"))]);
    let motion = answer(&mut actuator, 0, 0.5).motion.dive_planes.clone();
    let rate = (motion[50] - motion[10]) / 0.04;
    assert!((rate.to_degrees() - 40.0).abs() < 1e-9, "{rate}");
    let last = (1..30).map(|k| answer(&mut actuator, k * TICK, 0.5)).last();
    let state = last.expect("answered").states()[0].clone();
    assert!((state.plane_angle - 0.5).abs() < 1e-9);
    assert_eq!((state.pressure, state.pulses), (0.0, 0));
}

/// Bow, stern, roll and rudder with an actuator each.
fn each(changes: &[(&str, Value)]) -> Actuator {
    let mut all = vec![("groups", Value::from("each"))];
    all.extend_from_slice(changes);
    actuator(&all)
}

#[test]
fn each_group_follows_its_own_command_with_its_own_actuator() {
    let mut actuator = each(&[
        ("bow.actuator", Value::from("auv_two_speed")),
        ("roll.model", Value::from("first_order")),
        ("rudder.model", Value::from("ideal")),
    ]);
    let mut last = None;
    for k in 0..40 {
        let asked = PlaneCommand {
            bow_stern_differential: 0.125,
            roll_differential: -0.2,
            rudder: 0.3,
            ..command(k * TICK, 0.25)
        };
        last = Some(actuator.on_command(&asked).expect("finite"));
    }
    let last = last.expect("answered");
    let (motion, planes, states) = (&last.motion, last.planes(), last.states());
    let close = |angle: f64, asked: f64| assert!((angle - asked).abs() < 0.015, "{angle}");
    for (state, (group, asked)) in states.iter().zip([
        ("bow", 0.375),
        ("stern", 0.125),
        ("roll", -0.2),
        ("rudder", 0.3),
    ]) {
        assert_eq!(
            (state.group.as_str(), state.commanded_angle),
            (group, asked)
        );
        close(state.plane_angle, asked);
    }
    // The bow's volumes are of one degree, the stern's of half a degree.
    assert!(states[0].pulses < 30 && states[1].pulses > 10);
    assert_eq!((states[2].pulses, states[3].pulses), (0, 0));
    close(motion.dive_planes[50], 0.25);
    close(motion.bow_stern_differential[50], 0.125);
    close(motion.roll_differential[50], -0.2);
    assert_eq!(motion.rudder, [0.3; 51]);
    assert_eq!(planes.name[..3], ["dive_planes", "bow", "bow_ram"]);
    assert_eq!(planes.position.len(), 9);
    assert_eq!(planes.position[0], motion.dive_planes[0]);
    assert!(motion.first_non_finite().is_none());
}

#[test]
fn each_with_equal_actuators_moves_the_dive_planes_as_one_ram_does() {
    let (mut one, mut four) = (actuator(&[]), each(&[]));
    for k in 0..100 {
        let angle = 0.4 * libm::sin(0.1 * k as f64);
        let (one, four) = (
            answer(&mut one, k * TICK, angle),
            answer(&mut four, k * TICK, angle),
        );
        assert_eq!(four.motion.dive_planes, one.motion.dive_planes);
        assert!(four.motion.bow_stern_differential.iter().all(|d| *d == 0.0));
    }
}

#[test]
fn a_fault_befalls_its_group_from_the_next_tick_on_and_is_reported() {
    let mut actuator = each(&[]);
    answer(&mut actuator, 0, 0.3);
    assert!(actuator.faults().is_empty());
    let ill = with(&[
        ("groups", Value::from("each")),
        ("fault.group", Value::from("stern")),
        ("fault.lost_supply", Value::from(0.9)),
    ]);
    actuator.set_parameters(&ill).expect("accepted");
    assert_eq!(actuator.faults(), ["stern: supply pressure low by 90.0 %"]);
    let states = (1..40)
        .map(|k| answer(&mut actuator, k * TICK, 0.3).states())
        .last()
        .expect("answered");
    assert!(states[0].faults.is_empty() && states[0].plane_angle > 0.29);
    assert_eq!(states[1].faults, "supply pressure low by 90.0 %");
    assert!(states[1].plane_angle < 0.1, "{}", states[1].plane_angle);
    let sound = with(&[("groups", Value::from("each"))]);
    actuator.set_parameters(&sound).expect("accepted");
    let mended = (40..80)
        .map(|k| answer(&mut actuator, k * TICK, 0.3).states())
        .last()
        .expect("answered");
    assert!(mended[1].faults.is_empty() && mended[1].plane_angle > 0.28);
}

#[test]
fn faults_that_cannot_be_are_refused_as_a_set() {
    for (changes, rule) in [
        (
            vec![
                ("fault.group", Value::from("rudder")),
                ("fault.air", 0.5.into()),
            ],
            "no actuator belongs to fault.group 'rudder'; known: all, dive_planes",
        ),
        (
            vec![("model", Value::from("ideal")), ("fault.air", 0.5.into())],
            "could fail",
        ),
        (
            vec![
                ("groups", Value::from("each")),
                ("rudder.model", Value::from("first_order")),
                ("fault.group", Value::from("rudder")),
                ("fault.encoder", Value::from("lost")),
            ],
            "fault.group 'rudder' has no",
        ),
        (
            vec![("fault.stuck_valve", Value::from("both"))],
            "fault.stuck_valve",
        ),
    ] {
        let error = match ActuatorParameters::default().with(&changes) {
            Ok(parameters) => Actuator::new(&parameters, TICK)
                .expect_err(rule)
                .to_string(),
            Err(refusal) => refusal.to_string(),
        };
        assert!(error.contains(rule), "{error}");
    }
}

#[test]
fn the_state_tells_power_slewing_and_the_limit_cycle() {
    let mut actuator = actuator(&[]);
    answer(&mut actuator, 0, 0.0);
    let slews = answer(&mut actuator, TICK, 0.5).states()[0].clone();
    assert!(slews.slewing && slews.pulses == 4 && !slews.inhibited);
    // Four volumes of half a degree against 80 psi in a tick.
    let watts = 4.0 * 80.0 * 6894.757 * 3.5752e-9 / 0.05;
    assert!(
        (slews.hydraulic_power / watts - 1.0).abs() < 1e-3,
        "{} W for {watts} W",
        slews.hydraulic_power
    );
    assert_eq!(slews.limit_cycle_frequency, 0.0);
    // Held at a constant angle, the drift and its correction make a limit cycle.
    let mut held = Vec::new();
    for k in 2..1200 {
        held.push(answer(&mut actuator, k * TICK, 0.1).states()[0].clone());
    }
    let last = held.last().expect("answered");
    assert!(!last.slewing && last.sign_changes > 20);
    let cycles = (last.sign_changes - held[200].sign_changes) as f64 / 2.0;
    let frequency = cycles / (0.05 * (held.len() - 201) as f64);
    assert!(
        (last.limit_cycle_frequency / frequency - 1.0).abs() < 0.1,
        "{} Hz for {frequency} Hz",
        last.limit_cycle_frequency
    );
    let covered = held[200..].iter().map(|state| state.plane_angle);
    let high = covered.clone().fold(f64::NEG_INFINITY, f64::max);
    let low = covered.fold(f64::INFINITY, f64::min);
    let amplitude = last.limit_cycle_amplitude;
    assert!(amplitude > 0.0 && amplitude <= 0.5 * (high - low) * 1.01);
}

#[test]
fn parameters_take_effect_at_the_next_tick() {
    let mut actuator = actuator(&[]);
    answer(&mut actuator, 0, 0.5);
    actuator
        .set_parameters(&with(&[("command_limit", Value::Double(0.1))]))
        .expect("accepted");
    let next = answer(&mut actuator, TICK, 0.5);
    assert_eq!(next.states()[0].commanded_angle, 0.1);
    let changed = with(&[("model", Value::from("ideal"))]);
    assert!(actuator.set_parameters(&changed).is_err());
    let two_speed = with(&[("logic.mode", Value::from("two_speed"))]);
    let error = actuator.set_parameters(&two_speed).expect_err("refused");
    assert!(error.to_string().contains("small_volume"), "{error}");
    assert!(Actuator::new(&two_speed, TICK).is_err());
    let unknown = with(&[("actuator", Value::from("no/such.yaml"))]);
    let error = Actuator::new(&unknown, TICK).expect_err("refused");
    assert!(error.to_string().contains("no/such.yaml"), "{error}");
    assert!(Actuator::new(&with(&[]), 0).is_err());
}

#[test]
fn the_sample_interval_divides_the_tick() {
    for (interval, samples) in [(0.001, 51), (0.005, 11), (0.02, 4), (1.0, 2)] {
        let mut actuator = actuator(&[("sample_interval", Value::Double(interval))]);
        let motion = answer(&mut actuator, 0, 0.2).motion.clone();
        assert_eq!(motion.dive_planes.len(), samples, "{interval} s");
    }
}

#[test]
fn the_drift_option_decides_where_precision_logic_lets_the_ram_drift() {
    let angle = |option: i64| {
        let mut actuator = actuator(&[
            ("logic.mode", Value::from("precision")),
            ("logic.drift_option", Value::from(option)),
        ]);
        for k in 0..40 {
            answer(&mut actuator, k * TICK, 0.101);
        }
        answer(&mut actuator, 40 * TICK, 0.101).motion.dive_planes[0]
    };
    // By the error's sign it drifts to the command; by the last command's it may drift away from it.
    let misses = [1, 2, 3].map(|option| (angle(option) - 0.101).abs());
    assert!(misses[1] < misses[0] || misses[1] < misses[2], "{misses:?}");
}
