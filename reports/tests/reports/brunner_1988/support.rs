//! Common to the tests of the thesis' kinds of runs: the expected values and the runs by name.

use planesman_reports::brunner_1988::identification::synthetic::{Plant, Run};
use serde_json::Value;

/// The noise's seed.
pub(crate) const SEED: u32 = 12345;
/// The depth noise's seed.
pub(crate) const DEPTH_SEED: u32 = 54321;

/// The expected values that lie beside these tests.
pub(crate) fn expected() -> Value {
    serde_json::from_str(include_str!("least_squares_cases.json")).unwrap()
}

/// A list of numbers.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect()
}

/// The plant of a run.
pub(crate) fn plant(run: &str) -> Plant {
    Run::of(run).unwrap().plant()
}

/// The plane command of a run, V.
pub(crate) fn planes(run: &str) -> Vec<f64> {
    Run::of(run).unwrap().planes()
}

/// The clean output of a run, V.
pub(crate) fn clean(run: &str) -> Vec<f64> {
    Run::of(run).unwrap().clean()
}
