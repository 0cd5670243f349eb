//! The linear-quadratic regulator of `crates/vehicle/flight/examples/own_law.rs`, against scipy.
//!
//! Where `.venv` is absent the test passes, saying what it skipped (tests/README.md).

use std::process::{Command, Output};

use crate::foreign::peers;
use peers::program;

/// What the example prints; `cargo test --workspace` has built it beside the tests.
fn example() -> Output {
    let tests = std::env::current_exe().unwrap();
    let built = tests.ancestors().nth(2).unwrap().join("examples/own_law");
    if built.is_file() {
        return Command::new(built).output().unwrap();
    }
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--package", "planesman_flight"]);
    cargo.args(["--example", "own_law"]).output().unwrap()
}

#[test]
fn the_example_regulator_has_the_gain_that_scipy_finds() {
    let Some(mut peer) = program("lqr_gain.py") else {
        return;
    };
    let peer = peer.output().unwrap();
    let expected: Vec<f64> = serde_json::from_slice(&peer.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&peer.stderr)));
    let printed = String::from_utf8(example().stdout).unwrap();
    let gain = printed
        .lines()
        .next()
        .unwrap()
        .strip_prefix("K = ")
        .unwrap();
    let gain: Vec<f64> = serde_json::from_str(gain).unwrap();
    assert_eq!(gain.len(), 4);
    for (own, expected) in gain.iter().zip(&expected) {
        // Three decimals are printed.
        assert!((own - expected).abs() < 6e-4, "{gain:?} {expected:?}");
    }
}
