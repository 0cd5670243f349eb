//! The numbers of IBM 66-L03-005: every one comes out again, with its verdict.

use planesman_reports::book::{Comparison, Verdict};
use planesman_reports::ibm_1966::{book, recomputed};

/// Printed, and nothing to compute it from: measurements, the runs of Phase I, and parameters that no
/// case uses as they stand in their table.
const PRINTED_ONLY: [&str; 9] = [
    "T3-1.q_LC",
    "T4-1.q_LC_star",
    "T2-1.phase_1.max_pos_step",
    "T2-1.phase_1.Kg_stable",
    "T2-1.phase_1.Kg_unstable",
    "T3-2.hardware.max_pos_step",
    "T3-2.hardware.max_neg_step",
    "T3-2.hardware.Kg_stable",
    "T3-2.hardware.Kg_unstable",
];

/// How many printed numbers of a table the simulation gives exactly, and how many to one test step;
/// a gain margin counts once, by its stable K_g.
fn score(comparison: &Comparison<'_>, table: &str) -> (usize, usize) {
    let verdicts = comparison.lines.iter().filter_map(|line| {
        let id = &line.entry.id;
        (id.starts_with(table) && !id.ends_with("unstable")).then_some(line.verdict)?
    });
    verdicts.fold((0, 0), |(exact, near), verdict| match verdict {
        Verdict::Agrees => (exact + 1, near + 1),
        Verdict::Approximate => (exact, near + 1),
        Verdict::Contradicts => (exact, near),
    })
}

#[test]
fn every_number_of_the_study_comes_out_again_with_its_verdict() {
    let book = book().expect("the book is valid");
    let values = recomputed();
    let comparison = Comparison::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
    let changes = comparison.changes();
    assert!(changes.is_empty(), "{}", changes.join("\n"));
    assert!(comparison.unlisted.is_empty(), "{:?}", comparison.unlisted);
    let left_out: Vec<&str> = comparison
        .left_out()
        .map(|entry| entry.id.as_str())
        .collect();
    let mut expected = PRINTED_ONLY.to_vec();
    expected.sort_by_key(|id| comparison.lines.iter().position(|l| l.entry.id == *id));
    assert_eq!(left_out, expected);

    // What the reference simulation of the study comes to: 21 of 24, and none of 18.
    assert_eq!(score(&comparison, "T4-2."), (21, 24));
    assert_eq!(score(&comparison, "T3-2.").0, 0);
}
