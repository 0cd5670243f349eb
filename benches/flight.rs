//! The loop in one process: times real time, without a file. The median of several rounds, and the best.
//!
//! `cargo bench --bench flight`; `--bench flight -- SCENARIO NODE.PARAMETER=VALUE...` for another flight.
#![allow(clippy::expect_used)]

use std::time::Instant;

use planesman_flight::compose::Loop;
use planesman_flight::scenario::Scenario;

const ROUNDS: usize = 15;

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|it| it != "--bench");
    let name = arguments.next().unwrap_or_else(|| "dive".to_owned());
    let changes: Vec<String> = arguments.collect();
    let scenario = Scenario::load_with(&name, &changes).expect("a scenario");
    let mut seconds: Vec<f64> = (0..ROUNDS).map(|_| fly(&scenario)).collect();
    seconds.sort_by(f64::total_cmp);
    let text = |seconds: f64| {
        let tick = 1e6 * seconds / scenario.ticks() as f64;
        format!(
            "{:.0} times real time, {tick:.2} us a tick",
            scenario.duration / seconds
        )
    };
    println!(
        "{name}: best {}; median {}",
        text(seconds[0]),
        text(seconds[ROUNDS / 2])
    );
}

/// One flight; the time it took, s.
fn fly(scenario: &Scenario) -> f64 {
    let mut flight = Loop::new(scenario).expect("a flight");
    let began = Instant::now();
    while !flight.is_over() {
        std::hint::black_box(flight.step().expect("a step"));
    }
    began.elapsed().as_secs_f64()
}
