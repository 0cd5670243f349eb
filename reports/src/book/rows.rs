//! Numbers of reports as rows, for other programs.

use planesman_parallel::on_all_cores;
use serde::Serialize;

use crate::book::{Book, Comparison, Line, Names, Report, ReportError};

/// A number with its comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    report: &'static str,
    number: String,
    family: String,
    name: Option<String>,
    source: String,
    unit: String,
    printed: Option<f64>,
    /// Allowed difference of a recomputed number.
    within: Option<f64>,
    recomputed: Option<f64>,
    verdict: String,
    /// Number and text of the erratum that explains it.
    erratum: Option<String>,
    explanation: Option<String>,
    note: Option<String>,
}

/// The numbers of all reports.
///
/// # Errors
/// None in practice: the books are compiled in.
pub fn all(reports: &[Report]) -> Result<Vec<Row>, ReportError> {
    let recomputed = on_all_cores(reports, |report| (report.recomputed)());
    let mut rows = Vec::new();
    for (report, values) in reports.iter().zip(recomputed) {
        let (book, names) = ((report.book)()?, (report.names)()?);
        let comparison = Comparison::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
        rows.extend(of(report, &book, &names, &comparison));
    }
    Ok(rows)
}

/// The numbers of one report.
#[must_use]
pub fn of(report: &Report, book: &Book, names: &Names, comparison: &Comparison<'_>) -> Vec<Row> {
    let lines = comparison.lines.iter();
    let row = |line: &Line<'_>| {
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
            verdict: line.told(),
            erratum: erratum.map(|(number, _)| number.to_owned()),
            explanation: erratum.map(|(_, text)| text.to_owned()),
            note: entry.note.clone(),
        }
    };
    lines.map(row).collect()
}
