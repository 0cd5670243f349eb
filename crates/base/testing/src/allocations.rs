//! Counts allocations on the heap.
//!
//! A test that counts declares the counter and runs without the test harness, whose threads would be counted too:
//!
//! ```
//! use planesman_testing::allocations::{self, COUNTER, Counter};
//!
//! #[global_allocator]
//! static GLOBAL: Counter = COUNTER;
//!
//! allocations::assert_none(|| assert_eq!(std::hint::black_box(1) + 1, 2));
//! ```

use std::{alloc::System, hint::black_box};

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, Stats, StatsAlloc};

/// The type of the counter.
pub type Counter = &'static StatsAlloc<System>;

/// The counter, to be declared as the program's global allocator.
pub const COUNTER: Counter = &INSTRUMENTED_SYSTEM;

fn counted<T>(run: impl FnOnce() -> T) -> (T, Stats) {
    let region = Region::new(COUNTER);
    let result = run();
    (result, region.change())
}

/// Runs something and checks that it neither takes memory from the heap nor gives any back.
///
/// # Panics
/// When it does, or when the counter is not the program's allocator.
pub fn assert_none<T>(run: impl FnOnce() -> T) -> T {
    let (result, taken) = counted(run);
    assert_eq!(
        (taken.allocations, taken.reallocations, taken.deallocations),
        (0, 0, 0)
    );
    let ((), taken) = counted(|| drop(black_box(vec![1.0_f64; 8])));
    assert!(taken.allocations > 0, "the counter counts nothing");
    result
}
