//! `planesman tune`: from data and from a model file to gains, a page and JSON; what is refused.

use std::fmt::Write as _;
use std::fs;

use planesman_identification::noise;
use planesman_testing::content;
use serde_json::Value;

use crate::stage::Stage;

/// Of the plant below: the interval between samples, s, and the pole in z, exp(-0.2 / 4).
pub(crate) const SAMPLE_TIME: f64 = 0.2;
pub(crate) const POLE: f64 = 0.951_229_424_500_714;

/// Steps of a valve, and 2 e^(-s) / (4 s + 1) of it with noise, every 0.2 s.
pub(crate) fn steps(stage: &Stage) -> String {
    let noise = noise(5, 600);
    let mut y = vec![0.0_f64];
    let u = |k: usize| [0.0, 2.0, -1.0, 1.0][k / 150];
    for k in 1..600 {
        let late = if k > 5 { u(k - 6) } else { 0.0 };
        y.push(POLE * y[k - 1] + 2.0 * (1.0 - POLE) * late);
    }
    let mut text = String::from("t,valve,temperature");
    for k in 0..600 {
        let _ = write!(
            text,
            "\n{:.1},{},{}",
            SAMPLE_TIME * k as f64,
            u(k),
            20.0 + y[k] + 0.02 * noise[k]
        );
    }
    stage.file("steps.csv", text)
}

#[test]
fn data_and_its_model_file_lead_to_gains_that_keep_their_limits() {
    let stage = Stage::new();
    let data = steps(&stage);
    let signals = ["-i", "valve", "-o", "temperature"];
    let page = stage.path("tune.html");
    let from_data = [
        &["tune", &data][..],
        &signals,
        &["--quiet", "--verbose", "--html", &page],
    ]
    .concat();
    let outcome = stage.run(&from_data).success();
    for part in [
        "kp ",
        "Ti ",
        "(ideal form)",
        "worst of 95 %",
        "Limits kept by 95 % of 500 plants",
        "limited by ",
    ] {
        assert!(
            outcome.stdout.contains(part),
            "no '{part}' in {}",
            outcome.stdout
        );
    }
    let page = fs::read_to_string(page).unwrap();
    for part in [
        "Output after a step of the setpoint",
        "Nyquist plot",
        "Phase margins of the drawn plants",
        "What limits the margins",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!content(&page).contains("NaN") && page.len() < 3_000_000);
    let model = stage.path("model.yaml");
    let fit = [
        &["sysid", "fit", &data][..],
        &signals,
        &["--method", "process", "--quiet", "--model", &model],
    ]
    .concat();
    stage.run(&fit).success();
    let outcome = stage
        .run(&[
            "tune",
            &model,
            "--json",
            "--controller",
            "pi",
            "--period",
            "200ms",
        ])
        .success();
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(found["limits"]["are_kept"], true);
    assert_eq!(found["method"], "simc");
    // SIMC on 2 e^(-s) / (4 s + 1): dead time and hold 1.1 s, so kp 0.91 for tau_c 1.1 s; a calmer one keeps Ms 1.6 over the draws.
    let kp = found["parallel"]["kp"].as_f64().unwrap();
    assert!(kp > 0.75 && kp < 0.95, "{kp}");
    let ti = found["ideal"]["ti"].as_f64().unwrap();
    assert!((ti - 4.0).abs() < 0.2, "{ti}");
    assert!(found["ms"]["q95"].as_f64().unwrap() <= 1.6);
}

#[test]
fn what_is_missing_is_said() {
    let stage = Stage::new();
    let data = steps(&stage);
    for (arguments, says) in [
        (vec!["tune", &data], "--input and --output"),
        (vec!["tune", &data, "-i", "valve"], "--input and --output"),
        (vec!["tune", "nothing.yaml"], "nothing.yaml"),
    ] {
        let outcome = stage.run(&arguments);
        assert_eq!(outcome.status.code(), Some(1), "{arguments:?}");
        assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    }
    for wrong in [
        &["--method", "ziegler"][..],
        &["--input-limit", "5..10"],
        &["--step", "0"],
    ] {
        let outcome = stage.run(&[&["tune", "model.yaml"][..], wrong].concat());
        assert_eq!(outcome.status.code(), Some(2), "{wrong:?}");
    }
}
