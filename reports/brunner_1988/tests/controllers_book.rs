//! The controllers' numbers of Brunner 1988: every recomputed one comes out again, with its verdict.

mod verdict;

use std::collections::BTreeMap;

use brunner_1988::controllers::{book, recomputed};

/// Printed, and nothing to compute it from: the report's judgement by eye.
const CHOICES: [&str; 1] = ["T6.Kdz_opt"];

#[test]
fn every_number_of_the_controllers_comes_out_again_with_its_verdict() {
    let book = book().expect("the book is valid");
    let mut values = BTreeMap::new();
    for (id, value) in recomputed() {
        assert!(
            values.insert(id.clone(), value).is_none(),
            "{id} is given twice"
        );
    }
    let mut faults = Vec::new();
    for entry in book.entries() {
        let Some(value) = values.remove(entry.id.as_str()) else {
            if !CHOICES.contains(&entry.id.as_str()) {
                faults.push(format!("{}: nothing recomputes it", entry.id));
            }
            continue;
        };
        faults.extend(verdict::faults(entry, value));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(values.is_empty(), "the book has no {:?}", values.keys());
}
