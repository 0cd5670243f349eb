//! The check of one number of a book.

use planesman_book::Entry;

/// The differences of a recomputed value from the book: its reference, and its verdict.
pub(crate) fn faults(entry: &Entry, value: f64) -> Vec<String> {
    let mut faults = Vec::new();
    if entry.near_reference(value) == Some(false) {
        let (reference, within) = (entry.reference, entry.tolerance);
        faults.push(format!(
            "{}: {value}, not {reference:?} within {within:?}",
            entry.id
        ));
    }
    let verdict = entry.judge(value);
    if verdict != entry.verdict {
        let (id, printed, stands) = (&entry.id, entry.printed, entry.verdict);
        faults.push(format!(
            "{id}: {value} against {printed:?} is {verdict:?}, not {stands:?}"
        ));
    }
    faults
}
