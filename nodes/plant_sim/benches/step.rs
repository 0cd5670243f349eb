//! What one integration step of the vehicle costs.
//!
//! ```text
//! cargo bench -p plant_sim --bench step                  the step alone
//! python nodes/plant_sim/benches/peers.py                beside scipy and python-control
//! ```
//!
//! The problem is program T2 in consistent units: the vehicle `brunner` at 1 ft/s, planes at 30
//! degrees for 10 s and then neutral, until 60 s, in steps of 1 ms. Times are the best of several
//! rounds: what else the machine does only ever adds.

use std::{hint::black_box, time::Instant};

use plant_sim::{
    Restoring, State, environment::Environment, linearised, motion::Motion, planes::PlanePath,
    quantity::FOOT, track::Track, vehicle_file::brunner,
};

const ROUNDS: usize = 20;
const STEPS: u32 = 50_000;

/// The shortest of some rounds \[s\].
fn best(mut work: impl FnMut()) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let motion = Motion {
        derivatives: brunner().derivatives(FOOT),
        restoring: Restoring::Sine,
        environment: Environment {
            density: 999.835,
            gravity: 9.81456,
            atmospheric_pressure: 101_325.0,
        },
        step: 0.001,
    };
    let planes = 30.0_f64.to_radians();

    // As a tick does: many steps in one call, so that the call itself does not count.
    let stepping = best(|| {
        let path = PlanePath::held(black_box(&planes));
        let end = motion.advance(black_box(&State::default()), &path, STEPS);
        assert!(black_box(end).is_ok());
    });
    println!(
        "plant_sim, one Runge-Kutta step: {:.1} ns",
        stepping / f64::from(STEPS) * 1e9
    );

    let dive = best(|| {
        let track = Track::of_dive(black_box(&motion), planes, 10.0, 60.0);
        assert!(black_box(track).is_ok());
    });
    println!("plant_sim, dive of 60 s: {:.3} ms", dive * 1e3);

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
    let linear = best(|| assert!(black_box(depth.simulate(black_box(&input))).is_ok()));
    println!(
        "planesman_linear, linear dive of 60 s at 20 Hz: {:.3} ms",
        linear * 1e3
    );

    let path = PlanePath::held(&planes);
    let Ok(end) = motion.advance(&State::default(), &path, 10_000) else {
        eprintln!("the vehicle diverged");
        return;
    };
    println!(
        "after 10 s: pitch {:.6} deg, depth {:.6} ft",
        end.pitch.to_degrees(),
        end.depth / FOOT
    );
}
