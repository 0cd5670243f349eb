//! The comparison of a book with recomputed numbers.

use std::collections::BTreeMap;

use crate::{Book, Entry, Verdict};

/// One entry beside its recomputed value.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// The entry.
    pub entry: &'a Entry,
    /// The recomputed value; `None` when nothing recomputes it.
    pub value: Option<f64>,
    /// The verdict now; `None` without a printed or without a recomputed number.
    pub verdict: Option<Verdict>,
}

impl Line<'_> {
    /// The verdict in words; of a number without one, why there is none.
    #[must_use]
    pub fn told(&self) -> String {
        match (self.verdict, self.value) {
            (Some(Verdict::Agrees | Verdict::Approximate), _) if self.entry.input => {
                "read back".to_owned()
            }
            (Some(verdict), _) => verdict.to_string(),
            (None, Some(_)) => "not printed".to_owned(),
            (None, None) => "not recomputed".to_owned(),
        }
    }

    /// A difference from the book: another verdict, or a value away from the reference.
    #[must_use]
    pub fn change(&self) -> Option<String> {
        let value = self.value?;
        if self.entry.verdict != self.verdict {
            let shown =
                |verdict: Option<Verdict>| verdict.map_or("none".to_owned(), |v| v.to_string());
            let (stands, now) = (shown(self.entry.verdict), shown(self.verdict));
            return Some(format!("the verdict was '{stands}' and is '{now}'"));
        }
        if self.entry.near_reference(value) == Some(false) {
            return Some("it differs from the previous value".to_owned());
        }
        None
    }
}

/// The number of entries of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Printed numbers that agree to their rounding.
    pub agrees: usize,
    /// Printed numbers that agree within their slack only.
    pub approximate: usize,
    /// Printed constants that the models are given, read back.
    pub read_back: usize,
    /// Printed numbers that do not agree.
    pub contradicts: usize,
    /// Printed numbers that nothing recomputes: measurements, readings, choices.
    pub printed_only: usize,
    /// Numbers the report does not print, recomputed.
    pub not_printed: usize,
    /// Numbers the report does not print and that nothing recomputes here.
    pub not_recomputed: usize,
    /// Entries that are not as they stand in the book.
    pub changes: usize,
}

/// A book gone through.
#[derive(Clone, Debug)]
pub struct Comparison<'a> {
    /// Every entry, in the book's order.
    pub lines: Vec<Line<'a>>,
    /// Names among the recomputed values that no entry has.
    pub unlisted: Vec<String>,
}

impl<'a> Comparison<'a> {
    /// Goes through `book` with the values by name. The first of several values for a name counts.
    pub fn of<'s>(book: &'a Book, values: impl IntoIterator<Item = (&'s str, f64)>) -> Self {
        let mut by_name = BTreeMap::new();
        for (id, value) in values {
            by_name.entry(id).or_insert(value);
        }
        let lines = book
            .entries()
            .iter()
            .map(|entry| {
                let value = by_name.remove(entry.id.as_str());
                let verdict = value.and_then(|v| entry.judge(v));
                Line {
                    entry,
                    value,
                    verdict,
                }
            })
            .collect();
        Self {
            lines,
            unlisted: by_name.into_keys().map(str::to_owned).collect(),
        }
    }

    /// The differences from the book, a sentence for each.
    #[must_use]
    pub fn changes(&self) -> Vec<String> {
        let change = |line: &Line<'_>| Some(format!("{}: {}", line.entry.id, line.change()?));
        self.lines.iter().filter_map(change).collect()
    }

    /// The entries that nothing recomputes.
    pub fn left_out(&self) -> impl Iterator<Item = &'a Entry> {
        let left_out = self.lines.iter().filter(|line| line.value.is_none());
        left_out.map(|line| line.entry)
    }

    /// The number of each kind.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let mut totals = Totals::default();
        for line in &self.lines {
            *match (line.verdict, line.value, line.entry.printed) {
                (Some(Verdict::Agrees | Verdict::Approximate), ..) if line.entry.input => {
                    &mut totals.read_back
                }
                (Some(Verdict::Agrees), ..) => &mut totals.agrees,
                (Some(Verdict::Approximate), ..) => &mut totals.approximate,
                (Some(Verdict::Contradicts), ..) => &mut totals.contradicts,
                (None, Some(_), _) => &mut totals.not_printed,
                (None, None, Some(_)) => &mut totals.printed_only,
                (None, None, None) => &mut totals.not_recomputed,
            } += 1;
            totals.changes += usize::from(line.change().is_some());
        }
        totals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENTRIES: &str = r#"[
        {"id": "a", "unit": "-", "source": "p. 1", "printed": 2.5, "slack": 0.1, "verdict": "agrees"},
        {"id": "b", "unit": "-", "source": "p. 1", "printed": 3, "slack": 0.1, "verdict": "agrees"},
        {"id": "c", "unit": "-", "source": "p. 1", "recomputed": 1.0, "tolerance": 0.5},
        {"id": "d", "unit": "-", "source": "p. 1", "recomputed": 1.0, "tolerance": 0.5},
        {"id": "e", "unit": "-", "source": "p. 1", "printed": 1.0, "slack": 0.5},
        {"id": "f", "unit": "-", "source": "p. 1", "printed": 1.0, "slack": 0, "verdict": "agrees", "input": true}]"#;

    #[test]
    fn a_verdict_that_changes_and_a_value_that_moves_are_changes() {
        let book = Book::parse(ENTRIES, "{}").expect("a book");
        let comparison = Comparison::of(
            &book,
            [("a", 2.51), ("b", 4.0), ("c", 1.6), ("f", 1.0), ("x", 1.0)],
        );
        let changes: Vec<_> = comparison.lines.iter().map(Line::change).collect();
        assert!(changes[0].is_none() && changes[3].is_none() && changes[4].is_none());
        assert!(
            changes[1]
                .as_ref()
                .is_some_and(|n| n.contains("contradicts"))
        );
        assert!(changes[2].is_some());
        assert_eq!(comparison.unlisted, ["x"]);
        assert_eq!(
            comparison.totals(),
            Totals {
                agrees: 1,
                read_back: 1,
                contradicts: 1,
                not_printed: 1,
                not_recomputed: 1,
                printed_only: 1,
                changes: 2,
                ..Totals::default()
            }
        );
    }
}
