//! A step of the vehicle takes no memory from the heap.
//!
//! A program of its own, without the test harness, whose threads would be counted too.

use planesman_testing::allocations::{self, COUNTER, Counter};
use planesman_units::FOOT;
use planesman_vehicle::{Environment, Motion, PlanePath, Restoring, State, vehicle_file::brunner};

#[global_allocator]
static GLOBAL: Counter = COUNTER;

fn main() {
    a_thousand_steps_allocate_nothing();
    println!("a_thousand_steps_allocate_nothing ... ok");
}

fn a_thousand_steps_allocate_nothing() {
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
    let samples = [0.0, 0.1, 0.2, 0.1];
    let path = PlanePath::new(&samples, 1_000_000_000, 1_000_000_000).expect("a path");

    let end = allocations::assert_none(|| motion.advance(&State::default(), &path, 1000));
    assert!(end.is_ok());
}
