//! The numbers of the thesis: every recomputed one comes out again, with its verdict.

use std::collections::BTreeMap;

use planesman_reports::book::{Book, Comparison, Entry, Verdict};
use planesman_reports::brunner_1988::{controllers, identification, vehicle};

/// The families of the instruments, where a printed measurement without a reference has nothing to be
/// computed from.
const INSTRUMENTS: [&str; 7] = ["gyro", "press", "daq", "plane", "rollplane", "tx", "tank"];

/// Printed, and nothing to compute it from: the report's judgement by eye.
const CHOICES: [&str; 1] = ["T6.Kdz_opt"];

/// Goes through a share of the book: each value is given once, and stands as it is in the book.
fn compared<'a>(book: &'a Book, values: &[(&str, f64)]) -> Comparison<'a> {
    let mut once = BTreeMap::new();
    for (id, value) in values {
        assert!(once.insert(id, value).is_none(), "{id} is given twice");
        assert!(value.is_finite(), "{id} is {value}");
    }
    let comparison = Comparison::of(book, values.iter().copied());
    let changes = comparison.changes();
    assert!(changes.is_empty(), "{}", changes.join("\n"));
    comparison
}

/// No entry that could be computed is left out.
fn assert_complete(comparison: &Comparison<'_>, may_be_left_out: impl Fn(&Entry) -> bool) {
    let missing: Vec<_> = comparison
        .left_out()
        .filter(|e| !may_be_left_out(e))
        .collect();
    assert!(missing.is_empty(), "nothing recomputes {missing:?}");
}

fn family(id: &str) -> &str {
    id.split('.').next().unwrap_or_default()
}

#[test]
fn every_number_of_the_vehicle_comes_out_again_with_its_verdict() {
    let book = vehicle::book().unwrap();
    let comparison = compared(&book, &vehicle::recomputed());
    assert_complete(&comparison, |entry| {
        entry.reference.is_none() && INSTRUMENTS.contains(&family(&entry.id))
    });
    // Whole rows of the programs and of Table 8 are computed; the book holds some numbers of each.
    let entries = || book.entries().iter().map(|entry| family(&entry.id));
    for id in &comparison.unlisted {
        let known = !INSTRUMENTS.contains(&family(id)) && entries().any(|of| of == family(id));
        assert!(known, "the book has no {id}");
    }
}

#[test]
fn the_instruments_are_made_of_the_printed_numbers() {
    let book = vehicle::book().unwrap();
    for (id, value) in vehicle::carried() {
        let entry = book.entries().iter().find(|entry| entry.id == id);
        let printed = entry.and_then(|entry| entry.printed).expect(id);
        assert!((value - printed).abs() < 1e-9, "{id}: {value}");
    }
}

#[test]
fn every_number_of_the_controllers_comes_out_again_with_its_verdict() {
    let book = controllers::book().unwrap();
    let values = controllers::recomputed();
    let values: Vec<_> = values.iter().map(|(id, v)| (id.as_str(), *v)).collect();
    let comparison = compared(&book, &values);
    assert_complete(&comparison, |entry| CHOICES.contains(&entry.id.as_str()));
    assert!(comparison.unlisted.is_empty(), "{:?}", comparison.unlisted);
}

#[test]
fn every_number_of_table_9_comes_out_again() {
    let book = identification::book().unwrap();
    let comparison = compared(&book, &identification::recomputed());
    assert_complete(&comparison, |entry| {
        entry.reference.is_none() && entry.verdict.is_none()
    });
    assert!(comparison.unlisted.is_empty(), "{:?}", comparison.unlisted);
}

fn values() -> BTreeMap<&'static str, f64> {
    identification::recomputed().into_iter().collect()
}

#[test]
fn every_printed_root_is_judged_and_only_the_misprints_contradict() {
    let book = identification::book().unwrap();
    let roots = book.entries().iter().filter(|e| e.id.contains(".root"));
    for entry in roots.filter(|e| e.printed.is_some()) {
        assert!(entry.verdict.is_some(), "{}", entry.id);
    }
    let contradicted: Vec<_> = book
        .entries()
        .iter()
        .filter(|e| e.verdict == Some(Verdict::Contradicts))
        .map(|e| (e.id.as_str(), e.erratum.as_deref()))
        .collect();
    let e19 = Some("E19");
    assert_eq!(
        contradicted,
        [
            ("Tab9.7/3.qd2.root2.re", e19),
            ("Tab9.9/1.qd2.a1", e19),
            ("Tab9.9/1.zd4.a4", e19),
        ]
    );
}

#[test]
fn every_model_from_pitch_rate_to_depth_is_unstable() {
    let values = values();
    for model in ["8/1.zq2", "8/1.zq4", "9/1.zq2", "9/1.zq4"] {
        assert!(values[format!("Tab9.{model}.s1.re").as_str()] > 0.0);
    }
}

#[test]
fn the_two_runs_that_the_thesis_calls_excellent_agree_with_theory_and_the_others_do_not() {
    let values = values();
    let value = |run: &str, what: &str| values[format!("Tab9.{run}.qd2.{what}").as_str()];
    // How far pole and steady-state gain of the identified model are off the theory's.
    let off = |run: &str| {
        let pole = -value(run, "s1.re") / value(run, "pole_pred") - 1.0;
        let gain = value(run, "dc") / value(run, "dc_pred") - 1.0;
        pole.abs().max(gain.abs())
    };
    for run in ["9/2", "8/1"] {
        assert!(off(run) < 0.14, "{run}: {}", off(run));
    }
    for run in ["7/3", "7/5", "9/1"] {
        assert!(off(run) > 0.3, "{run}: {}", off(run));
    }
}
