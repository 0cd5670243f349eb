//! Gains of `planesman tune` and `planesman design optimise` beside scipy.
//!
//! Where `.venv` is absent these pass, saying what they skipped (tests/README.md).

use std::path::Path;
use std::process::Command;

use planesman_linear::TransferFunction;
use planesman_model_file::ModelFile;
use planesman_tuning::{Kind, Method, Plant, TuneOptions, tune};
use serde_json::{Value, json};

use crate::foreign::peers::program;

/// The one JSON object that a program of `tests/peers` prints for a case; `None` where there is no Python for it.
fn answer(of: &str, case: &Value) -> Option<Value> {
    let printed = program(of)?.arg(case.to_string()).output().unwrap();
    let complaint = String::from_utf8_lossy(&printed.stderr).into_owned();
    Some(serde_json::from_slice(&printed.stdout).unwrap_or_else(|_| panic!("{complaint}")))
}

fn number(of: &Value, at: &str) -> f64 {
    of.pointer(at)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{at} in {of}"))
}

/// An oscillating plant and one of two lags: numerator, denominator, ticks of dead time, tick.
fn plants() -> [(Vec<f64>, Vec<f64>, usize, f64); 2] {
    [
        (vec![1.0], vec![0.25, 0.2, 1.0], 4, 0.05),
        (vec![2.0], vec![5.0, 6.0, 1.0], 6, 0.05),
    ]
}

#[test]
fn optimised_gains_have_the_least_error_that_scipy_finds() {
    for (num, den, delay, tick) in plants() {
        let transfer = TransferFunction::new(num.clone(), den.clone()).unwrap();
        let plant = Plant::held(&transfer, delay as f64 * tick, tick).unwrap();
        let lead = vec![0.0; plant.delay];
        let denominator = [&[1.0][..], &plant.a].concat();
        let order = denominator.len().max(plant.delay + plant.b.len());
        let padded = |mut it: Vec<f64>| {
            it.resize(order, 0.0);
            it
        };
        let file = ModelFile::exact(
            "u",
            "y",
            tick,
            padded([lead, plant.b].concat()),
            padded(denominator),
        );
        let options = TuneOptions {
            method: Some(Method::Optimise),
            controller: Some(Kind::Pid),
            ..TuneOptions::default()
        };
        let found = tune(&file, &options).unwrap();
        let gains = found.controller;
        let case = json!({
            "num": num, "den": den, "delay": delay, "tick": tick,
            "phase": options.phase_margin, "gain": options.gain_margin, "ms": options.ms,
            "given": [gains.kp, gains.ki, gains.kd, gains.filter],
        });
        let Some(peer) = answer("best_pid.py", &case) else {
            return;
        };
        println!("{den:?} e^-{delay}: {peer}");
        // Each has margins of its own grid.
        for (at, least) in [("/given/phase", 44.9), ("/given/gain", 5.95)] {
            assert!(number(&peer, at) >= least, "{den:?}: {peer}");
        }
        assert!(number(&peer, "/given/ms") <= 1.605, "{den:?}: {peer}");
        let (own, best) = (found.steps.load_error.model, number(&peer, "/best/error"));
        assert!(own <= 1.02 * best, "{den:?}: {own}, and {peer}");
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
        6,
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
                (ratio - 1.0).abs() < 0.2,
                "{file}: {at} {ratio}: {by_model} {by_data}"
            );
        }
    }
}

/// Speeds, margins (deg, dB) and overshoot (%); the first is that of the help's example.
const DIVES: [(&str, &[f64], f64, f64, f64); 3] = [
    ("0.3048,0.6096", &[0.3048, 0.6096], 45.0, 8.0, 5.0),
    ("0.3048", &[0.3048], 45.0, 6.0, 5.0),
    ("0.6096", &[0.6096], 45.0, 6.0, 5.0),
];

#[test]
fn dive_gains_have_the_least_error_that_scipy_finds_from_any_start() {
    for (place, (words, speeds, phase, gain, overshoot)) in DIVES.into_iter().enumerate() {
        let [phase_margin, gain_margin, most] = [phase, gain, overshoot].map(|it| it.to_string());
        let printed = |start: &[&str]| {
            let mut program = Command::new(env!("CARGO_BIN_EXE_planesman"));
            let words = [
                "design",
                "optimise",
                "brunner",
                "--actuator",
                "ideal",
                "--speed",
                words,
            ];
            let limits = [
                "--phase-margin",
                &phase_margin,
                "--gain-margin",
                &gain_margin,
                "--overshoot",
                &most,
            ];
            let printed = program
                .args(words)
                .args(limits)
                .args(start)
                .output()
                .unwrap();
            String::from_utf8(printed.stdout).unwrap()
        };
        let text = printed(&[]);
        let of = |name: &str| {
            let rest = text
                .split_once(&format!("{name} "))
                .unwrap_or_else(|| panic!("{name} in {text}"))
                .1;
            rest.split_whitespace()
                .next()
                .unwrap()
                .trim_end_matches(',')
                .parse::<f64>()
                .unwrap()
        };
        if place == 0 {
            let other = printed(&[
                "--depth-p",
                "2",
                "--depth-d",
                "0.1",
                "--pitch-p",
                "3",
                "--pitch-rate",
                "5",
            ]);
            let found = |text: &str| text.lines().take(3).map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(found(&text), found(&other));
        }
        let case = json!({
            "speeds": speeds, "phase": phase, "gain": gain, "overshoot": overshoot, "step": 0.9144,
            "pitch_limit": 45, "planes_limit": 30, "duration": 120,
            "given": [of("Kpz"), of("Kdz"), of("Kpy"), of("Kr")],
        });
        let Some(peer) = answer("best_dive_gains.py", &case) else {
            return;
        };
        println!("{words}: {} and {peer}", of("worst ITAE"));
        // The gains are printed to four digits.
        assert!(number(&peer, "/given/missed") < 2e-3, "{words}: {peer}");
        let (own, best) = (of("worst ITAE"), number(&peer, "/best/worst"));
        assert!(own <= 1.01 * best + 0.005, "{words}: {own}, and {peer}");
    }
}
