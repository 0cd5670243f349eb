//! Program T6 (Brunner, NPS thesis, 1988, App. C), flown through the controller's loops.
//!
//! Expected values are the program's, recomputed from its listing; the thesis prints "optimum about 0.6,
//! no overshoot, within 3.5 % after about 12.5 s". `book.rs` has the rest of its numbers.

use planesman_control::{Controller, ControllerParameters, Quantity};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_reports::brunner_1988::controllers::program_t6::{Motion, Plant, Program};
use planesman_units::FOOT;

#[test]
fn the_trajectory_is_the_programs() {
    let track = Program::new(5.0, 0.6).fly().unwrap();
    for (time, depth, tolerance) in [
        (2.5, 0.3538255, 1e-6),
        (5.0, 1.6968059, 1e-6),
        (10.0, 4.4795093, 1e-6),
        (12.5, 4.93299, 1e-5),
        (20.0, 4.8325090, 1e-6),
        (50.0, 4.9996835, 1e-6),
    ] {
        let flown = track.depth(time);
        assert!((flown - depth).abs() < tolerance, "z({time}) = {flown}");
    }
}

#[test]
fn each_derivative_gain_gives_the_programs_overshoot_and_rise() {
    for (setpoint, derivative, limited, excess, t90, t98) in [
        (5.0, 0.25, false, 14.91, 8.90, 9.65),
        (5.0, 0.50, false, 3.27, 9.63, 10.89),
        (5.0, 0.60, false, 0.20, 10.07, 12.09),
        (5.0, 0.60, true, 0.13, 11.35, 14.00),
        (3.0, 0.60, false, 0.21, 9.79, 11.67),
        (3.0, 0.60, true, 0.21, 9.79, 11.67),
    ] {
        let program = Program {
            limited,
            ..Program::new(setpoint, derivative)
        };
        let track = program.fly().unwrap();
        assert!((track.overshoot() - excess).abs() < 0.006, "{program:?}");
        assert!(
            (track.reached(0.90).unwrap() - t90).abs() < 0.011,
            "{program:?}"
        );
        assert!(
            (track.reached(0.98).unwrap() - t98).abs() < 0.011,
            "{program:?}"
        );
    }
}

#[test]
fn a_larger_derivative_gain_creeps_up_without_overshoot() {
    for (derivative, t90, t98) in [(0.75, 11.13, 22.63), (1.0, 16.72, 25.97)] {
        let track = Program::new(5.0, derivative).fly().unwrap();
        assert!(track.overshoot() < 0.0);
        assert!((track.reached(0.90).unwrap() - t90).abs() < 0.011);
        assert!((track.reached(0.98).unwrap() - t98).abs() < 0.011);
    }
}

#[test]
fn the_three_foot_step_starts_within_the_pitch_limit_and_at_the_plane_limit() {
    let command = Program::new(3.0, 0.6).first_command().unwrap();
    assert!((command.dive_angle.to_degrees() - 42.97).abs() < 0.005);
    assert!((command.planes.to_degrees() - 30.08).abs() < 0.005);
}

#[test]
fn the_five_foot_step_starts_beyond_both_limits() {
    let command = Program::new(5.0, 0.6).first_command().unwrap();
    assert!((command.dive_angle.to_degrees() - 71.6).abs() < 0.05);
    assert!((command.planes.to_degrees() - 50.1).abs() < 0.05);
}

/// First time a share of the setpoint is reached by depths 0.01 s apart, s.
fn reached(depths: &[f64], level: f64) -> f64 {
    depths.iter().position(|z| *z >= level).unwrap() as f64 * 0.01
}

#[test]
fn sampled_at_twenty_hertz_the_controllers_defaults_fly_the_program() {
    let mut controller = Controller::new(&ControllerParameters::default()).unwrap();
    controller
        .set_setpoint(Quantity::Depth, 3.0 * FOOT)
        .unwrap();
    let (plant, mut motion) = (Plant::default(), Motion::default());
    let mut depths = vec![0.0];
    for tick in 0..1200_i64 {
        let mut state = VehicleState {
            depth: motion.depth,
            depth_rate: plant.depth_rate(&motion),
            pitch: motion.pitch,
            pitch_rate: motion.pitch_rate,
            ..VehicleState::default()
        };
        state.header.stamp = Time::from_nanos(tick * 50_000_000);
        let (command, _) = controller.on_state(&state).unwrap();
        for _ in 0..5 {
            motion = plant.after(motion, 0.01, |_| command.dive_planes);
            depths.push(motion.depth / FOOT);
        }
    }
    // The continuous law: 0.21 %, 9.79 s, 11.67 s. Holding the planes for a tick costs a little damping.
    assert!(depths.iter().all(|z| *z < 1.01 * 3.0));
    assert!((reached(&depths, 0.90 * 3.0) - 9.79).abs() < 0.15);
    assert!((reached(&depths, 0.98 * 3.0) - 11.67).abs() < 0.15);
}
