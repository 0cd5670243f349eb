//! Another vehicle in the whole loop: the scenario `remus_100`, composed in one process.
#![allow(clippy::unwrap_used)]

use planesman::compose::Loop;
use planesman::scenario::Scenario;

#[test]
fn the_remus_100_goes_down_to_five_metres_and_stays_there() {
    let scenario = Scenario::load("remus_100").unwrap();
    let depths: Vec<f64> = Loop::new(&scenario)
        .unwrap()
        .map(|tick| tick.unwrap().observation.state.depth)
        .collect();
    let arrived = depths.iter().position(|depth| *depth > 4.9).unwrap();
    assert!(arrived < 400, "within 20 s: {arrived}");
    for depth in &depths[600..] {
        assert!((depth - 5.0).abs() < 0.05, "{depth}");
    }
}
