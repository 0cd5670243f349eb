//! The instruments' numbers of Brunner 1988 come out of the models.

use std::collections::BTreeMap;

use plant_sim::book::sensors::{carried, recomputed};
use serde::Deserialize;

const FAMILIES: [&str; 7] = ["gyro", "press", "daq", "plane", "rollplane", "tx", "tank"];

#[derive(Deserialize)]
struct Entry {
    id: String,
    printed: Option<f64>,
    slack: Option<f64>,
    recomputed: Option<f64>,
    tolerance: Option<f64>,
}

fn entries() -> Vec<Entry> {
    let all: Vec<Entry> =
        serde_json::from_str(include_str!("../data/brunner_1988.json")).expect("the data file");
    let ours = |entry: &Entry| {
        let family = entry.id.split('.').next().unwrap_or_default();
        FAMILIES.contains(&family)
    };
    all.into_iter().filter(ours).collect()
}

#[test]
fn every_recomputed_number_of_the_instruments_comes_out_of_the_models() {
    let mut ours: BTreeMap<&str, f64> = BTreeMap::new();
    for (id, value) in recomputed() {
        assert!(ours.insert(id, value).is_none(), "{id} is given twice");
    }
    let mut wrong = Vec::new();
    for entry in entries() {
        let found = ours.remove(entry.id.as_str());
        // What the data file has no recomputed value for must agree with the print.
        let (expected, tolerance) = match (entry.recomputed, found) {
            (Some(expected), _) => (expected, entry.tolerance.expect("a tolerance")),
            (None, Some(_)) => {
                let printed = entry.printed.expect("printed or recomputed");
                (printed, entry.slack.expect("a slack"))
            }
            (None, None) => continue,
        };
        if found.is_none_or(|value| (value - expected).abs() > tolerance) {
            wrong.push(format!("{}: {found:?}, not {expected}", entry.id));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(ours.is_empty(), "the data file has no {:?}", ours.keys());
}

#[test]
fn the_models_are_made_of_the_printed_numbers() {
    let entries = entries();
    for (id, value) in carried() {
        let entry = entries.iter().find(|entry| entry.id == id);
        let printed = entry.and_then(|e| e.printed).expect(id);
        assert!((value - printed).abs() < 1e-9, "{id}: {value}");
    }
}
