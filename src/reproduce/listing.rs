//! The book of numbers as text.

use std::fmt::Write as _;

use crate::arguments::number;
use planesman_book::{Book, Line, Reckoning};

/// Every entry, the errata that are named, and the totals.
#[must_use]
pub fn text(book: &Book, reckoning: &Reckoning<'_>) -> String {
    let mut text = format!(
        "{:<30} {:>12} {:>14} {:>10} {:<12} {:<12} erratum\n",
        "number", "printed", "recomputed", "within", "unit", "verdict"
    );
    for line in &reckoning.lines {
        let entry = line.entry;
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{:<30} {:>12} {:>14} {:>10} {:<12} {:<12} {}",
            entry.id,
            written(entry.printed),
            written(line.value),
            written(entry.slack.or(entry.tolerance)),
            entry.unit,
            verdict(line),
            entry.erratum.as_deref().unwrap_or_default(),
        );
        if let Some(news) = line.news() {
            let _ = writeln!(text, "{:<30} not as in the book: {news}", "");
        }
    }
    let named = |number: &str| {
        reckoning
            .lines
            .iter()
            .any(|l| l.entry.erratum.as_deref() == Some(number))
    };
    text.push_str("\nErrata named above\n");
    for (number, erratum) in book.errata().iter().filter(|(n, _)| named(n)) {
        let _ = writeln!(text, "{number:>4}  {erratum}");
    }
    text.push_str(&totals(reckoning));
    text
}

/// The totals, a line per kind.
#[must_use]
pub fn totals(reckoning: &Reckoning<'_>) -> String {
    let t = reckoning.totals();
    let mut text = format!("\n{} numbers\n", reckoning.lines.len());
    for (count, what) in [
        (t.agrees, "printed, agree to their rounding"),
        (t.approximate, "printed, agree approximately"),
        (t.contradicts, "printed, contradicted"),
        (t.not_printed, "not printed, recomputed"),
        (
            t.printed_only,
            "printed, not recomputed: measurements, choices, parts not here",
        ),
        (t.not_recomputed, "not printed, not recomputed"),
        (t.news, "not as they stand in the book"),
        (
            reckoning.strangers.len(),
            "more recomputed, of which the book has no entry",
        ),
    ] {
        let _ = writeln!(text, "{count:>5}  {what}");
    }
    text
}

/// The verdict on a line.
#[must_use]
pub fn verdict(line: &Line<'_>) -> String {
    match (line.verdict, line.value) {
        (Some(verdict), _) => verdict.to_string(),
        (None, Some(_)) => "not printed".to_owned(),
        (None, None) => "not recomputed".to_owned(),
    }
}

/// A number in six significant digits, or nothing.
#[must_use]
pub fn written(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}
