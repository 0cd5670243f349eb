//! Page of a model with several inputs and outputs: for each output the verdict, a table of its inputs, data and simulation, the response to
//! each input, and residual tests.

use crate::plot::{Plot, Series, Style};
use maud::{Markup, html};
use planesman_fit::SeveralResult;
use planesman_flight::titles;
use planesman_identification::SIGMAS_95;
use planesman_identification::several::{Analysis, ChannelModel, HEAD_OF_F};

use crate::pages::cards::{Card, cards, findings};
use crate::pages::fit::{
    RECORD, SINCE_STEP, STEP, TIME, correlation, is_near, line, range, settling, timed,
};
use crate::pages::{document, figures_with_first};

/// The HTML page of the models of all outputs.
#[must_use]
pub fn page(found: &SeveralResult) -> String {
    let record = &found.prepared.resampled.record;
    let names = |names: &[String]| {
        let names: Vec<String> = names.iter().map(|it| titles::name(it)).collect();
        names.join(", ")
    };
    let title = format!("{} to {}", names(&record.inputs), names(&record.outputs));
    let body = html! {
        h1 { (title) }
        @for (output, analysis) in found.outputs.iter().enumerate() { (of_output(found, output, analysis)) }
        details { summary { "All numbers" } pre { (found.text()) } }
    };
    document(&title, "", &body, "")
}

fn of_output(found: &SeveralResult, output: usize, analysis: &Analysis) -> Markup {
    let column = |name: &String| titles::title(found.prepared.reading.column(name));
    let record = &found.prepared.resampled.record;
    let inputs: Vec<String> = record.inputs.iter().map(column).collect();
    let output_title = column(&analysis.output);
    let plots = plots(found, output, &inputs, &output_title);
    html! {
        h2 { (titles::name(&analysis.output)) }
        (cards(&[
            Card::verdict(analysis.verdict, &analysis.next()),
            Card::new("fit on held-out data", analysis.held_out.fit.map_or("none".to_owned(), |fit| format!("{fit:.1} %"))),
        ]))
        (findings(analysis.reasons.iter().map(|it| (it, it.reason.is_against()))))
        div.scroll { table.words {
            tr { @for head in ["input", "order", "delay, samples", "steady-state gain", "modes", HEAD_OF_F] { th { (head) } } }
            @for row in analysis.rows() { tr { @for cell in row { td { (cell) } } } }
        } }
        (figures_with_first(&plots))
    }
}

fn plots<'a>(
    found: &SeveralResult,
    output: usize,
    inputs: &'a [String],
    output_title: &'a str,
) -> Vec<Plot<'a>> {
    let analysis = &found.outputs[output];
    let record = &found.prepared.resampled.record;
    let segment = &record.segments[analysis.segments[analysis.longest]];
    let measured = &segment.outputs[output];
    let simulated = &analysis.simulated[analysis.longest];
    let (low, high) = range(measured);
    let timed = |values: &[f64]| timed(values, record.sample_time);
    let near = |values: &[f64], (low, high): (f64, f64)| {
        // What unknown inputs act on is not simulated.
        let points = timed(values).into_iter().skip(analysis.unknown);
        points
            .filter(|(_, it)| is_near(*it, low, high))
            .collect::<Vec<_>>()
    };
    let spread = high - low;
    let errors: Vec<f64> = measured.iter().zip(simulated).map(|(y, x)| y - x).collect();
    let mut plots = vec![
        Plot::new("Measured and simulated output", [TIME, output_title])
            .note("The model is simulated from the inputs only.")
            .linked(RECORD)
            .with(Style::Broad, "measured", timed(measured))
            .line("simulated", near(simulated, (low, high))),
        Plot::new("Measured less simulated output", [TIME, output_title])
            .note("The part of the output that the model does not explain.")
            .linked(RECORD)
            .line("error", near(&errors, (-spread, spread))),
    ];
    for (number, input, model) in analysis.channels() {
        plots.push(
            Plot::new(
                format!("Input {}", titles::name(&input.name)),
                [TIME, inputs[number].as_str()],
            )
            .linked(RECORD)
            .line("input", timed(&segment.inputs[number])),
        );
        plots.push(step(&input.name, model, output_title));
        if let Some(tests) = &model.residuals {
            plots.push(correlation(
                format!("Cross-correlation of residual and {}", titles::name(&input.name)),
                "Outside the bound at lags of 0 and above: missing dynamics; at negative lags: feedback.",
                &tests.input,
            ));
        }
    }
    if let Some(tests) = &analysis.residual_tests {
        plots.push(correlation(
            "Residual autocorrelation",
            "White residuals stay within the band.",
            &tests.whiteness,
        ));
    }
    plots
}

/// The output after a unit step of one input, with the other inputs constant.
fn step<'a>(input: &str, model: &ChannelModel, output_title: &'a str) -> Plot<'a> {
    let estimate = &model.estimate;
    let title = format!("Step response to {}", titles::name(input));
    let plot = Plot::new(title, [SINCE_STEP, output_title]);
    let Some(settled) = settling(estimate, 0) else {
        return plot.note("The model is unstable: its step response has no final value.");
    };
    let count = (settled + settled / 2).clamp(STEP.0, STEP.1);
    let at = |k: usize| k as f64 * estimate.sample_time;
    let response = model.reading().uncertain_step_response(count);
    let each = response.iter().enumerate();
    let band = each.clone().map(|(k, (value, deviation))| {
        let half = SIGMAS_95 * deviation;
        (at(k), value - half, value + half)
    });
    plot.note("Response to a unit step of this input while the other inputs are constant, without offset; with its 95 % band.")
        .with_all([Series::band("95 %", band)])
        .with_all([line("model", each.map(|(k, it)| (at(k), it.0)).collect())])
}
