//! The page of a vehicle fitted to a recording: predictions of held-out motion beside simpler models, the numbers, and what the recording says.

use maud::html;
use planesman_console::Table;
use planesman_linear::digits::{significant, value_and_interval};
use planesman_six_dof_fit::{Predictor, SIGNALS, SixDofResult, Trajectory};

use crate::pages::cards::{Card, cards, findings};
use crate::pages::{document, figures, figures_with_first};
use crate::plot::Plot;

/// Seconds between two predicted parts in a plot.
const APART: f64 = 2.0;
const TIME: &str = "time in the parts, one after the other, s";

/// The HTML page; `recording` names the data.
#[must_use]
pub fn page(of: &SixDofResult, recording: &str) -> String {
    let title = format!("{} fitted to {recording}", of.like);
    let titles = SIGNALS.map(|(name, unit)| format!("{name}, {unit}"));
    // Velocities first, since they are what the vehicle's numbers move.
    let order = (SURGE..SIGNALS.len()).chain(0..SURGE);
    let plots: Vec<Plot<'_>> = order
        .filter_map(|channel| plot(&of.trajectories, channel, &titles[channel]))
        .collect();
    let said = of.contradictions.iter().map(ToString::to_string);
    let said = said.chain(of.reversed_inputs.iter().map(ToString::to_string));
    let said = said.map(|it| (it, true));
    let differing = of.agreements.iter().filter(|it| !it.is_close());
    let said = said.chain(differing.map(|it| (it.to_string(), true)));
    let resets = match of.resets.len() {
        0 => None,
        n => Some((format!("{n} jumps of the pose are left out"), true)),
    };
    let saturated = of.saturated.iter().map(|it| (it.to_string(), true));
    let body = html! {
        h1 { (title) }
        (cards(&summary(of)))
        @if let Some(first) = plots.first() { (figures_with_first(std::slice::from_ref(first))) }
        (findings(said.chain(resets).chain(saturated)))
        div.columns {
            div { h2 { "Errors of predictions" } p { "Root-mean-square errors on held-out data; the prediction of each window starts from a measured state." } (errors(of).html()) }
            div { h2 { "Numbers" } (numbers(of).html()) }
        }
        h2 { "Measured and predicted" }
        (figures(plots.get(1..).unwrap_or_default()))
    };
    document(&title, "", &body, "")
}

/// The place of surge among the signals, the first velocity.
const SURGE: usize = 6;

fn summary(of: &SixDofResult) -> Vec<Card> {
    let verdict = of.verdict();
    let mut all = vec![
        Card::new("verdict", verdict.standing().name().replace('_', " "))
            .toned(verdict.standing().into())
            .note(verdict.to_string()),
    ];
    if let Some(judged) = of.predictions.iter().find(|it| it.is_judged) {
        let error = |predictor| {
            judged
                .of(predictor)
                .map(|it| significant(it.position, 3) + " m")
        };
        let linear = error(Predictor::LinearPerAxis).unwrap_or_default();
        let value = error(Predictor::Fitted).unwrap_or_else(|| "diverges".to_owned());
        let label = format!("position after up to {} s", judged.horizon);
        all.push(Card::new(label, value).note(format!("linear model per axis: {linear}")));
    }
    for delay in of.delays.iter().take(1) {
        let (value, interval) = value_and_interval(delay.value, delay.interval);
        let label = match delay.name.as_str() {
            "all" => "delay of the inputs".to_owned(),
            input => format!("delay of input {input}"),
        };
        all.push(Card::new(label, format!("{value} ± {interval} s")));
    }
    let determined = of.numbers.len() - of.undetermined.len();
    all.push(Card::new(
        "numbers determined",
        format!("{determined} of {}", of.numbers.len()),
    ));
    all
}

fn errors(of: &SixDofResult) -> Table {
    let mut table = Table::of([
        "s",
        "model",
        "velocity, m/s",
        "rate, deg/s",
        "position, m",
        "attitude, deg",
    ]);
    for prediction in &of.predictions {
        for (predictor, errors) in &prediction.errors {
            let row = errors.map_or_else(
                || {
                    [
                        "diverges".to_owned(),
                        String::new(),
                        String::new(),
                        String::new(),
                    ]
                },
                |it| {
                    [
                        it.velocity,
                        it.rate.to_degrees(),
                        it.position,
                        it.attitude.to_degrees(),
                    ]
                    .map(|it| significant(it, 3))
                },
            );
            let head = [prediction.horizon.to_string(), predictor.name().to_owned()];
            table.row(head.into_iter().chain(row));
        }
    }
    table
}

fn numbers(of: &SixDofResult) -> Table {
    let mut table = Table::of(["number", "fitted", "± 95 %", "initial"]);
    for it in &of.numbers {
        let (value, interval) = value_and_interval(it.value, it.interval);
        table.row([it.name.clone(), value, interval, significant(it.like, 4)]);
    }
    table
}

/// A signal in all parts, one after the other; `None` if it is not recorded.
fn plot<'a>(parts: &[Trajectory], channel: usize, title: &'a str) -> Option<Plot<'a>> {
    let (mut measured, mut predicted) = (Vec::new(), Vec::new());
    let mut from = 0.0;
    for part in parts {
        let own = part.samples.iter().filter(|it| it.1 == channel);
        let mut end = from;
        for (time, _, value, at) in own {
            end = from + time;
            measured.push((end, *value));
            predicted.push((end, *at));
        }
        // A gap between two parts.
        measured.push((end + 0.5 * APART, f64::NAN));
        predicted.push((end + 0.5 * APART, f64::NAN));
        from = end + APART;
    }
    measured.iter().any(|it| it.1.is_finite()).then(|| {
        Plot::new(title, [TIME, title])
            .line("measured", measured)
            .line(
                "predicted from the state at the beginning of each part",
                predicted,
            )
    })
}
