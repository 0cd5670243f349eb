//! The thesis' numbers, and the check that a part of the book gives every one of its families.

use std::collections::BTreeMap;

use serde::Deserialize;

/// One number of `data/brunner_1988.json`.
#[derive(Deserialize)]
struct Entry {
    id: String,
    printed: Option<f64>,
    #[serde(default)]
    slack: f64,
    recomputed: Option<f64>,
    tolerance: Option<f64>,
    #[serde(default)]
    note: String,
}

impl Entry {
    fn family(&self) -> &str {
        self.id.split('.').next().unwrap_or_default()
    }

    /// What is wrong with a value for this entry, if anything.
    fn complaint(&self, value: Option<f64>) -> Option<String> {
        let Some(value) = value else {
            return Some(format!("{}: not computed", self.id));
        };
        if let (Some(expected), Some(tolerance)) = (self.recomputed, self.tolerance) {
            let off = (value - expected).abs();
            // Written so that NaN is no match.
            let holds = off <= tolerance;
            return (!holds)
                .then(|| format!("{}: {value} is not {expected} +- {tolerance}", self.id));
        }
        // Printed alone: agree with print, unless the entry says that it cannot.
        let printed = self.printed?;
        let holds = (value - printed).abs() <= self.slack || self.note.contains("DIFFERS");
        (!holds).then(|| {
            format!(
                "{}: {value} is not the printed {printed} +- {}",
                self.id, self.slack
            )
        })
    }
}

/// Every entry of the families is among `values`, within its tolerance.
///
/// # Panics
/// With all complaints.
pub(crate) fn holds(families: &[&str], values: &[(&'static str, f64)]) {
    let text = include_str!("../../data/brunner_1988.json");
    let entries: Vec<Entry> = serde_json::from_str(text).expect("the data file is valid");
    let by_id: BTreeMap<&str, f64> = values.iter().copied().collect();
    assert_eq!(by_id.len(), values.len(), "an entry is given twice");
    let mine: Vec<&Entry> = entries
        .iter()
        .filter(|e| families.contains(&e.family()))
        .collect();
    for family in families {
        assert!(
            mine.iter().any(|e| e.family() == *family),
            "no entry of the family {family}"
        );
    }
    let complaints: Vec<String> = mine
        .iter()
        .filter_map(|e| e.complaint(by_id.get(e.id.as_str()).copied()))
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}
