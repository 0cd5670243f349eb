//! All entries of a report with its errata, read from JSON.

use std::collections::{BTreeMap, BTreeSet};

use crate::book::{Entry, Verdict};

/// The numbers of one report.
#[derive(Clone, Debug, PartialEq)]
pub struct Book {
    entries: Vec<Entry>,
    errata: BTreeMap<String, String>,
}

/// The reason why a book is invalid.
#[derive(Debug, thiserror::Error)]
pub enum BookError {
    /// The entries are not JSON of the expected form.
    #[error("the entries: {0}")]
    Entries(#[source] serde_json::Error),
    /// The errata are not JSON of the expected form.
    #[error("the errata: {0}")]
    Errata(#[source] serde_json::Error),
    /// Two entries with the same name.
    #[error("there are two entries '{id}'")]
    Twice {
        /// The common name.
        id: String,
    },
    /// An entry that violates a rule.
    #[error("entry '{id}': {rule}")]
    Refused {
        /// Its name.
        id: String,
        /// The violated rule.
        rule: EntryRule,
    },
}

/// A rule for entries.
#[derive(Debug, thiserror::Error)]
pub enum EntryRule {
    /// A number and its bound must be given together.
    #[error("{0} must be given together")]
    Together(&'static str),
    /// A bound must not be negative.
    #[error("{0}: the second number must not be negative")]
    Bound(&'static str),
    /// The named erratum must exist.
    #[error("the erratum '{0}' does not exist")]
    Erratum(String),
    /// `counted_with` must name an entry without `counted_with`.
    #[error("counted_with '{0}' must name an entry that has no counted_with itself")]
    CountedWith(String),
    /// A contradiction needs an explanation.
    #[error("a contradiction must name the erratum that explains it")]
    Unexplained,
    /// A verdict needs a printed number.
    #[error("a verdict needs a printed number")]
    NotPrinted,
}

impl Book {
    /// Parses a book from two JSON texts: a list of [entries](Entry), and the errata as an object from number to text.
    ///
    /// # Errors
    /// [`BookError`] for invalid JSON, a repeated name, a missing or invalid bound, a missing erratum, and a contradiction without one.
    pub fn parse(entries: &str, errata: &str) -> Result<Self, BookError> {
        let book = Self {
            entries: serde_json::from_str(entries).map_err(BookError::Entries)?,
            errata: serde_json::from_str(errata).map_err(BookError::Errata)?,
        };
        book.checked()
    }

    /// Combines the parts of a report into one book, in order.
    ///
    /// # Errors
    /// [`BookError::Twice`] for a name in two of them.
    pub fn of_shares(shares: impl IntoIterator<Item = Self>) -> Result<Self, BookError> {
        let mut whole = Self {
            entries: Vec::new(),
            errata: BTreeMap::new(),
        };
        for share in shares {
            whole.entries.extend(share.entries);
            whole.errata.extend(share.errata);
        }
        whole.checked()
    }

    fn checked(self) -> Result<Self, BookError> {
        let mut seen = BTreeSet::new();
        for entry in &self.entries {
            if !seen.insert(&entry.id) {
                return Err(BookError::Twice {
                    id: entry.id.clone(),
                });
            }
            self.check(entry).map_err(|rule| BookError::Refused {
                id: entry.id.clone(),
                rule,
            })?;
        }
        Ok(self)
    }

    fn check(&self, entry: &Entry) -> Result<(), EntryRule> {
        for (value, bound, names) in [
            (entry.printed, entry.slack, "printed and slack"),
            (entry.reference, entry.tolerance, "recomputed and tolerance"),
        ] {
            if value.is_some() != bound.is_some() {
                return Err(EntryRule::Together(names));
            }
            if bound.is_some_and(|b| b < 0.0) {
                return Err(EntryRule::Bound(names));
            }
        }
        let counts = |id: &str| self.entry(id).is_some_and(|it| it.counted_with.is_none());
        if let Some(id) = entry.counted_with.as_ref().filter(|id| !counts(id)) {
            return Err(EntryRule::CountedWith(id.clone()));
        }
        match &entry.erratum {
            Some(number) if !self.errata.contains_key(number) => {
                Err(EntryRule::Erratum(number.clone()))
            }
            None if entry.verdict == Some(Verdict::Contradicts) => Err(EntryRule::Unexplained),
            _ if entry.verdict.is_some() && entry.printed.is_none() => Err(EntryRule::NotPrinted),
            _ => Ok(()),
        }
    }

    /// All entries, in the book's order.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entry with this name.
    #[must_use]
    pub fn entry(&self, id: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.id == id)
    }

    /// Number printed for `id`.
    #[must_use]
    pub fn printed(&self, id: &str) -> Option<f64> {
        self.entry(id)?.printed
    }

    /// Errata by number.
    #[must_use]
    pub fn errata(&self) -> &BTreeMap<String, String> {
        &self.errata
    }

    /// Number and text of the erratum that explains `entry`.
    #[must_use]
    pub fn erratum_of(&self, entry: &Entry) -> Option<(&str, &str)> {
        let (number, text) = self.errata.get_key_value(entry.erratum.as_ref()?)?;
        Some((number, text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(entries: &str) -> String {
        Book::parse(entries, r#"{"E1": "inches for feet"}"#)
            .expect_err("refused")
            .to_string()
    }

    #[test]
    fn an_entry_is_found_with_its_erratum() {
        let text = r#"[{"id": "a.b", "unit": "ft", "source": "p. 1", "printed": 2.0, "slack": 0.1,
            "recomputed": 3.0, "tolerance": 0.1, "verdict": "contradicts", "erratum": "E1"}]"#;
        let book = Book::parse(text, r#"{"E1": "inches for feet"}"#).expect("a book");
        let entry = book.entry("a.b").expect("there");
        assert_eq!(entry.family(), "a");
        assert_eq!(book.printed("a.b"), Some(2.0));
        assert_eq!(book.erratum_of(entry), Some(("E1", "inches for feet")));
        assert_eq!(entry.judge(3.0), Some(Verdict::Contradicts));
        assert_eq!(entry.near_reference(3.05), Some(true));
    }

    #[test]
    fn shares_make_one_book_unless_they_hold_the_same_number() {
        let share = |id: &str| {
            let text = format!(r#"[{{"id": "{id}", "unit": "-", "source": "p. 1"}}]"#);
            Book::parse(&text, r#"{"E1": "inches for feet"}"#).expect("a book")
        };
        let whole = Book::of_shares([share("a"), share("b")]).expect("one book");
        assert!(whole.entry("a").is_some() && whole.entry("b").is_some());
        assert_eq!(whole.errata().len(), 1);
        let twice = Book::of_shares([share("a"), share("a")]).expect_err("refused");
        assert_eq!(twice.to_string(), "there are two entries 'a'");
    }

    #[test]
    fn what_breaks_a_rule_is_refused_by_name() {
        let head = r#"{"id": "a", "unit": "-", "source": "p. 1""#;
        assert!(refusal("{").starts_with("the entries: "));
        assert_eq!(
            refusal(&format!("[{head}}}, {head}}}]")),
            "there are two entries 'a'"
        );
        assert!(refusal(&format!(r#"[{head}, "printed": 1.0}}]"#)).contains("printed and slack"));
        assert!(
            refusal(&format!(r#"[{head}, "printed": 1, "slack": -1}}]"#))
                .contains("must not be negative")
        );
        assert!(refusal(&format!(r#"[{head}, "erratum": "E9"}}]"#)).contains("'E9'"));
        assert!(refusal(&format!(r#"[{head}, "counted_with": "a"}}]"#)).contains("'a'"));
        assert!(
            refusal(&format!(
                r#"[{head}, "printed": 1, "slack": 1, "verdict": "contradicts"}}]"#
            ))
            .contains("must name the erratum")
        );
        assert!(refusal(&format!(r#"[{head}, "colour": 3}}]"#)).contains("colour"));
    }
}
