//! The actuator takes no memory from the heap while it runs.
//!
//! A program of its own, without the test harness, whose threads would be counted too.

use planesman_hydraulics::actuator_file::load;
use planesman_hydraulics::{Demand, Dha};
use planesman_testing::allocations::{self, COUNTER, Counter};
use planesman_units::DEGREE;

#[global_allocator]
static GLOBAL: Counter = COUNTER;

fn main() {
    ten_seconds_of_slewing_and_holding_allocate_nothing();
    println!("ten_seconds_of_slewing_and_holding_allocate_nothing ... ok");
}

fn ten_seconds_of_slewing_and_holding_allocate_nothing() {
    let set = load("auv").expect("built in");
    let mut dha = Dha::new(&set);

    let travel = allocations::assert_none(|| {
        let mut travel = 0.0;
        for k in 1..=10_000 {
            let nanos = k * 1_000_000;
            let angle = if k / 1000 % 2 == 0 { 10.0 } else { -10.0 };
            dha.advance_to(nanos, Demand::angle(angle * DEGREE));
            travel += dha.plane_rate(&dha.reading(nanos)).abs() * 1e-3;
        }
        travel
    });
    assert!(travel > 100.0 * DEGREE, "{travel}");
}
