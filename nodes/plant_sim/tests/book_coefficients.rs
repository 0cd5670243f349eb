//! The vehicle's quantities of Brunner 1988, computed again, against the book's reference values.

use std::collections::BTreeMap;

use plant_sim::book;

/// Families of this part.
const FAMILIES: &[&str] = &[
    "Tab1", "Tab2", "Tab4", "Tab6", "F23", "Zw", "Mw", "Zdelta", "Mdelta", "Zq", "Mq", "fin",
    "hull", "munk", "am", "vol", "damp", "disp", "Ky", "Kx", "Kz", "Jx", "Jy", "Jz", "ind", "pow",
    "prop", "wt", "swing", "SI",
];

fn is_ours(id: &str) -> bool {
    FAMILIES.contains(&id.split('.').next().unwrap_or(id))
}

#[test]
fn every_quantity_of_the_vehicle_comes_to_its_reference_and_has_its_verdict() {
    let book = book::brunner_1988().expect("the book is valid");
    let values: BTreeMap<_, _> = book::coefficients::recomputed().into_iter().collect();
    let mut checked = 0;
    let mut faults = Vec::new();
    for entry in book.entries().iter().filter(|e| is_ours(&e.id)) {
        let Some(value) = values.get(entry.id.as_str()) else {
            faults.push(format!("{}: nothing recomputes it", entry.id));
            continue;
        };
        if entry.near_reference(*value) == Some(false) {
            faults.push(format!("{}: {value}, not {:?}", entry.id, entry.reference));
        }
        if entry.judge(*value) != entry.verdict {
            faults.push(format!(
                "{}: {value} against {:?} is {:?}, not {:?}",
                entry.id,
                entry.printed,
                entry.judge(*value),
                entry.verdict
            ));
        }
        checked += 1;
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(checked > 150, "only {checked} entries");
}

#[test]
fn no_quantity_is_computed_twice_or_is_not_finite() {
    let values = book::coefficients::recomputed();
    let names: BTreeMap<_, _> = values.iter().copied().collect();
    assert_eq!(names.len(), values.len());
    for (id, value) in names {
        assert!(value.is_finite(), "{id} is {value}");
        assert!(is_ours(id), "{id}");
    }
}
