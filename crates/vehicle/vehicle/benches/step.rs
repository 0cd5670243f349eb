//! The time of one integration step of the vehicle.
//!
//! ```text
//! cargo bench -p planesman_vehicle --bench step         the step alone
//! benches/peers/run --only vehicle                      beside scipy, C++ and python-control
//! ```
//!
//! The problem is program T2 in consistent units: the vehicle `brunner` at 1 ft/s, planes at 30
//! degrees for 10 s and then neutral, until 60 s. Times are the best of several rounds: what else the machine does
//! only ever adds.

use std::{hint::black_box, time::Instant};

use planesman_units::FOOT;
use planesman_vehicle::{
    Body, BodyMotion, Diverged, Drive, Environment, GeneralisedForce, Inputs, Motion, PlanePath,
    Restoring, State, Variant, Vehicle, linearised,
    vehicle_file::{brunner, remus_100},
};

const ROUNDS: usize = 2000;
const STEPS: u32 = 1000;
/// \[s\]
const STEP: f64 = 0.05;

/// The shortest of some rounds \[s\].
fn best(rounds: usize, mut work: impl FnMut()) -> f64 {
    (0..rounds)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// A vehicle's vertical plane at a held speed \[m/s\].
fn vertical(vehicle: &Vehicle, speed: f64) -> Motion {
    Motion {
        derivatives: vehicle.derivatives(speed),
        restoring: Restoring::Sine,
        environment: Environment {
            density: 999.835,
            gravity: 9.81456,
            atmospheric_pressure: 101_325.0,
        },
        step: STEP,
    }
}

/// One step \[ns\] with every actuator at an angle, as a tick does: many in one call, so that the
/// call itself does not count.
fn step_of(motion: &BodyMotion, angle: f64) -> f64 {
    let inputs = Inputs::all(PlanePath::held(&angle));
    // Below the surface: at it every step asks for the time of contact.
    let submerged = State {
        depth: 1.0,
        ..State::default()
    };
    let start = Body::upright(submerged, motion.vertical.derivatives.speed);
    let seconds = best(ROUNDS, || {
        let end = motion.advance(
            black_box(&start),
            black_box(&inputs),
            GeneralisedForce::NONE,
            STEPS,
        );
        assert!(black_box(end).is_ok());
    });
    seconds / f64::from(STEPS) * 1e9
}

/// The dive's states after 10 and 60 s; each call is for `motion.step`.
fn dive(motion: &Motion, angle: f64) -> Result<[State; 2], Diverged> {
    let mut state = State::default();
    let mut hold = |angle: f64, seconds: f64| {
        let path = PlanePath::held(&angle);
        for _ in 0..(seconds / motion.step).round() as u32 {
            state = motion.advance(&state, &path, 1)?;
        }
        Ok(state)
    };
    Ok([hold(angle, 10.0)?, hold(0.0, 50.0)?])
}

/// The largest error of a quantity, relative to its largest value.
fn worst(found: &[State; 2], exact: &[State; 2], of: impl Fn(&State) -> f64) -> f64 {
    let largest = |values: [f64; 2]| values[0].abs().max(values[1].abs());
    let values = exact.each_ref().map(&of);
    let errors = [0, 1].map(|i| of(&found[i]) - values[i]);
    largest(errors) / largest(values)
}

fn main() {
    let vehicle = brunner();
    let motion = vertical(&vehicle, FOOT);
    let planes = 30.0_f64.to_radians();
    let plane_alone = BodyMotion::of_the_plane(motion);
    let all_axes = BodyMotion {
        roll: vehicle.roll,
        yaw: vehicle.yaw,
        ..plane_alone.clone()
    };
    let under_thrust = BodyMotion {
        drive: vehicle.propulsion.map(|propulsion| Drive {
            propulsion,
            vehicle: vehicle.clone(),
            variant: Variant::default(),
        }),
        ..all_axes.clone()
    };
    let remus = BodyMotion::of_the_plane(vertical(&remus_100(), 1.54));
    for (what, motion, angle) in [
        ("brunner", &plane_alone, planes),
        ("remus_100", &remus, 0.1),
        ("brunner with roll and yaw", &all_axes, 0.1),
        ("brunner with roll, yaw and thrust", &under_thrust, 0.1),
    ] {
        println!(
            "planesman_vehicle, 50 ms, {what}: {:.1} ns",
            step_of(motion, angle)
        );
    }

    let Ok(exact) = dive(
        &Motion {
            step: 1e-4,
            ..motion
        },
        planes,
    ) else {
        eprintln!("the vehicle diverged");
        return;
    };
    for step in [10.0, STEP, 1e-3] {
        let motion = Motion { step, ..motion };
        let mut end = exact;
        let seconds = best(ROUNDS / 10, || {
            end = black_box(dive(black_box(&motion), planes)).unwrap_or_default();
        });
        println!(
            "planesman_vehicle, dive of 60 s, a state every {step} s: {:.4} ms, error {:.1e} of depth and {:.1e} of pitch",
            seconds * 1e3,
            worst(&end, &exact, |state| state.depth),
            worst(&end, &exact, |state| state.pitch),
        );
    }

    let held = linearised::state_space(&brunner(), FOOT)
        .and_then(|s| s.zero_order_hold(0.05))
        .and_then(|s| s.transfer_function(2, 0));
    let Ok(depth) = held else {
        eprintln!("the linear model could not be formed");
        return;
    };
    let input: Vec<f64> = (0..1200)
        .map(|k| if k < 200 { planes } else { 0.0 })
        .collect();
    let linear = best(ROUNDS / 10, || {
        assert!(black_box(depth.simulate(black_box(&input))).is_ok())
    });
    println!(
        "planesman_linear, linear dive of 60 s at 20 Hz: {:.3} ms",
        linear * 1e3
    );

    println!(
        "after 10 s: pitch {:.6} deg, depth {:.6} ft",
        exact[0].pitch.to_degrees(),
        exact[0].depth / FOOT
    );
}
