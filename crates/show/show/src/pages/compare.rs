//! Page that compares models: simulated outputs, frequency and step responses, poles, residual correlations.

use std::cmp::Reverse;

use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_fit::{Compared, Response, frequency_responses};
use planesman_identification::Reading;
use planesman_identification::validation::residuals::{Correlation, ResidualTests};
use planesman_linear::{ComplexFunctions as _, is_sampling_artefact};
use planesman_signals::PreparedRecord;

use super::fit::{
    DRAWN_WITHIN, FREQUENCY, LAG, MAGNITUDE, PHASE, RECORD, SINCE_STEP, STEP, TIME, bound, is_near,
    line, range, settling, timed, unit_circle,
};
use super::tables::fits;
use crate::pages::{document, figures_with_first, poles};
use planesman_flight::titles;

/// The HTML page of the compared models.
#[must_use]
pub fn page(models: &[Compared], prepared: &PreparedRecord) -> String {
    let record = &prepared.resampled.record;
    let first = |names: &[String]| {
        names
            .first()
            .map_or_else(String::new, |it| titles::title(it))
    };
    let (input, output) = (first(&record.inputs), first(&record.outputs));
    let title = format!(
        "Models: {} to {}",
        titles::name(record.inputs.first().map_or("", String::as_str)),
        titles::name(record.outputs.first().map_or("", String::as_str))
    );
    let readings: Vec<_> = models
        .iter()
        .map(|it| (it.name.as_str(), it.reading()))
        .collect();
    let mut best: Vec<&Compared> = models.iter().collect();
    best.sort_by_key(|it| Reverse(it.judgement.fit.map(|fit| (1e6 * fit) as i64)));
    let body = html! {
        h1 { (title) }
        @if let [best, _, ..] = best[..] { @if let Some(fit) = best.judgement.fit {
            ul.verdict { li { (best.name) " simulates best: " (format!("{fit:.2}")) " %." } }
        } }
        (fits(models).html())
        p.lead { "Each model is simulated with its own offset, from an initial state fitted to the beginning of the data." }
        (figures_with_first(&plots(models, prepared, &input, &output)))
        h2 { "Poles" }
        (poles::table_with_note(&readings, |cell| html! { (cell) }))
        details { summary { "The data" } pre { (prepared.description()) } }
    };
    document(&title, "", &body, "")
}

fn plots<'a>(
    models: &'a [Compared],
    prepared: &'a PreparedRecord,
    input: &'a str,
    output: &'a str,
) -> Vec<Plot<'a>> {
    let record = &prepared.resampled.record;
    let Some(longest) = models
        .first()
        .map(|it| it.judgement.segments[it.judgement.longest])
    else {
        return Vec::new();
    };
    let segment = &record.segments[longest];
    let timed = |values: &[f64]| timed(values, record.sample_time);
    let measured = &segment.outputs[0];
    // A simulation that diverges would flatten all others.
    let (low, high) = range(measured);
    // Models first, so that each has one colour on the whole page.
    let each = |of: &dyn Fn(&Compared) -> Vec<(f64, f64)>| -> Vec<Series<'a>> {
        models
            .iter()
            .map(|model| line(&model.name, of(model)))
            .collect()
    };
    let responses = frequency_responses(models);
    let over_frequency = |of: &dyn Fn(&Response) -> f64| -> Vec<Series<'a>> {
        let each = models.iter().zip(&responses);
        each.map(|(model, responses)| {
            let points = responses.iter().map(|it| (it.omega, of(it)));
            line(&model.name, points.collect())
        })
        .collect()
    };
    let simulated = each(&|model| {
        let mut points = timed(&model.judgement.simulated[model.judgement.longest]);
        points.retain(|(_, value)| is_near(*value, low, high));
        points
    });
    // Longer than about half of them take, so that one slow mode does not hide the others' beginning.
    let settling: Vec<Option<usize>> = models
        .iter()
        .map(|it| settling(&it.judgement.estimate, it.judgement.longest))
        .collect();
    let mut settled: Vec<usize> = settling.iter().copied().flatten().collect();
    settled.sort_unstable();
    let usual = settled
        .get(settled.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or_default();
    let count = (usual + usual / 2).clamp(STEP.0, STEP.1);
    let steps = models.iter().zip(&settling).map(|(model, settling)| {
        let of = &model.judgement;
        let points =
            settling.map(|_| timed(&Reading::new(&of.estimate, of.longest).step_response(count)));
        line(&model.name, points.unwrap_or_default())
    });
    vec![
        Plot::new("Measured and simulated output", [TIME, output])
            .note("Measured, and simulated from the input only. Values far outside the measured range are not shown.")
            .linked(RECORD)
            .with_all(simulated)
            .with_all([bound("measured", timed(measured))]),
        Plot::new("Input", [TIME, input])
            .note("Mean over each sampling interval.")
            .linked(RECORD)
            .line("input", timed(&segment.inputs[0])),
        Plot::new("Magnitude", MAGNITUDE)
            .note("Frequency responses of the models up to half the sampling rate.")
            .log_x()
            .linked(FREQUENCY)
            .with_all(over_frequency(&|it| it.magnitude(0.0))),
        Plot::new("Phase", PHASE)
            .note("Up to half the sampling rate.")
            .log_x()
            .linked(FREQUENCY)
            .with_all(over_frequency(&|it| it.phase)),
        Plot::new("Poles", ["real part", "imaginary part"])
            .note("z plane; points beyond |z| = 4 are not shown.")
            .one_scale()
            .with_all(models.iter().map(pole_map))
            .with_all(artefacts(models))
            .with_all([unit_circle()]),
        Plot::new("Step responses", [SINCE_STEP, output])
            .note("Response to a unit step of the input, from rest, without offset. Unstable models are not shown.")
            .with_all(steps),
        correlations(
            models,
            "Residual autocorrelation",
            "The bound contains 99 % of the correlations of white residuals.",
            |tests| &tests.whiteness,
        ),
        correlations(
            models,
            "Cross-correlation of residual and input",
            "Same bound. Outside the bound at positive lags: missing dynamics; at negative lags: feedback.",
            |tests| &tests.input,
        ),
    ]
}

/// The poles near the unit circle: either the artefacts of sampling, or the other poles.
fn near_poles(model: &Compared, artefacts: bool) -> Vec<(f64, f64)> {
    let poles = model.reading().poles().unwrap_or_default();
    let wanted = poles
        .iter()
        .map(|it| it.value)
        .filter(|it| it.modulus() < DRAWN_WITHIN && is_sampling_artefact(*it) == artefacts);
    wanted.map(|it| (it.re, it.im)).collect()
}

fn pole_map(model: &Compared) -> Series<'_> {
    Series::new(
        Style::Crosses,
        model.name.as_str(),
        near_poles(model, false),
    )
}

fn artefacts(models: &[Compared]) -> Option<Series<'static>> {
    let found: Vec<_> = models.iter().flat_map(|it| near_poles(it, true)).collect();
    (!found.is_empty()).then(|| Series::new(Style::Crosses, poles::ARTEFACT, found))
}

fn correlations<'a>(
    models: &'a [Compared],
    title: &'static str,
    note: &'static str,
    of: fn(&ResidualTests) -> &Correlation,
) -> Plot<'a> {
    let series: Vec<Series<'a>> = models
        .iter()
        .map(|model| {
            let found = model.judgement.residuals.as_ref().map(of);
            let points = found.iter().flat_map(|it| {
                let values = it.values.iter();
                values.map(|(lag, r)| (*lag as f64, r / it.bound))
            });
            line(&model.name, points.collect())
        })
        .collect();
    let lags: Vec<f64> = series
        .iter()
        .flat_map(|it| it.points.iter().map(|p| p.0))
        .collect();
    let ends = [f64::min, f64::max].map(|pick| lags.iter().copied().reduce(pick));
    let bounds = [("99 %", 1.0), ("-99 %", -1.0)].map(|(name, level)| {
        let ends = ends.iter().flatten();
        bound(name, ends.map(|lag| (*lag, level)).collect())
    });
    Plot::new(title, ["lag [samples]", "correlation / bound"])
        .note(note)
        .linked(LAG)
        .with_all(series)
        .with_all(bounds)
}
