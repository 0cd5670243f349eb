//! The controller as the node uses it: states in, plane commands out.

use planesman_control::{Controller, ControllerParameters, Fault, Mode, Quantity};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::action::ManoeuvreGoal;
use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand, VehicleState};
use planesman_parameters::{Choice as _, Parameters as _, Value};
use std::f64::consts::FRAC_PI_6;

const TICK: i64 = 50_000_000;

fn with(changes: &[(&str, Value)]) -> ControllerParameters {
    ControllerParameters::default().with(changes).unwrap()
}

fn controller(changes: &[(&str, Value)]) -> Controller {
    Controller::new(&with(changes)).unwrap()
}

fn state(tick: i64) -> VehicleState {
    let mut state = VehicleState::default();
    state.header.stamp = Time::from_nanos(tick * TICK);
    state
}

#[test]
fn a_deeper_setpoint_dives_the_planes_and_the_answer_bears_the_states_stamp() {
    let mut controller = controller(&[]);
    controller.set_setpoint(Quantity::Depth, 0.1).unwrap();
    let (command, control) = controller.on_state(&state(3)).unwrap();
    assert!(command.dive_planes > 0.0);
    assert!(control.pitch_command < 0.0);
    assert_eq!(command.header.stamp, Time::from_nanos(3 * TICK));
    assert_eq!(control.header, command.header);
    assert_eq!(control.dive_planes, control.planes_p + control.planes_rate);
}

#[test]
fn a_stamp_seen_again_gets_the_same_answer_even_after_a_change() {
    let mut controller = controller(&[]);
    controller.set_setpoint(Quantity::Depth, 0.1).unwrap();
    let first = controller.on_state(&state(0)).unwrap();
    controller.set_setpoint(Quantity::Depth, 0.2).unwrap();
    controller
        .set_parameters(&with(&[("pitch.p", Value::Double(0.1))]))
        .unwrap();
    assert_eq!(controller.on_state(&state(0)).unwrap(), first);
    assert_ne!(
        controller.on_state(&state(1)).unwrap().0.dive_planes,
        first.0.dive_planes
    );
}

#[test]
fn the_schedule_runs_from_the_first_state_and_the_topic_overrides_it() {
    let mut controller = controller(&[
        ("depth_setpoint", Value::Double(0.05)),
        ("schedule.times", Value::DoubleArray(vec![0.1, 0.2])),
        ("schedule.depths", Value::DoubleArray(vec![0.3, 0.4])),
    ]);
    let setpoint = |controller: &mut Controller, tick: i64| {
        controller
            .on_state(&state(1000 + tick))
            .unwrap()
            .1
            .depth_setpoint
    };
    for (tick, depth) in [(0, 0.05), (1, 0.05), (2, 0.3), (3, 0.3), (4, 0.4)] {
        assert_eq!(setpoint(&mut controller, tick), depth);
    }
    controller.set_setpoint(Quantity::Depth, 0.7).unwrap();
    assert_eq!(setpoint(&mut controller, 5), 0.7);
}

#[test]
fn the_last_depth_command_counts() {
    let mut controller = controller(&[]);
    controller.set_setpoint(Quantity::Depth, 0.7).unwrap();
    let changed = [("depth_setpoint", Value::Double(0.2))];
    controller.set_parameters(&with(&changed)).unwrap();
    assert_eq!(
        controller.on_state(&state(0)).unwrap().1.depth_setpoint,
        0.2
    );
    let scheduled = [
        ("depth_setpoint", Value::Double(0.2)),
        ("schedule.times", Value::DoubleArray(vec![0.0])),
        ("schedule.depths", Value::DoubleArray(vec![0.3])),
    ];
    controller.set_parameters(&with(&scheduled)).unwrap();
    assert_eq!(
        controller.on_state(&state(1)).unwrap().1.depth_setpoint,
        0.3
    );
}

#[test]
fn an_earlier_stamp_begins_the_run_again() {
    let changes = [
        ("schedule.times", Value::DoubleArray(vec![0.0, 0.1])),
        ("schedule.depths", Value::DoubleArray(vec![0.3, 0.4])),
    ];
    let mut controller = controller(&changes);
    let first = controller.on_state(&state(0)).unwrap();
    for tick in 1..5 {
        controller.on_state(&state(tick)).unwrap();
    }
    controller.set_setpoint(Quantity::Depth, 0.9).unwrap();
    assert_eq!(controller.on_state(&state(0)).unwrap(), first);
}

#[test]
fn the_test_signal_is_added_in_every_mode_that_moves_the_planes() {
    for mode in Mode::NAMES[1..].iter().filter(|mode| **mode != "hover") {
        let mut controller = controller(&[
            ("mode", Value::from(*mode)),
            ("identification.signal", Value::from("square")),
            ("identification.amplitude", Value::Double(0.1)),
            ("identification.period", Value::Double(0.1)),
        ]);
        assert_eq!(controller.on_state(&state(0)).unwrap().0.dive_planes, 0.1);
        assert_eq!(controller.on_state(&state(1)).unwrap().0.dive_planes, -0.1);
    }
}

#[test]
fn switched_off_everything_is_neutral_at_once() {
    let mut controller = controller(&[
        ("depth_setpoint", Value::Double(5.0)),
        ("speed.active", Value::Bool(true)),
    ]);
    let mut adrift = state(0);
    (adrift.roll, adrift.yaw) = (0.1, 0.2);
    let (command, _) = controller.on_state(&adrift).unwrap();
    for angle in [command.dive_planes, command.rudder, command.thrust] {
        assert_ne!(angle, 0.0);
    }
    let off = [
        ("mode", Value::from("off")),
        ("identification.signal", Value::from("step")),
    ];
    controller.set_parameters(&with(&off)).unwrap();
    adrift.header.stamp = Time::from_nanos(TICK);
    let (command, control) = controller.on_state(&adrift).unwrap();
    let neutral = PlaneCommand {
        header: command.header.clone(),
        ..PlaneCommand::default()
    };
    assert_eq!(command, neutral);
    assert_eq!(control.mode, ControlState::MODE_OFF);
}

#[test]
fn roll_is_held_level_within_what_the_dive_leaves_of_the_bow_planes() {
    let mut controller = controller(&[]);
    let mut heeled = state(0);
    heeled.roll = 0.01;
    let (command, _) = controller.on_state(&heeled).unwrap();
    assert!(
        (command.roll_differential + 0.1).abs() < 1e-15,
        "port side down"
    );
    controller.set_setpoint(Quantity::Depth, 100.0).unwrap();
    heeled.header.stamp = Time::from_nanos(TICK);
    let (command, _) = controller.on_state(&heeled).unwrap();
    assert_eq!(command.dive_planes, FRAC_PI_6);
    assert_eq!(command.roll_differential, 0.0);
}

#[test]
fn a_heading_from_the_topic_is_steered_the_short_way_at_its_rate() {
    let mut controller = controller(&[("heading.setpoint_rate", Value::Double(0.2))]);
    controller.set_setpoint(Quantity::Heading, -3.0).unwrap();
    let mut off_heading = state(0);
    off_heading.yaw = 3.0;
    let (command, control) = controller.on_state(&off_heading).unwrap();
    assert!(control.heading_held);
    assert_eq!((command.rudder, control.heading_setpoint), (0.0, 3.0));
    off_heading.header.stamp = Time::from_nanos(TICK);
    let (command, control) = controller.on_state(&off_heading).unwrap();
    assert!((control.heading_error - 0.2 * 0.05).abs() < 1e-12);
    assert!((command.rudder - 0.2 * 0.05).abs() < 1e-12, "to starboard");
}

#[test]
fn a_speed_is_held_once_it_is_asked_for() {
    let mut controller = controller(&[]);
    let (command, control) = controller.on_state(&state(0)).unwrap();
    assert!(!control.speed_held);
    assert_eq!(command.thrust, 0.0);
    controller.set_setpoint(Quantity::Speed, 0.3).unwrap();
    let (command, control) = controller.on_state(&state(1)).unwrap();
    assert!(control.speed_held);
    assert!((command.thrust - (0.3 / 1.524 + 2.0 * 0.3)).abs() < 1e-12);
}

#[test]
fn bow_or_stern_planes_dive_alone_when_asked_to() {
    for (allocation, bow, stern) in [("bow", 1.0, 0.0), ("stern", 0.0, 1.0)] {
        let mut controller = controller(&[
            ("planes.allocation", Value::from(allocation)),
            ("depth_setpoint", Value::Double(100.0)),
        ]);
        let (command, _) = controller.on_state(&state(0)).unwrap();
        let differential = command.bow_stern_differential;
        assert_eq!(command.dive_planes + differential, bow * FRAC_PI_6);
        assert_eq!(command.dive_planes - differential, stern * FRAC_PI_6);
    }
}

#[test]
fn a_depth_setpoint_is_limited_and_moves_at_its_rate() {
    let mut controller = controller(&[
        ("depth.max", Value::Double(2.0)),
        ("depth.setpoint_rate", Value::Double(1.0)),
    ]);
    controller.set_setpoint(Quantity::Depth, 5.0).unwrap();
    let mut setpoints = (0..100).map(|tick| controller.on_state(&state(tick)).unwrap().1);
    let first = setpoints.next().unwrap();
    assert_eq!((first.depth_target, first.depth_setpoint), (5.0, 0.0));
    assert_eq!(first.depth_setpoint_source, ControlState::SETPOINT_TOPIC);
    assert!((setpoints.next().unwrap().depth_setpoint - 0.05).abs() < 1e-12);
    assert_eq!(setpoints.last().unwrap().depth_setpoint, 2.0);
}

#[test]
fn a_setpoint_from_the_topic_holds_as_long_as_it_is_allowed_to() {
    let mut controller = controller(&[("setpoint_timeout", Value::Double(0.1))]);
    controller.on_state(&state(0)).unwrap();
    controller.set_setpoint(Quantity::Depth, 5.0).unwrap();
    let mut setpoint = |tick| controller.on_state(&state(tick)).unwrap().1.depth_setpoint;
    assert_eq!([1, 2, 3].map(&mut setpoint), [5.0, 5.0, 0.0]);
    assert_eq!(controller.take_changes().len(), 1);
}

#[test]
fn way_depths_follow_the_distance_run() {
    let mut controller = controller(&[
        ("schedule.distances", Value::DoubleArray(vec![0.0, 10.0])),
        ("schedule.depths", Value::DoubleArray(vec![1.0, 3.0])),
    ]);
    let mut setpoint = |tick, distance| {
        let mut state = state(tick);
        state.distance = distance;
        let (_, control) = controller.on_state(&state).unwrap();
        assert_eq!(
            control.depth_setpoint_source,
            ControlState::SETPOINT_SCHEDULE
        );
        control.depth_setpoint
    };
    assert_eq!(setpoint(0, 100.0), 1.0, "the run begins here");
    assert_eq!(setpoint(1, 109.9), 1.0);
    assert_eq!(setpoint(2, 110.0), 3.0);
}

#[test]
fn an_integral_takes_away_what_a_trim_moment_leaves() {
    // A plant that answers the planes at once and is pulled bow up by 0.1 rad.
    let settled = |gain: f64| {
        let mut controller = controller(&[
            ("mode", Value::from("pitch")),
            ("pitch.i", Value::Double(gain)),
        ]);
        (0..4000).fold(0.1, |pitch, tick| {
            let mut state = state(tick);
            state.pitch = pitch;
            let (command, _) = controller.on_state(&state).unwrap();
            0.9 * pitch + 0.1 * (0.1 - command.dive_planes)
        })
    };
    assert!((settled(0.0) - 0.1 / 1.7).abs() < 1e-9);
    assert!(settled(0.5).abs() < 1e-6);
}

#[test]
fn pitch_is_held_within_the_limit() {
    let mut controller = controller(&[("mode", Value::from("pitch"))]);
    controller.set_setpoint(Quantity::Pitch, -0.2).unwrap();
    let (command, control) = controller.on_state(&state(0)).unwrap();
    assert!((command.dive_planes - 0.7 * 0.2).abs() < 1e-15);
    assert_eq!(control.mode, ControlState::MODE_PITCH);
    assert_eq!(
        controller.set_setpoint(Quantity::Pitch, -1.5).unwrap(),
        -std::f64::consts::FRAC_PI_4
    );
    let (_, control) = controller.on_state(&state(1)).unwrap();
    assert!(control.pitch_command_limited);
    assert_eq!(control.pitch_command, -std::f64::consts::FRAC_PI_4);
}

#[test]
fn silence_puts_the_planes_to_neutral_and_says_so() {
    let mut controller = controller(&[("depth_setpoint", Value::Double(5.0))]);
    controller.on_state(&state(0)).unwrap();
    let (command, control) = controller.on_silence(Time::from_nanos(20 * TICK));
    assert_eq!(command.dive_planes, 0.0);
    assert!(control.feedback_stale);
    assert!(!controller.on_state(&state(1)).unwrap().1.feedback_stale);
}

#[test]
fn what_is_not_finite_is_refused_and_changes_nothing() {
    let mut controller = controller(&[("depth_setpoint", Value::Double(0.1))]);
    let before = controller.on_state(&state(1)).unwrap();
    let mut bad = state(0);
    bad.pitch_rate = f64::NAN;
    assert!(
        controller
            .on_state(&bad)
            .unwrap_err()
            .to_string()
            .contains("pitch_rate")
    );
    assert!(
        controller
            .set_setpoint(Quantity::Depth, f64::INFINITY)
            .is_err()
    );
    assert!(controller.set_setpoint(Quantity::Pitch, f64::NAN).is_err());
    assert_eq!(controller.on_state(&state(1)).unwrap(), before);
}

#[test]
fn a_setpoint_that_its_parameter_would_refuse_is_refused_and_the_last_one_stays() {
    let mut controller = controller(&[("depth_setpoint", Value::Double(0.1))]);
    for (quantity, value, rule) in [
        (Quantity::Depth, -3.0, "[0, 10000] m, positive down"),
        (Quantity::Pitch, 30.0, "rad, positive bow up"),
        (Quantity::Heading, 90.0, "rad, positive to starboard"),
        (Quantity::Speed, -0.5, "[0, 10] m/s"),
    ] {
        let refusal = controller.set_setpoint(quantity, value).unwrap_err();
        let refusal = refusal.to_string();
        assert!(refusal.contains(rule), "{refusal}");
        let (_, control) = controller.on_state(&state(1)).unwrap();
        assert_eq!(control.depth_setpoint, 0.1);
        assert_eq!(control.heading_setpoint, 0.0);
        assert!(!control.speed_held);
    }
}

#[test]
fn a_vehicle_that_was_reset_begins_a_new_run_though_its_time_goes_on() {
    let mut controller = controller(&[
        ("depth.i", Value::Double(0.5)),
        ("schedule.times", Value::DoubleArray(vec![0.0, 1.0])),
        ("schedule.depths", Value::DoubleArray(vec![1.0, 3.0])),
    ]);
    let first = controller.on_state(&state(0)).unwrap();
    for tick in 1..40 {
        controller.on_state(&state(tick)).unwrap();
    }
    let mut reset = state(40);
    reset.planes_source = VehicleState::PLANES_RESET;
    let (command, control) = controller.on_state(&reset).unwrap();
    assert_eq!(command.dive_planes, first.0.dive_planes);
    assert_eq!(control.depth_setpoint, 1.0, "the schedule begins anew");
}

fn deep(tick: i64, depth: f64) -> VehicleState {
    let mut state = state(tick);
    state.depth = depth;
    state
}

#[test]
fn below_the_floor_it_climbs_then_goes_neutral_and_stays_so_until_it_is_reset() {
    let mut controller = controller(&[
        ("safety.floor", Value::Double(3.0)),
        ("depth.max", Value::Double(2.5)),
        ("depth_setpoint", Value::Double(2.0)),
    ]);
    let climb = -10_f64.to_radians();
    for (tick, depth, planes) in [
        (0, 3.1, climb),
        (1, 2.8, climb),
        (2, 2.7, 0.0),
        (3, 1.0, 0.0),
    ] {
        let (command, control) = controller.on_state(&deep(tick, depth)).unwrap();
        assert_eq!(command.dive_planes, planes, "tick {tick}");
        assert_eq!(control.fault, ControlState::FAULT_FLOOR);
        assert_eq!(control.climbing, planes != 0.0);
        assert_eq!(command.rudder, 0.0);
    }
    // Neither a new run nor another mode takes it back.
    assert_eq!(
        controller.on_state(&deep(0, 1.0)).unwrap().1.fault,
        ControlState::FAULT_FLOOR
    );
    let goal = ManoeuvreGoal {
        name: "pulse".to_owned(),
        amplitude: 0.1,
        period: 1.0,
        ..ManoeuvreGoal::default()
    };
    let refusal = controller.begin_manoeuvre(&goal).unwrap_err().to_string();
    assert!(refusal.contains("safety.floor"), "{refusal}");

    assert_eq!(controller.reset_fault(), Ok(Fault::Floor));
    let (command, control) = controller.on_state(&deep(1, 1.0)).unwrap();
    assert_eq!(control.fault, ControlState::FAULT_NONE);
    assert!(command.dive_planes.abs() < 1e-13, "without a bump");
    let (command, _) = controller.on_state(&deep(2, 1.0)).unwrap();
    assert!(command.dive_planes > 0.0);
    assert!(controller.begin_manoeuvre(&goal).is_ok());
}

#[test]
fn a_manoeuvre_is_broken_off_by_a_fault() {
    let mut controller = controller(&[("safety.pitch", Value::Double(1.0))]);
    let goal = ManoeuvreGoal {
        name: "step".to_owned(),
        amplitude: 0.1,
        duration: 10.0,
        ..ManoeuvreGoal::default()
    };
    controller.begin_manoeuvre(&goal).unwrap();
    assert_eq!(controller.on_state(&state(0)).unwrap().1.manoeuvre, 0.1);
    assert_eq!(controller.manoeuvre_end(), None);
    let mut pitched = state(1);
    pitched.pitch = 1.1;
    let (command, control) = controller.on_state(&pitched).unwrap();
    assert_eq!((command.dive_planes, control.manoeuvre), (0.0, 0.0));
    assert_eq!(control.fault, ControlState::FAULT_BOW_UP);
    let end = controller.manoeuvre_end().unwrap().unwrap_err().to_string();
    assert!(end.contains("broken off"), "{end}");
}

#[test]
fn silence_stays_a_fault_where_it_is_to() {
    let mut controller = controller(&[("safety.latch_silence", Value::Bool(true))]);
    controller.on_state(&state(0)).unwrap();
    let (_, control) = controller.on_silence(Time::from_nanos(20 * TICK));
    assert_eq!(control.fault, ControlState::FAULT_SILENCE);
    assert!(
        controller
            .reset_fault()
            .unwrap_err()
            .to_string()
            .contains("no vehicle state")
    );
    let (_, control) = controller.on_state(&state(21)).unwrap();
    assert_eq!(control.fault, ControlState::FAULT_SILENCE);
    assert_eq!(controller.reset_fault(), Ok(Fault::Silence));
    assert_eq!(
        controller.on_state(&state(22)).unwrap().1.fault,
        ControlState::FAULT_NONE
    );
}

#[test]
fn the_dive_command_is_shared_in_the_ratio_of_bow_to_stern() {
    for (ratio, bow, stern) in [(0.5, 0.5, 1.0), (4.0, 1.0, 0.25)] {
        let mut controller = controller(&[
            ("planes.allocation", Value::from("ratio")),
            ("planes.bow_to_stern", Value::Double(ratio)),
            ("depth_setpoint", Value::Double(100.0)),
        ]);
        let (command, _) = controller.on_state(&state(0)).unwrap();
        let differential = command.bow_stern_differential;
        assert!((command.dive_planes + differential - bow * FRAC_PI_6).abs() < 1e-15);
        assert!((command.dive_planes - differential - stern * FRAC_PI_6).abs() < 1e-15);
    }
}

#[test]
fn the_plane_command_moves_at_most_at_its_rate() {
    let mut controller = controller(&[
        ("planes.rate_limit", Value::Double(0.4)),
        ("depth_setpoint", Value::Double(100.0)),
    ]);
    let angles = [0, 1, 2].map(|tick| controller.on_state(&state(tick)).unwrap().0.dive_planes);
    for pair in angles.windows(2) {
        assert!((pair[1] - pair[0] - 0.4 * 0.05).abs() < 1e-12, "{angles:?}");
    }
}

#[test]
fn below_the_lowest_speed_scheduled_gains_no_longer_grow() {
    let planes = |speed: f64, lowest: f64| {
        let mut controller = controller(&[
            ("gains.source", Value::from("scheduled")),
            ("gains.lowest_speed", Value::Double(lowest)),
            ("feedback.speed", Value::Double(speed)),
            ("depth_setpoint", Value::Double(0.01)),
        ]);
        controller.on_state(&state(0)).unwrap().0.dive_planes
    };
    assert_eq!(planes(0.1, 0.2), planes(0.2, 0.2));
    assert!(planes(0.1, 0.05) > planes(0.1, 0.2));
}

#[test]
fn new_way_points_are_followed_from_the_first_and_one_that_is_repeated_is_one() {
    let path = |x: [f64; 3], y: [f64; 3]| {
        [
            ("heading.active", Value::Bool(true)),
            ("waypoints.x", Value::DoubleArray(x.to_vec())),
            ("waypoints.y", Value::DoubleArray(y.to_vec())),
        ]
    };
    let mut controller = controller(&path([10.0, 20.0, 30.0], [0.0; 3]));
    let heading = |controller: &mut Controller, tick: i64| {
        let mut there = state(tick);
        there.distance = 25.0;
        controller.on_state(&there).unwrap().1.heading_setpoint
    };
    heading(&mut controller, 0);
    controller
        .set_parameters(&with(&path([25.0; 3], [40.0; 3])))
        .unwrap();
    // From where it is, to starboard.
    let course = heading(&mut controller, 1);
    assert!((course - 3.0 * FRAC_PI_6).abs() < 1e-12, "{course}");
}
