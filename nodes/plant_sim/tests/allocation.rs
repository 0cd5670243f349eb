//! A step of the vehicle takes no memory from the heap.
//!
//! A program of its own, without the test harness, whose threads would be counted too.

use std::alloc::System;

use planesman_units::FOOT;
use plant_sim::{
    Restoring, State, environment::Environment, motion::Motion, planes::PlanePath,
    vehicle_file::brunner,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

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

    let region = Region::new(GLOBAL);
    let end = motion.advance(&State::default(), &path, 1000);
    let taken = region.change();

    assert!(end.is_ok());
    assert_eq!(
        (taken.allocations, taken.reallocations, taken.deallocations),
        (0, 0, 0)
    );
    let counted = {
        let region = Region::new(GLOBAL);
        drop(std::hint::black_box(vec![1.0_f64; 8]));
        region.change().allocations
    };
    assert!(counted > 0, "the counter counts nothing");
}
