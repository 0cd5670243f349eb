//! The built-in flights of vehicles with six degrees of freedom, compared with an independent computation in numpy and scipy (DOP853 at
//! 1e-11, the equations as matrices).

use planesman_msgs::planesman_msgs::msg::VehicleState;

use crate::compose::{Loop, Tick};
use crate::scenario::Scenario;

fn flown(name: &str) -> Vec<Tick> {
    let scenario = Scenario::load(name).expect("built in");
    let flight = Loop::new(&scenario).expect("a loop");
    flight.map(|tick| tick.expect("a tick")).collect()
}

fn near(found: f64, expected: f64, allowed: f64) {
    assert!(
        (found - expected).abs() <= allowed,
        "{found} is not {expected}"
    );
}

#[test]
fn the_turning_circle_comes_to_the_steady_turn_that_scipy_finds() {
    let flight = flown("turning_circle");
    let last = flight.last().expect("it flew");
    let state = &last.observation.state;
    // fsolve of the accelerations and the depth rate, at 8.4 N and 10 degrees.
    near(state.yaw_rate, 0.210_694_87, 3e-5);
    near(state.surge, 1.358_850_4, 1e-4);
    near(state.roll, 0.028_863_8, 1e-4);
    near(state.pitch, -0.008_824_45, 1e-4);
    // The stern planes alone.
    near(state.dive_planes, -0.010_610_34, 1e-4);
    let pose = last.observation.pose.as_ref().expect("there");
    near(-pose.odometry.twist.twist.linear.y, -0.097_791_41, 1e-4);
}

/// Times at which the rudder switches, s, and overshoots of the heading, degrees.
fn overshoots(flight: &[Tick]) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut last = 0.0;
    for (k, tick) in flight.iter().enumerate() {
        let rudder = tick.command.rudder;
        if rudder * last < 0.0 {
            found.push((k as f64 * 0.05, 0.0));
        }
        if rudder != 0.0 {
            last = rudder;
        }
        if let Some((_, most)) = found.last_mut() {
            let out = tick.observation.state.yaw * -rudder.signum();
            *most = f64::max(*most, out.to_degrees() - 10.0);
        }
    }
    found
}

#[test]
fn the_zigzag_overshoots_as_scipy_integrates_it() {
    let found = overshoots(&flown("zigzag"));
    let expected = [
        (1.0, 0.835_385),
        (3.1, 1.157_752),
        (5.25, 0.892_792),
        (7.4, 1.019_241),
    ];
    for ((time, angle), (after, expected)) in found.iter().zip(expected) {
        near(time - 20.0, after, 1e-9);
        // There the stern planes stand still; here they hold the depth.
        near(*angle, expected, 0.02);
    }
}

fn distance(state: &VehicleState, [x, y]: [f64; 2]) -> f64 {
    libm::hypot(state.distance - x, state.cross_track - y)
}

#[test]
fn the_way_points_are_passed_at_depth() {
    let flight = flown("lauv");
    for point in [[60.0, 0.0], [60.0, 60.0], [0.0, 0.0]] {
        let later = flight.iter().skip(200).map(|it| &it.observation.state);
        let closest = later
            .map(|it| distance(it, point))
            .fold(f64::INFINITY, f64::min);
        // The next leg begins 4 m before.
        assert!(closest < 4.0, "{closest} m from {point:?}");
    }
    for tick in flight.iter().skip(800) {
        near(tick.observation.state.depth, 5.0, 0.1);
    }
}

#[test]
fn the_rov_keeps_its_station_in_the_current() {
    let flight = flown("bluerov2");
    for tick in &flight {
        let state = &tick.observation.state;
        assert!(
            state.roll.abs() < 0.35 && state.pitch.abs() < 0.35,
            "{state:?}"
        );
    }
    for tick in flight.iter().skip(1400) {
        let state = &tick.observation.state;
        assert!(distance(state, [0.0, 5.0]) < 0.01);
        near(state.depth, 4.0, 0.01);
        near(state.yaw, std::f64::consts::FRAC_PI_4, 0.01);
        // Through water that moves by 0.15 m/s across.
        near(state.surge, -0.15 * std::f64::consts::FRAC_1_SQRT_2, 0.01);
    }
}
