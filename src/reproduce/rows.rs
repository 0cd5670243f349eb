//! The numbers as rows, for other programs: as JSON and CSV.

use anyhow::{Context as _, Result};
use planesman_book::{Book, Names, Reckoning, Recomputed, Report};
use serde::Serialize;

use super::listing::verdict;
use planesman_console::progress::on_all_cores;

/// The reports.
pub(super) const REPORTS: [Report; 2] = [brunner_1988::REPORT, ibm_1966::REPORT];

/// The recomputed numbers of each of the [`REPORTS`], by name.
pub(super) fn recomputed() -> Vec<Recomputed> {
    on_all_cores("reports", &REPORTS, |report| (report.recomputed)())
}

/// One number.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    report: &'static str,
    number: String,
    family: String,
    name: Option<String>,
    source: String,
    unit: String,
    printed: Option<f64>,
    /// How far a recomputed number may be off.
    within: Option<f64>,
    recomputed: Option<f64>,
    verdict: String,
    /// The number of the erratum that explains it, and what that says.
    erratum: Option<String>,
    explanation: Option<String>,
    note: Option<String>,
}

/// The numbers of every report.
///
/// # Errors
/// None in practice: the books are built in.
pub fn all() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (report, values) in REPORTS.iter().zip(recomputed()) {
        let (book, names) = ((report.book)()?, (report.names)()?);
        let reckoning = Reckoning::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
        rows.extend(of(report, &book, &names, &reckoning));
    }
    Ok(rows)
}

/// The numbers of a report.
pub(super) fn of(
    report: &Report,
    book: &Book,
    names: &Names,
    reckoning: &Reckoning<'_>,
) -> Vec<Row> {
    let lines = reckoning.lines.iter();
    let row = |line: &planesman_book::Line<'_>| {
        let entry = line.entry;
        let erratum = book.erratum_of(entry);
        Row {
            report: report.name,
            number: entry.id.clone(),
            family: names.family(entry).to_owned(),
            name: names.name(entry),
            source: entry.source.clone(),
            unit: entry.unit.clone(),
            printed: entry.printed,
            within: entry.slack.or(entry.tolerance),
            recomputed: line.value,
            verdict: verdict(line),
            erratum: erratum.map(|(number, _)| number.to_owned()),
            explanation: erratum.map(|(_, text)| text.to_owned()),
            note: entry.note.clone(),
        }
    };
    lines.map(row).collect()
}

/// A list of objects.
///
/// # Errors
/// None in practice: writing to memory.
pub fn json(rows: &[Row]) -> Result<String> {
    Ok(serde_json::to_string_pretty(rows)? + "\n")
}

/// A header row, and a row for each number.
///
/// # Errors
/// None in practice: writing to memory.
pub(super) fn csv(rows: &[Row]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().ok().context("a table in memory")?;
    Ok(String::from_utf8(bytes)?)
}
