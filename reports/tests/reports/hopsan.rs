//! Hopsan's recorded numbers: every one comes out again, with its verdict.

use planesman_reports::book::Comparison;
use planesman_reports::hopsan::{book, recomputed};

#[test]
fn every_recorded_number_comes_out_again_with_its_verdict() {
    let book = book().expect("the book is valid");
    let values = recomputed();
    let comparison = Comparison::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
    let changes = comparison.changes();
    assert!(changes.is_empty(), "{}", changes.join("\n"));
    assert!(comparison.unlisted.is_empty(), "{:?}", comparison.unlisted);
    assert_eq!(comparison.left_out().count(), 0);
}
