//! Gains from a model and from its data, and the recorded gains of scipy computed again.
//!
//! Where `.venv` is absent these pass, saying what they skipped (tests/README.md).

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::foreign::peers::program;

fn number(of: &Value, at: &str) -> f64 {
    of.pointer(at)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{at} in {of}"))
}

/// `tests/peers/best_gains.json`, which `tests/program/best_gains.rs` compares with `planesman`, is what its script computes: two cases are evaluated again.
#[test]
fn the_recorded_gains_cost_what_scipy_says() {
    let cases = ["oscillating", "2 ft/s, 60 deg"];
    let Some(mut peer) = program("best_gains.py") else {
        return;
    };
    let printed = peer.arg("check").args(cases).output().unwrap();
    let told = String::from_utf8(printed.stdout).unwrap();
    let complaint = String::from_utf8_lossy(&printed.stderr);
    assert_eq!(told.lines().count(), cases.len(), "{complaint}");
    for line in told.lines() {
        let case: Value = serde_json::from_str(line).unwrap();
        for at in ["cost", "phase", "gain", "ms"] {
            let [recorded, again] =
                ["recorded", "again"].map(|it| number(&case, &format!("/{it}/{at}")));
            assert!((again / recorded - 1.0).abs() < 1e-6, "{at}: {case}");
        }
        assert_eq!(number(&case, "/again/missed"), 0.0, "{case}");
    }
}

/// `planesman` with these words, in a folder: what it prints as JSON.
fn run(folder: &Path, words: &[&str]) -> Value {
    let mut program = Command::new(env!("CARGO_BIN_EXE_planesman"));
    let printed = program.args(words).current_dir(folder).output().unwrap();
    let complaint = String::from_utf8_lossy(&printed.stderr).into_owned();
    serde_json::from_slice(&printed.stdout).unwrap_or_else(|_| panic!("{words:?}: {complaint}"))
}

#[test]
fn gains_from_a_model_and_from_its_data_agree_where_there_is_little_dead_time() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut peer) = program("little_dead_time.py") else {
        return;
    };
    let printed = peer.arg(folder.path()).output().unwrap();
    let told = String::from_utf8(printed.stdout).unwrap();
    assert_eq!(
        told.lines().count(),
        10,
        "{}",
        String::from_utf8_lossy(&printed.stderr)
    );
    for line in told.lines() {
        let plant: Value = serde_json::from_str(line).unwrap();
        let file = plant["file"].as_str().unwrap();
        let model = format!("{file}.yaml");
        let signals = ["-i", "u", "-o", "y", "--quiet", "--json"];
        run(
            folder.path(),
            &[&["sysid", "fit", file, "--model", &model], &signals[..]].concat(),
        );
        let by_model = run(folder.path(), &["tune", &model, "--json"]);
        let by_data = run(folder.path(), &[&["tune", file], &signals[..]].concat());
        for it in [&by_model, &by_data] {
            let gain = number(it, "/reduced/gain") / number(&plant, "/gain");
            assert!((gain - 1.0).abs() < 0.03, "{file}: {}", it["reduced"]);
            let integrates = number(it, "/reduced/integrators") > 0.0;
            assert_eq!(Value::from(integrates), plant["integrates"], "{file}");
        }
        for at in ["/parallel/kp", "/parallel/ki"] {
            let ratio = number(&by_model, at) / number(&by_data, at);
            assert!(
                (ratio - 1.0).abs() < 0.1,
                "{file}: {at} {ratio}: {by_model} {by_data}"
            );
        }
    }
}
