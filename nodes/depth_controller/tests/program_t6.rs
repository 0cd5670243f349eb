//! Program T6 (Brunner, NPS thesis, 1988, App. C), the depth controller on the
//! damped-inertia plant, flown through this crate's control law.
//!
//! ```text
//! J T'' = Ky delta - By T',   z' = U sin T      (T dive-positive, feet)
//! J = 0.6 ft-lbf s^2, By = 0.06 ft-lbf s, Ky = 0.14 ft-lbf/rad, U = 1 ft/s
//! ```
//! The law works in SI with pitch bow-up positive; the world here is T6's with theta = -T.
//! Expected values are the program's, recomputed from its listing; the thesis prints "optimum about 0.6,
//! no overshoot, within 3.5 % after about 12.5 s".

#![allow(clippy::unwrap_used)]

use depth_controller::core::Controller;
use depth_controller::depth_loop::DepthLoop;
use depth_controller::limits::Limit;
use depth_controller::parameters::{METRES_PER_FOOT as FOOT, declarations};
use depth_controller::pitch_loop::PitchLoop;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_parameters::Values;

const INERTIA: f64 = 0.6;
const DAMPING: f64 = 0.06;
const PLANE_MOMENT: f64 = 0.14;
const SPEED: f64 = 1.0 * FOOT;

/// Far beyond anything the run asks for: the program codes no limit.
const NO_LIMIT: f64 = 1e3;

/// pitch (rad, bow up), pitch rate (rad/s), depth (m).
type State = [f64; 3];

/// T6 with its loops.
struct Program {
    depth: DepthLoop,
    pitch: PitchLoop,
    planes: Limit,
    setpoint: f64,
}

impl Program {
    /// Setpoint in ft, Kdz in rad s/ft.
    fn new(setpoint: f64, kdz: f64) -> Self {
        Self {
            depth: DepthLoop {
                p: 0.25 / FOOT,
                d: kdz / FOOT,
                pitch_limit: Limit::new(NO_LIMIT).unwrap(),
            },
            pitch: PitchLoop { p: 0.7, rate: 2.0 },
            planes: Limit::new(NO_LIMIT).unwrap(),
            setpoint: setpoint * FOOT,
        }
    }

    fn with_the_thesis_limits(mut self) -> Self {
        self.depth.pitch_limit = Limit::new(45_f64.to_radians()).unwrap();
        self.planes = Limit::new(30_f64.to_radians()).unwrap();
        self
    }

    /// The plane angle the law asks for, rad, dive positive.
    fn planes(&self, [pitch, pitch_rate, depth]: State) -> f64 {
        let command = self.depth.evaluate(self.setpoint, depth, depth_rate(pitch));
        let terms = self
            .pitch
            .evaluate(command.pitch_command.value, pitch, pitch_rate);
        self.planes.apply(terms.dive_planes()).value
    }

    /// Depth in feet every 0.01 s over 60 s, the law evaluated in continuous time
    /// (fourth-order Runge-Kutta, 5 ms).
    fn fly(&self) -> Vec<f64> {
        let mut state = [0.0; 3];
        let mut depths = vec![0.0];
        for step in 1..=12_000 {
            state = runge_kutta(state, 0.005, |state| self.planes(state));
            if step % 2 == 0 {
                depths.push(state[2] / FOOT);
            }
        }
        depths
    }
}

/// z', m/s down.
fn depth_rate(pitch: f64) -> f64 {
    -SPEED * pitch.sin()
}

/// The plant after `dt` seconds under the plane angle that `planes` gives.
fn runge_kutta(state: State, dt: f64, planes: impl Fn(State) -> f64) -> State {
    let derivative = |x: State| {
        let [pitch, pitch_rate, _] = x;
        let pitch_acceleration = (-PLANE_MOMENT * planes(x) - DAMPING * pitch_rate) / INERTIA;
        [pitch_rate, pitch_acceleration, depth_rate(pitch)]
    };
    let along = |k: State, h: f64| [0, 1, 2].map(|i| state[i] + h * k[i]);
    let k1 = derivative(state);
    let k2 = derivative(along(k1, dt / 2.0));
    let k3 = derivative(along(k2, dt / 2.0));
    let k4 = derivative(along(k3, dt));
    [0, 1, 2].map(|i| state[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

/// Largest excess over the setpoint, %.
fn overshoot(depths: &[f64], setpoint: f64) -> f64 {
    let deepest = depths.iter().copied().fold(f64::MIN, f64::max);
    100.0 * (deepest / setpoint - 1.0)
}

/// First time a share of the setpoint is reached, s.
fn reached(depths: &[f64], level: f64) -> f64 {
    depths.iter().position(|z| *z >= level).unwrap() as f64 * 0.01
}

#[test]
fn the_trajectory_is_the_programs() {
    let depths = Program::new(5.0, 0.6).fly();
    for (time, depth) in [
        (2.5, 0.3538255),
        (5.0, 1.6968059),
        (10.0, 4.4795093),
        (12.5, 4.93299),
        (20.0, 4.8325090),
        (50.0, 4.9996835),
    ] {
        let flown = depths[(time * 100.0) as usize];
        let tolerance = if time == 12.5 { 1e-5 } else { 1e-6 };
        assert!((flown - depth).abs() < tolerance, "z({time}) = {flown}");
    }
}

#[test]
fn each_derivative_gain_gives_the_programs_overshoot_and_rise() {
    for (setpoint, kdz, limited, excess, t90, t98) in [
        (5.0, 0.25, false, 14.91, 8.90, 9.65),
        (5.0, 0.50, false, 3.27, 9.63, 10.89),
        (5.0, 0.60, false, 0.20, 10.07, 12.09),
        (5.0, 0.60, true, 0.13, 11.35, 14.00),
        (3.0, 0.60, false, 0.21, 9.79, 11.67),
        (3.0, 0.60, true, 0.21, 9.79, 11.67),
    ] {
        let mut program = Program::new(setpoint, kdz);
        if limited {
            program = program.with_the_thesis_limits();
        }
        let depths = program.fly();
        let row = format!("setpoint {setpoint} ft, Kdz {kdz}, limited {limited}");
        assert!(
            (overshoot(&depths, setpoint) - excess).abs() < 0.006,
            "{row}"
        );
        assert!(
            (reached(&depths, 0.90 * setpoint) - t90).abs() < 0.011,
            "{row}"
        );
        assert!(
            (reached(&depths, 0.98 * setpoint) - t98).abs() < 0.011,
            "{row}"
        );
    }
}

#[test]
fn a_larger_derivative_gain_creeps_up_without_overshoot() {
    for (kdz, t90, t98) in [(0.75, 11.13, 22.63), (1.0, 16.72, 25.97)] {
        let depths = Program::new(5.0, kdz).fly();
        assert!(overshoot(&depths, 5.0) < 0.0);
        assert!((reached(&depths, 4.5) - t90).abs() < 0.011);
        assert!((reached(&depths, 4.9) - t98).abs() < 0.011);
    }
}

#[test]
fn the_three_foot_step_starts_within_the_pitch_limit_and_at_the_plane_limit() {
    let program = Program::new(3.0, 0.6);
    let command = program
        .depth
        .evaluate(3.0 * FOOT, 0.0, 0.0)
        .pitch_command
        .value;
    let planes = program.pitch.evaluate(command, 0.0, 0.0).dive_planes();
    assert!((command.to_degrees() + 42.97).abs() < 0.005);
    assert!((planes.to_degrees() - 30.08).abs() < 0.005);
}

#[test]
fn the_five_foot_step_starts_beyond_both_limits() {
    let program = Program::new(5.0, 0.6);
    let command = program
        .depth
        .evaluate(5.0 * FOOT, 0.0, 0.0)
        .pitch_command
        .value;
    let planes = program.pitch.evaluate(command, 0.0, 0.0).dive_planes();
    assert!((command.to_degrees() + 71.6).abs() < 0.05);
    assert!((planes.to_degrees() - 50.1).abs() < 0.05);
}

#[test]
fn sampled_at_twenty_hertz_the_controllers_defaults_fly_the_program() {
    let mut controller = Controller::new(&Values::defaults(declarations())).unwrap();
    controller.set_depth_setpoint(3.0 * FOOT).unwrap();
    let mut plant = [0.0; 3];
    let mut depths = vec![0.0];
    for tick in 0..1200_i64 {
        let [pitch, pitch_rate, depth] = plant;
        let mut state = VehicleState {
            depth,
            depth_rate: depth_rate(pitch),
            pitch,
            pitch_rate,
            ..VehicleState::default()
        };
        state.header.stamp = Time::from_nanos(tick * 50_000_000);
        let (command, _) = controller.on_state(&state).unwrap();
        for _ in 0..5 {
            plant = runge_kutta(plant, 0.01, |_| command.dive_planes);
            depths.push(plant[2] / FOOT);
        }
    }
    // The continuous law: 0.21 %, 9.79 s, 11.67 s. Holding the planes for a tick costs a little damping.
    assert!(overshoot(&depths, 3.0) < 1.0);
    assert!((reached(&depths, 0.90 * 3.0) - 9.79).abs() < 0.15);
    assert!((reached(&depths, 0.98 * 3.0) - 11.67).abs() < 0.15);
}
