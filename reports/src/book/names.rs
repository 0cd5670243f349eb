//! Plain names for a report's numbers.
//!
//! An entry's own name is short: `T6.ZC5.noimp.Kdz0.25.t90`. The report's `names.json` has words for its family (`T6`) and quantity (`t90`); the
//! rest identifies the case.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::book::Entry;

/// Plain names of one report.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Names {
    families: BTreeMap<String, String>,
    quantities: BTreeMap<String, String>,
}

impl Names {
    /// Parses a JSON object with `families` and `quantities`, each a mapping from short to plain names.
    ///
    /// # Errors
    /// The JSON has another form.
    pub fn parse(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// Plain name of an entry's family; the short name if there is no plain name.
    #[must_use]
    pub fn family<'a>(&'a self, entry: &'a Entry) -> &'a str {
        let family = entry.family();
        self.families.get(family).map_or(family, String::as_str)
    }

    /// Plain name of an entry within its family, with its case: `time to 90 % of the step (ZC5, noimp, Kdz0.25)`. `None` if its quantity has no plain
    /// name.
    #[must_use]
    pub fn name(&self, entry: &Entry) -> Option<String> {
        if let Some(name) = self.quantities.get(&entry.id) {
            return Some(name.clone());
        }
        let parts = parts(&entry.id);
        let (last, before) = parts.split_last()?;
        // What the last part says behind its quantity, as `_U1` of `Kdz_min_U1`, belongs to the case.
        let mut ends: Vec<usize> = last.match_indices('_').map(|(at, _)| at).collect();
        ends.push(last.len());
        let (end, name) = ends.iter().rev().find_map(|end| {
            let short = &last[..*end];
            let of_family = format!("{}.{short}", entry.family());
            let name = self.quantities.get(&of_family);
            Some((*end, name.or_else(|| self.quantities.get(short))?))
        })?;
        let case = before.iter().skip(1).copied();
        let case: Vec<&str> = case
            .chain([last[end..].trim_start_matches('_')])
            .filter(|it| !it.is_empty())
            .collect();
        Some(match case[..] {
            [] => name.clone(),
            _ => format!("{name} ({})", case.join(", ")),
        })
    }
}

/// Parts of an entry's own name, family first. A dot before a digit belongs to a number: `Kdz0.25`.
fn parts(id: &str) -> Vec<&str> {
    let is_end = |(at, _): &(usize, &str)| {
        let behind = id[at + 1..].chars().next();
        let is_first = !id[..*at].contains('.');
        is_first || !behind.is_some_and(|it| it.is_ascii_digit())
    };
    let ends = id.match_indices('.').filter(is_end).map(|(at, _)| at);
    let (mut parts, mut from) = (Vec::new(), 0);
    for end in ends {
        parts.push(&id[from..end]);
        from = end + 1;
    }
    parts.push(&id[from..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::book::Book;

    #[test]
    fn a_number_is_told_by_its_quantity_and_its_case() {
        let names = r#"{"families": {"T6": "Program T6"}, "quantities":
            {"t90": "time to 90 %", "Kdz_min": "least Kdz", "T6.T": "pitch", "T": "period"}}"#;
        let names = Names::parse(names).expect("names");
        let told = |id: &str| {
            let entry = format!(r#"[{{"id": "{id}", "unit": "-", "source": "p. 1"}}]"#);
            let book = Book::parse(&entry, "{}").expect("a book");
            let entry = &book.entries()[0];
            (names.family(entry).to_owned(), names.name(entry))
        };
        for (id, family, name) in [
            (
                "T6.ZC5.Kdz0.25.t90",
                "Program T6",
                Some("time to 90 % (ZC5, Kdz0.25)"),
            ),
            (
                "depth.Kdz_min_Kpz0.25_U1",
                "depth",
                Some("least Kdz (Kpz0.25_U1)"),
            ),
            ("T6.T", "Program T6", Some("pitch")),
            ("T2.T", "T2", Some("period")),
            ("T2.x", "T2", None),
        ] {
            assert_eq!(
                told(id),
                (family.to_owned(), name.map(str::to_owned)),
                "{id}"
            );
        }
    }
}
