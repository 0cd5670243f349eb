//! The book of numbers as text.

use std::fmt::Write as _;

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
            number(entry.printed),
            number(line.value),
            number(entry.slack.or(entry.tolerance)),
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

/// A number in six significant digits without the zeros at its end, or nothing.
#[must_use]
pub fn number(value: Option<f64>) -> String {
    let Some(value) = value else {
        return String::new();
    };
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let decimals = (5.0 - value.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_written_in_six_digits_or_fewer() {
        for (value, text) in [
            (2.600_410_8, "2.60041"),
            (-0.854_145, "-0.854145"),
            (543.0, "543"),
            (0.002_513_463, "0.00251346"),
            (125_000.0, "125000"),
            (1.54e-6, "1.540e-6"),
            (0.0, "0"),
        ] {
            assert_eq!(number(Some(value)), text);
        }
        assert_eq!(number(None), "");
    }
}
