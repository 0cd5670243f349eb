//! A continuous-time transfer function fitted at the recorded sample times: text for a terminal, and an HTML page.

use crate::plot::Plot;
use maud::html;
use planesman_console::{Format, Table};
use planesman_fit::ContinuousResult;
use planesman_identification::SIGMAS_95;
use planesman_linear::digits::{significant, value_and_interval, with_interval};

use crate::pages::equations::{measured_and_simulated, record};
use crate::pages::{document, figures};

/// Tables, sentences and verdict.
#[must_use]
pub fn text(of: &ContinuousResult) -> String {
    let fit = &of.fit;
    let (verdict, reasons) = of
        .sentences
        .split_last()
        .map_or(("", &[][..]), |(last, rest)| (last, rest));
    let mut text = format!("{verdict}\n\n{}\n\n", equation(of));
    text += &parameters(of).text(Format::Table);
    for pole in fit.poles().unwrap_or_default() {
        text += &format!("mode    {}\n", pole.mode_text());
    }
    let percent = |it: Option<f64>| it.map_or("none".to_owned(), |it| format!("{it:.2} %"));
    text += &format!(
        "fit     {} simulated, {} on held-out data; rms error {}\n\n",
        percent(fit.fit),
        percent(fit.held_out_fit),
        significant(fit.left, 4)
    );
    for sentence in reasons {
        text += &format!("- {sentence}\n");
    }
    text + &record(&of.data)
}

/// `(b1 s + b0) e^(-0.4 s) / (s^2 + a1 s + a0)`.
fn equation(of: &ContinuousResult) -> String {
    let fit = &of.fit;
    let power = |name: &str, k: usize| match k {
        0 => format!("{name}0"),
        1 => format!("{name}1 s"),
        k => format!("{name}{k} s^{k}"),
    };
    let sum = |name: &str, count: usize| {
        let terms = (0..count).rev().map(|k| power(name, k));
        terms.collect::<Vec<_>>().join(" + ")
    };
    let highest = match fit.order {
        1 => "s".to_owned(),
        n => format!("s^{n}"),
    };
    let late = match fit.longest_delay {
        Some(_) => " e^(-tau s)",
        None => "",
    };
    format!(
        "{} -> {}: ({}){late} / ({highest} + {})",
        of.data.signals[0],
        of.data.signals[1],
        sum("b", fit.numerator),
        sum("a", fit.order)
    )
}

fn parameters(of: &ContinuousResult) -> Table {
    let fit = &of.fit;
    let mut table = Table::new(["parameter", "value", "± 95 %", "unit"]);
    let names = (0..fit.order)
        .rev()
        .map(|k| (format!("a{k}"), k, String::new()));
    let b = (0..fit.numerator)
        .rev()
        .map(|k| (format!("b{k}"), fit.order + k, String::new()));
    let delay = fit
        .longest_delay
        .map(|_| ("tau".to_owned(), fit.order + fit.numerator, "s".to_owned()));
    for (name, at, unit) in names.chain(b).chain(delay) {
        let half = SIGMAS_95 * fit.covariance[(at, at)].max(0.0).sqrt();
        let (value, half) = value_and_interval(fit.parameters[at], half);
        let half = match name == "tau" && fit.is_delay_at_bound {
            true => "at a bound".to_owned(),
            false => half,
        };
        table.row([name, value, half, unit]);
    }
    let (gain, deviation) = fit.gain();
    let (gain, half) = value_and_interval(gain, SIGMAS_95 * deviation);
    table.row(["gain b0/a0".to_owned(), gain, half, String::new()]);
    table
}

/// The HTML page: verdict, parameters, measured and simulated output.
#[must_use]
pub fn page(of: &ContinuousResult) -> String {
    let fit = &of.fit;
    let title = format!("{} to {}", of.data.signals[0], of.data.signals[1]);
    let mut plots: Vec<Plot<'_>> = Vec::new();
    for (number, (run, values)) in of.data.runs.iter().zip(&fit.simulated).enumerate().take(6) {
        let segment = (of.data.runs.len() > 1).then_some(number + 1);
        plots.extend(measured_and_simulated(
            &of.data.signals[1],
            &run.outputs[0],
            values,
            segment,
        ));
    }
    let (gain, deviation) = fit.gain();
    let body = html! {
        h1 { (title) }
        ul.verdict { @for sentence in of.sentences.iter().rev() { li { (sentence) } } }
        p { (equation(of)) }
        (parameters(of).html())
        p { "Steady-state gain " (with_interval(gain, SIGMAS_95 * deviation)) }
        (figures(&plots))
        details { summary { "All numbers" } pre { (text(of)) } }
    };
    document(&title, "", &body, "")
}
