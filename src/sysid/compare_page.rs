//! Models drawn over each other on one self-contained HTML page: simulated outputs, frequency and step responses, poles,
//! residual correlations.

use anyhow::Result;
use maud::{Markup, html};
use planesman_identification::filter;
use planesman_identification::validation::residuals::{Correlation, ResidualTests};
use planesman_plot::{Series, Style};
use planesman_signals::Taken;

use super::compared::{Compared, fits, frequency_responses};
use super::page::{LOG_OMEGA, Response, bound, drawn, line, plot, unit_circle};
use crate::page::document;

/// Samples of a step response: at least, and at most.
const STEP: (usize, usize) = (20, 2000);
/// The share of its range that a step response may still be off where it counts as settled.
const SETTLED: f64 = 0.02;
/// Poles farther from 0 are not drawn, nor what lies so many ranges of the measured output beyond it.
const FAR: f64 = 4.0;

/// A page with the models drawn over each other.
///
/// # Errors
/// When a plot cannot be drawn.
pub(super) fn page(models: &[Compared], taken: &Taken) -> Result<String> {
    let record = &taken.resampled.record;
    let title = format!(
        "Models of {} to {}",
        record.inputs.first().map_or("", String::as_str),
        record.outputs.first().map_or("", String::as_str)
    );
    let plots = plots(models, taken)?;
    let body = html! {
        h1 { (title) }
        p.lead { "Each model is simulated from a state fitted to the beginning of the data; its offset is its own." }
        (fits(models).html())
        pre { (taken.account()) }
        @for plot in plots { (plot) }
    };
    Ok(document(&title, "", &body))
}

fn plots(models: &[Compared], taken: &Taken) -> Result<Vec<Markup>> {
    let record = &taken.resampled.record;
    let Some(longest) = models
        .first()
        .map(|it| it.judgement.segments[it.judgement.longest])
    else {
        return Ok(Vec::new());
    };
    let segment = &record.segments[longest];
    let timed = |values: &[f64]| -> Vec<(f64, f64)> {
        let values = values.iter().enumerate();
        values
            .map(|(k, v)| (k as f64 * record.sample_time, *v))
            .collect()
    };
    let measured = &segment.outputs[0];
    let range = |pick: fn(f64, f64) -> f64| measured.iter().copied().fold(measured[0], pick);
    let (low, high) = (range(f64::min), range(f64::max));
    // A simulation that diverges would flatten all others.
    let near =
        |value: f64| (value - low).abs().max((value - high).abs()) < FAR * (high - low).max(1e-9);
    // Models first, so that each has one colour on the whole page.
    let each = |of: &dyn Fn(&Compared) -> Vec<(f64, f64)>| -> Vec<Series<'_>> {
        models
            .iter()
            .map(|model| line(&model.name, of(model)))
            .collect()
    };
    let responses = frequency_responses(models);
    let over_frequency = |of: &dyn Fn(&Response) -> f64| -> Vec<Series<'_>> {
        let each = models.iter().zip(&responses);
        each.map(|(model, responses)| {
            let points = responses.iter().map(|it| (it.log_omega, of(it)));
            line(&model.name, points.collect())
        })
        .collect()
    };
    let mut simulated = each(&|model| {
        let mut points = timed(&model.judgement.simulated[model.judgement.longest]);
        points.retain(|(_, value)| near(*value));
        points
    });
    simulated.push(bound("measured", timed(measured)));
    let output = &record.outputs[0];
    let mut drawings = vec![
        drawn(
            "Measured, and simulated on the input alone. What lies far beyond the measured range is not shown.",
            plot(
                "Measured and simulated output",
                "time [s]",
                output,
                simulated,
            ),
        )?,
        drawn(
            "Input over each sampling interval.",
            plot(
                "Input",
                "time [s]",
                &record.inputs[0],
                vec![line("input", timed(&segment.inputs[0]))],
            ),
        )?,
        drawn(
            "Frequency responses up to half the sampling rate.",
            plot(
                "Magnitude",
                LOG_OMEGA,
                "magnitude [dB]",
                over_frequency(&|it| it.magnitude(0.0)),
            ),
        )?,
        drawn(
            "The same for the phase.",
            plot(
                "Phase",
                LOG_OMEGA,
                "phase [deg]",
                over_frequency(&|it| it.phase),
            ),
        )?,
    ];
    let mut poles: Vec<Series<'_>> = models.iter().map(pole_map).collect();
    poles.push(Series {
        style: Style::Bound,
        ..unit_circle()
    });
    drawings.push(drawn(
        "In the z plane; points beyond |z| = 4 are not shown.",
        plot("Poles", "real part", "imaginary part", poles).one_scale(),
    )?);
    // Longer than about half of them take, so that one slow mode does not hide the others' beginning.
    let settling: Vec<Option<usize>> = models.iter().map(settling).collect();
    let mut settled: Vec<usize> = settling.iter().copied().flatten().collect();
    settled.sort_unstable();
    let usual = settled
        .get(settled.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or_default();
    let count = (usual + usual / 2).clamp(STEP.0, STEP.1);
    let steps = models.iter().zip(&settling).map(|(model, settling)| {
        let points = settling.map(|_| timed(&step_response(model, count)));
        line(&model.name, points.unwrap_or_default())
    });
    drawings.push(drawn(
        "From rest, without offset. Unstable models are left out.",
        plot("Step responses", "time [s]", output, steps.collect()),
    )?);
    drawings.push(correlations(
        models,
        "Residuals with themselves",
        "Over the bound that 99 % of white residuals stay within.",
        |tests| &tests.whiteness,
    )?);
    drawings.push(correlations(
        models,
        "Residuals with the input",
        "Over the same bound. Outside at positive lags: missing dynamics; at negative lags: feedback.",
        |tests| &tests.input,
    )?);
    Ok(drawings)
}

fn pole_map(model: &Compared) -> Series<'_> {
    let poles = model.reading().poles().unwrap_or_default();
    let points = poles.iter().map(|it| (it.value.re, it.value.im));
    Series {
        name: model.name.as_str().into(),
        points: points.filter(|p| p.0.hypot(p.1) < FAR).collect(),
        style: Style::Crosses,
    }
}

/// Samples after which a step response stays within a share of its range about its end; `None` for an unstable model,
/// whose response has none.
fn settling(model: &Compared) -> Option<usize> {
    let poles = model.reading().poles().ok()?;
    if poles.iter().any(|it| it.value.norm() > 1.0 + 1e-6) {
        return None;
    }
    let response = step_response(model, STEP.1);
    let end = *response.last()?;
    let most = response
        .iter()
        .fold(0.0_f64, |most, y| most.max((y - end).abs()));
    let far = response
        .iter()
        .rposition(|y| (y - end).abs() > SETTLED * most.max(end.abs()));
    Some(far.map_or(0, |last| last + 1))
}

fn step_response(model: &Compared, count: usize) -> Vec<f64> {
    let estimate = &model.judgement.estimate;
    let layout = &estimate.layout;
    let theta = estimate.theta.as_slice();
    let a = layout.denominator(theta);
    let mut b = vec![0.0; layout.structure.delay];
    b.extend(&theta[layout.b(model.judgement.longest)]);
    filter(&b, &a, &vec![1.0; count])
}

fn correlations(
    models: &[Compared],
    title: &str,
    note: &str,
    of: fn(&ResidualTests) -> &Correlation,
) -> Result<Markup> {
    let mut series: Vec<Series<'_>> = models
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
    for (name, level) in [("99 %", 1.0), ("-99 %", -1.0)] {
        let ends = ends.iter().flatten();
        series.push(bound(name, ends.map(|lag| (*lag, level)).collect()));
    }
    drawn(
        note,
        plot(title, "lag [samples]", "correlation / bound", series),
    )
}
