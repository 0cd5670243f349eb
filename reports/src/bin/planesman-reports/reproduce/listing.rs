//! The numbers of a book as text.

use std::fmt::Write as _;

use anyhow::Result;

use planesman_console::{Format, Table, is_terminal, wrapped};
use planesman_reports::book::{Book, Comparison, Line, VERDICTS};
use planesman_text::number;

/// The entries that `told` selects, and the errata they refer to; wrapped to the terminal if standard output is one.
///
/// # Errors
/// None in practice: the text is written to memory.
pub(crate) fn text(
    book: &Book,
    comparison: &Comparison<'_>,
    told: impl Fn(&&Line<'_>) -> bool,
) -> Result<String> {
    let lines: Vec<&Line<'_>> = comparison.lines.iter().filter(told).collect();
    if lines.is_empty() {
        return Ok(String::new());
    }
    const COLUMNS: [&str; 7] = [
        "number",
        "printed",
        "recomputed",
        "within",
        "unit",
        "verdict",
        "erratum",
    ];
    let mut table = Table::new(COLUMNS);
    let aligned = |[id, printed, recomputed, within, unit, verdict, erratum]: [&str; 7]| {
        format!(
            "{id:<30} {printed:>12} {recomputed:>14} {within:>10} {unit:<12} {verdict:<17} {erratum}\n"
        )
    };
    let mut text = aligned(COLUMNS);
    let mut all_changes = String::new();
    for line in &lines {
        let entry = line.entry;
        let row = [
            entry.id.clone(),
            written(entry.printed),
            written(line.value),
            written(entry.slack.or(entry.tolerance)),
            entry.unit.clone(),
            line.told(),
            entry.erratum.clone().unwrap_or_default(),
        ];
        text += &aligned(row.each_ref().map(String::as_str));
        table.row(row);
        if let Some(change) = line.change() {
            text += &format!("{:<30} changed from the book: {change}\n", "");
            all_changes += &format!("{}: changed from the book: {change}\n", entry.id);
        }
    }
    if is_terminal() {
        text = table.text(Format::Table) + &all_changes;
    }
    let named = |number: &str| {
        let mut errata = lines.iter().map(|line| line.entry.erratum.as_deref());
        errata.any(|it| it == Some(number))
    };
    let mut errata = String::new();
    for (number, erratum) in book.errata().iter().filter(|(n, _)| named(n)) {
        // Writing to a String does not fail.
        let _ = writeln!(errata, "{number:>4}  {erratum}");
    }
    if !errata.is_empty() {
        errata.insert_str(0, "\nErrata mentioned above\n");
    }
    Ok(format!("\n{text}{}", wrapped(&errata)))
}

/// The totals, one line per kind.
#[must_use]
pub(crate) fn totals(comparison: &Comparison<'_>) -> String {
    let mut text = format!("\n{} numbers\n", comparison.lines.len());
    let counted = VERDICTS.map(|(verdict, what)| (comparison.count(verdict), what));
    let others = [
        (comparison.changes().len(), "changed from the book"),
        (
            comparison.unlisted.len(),
            "recomputed numbers without an entry in the book",
        ),
    ];
    for (count, what) in counted.into_iter().chain(others) {
        let _ = writeln!(text, "{count:>5}  {what}");
    }
    text
}

/// A number with six significant digits; empty if there is no number.
fn written(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}
