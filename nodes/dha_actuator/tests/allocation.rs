//! The actuator takes no memory from the heap while it runs.
//!
//! A program of its own, without the test harness, whose threads would be counted too.

use std::alloc::System;

use dha_actuator::actuator_file::load;
use dha_actuator::{Demand, Dha};
use planesman_units::DEGREE;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn main() {
    ten_seconds_of_slewing_and_holding_allocate_nothing();
    println!("ten_seconds_of_slewing_and_holding_allocate_nothing ... ok");
}

fn ten_seconds_of_slewing_and_holding_allocate_nothing() {
    let set = load("auv").expect("built in");
    let mut dha = Dha::new(&set);

    let region = Region::new(GLOBAL);
    let mut travel = 0.0;
    for k in 1..=10_000 {
        let nanos = k * 1_000_000;
        let angle = if k / 1000 % 2 == 0 { 10.0 } else { -10.0 };
        dha.advance_to(nanos, Demand::angle(angle * DEGREE));
        travel += dha.plane_rate(&dha.reading(nanos)).abs() * 1e-3;
    }
    let taken = region.change();

    assert!(travel > 100.0 * DEGREE, "{travel}");
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
