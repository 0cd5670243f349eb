//! `planesman review`: one page from data to gains, each number with its samples; what is not usable is said, with what to do.

use planesman_linear::{ComplexFunctions as _, polar};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use planesman_identification::noise;
use planesman_testing::content;
use serde_json::Value;

use crate::browser::{assert_alive, assert_prints_lines};
use crate::stage::Stage;
use crate::tune::{POLE, SAMPLE_TIME, steps};

/// Every link within the page leads somewhere, and none leads out of it.
fn assert_links_resolve(page: &str) {
    let after = |part: &str| -> BTreeSet<String> {
        let pieces = page.split(part).skip(1);
        pieces
            .filter_map(|it| Some(it.split_once('"')?.0.to_owned()))
            .collect()
    };
    let (targets, ids) = (after("href=\""), after(" id=\""));
    assert!(targets.len() > 20, "{targets:?}");
    for target in targets {
        let id = target
            .strip_prefix('#')
            .unwrap_or_else(|| panic!("{target}"));
        assert!(ids.contains(id), "{target} leads nowhere");
    }
    for outside in ["href=\"http", " src=", "<link", "@import", "url(http"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

/// The phase margin, degrees, of a PI controller and the plant that made the steps, 2 e^(-s) / (4 s + 1) sampled: by the loop's frequency response.
fn true_phase_margin(kp: f64, ki: f64) -> f64 {
    let open = |omega: f64| {
        let z = polar(1.0, omega * SAMPLE_TIME);
        let plant = z.powi(-6) * 2.0 * (1.0 - POLE) / (1.0 - POLE / z);
        plant * (kp + ki * SAMPLE_TIME * z / (z - 1.0))
    };
    let (mut low, mut high) = (1e-3, PI / SAMPLE_TIME);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        match open(middle).modulus() > 1.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    (open(low).argument() + PI).rem_euclid(TAU).to_degrees()
}

#[test]
fn a_review_leads_from_each_number_to_its_samples_and_agrees_with_the_plant() {
    let stage = Stage::new();
    let data = steps(&stage);
    let page = stage.path("review.html");
    let signals = ["-i", "valve", "-o", "temperature", "--controller", "pi"];
    let arguments = [
        &["review", &data][..],
        &signals,
        &["--quiet", "--html", &page],
    ]
    .concat();
    let outcome = stage.run(&arguments).success();
    for part in [
        "USABLE: the model is ",
        "worst of 95 % of 500 plants: phase margin ",
        "crossover",
    ] {
        assert!(outcome.stdout.contains(part), "{}", outcome.stdout);
    }
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.len() < 3_000_000 && !content(&text).contains("NaN"));
    assert_links_resolve(&text);
    for part in [
        "Spectrum of the input",
        "Coherence",
        "Poles and zeros",
        "Cross-correlation of residual and input",
        "Phase margins of the drawn plants",
        "Output after a step of the setpoint",
        "held out only to compute the fit on held-out data",
        // The last three tenths of 600 samples, every 0.2 s.
        "421 to 600",
        "84.000 to 119.800",
        "planesman review",
    ] {
        assert!(text.contains(part), "{part}");
    }

    let again = [
        &["review", &data][..],
        &signals,
        &["--quiet", "--json", "--html"],
    ]
    .concat();
    let second = stage.path("second.html");
    let outcome = stage.run(&[&again[..], &[&second]].concat()).success();
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let number = |path: &str| found.pointer(path).and_then(Value::as_f64).unwrap();
    let margin = true_phase_margin(number("/tuning/parallel/kp"), number("/tuning/parallel/ki"));
    let [low, high] = ["q05", "q95"].map(|it| number(&format!("/tuning/phase_margin/{it}")));
    assert!(
        (low - 0.5..=high + 0.5).contains(&margin),
        "{margin}: {low} to {high}"
    );
    let gain = number("/identification/model/steady_state_gain/0");
    assert!((gain - 2.0).abs() < 0.02, "{gain}");
    assert!(found["conclusion"].as_array().unwrap().len() >= 5);

    // The same for a reader with a browser, and on paper.
    assert_alive(Path::new(&page), 18);
    let pages = assert_prints_lines(Path::new(&page));
    assert!(pages.is_none_or(|it| (2..=12).contains(&it)), "{pages:?}");
}

#[test]
fn what_is_not_usable_is_reviewed_for_all_that_with_what_to_do() {
    let stage = Stage::new();
    let (u, y) = (noise(1, 400), noise(2, 400));
    let rows = u.iter().zip(&y).enumerate();
    let rows: String = rows
        .map(|(k, (u, y))| format!("\n{:.1},{u},{y}", 0.2 * k as f64))
        .collect();
    let data = stage.file("noise.csv", format!("t,valve,temperature{rows}"));
    let page = stage.path("review.html");
    let signals = ["-i", "valve", "-o", "temperature"];
    let outcome = stage.run(
        &[
            &["review", &data][..],
            &signals,
            &["--quiet", "--html", &page],
        ]
        .concat(),
    );
    assert_eq!(outcome.status.code(), Some(1), "{}", outcome.stdout);
    assert!(
        outcome.stdout.contains("NOT USABLE: "),
        "{}",
        outcome.stdout
    );
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("NOT USABLE") && text.contains("PRBS"));
    assert_links_resolve(&text);
    // Where nothing is read, there is no page.
    let other = stage.path("other.html");
    let outcome = stage.run(&["review", "none.csv", "-i", "u", "--html", &other]);
    assert_eq!(outcome.status.code(), Some(1));
    assert!(outcome.stderr.contains("--output"), "{}", outcome.stderr);
    assert!(!Path::new(&other).exists());
}
