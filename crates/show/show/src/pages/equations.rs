//! A fit of user-written state equations: text for a terminal, and an HTML page.

use crate::plot::{Plot, Style};
use maud::html;
use planesman_console::{Format, Table};
use planesman_equations::{EstimatedParameter, Run, Track};
use planesman_fit::{EquationsResult, StampedRuns};
use planesman_identification::SIGMAS_95;
use planesman_linear::digits::{significant, value_and_interval};

use crate::pages::cards::findings;
use crate::pages::fit::{RECORD, TIME};
use crate::pages::{document, figures_with_first};

/// Largest number of segments shown separately.
const SHOWN: usize = 6;

/// Tables, reasons and verdict.
#[must_use]
pub fn text(of: &EquationsResult) -> String {
    let fit = &of.fit;
    let mut text = format!("{}\n\n", fit.verdict_text());
    text += &parameters(of).text(Format::Table);
    let initial = initial(of);
    if !initial.is_empty() {
        text += &format!("\n{}", initial.text(Format::Table));
    }
    text += &format!("\n{}\n", outputs(of).text(Format::Table));
    for reason in &fit.reasons {
        text += &format!("- {reason}\n");
    }
    text + &record(&of.data)
}

/// Description of the data and its length.
pub(crate) fn record(data: &StampedRuns) -> String {
    format!("\n{}\n{}", data.description.join("\n"), span(data))
}

/// Number of segments and total duration of the data.
fn span(data: &StampedRuns) -> String {
    let seconds: f64 = data.runs.iter().map(Run::end).sum();
    let count = data.runs.len();
    let s = if count == 1 { "" } else { "s" };
    format!("{count} segment{s}, {seconds:.3} s, at the recorded sample times\n")
}

/// The segment's number in a title, if there are several.
fn named(segment: Option<usize>) -> String {
    segment.map_or(String::new(), |number| format!(", segment {number}"))
}

/// Plots of an output measured and simulated, and of the error.
pub(crate) fn measured_and_simulated<'a>(
    name: &'a str,
    track: &Track,
    values: &[f64],
    segment: Option<usize>,
) -> [Plot<'a>; 2] {
    let points = |of: &[f64]| {
        track
            .times
            .iter()
            .copied()
            .zip(of.iter().copied())
            .collect::<Vec<_>>()
    };
    let errors: Vec<f64> = track
        .values
        .iter()
        .zip(values)
        .map(|(y, x)| y - x)
        .collect();
    let of = named(segment);
    [
        Plot::new(format!("{name}, measured and simulated{of}"), [TIME, name])
            .note("The model is simulated from the inputs only.")
            .linked(RECORD)
            .with(Style::Broad, "measured", points(&track.values))
            .line("simulated", points(values)),
        Plot::new(format!("{name}, measured less simulated{of}"), [TIME, name])
            .note("The part of the output that the model does not explain.")
            .linked(RECORD)
            .line("error", points(&errors)),
    ]
}

fn row(found: &EstimatedParameter) -> Vec<String> {
    let half = found.deviation.map(|it| SIGMAS_95 * it);
    let (value, half) = match half {
        Some(half) => value_and_interval(found.value, half),
        None if found.is_at_bound => (significant(found.value, 6), "at a bound".to_owned()),
        None => (significant(found.value, 4), "not determined".to_owned()),
    };
    vec![
        found.unknown.name.clone(),
        value,
        half,
        found.unknown.unit.clone(),
    ]
}

fn parameters(of: &EquationsResult) -> Table {
    let mut table = Table::new(["parameter", "value", "± 95 %", "unit"]);
    for found in &of.fit.parameters {
        table.row(row(found));
    }
    table
}

fn initial(of: &EquationsResult) -> Table {
    let mut table = Table::new(["segment", "initial state", "value", "± 95 %", "unit"]);
    for (number, states) in of.fit.initial.iter().enumerate().take(SHOWN) {
        for found in states {
            table.row([vec![(number + 1).to_string()], row(found)].concat());
        }
    }
    table
}

fn outputs(of: &EquationsResult) -> Table {
    let mut table = Table::new([
        "output",
        "samples",
        "fit, %",
        "held-out fit, %",
        "rms left",
        "noise",
    ]);
    let percent = |it: Option<f64>| it.map_or("none".to_owned(), |it| format!("{it:.2}"));
    for it in &of.fit.outputs {
        table.row([
            it.name.clone(),
            it.samples.to_string(),
            percent(it.fit),
            percent(it.held_out_fit),
            significant(it.left, 4),
            it.noise.map_or(String::new(), |it| significant(it, 4)),
        ]);
    }
    table
}

/// The HTML page: verdict, parameters, and each output measured and simulated, per segment.
#[must_use]
pub fn page(of: &EquationsResult) -> String {
    let fit = &of.fit;
    let file = &fit.equations.file;
    let title = file
        .description
        .clone()
        .unwrap_or_else(|| "Equations".to_owned());
    let title = title.lines().next().unwrap_or_default().to_owned();
    let mut plots = Vec::new();
    for (number, (run, simulated)) in of
        .data
        .runs
        .iter()
        .zip(&fit.simulated)
        .enumerate()
        .take(SHOWN)
    {
        let segment = (of.data.runs.len() > 1).then_some(number + 1);
        for ((output, track), values) in fit.outputs.iter().zip(&run.outputs).zip(simulated) {
            plots.extend(measured_and_simulated(&output.name, track, values, segment));
        }
        for (name, track) in file.inputs.names().zip(&run.inputs) {
            let points = track
                .times
                .iter()
                .copied()
                .zip(track.values.iter().copied());
            let within: Vec<(f64, f64)> = points.filter(|it| it.0 >= 0.0).collect();
            plots.push(
                Plot::new(
                    format!("Input {name}{}", named(segment)),
                    [TIME, name.as_str()],
                )
                .linked(RECORD)
                .line("input", within),
            );
        }
    }
    let body = html! {
        h1 { (title) }
        ul.verdict { li { (fit.verdict_text()) } }
        (figures_with_first(&plots))
        div.columns { div { h2 { "Parameters" } (parameters(of).html()) } div { h2 { "Outputs" } (outputs(of).html()) } }
        h2 { "Findings" }
        (findings(fit.reasons.iter().map(|it| (it, false))))
        details { summary { "All numbers" } pre { (text(of)) } }
    };
    document(&title, "", &body, "")
}
