//! Compares a book with recomputed numbers.

use std::collections::{BTreeMap, BTreeSet};

use crate::book::{Book, Entry, Verdict};

/// An entry with its recomputed value.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// The entry.
    pub entry: &'a Entry,
    /// Recomputed value; `None` if it is not recomputed.
    pub value: Option<f64>,
    /// Present verdict; `None` without a printed or a recomputed number.
    pub verdict: Option<Verdict>,
    /// Whether the printed number is contradicted here but agrees in the entry that it is counted with.
    pub agrees_elsewhere: bool,
}

impl Line<'_> {
    /// The verdict as text; for a number without a verdict, the reason.
    #[must_use]
    pub fn told(&self) -> String {
        match (self.verdict, self.value) {
            (Some(Verdict::Agrees | Verdict::Approximate), _) if self.entry.input => {
                "read back".to_owned()
            }
            (Some(verdict), _) if self.entry.counted_with.is_some() => format!("{verdict} again"),
            (Some(Verdict::Agrees | Verdict::Approximate), _) if self.entry.calibrated => {
                "calibrated on".to_owned()
            }
            (Some(Verdict::Contradicts), _) if self.agrees_elsewhere => "surrogate".to_owned(),
            (Some(verdict), _) => verdict.to_string(),
            (None, Some(_)) => "not printed".to_owned(),
            (None, None) => "not recomputed".to_owned(),
        }
    }

    /// A change from the book: another verdict, or a value different from the reference.
    #[must_use]
    pub fn change(&self) -> Option<String> {
        let value = self.value?;
        if self.entry.verdict != self.verdict {
            let shown =
                |verdict: Option<Verdict>| verdict.map_or("none".to_owned(), |v| v.to_string());
            let (stands, now) = (shown(self.entry.verdict), shown(self.verdict));
            return Some(format!("the verdict changed from '{stands}' to '{now}'"));
        }
        if self.entry.near_reference(value) == Some(false) {
            return Some("the value differs from the previous one".to_owned());
        }
        None
    }
}

/// The verdicts returned by [`Line::told`], in the order of counting, with their meanings.
pub const VERDICTS: [(&str, &str); 11] = [
    ("agrees", "printed, agree within their rounding"),
    ("approximate", "printed, agree approximately"),
    (
        "read back",
        "printed constants used as inputs of the models",
    ),
    (
        "calibrated on",
        "printed and agree, but models were calibrated on them",
    ),
    ("contradicts", "printed, contradicted"),
    (
        "surrogate",
        "printed, contradicted by only one of the surrogate missiles",
    ),
    (
        "agrees again",
        "counted above; they agree in another unit or with the other surrogate missile",
    ),
    (
        "approximate again",
        "counted above; they agree approximately with the other surrogate missile",
    ),
    (
        "contradicts again",
        "counted above; contradicted by the other surrogate missile",
    ),
    ("not printed", "not printed, recomputed"),
    (
        "not recomputed",
        "not recomputed: measurements, choices and parts that are not modelled here",
    ),
];

/// Comparison of a whole book.
#[derive(Clone, Debug)]
pub struct Comparison<'a> {
    /// All entries, in the book's order.
    pub lines: Vec<Line<'a>>,
    /// Names of recomputed values without an entry.
    pub unlisted: Vec<String>,
}

impl<'a> Comparison<'a> {
    /// Compares `book` with the values, by name. The first of several values of a name counts.
    pub fn of<'s>(book: &'a Book, values: impl IntoIterator<Item = (&'s str, f64)>) -> Self {
        let mut by_name = BTreeMap::new();
        for (id, value) in values {
            by_name.entry(id).or_insert(value);
        }
        let mut lines: Vec<Line<'_>> = book
            .entries()
            .iter()
            .map(|entry| {
                let value = by_name.remove(entry.id.as_str());
                let verdict = value.and_then(|v| entry.judge(v));
                Line {
                    entry,
                    value,
                    verdict,
                    agrees_elsewhere: false,
                }
            })
            .collect();
        let agree =
            |line: &&Line<'_>| matches!(line.verdict, Some(Verdict::Agrees | Verdict::Approximate));
        let elsewhere = lines.iter().filter(agree);
        let elsewhere: BTreeSet<_> = elsewhere
            .filter_map(|it| it.entry.counted_with.as_deref())
            .collect();
        for line in &mut lines {
            line.agrees_elsewhere = line.verdict == Some(Verdict::Contradicts)
                && elsewhere.contains(line.entry.id.as_str());
        }
        Self {
            lines,
            unlisted: by_name.into_keys().map(str::to_owned).collect(),
        }
    }

    /// Changes from the book, one sentence each.
    #[must_use]
    pub fn changes(&self) -> Vec<String> {
        let change = |line: &Line<'_>| Some(format!("{}: {}", line.entry.id, line.change()?));
        self.lines.iter().filter_map(change).collect()
    }

    /// Entries that are not recomputed.
    pub fn left_out(&self) -> impl Iterator<Item = &'a Entry> {
        let left_out = self.lines.iter().filter(|line| line.value.is_none());
        left_out.map(|line| line.entry)
    }

    /// Number of lines with one of the [`VERDICTS`].
    #[must_use]
    pub fn count(&self, verdict: &str) -> usize {
        let lines = self.lines.iter();
        lines.filter(|line| line.told() == verdict).count()
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
        {"id": "g", "unit": "-", "source": "p. 1", "printed": 2, "slack": 0, "verdict": "agrees", "calibrated": true},
        {"id": "h", "unit": "-", "source": "p. 1", "printed": 9, "slack": 0, "verdict": "contradicts", "erratum": "E1"},
        {"id": "i", "unit": "-", "source": "p. 1", "printed": 9, "slack": 0, "verdict": "agrees", "counted_with": "h"},
        {"id": "f", "unit": "-", "source": "p. 1", "printed": 1.0, "slack": 0, "verdict": "agrees", "input": true}]"#;

    #[test]
    fn a_verdict_that_changes_and_a_value_that_moves_are_changes() {
        let book = Book::parse(ENTRIES, r#"{"E1": "lost"}"#).expect("a book");
        let values = [("a", 2.51), ("b", 4.0), ("c", 1.6), ("f", 1.0), ("x", 1.0)];
        let surrogates = [("g", 2.0), ("h", 7.0), ("i", 9.0)];
        let comparison = Comparison::of(&book, values.into_iter().chain(surrogates));
        let told: Vec<String> = comparison.lines[5..8].iter().map(Line::told).collect();
        assert_eq!(told, ["calibrated on", "surrogate", "agrees again"]);
        let changes: Vec<_> = comparison.lines.iter().map(Line::change).collect();
        assert!(changes[0].is_none() && changes[3].is_none() && changes[4].is_none());
        assert!(
            changes[1]
                .as_ref()
                .is_some_and(|n| n.contains("contradicts"))
        );
        assert!(changes[2].is_some());
        assert_eq!(comparison.unlisted, ["x"]);
        let counts = VERDICTS.map(|(verdict, _)| comparison.count(verdict));
        assert_eq!(counts, [1, 0, 1, 1, 1, 1, 1, 0, 0, 1, 2]);
        assert_eq!(comparison.changes().len(), 2);
    }
}
