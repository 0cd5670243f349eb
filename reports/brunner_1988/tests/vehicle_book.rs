//! The report's numbers of the vehicle and its instruments: every recomputed one comes out again, with its
//! verdict.

mod verdict;

use std::collections::BTreeMap;

use brunner_1988::vehicle::{book, carried, recomputed};

/// The families of the instruments, where a printed measurement without a reference has nothing to be
/// computed from.
const INSTRUMENTS: [&str; 7] = ["gyro", "press", "daq", "plane", "rollplane", "tx", "tank"];

fn family(id: &str) -> &str {
    id.split('.').next().unwrap_or_default()
}

#[test]
fn every_number_of_the_vehicle_comes_out_again_with_its_verdict() {
    let book = book().expect("the book is valid");
    let mut values = BTreeMap::new();
    for (id, value) in recomputed() {
        assert!(values.insert(id, value).is_none(), "{id} is given twice");
        assert!(value.is_finite(), "{id} is {value}");
    }
    let mut faults = Vec::new();
    for entry in book.entries() {
        let Some(value) = values.remove(entry.id.as_str()) else {
            if entry.reference.is_some() || !INSTRUMENTS.contains(&family(&entry.id)) {
                faults.push(format!("{}: nothing recomputes it", entry.id));
            }
            continue;
        };
        faults.extend(verdict::faults(entry, value));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // Whole rows of the programs and of Table 8 are computed; the book holds some numbers of each.
    let entries = || book.entries().iter().map(|entry| family(&entry.id));
    for id in values.into_keys() {
        let known = !INSTRUMENTS.contains(&family(id)) && entries().any(|of| of == family(id));
        assert!(known, "the book has no {id}");
    }
}

#[test]
fn the_instruments_are_made_of_the_printed_numbers() {
    let book = book().expect("the book is valid");
    for (id, value) in carried() {
        let entry = book.entries().iter().find(|entry| entry.id == id);
        let printed = entry.and_then(|entry| entry.printed).expect(id);
        assert!((value - printed).abs() < 1e-9, "{id}: {value}");
    }
}
