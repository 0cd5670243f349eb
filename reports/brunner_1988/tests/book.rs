//! Table 9 of the thesis, gone through again: every number has its twin, every verdict stands.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use planesman_book::{Book, Reckoning, Verdict};

fn book() -> Book {
    brunner_1988::identification::book().unwrap()
}

fn values() -> BTreeMap<&'static str, f64> {
    brunner_1988::identification::recomputed()
        .into_iter()
        .collect()
}

#[test]
fn every_number_of_table_9_comes_out_again() {
    let (book, values) = (book(), values());
    assert_eq!(
        values.len(),
        brunner_1988::identification::recomputed().len()
    );
    let complaints: Vec<String> = book
        .entries()
        .iter()
        .filter(|entry| entry.reference.is_some() || entry.verdict.is_some())
        .filter_map(|entry| {
            let Some(&value) = values.get(entry.id.as_str()) else {
                return Some(format!("{}: not computed", entry.id));
            };
            let off = entry.near_reference(value) == Some(false);
            let judged = entry.judge(value) != entry.verdict;
            (off || judged).then(|| {
                let now = entry.judge(value);
                format!("{value}, {now:?} is not {entry:?}")
            })
        })
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(Reckoning::of(&book, values).strangers.is_empty());
}

#[test]
fn every_printed_root_is_judged_and_only_the_misprints_contradict() {
    let book = book();
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
    // How far pole and steady gain of the identified model are off the theory's.
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
