//! Page of a model: the verdict, the model in plain words, data and simulation, residual tests, poles and zeros with their uncertainty,
//! frequency response with bands, step response, and the parameter estimates over time.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_fit::{Response, Simulated, frequency_response};
use planesman_identification::analysis::Analysis;
use planesman_identification::estimators::{Estimate, Row, StepResponse};
use planesman_identification::validation::residuals::Correlation;
use planesman_identification::{
    IdentificationError, Problem, Reading, Record, SIGMAS_95, Structure, Uncertain,
};
use planesman_linear::digits::with_interval;
use planesman_linear::{ComplexFunctions as _, is_sampling_artefact};

use crate::pages::cards::{Card, cards, findings};
use crate::pages::poles::{self, ARTEFACT};
use crate::pages::{document, figures, figures_with_first};
use planesman_flight::titles;

type Result<T, E = IdentificationError> = std::result::Result<T, E>;

/// Number of points of an ellipse.
const ELLIPSE: usize = 60;
/// Largest distance of plotted poles and zeros from 0; also the distance of plotted values from a range, in multiples of its width.
pub(crate) const DRAWN_WITHIN: f64 = 4.0;
/// Minimum and maximum number of samples of a step response.
pub(crate) const STEP: (usize, usize) = (20, 2000);
/// Range of a frequency-domain model's plot beyond its band, a factor.
const BESIDE_BAND: f64 = 3.0;
/// Range of a frequency response's plot: this many dB below the largest magnitude, and two turns of phase.
const DEPTH: f64 = 60.0;
const TURNS: f64 = 720.0;
/// Share of its range within which a step response counts as settled.
const SETTLED: f64 = 0.02;

pub(crate) const TIME: &str = "time [s]";
pub(crate) const SINCE_STEP: &str = "time after the step [s]";
/// Axes of a frequency response.
pub(crate) const MAGNITUDE: [&str; 2] = ["frequency [rad/s]", "magnitude [dB]"];
pub(crate) const PHASE: [&str; 2] = ["frequency [rad/s]", "phase [deg]"];
/// All plots over time share one x axis; so do all plots over frequency, and all plots over lag.
pub(crate) const RECORD: &str = "record";
pub(crate) const FREQUENCY: &str = "frequency";
pub(crate) const LAG: &str = "lag";

/// The HTML page of a model; `columns`: titles of its input and output, with units.
///
/// # Errors
/// The record does not belong to the model, or the poles cannot be computed.
pub fn page(analysis: &Analysis, record: &Record, columns: [&str; 2]) -> Result<String> {
    let [input, output] = columns.map(titles::title);
    let title = format!(
        "{} to {}",
        titles::title(&analysis.input),
        titles::name(&analysis.output)
    );
    let plots = plots(analysis, record, &input, &output)?;
    let body = html! {
        h1 { (title) }
        (cards(&summary(analysis)))
        (figures_with_first(&plots[..1]))
        h2 { "Findings" }
        (findings(analysis.reasons.iter().map(|it| (it, it.is_against()))))
        div.columns {
            div {
                h2 { "The model" }
                div.scroll { table.words { @for (name, value) in words(analysis) { tr { td { (name) } td { (value) } } } } }
            }
            @if analysis.reading().poles().is_ok_and(|it| !it.is_empty()) {
                div {
                    h2 { "Poles" }
                    (poles::table_with_note(&[("", analysis.reading())], |cell| html! { (cell) }))
                }
            }
        }
        h2 { "Plots" }
        (figures(&plots[1..]))
        details { summary { "All numbers" } pre { (analysis.all_numbers()) } }
    };
    Ok(document(&title, "", &body, ""))
}

/// Cards: the verdict, the fit, and the most important numbers.
fn summary(analysis: &Analysis) -> Vec<Card> {
    let percent = |fit: Option<f64>| fit.map_or("none".to_owned(), |fit| format!("{fit:.1} %"));
    let mut all = vec![
        Card::verdict(analysis.verdict, &analysis.next()),
        Card::new("fit on held-out data", percent(analysis.held_out.fit)),
    ];
    let reading = analysis.reading();
    if let Some(gain) = reading.steady_state_gain() {
        let gain = with_interval(gain.value.re, SIGMAS_95 * gain.real_deviation());
        all.push(Card::new("steady-state gain", gain));
    } else if let Some(gain) = reading.integrator_gain_text() {
        all.push(Card::new("gain", gain));
    }
    let slowest = reading.determined_modes().0.into_iter().next();
    all.extend(slowest.map(|it| Card::new("slowest mode", it)));
    all
}

/// The model in words of the field: property and value.
pub(crate) fn words(analysis: &Analysis) -> Vec<(String, String)> {
    let structure = &analysis.estimate.layout.structure;
    let sample_time = analysis.estimate.sample_time;
    let percent = |fit: Option<f64>| fit.map_or("none".to_owned(), |fit| format!("{fit:.2} %"));
    let mut rows: Vec<(String, String)> = Vec::new();
    let mut row = |name: &str, value: String| rows.push((name.to_owned(), value));
    for mode in analysis.modes() {
        row("mode", mode);
    }
    if let Some(process) = &analysis.estimate.process {
        row("process", process.form.equation().to_owned());
        for (name, unit, value, deviation) in process.named() {
            let value = with_interval(value, SIGMAS_95 * deviation);
            row(name, format!("{value} {unit}"));
        }
    }
    if let Some(fit) = &analysis.estimate.frequency {
        row("in s", fit.equation());
        for (name, value, deviation) in fit.named() {
            let unit = if name == "theta" { " s" } else { "" };
            row(&name, with_interval(value, SIGMAS_95 * deviation) + unit);
        }
    }
    if let Some(curved) = &analysis.curved {
        row(curved.label(), curved.in_words());
    }
    let delay = structure.delay;
    let mut late = format!(
        "{delay} sample{}, {:.4} s",
        if delay == 1 { "" } else { "s" },
        delay as f64 * sample_time
    );
    if let Some(lag) = analysis.lag {
        let (from, to) = lag.interval;
        late += &format!("; 95 % interval {from} to {to} samples");
    }
    row("delay", late);
    let gain = analysis.reading().steady_state_gain();
    let gain = gain.map(|it| with_interval(it.value.re, SIGMAS_95 * it.real_deviation()));
    row(
        "steady-state gain",
        gain.unwrap_or_else(|| "none (the model integrates)".to_owned()),
    );
    if let Some(gain) = analysis.reading().integrator_gain_text() {
        row("gain", gain);
    }
    row("simulated fit", percent(analysis.fit));
    row("on held-out data", percent(analysis.held_out.fit));
    let every = format!("{sample_time:.6}");
    row(
        "method",
        format!(
            "{}, {} poles, every {} s",
            analysis.method_name(),
            structure.poles,
            every.trim_end_matches('0')
        ),
    );
    rows
}

/// Minimum and maximum of values.
pub(crate) fn range(values: &[f64]) -> (f64, f64) {
    let values = values.iter();
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
        (low.min(*it), high.max(*it))
    })
}

/// Whether a value is at most [`DRAWN_WITHIN`] times a range's width outside the range.
pub(crate) fn is_near(value: f64, low: f64, high: f64) -> bool {
    (value - low).abs().max((value - high).abs()) < DRAWN_WITHIN * (high - low).max(1e-9)
}

pub(crate) fn line(name: &str, points: Vec<(f64, f64)>) -> Series<'_> {
    Series::new(Style::Line, name, points)
}

/// A line in the text colour: a bound, or a reference.
pub(crate) fn bound(name: &str, points: Vec<(f64, f64)>) -> Series<'_> {
    Series::new(Style::Bound, name, points)
}

/// Samples with their times.
pub(crate) fn timed(values: &[f64], sample_time: f64) -> Vec<(f64, f64)> {
    let values = values.iter().enumerate();
    values.map(|(k, v)| (k as f64 * sample_time, *v)).collect()
}

fn plots<'a>(
    analysis: &'a Analysis,
    record: &Record,
    input_title: &'a str,
    output_title: &'a str,
) -> Result<Vec<Plot<'a>>> {
    let Simulated {
        input,
        measured,
        simulated,
        unknown,
        ..
    } = Simulated::new(analysis, record)?;
    let timed = |values: &[f64]| timed(values, record.sample_time);
    let errors = measured.iter().zip(&simulated).map(|(y, model)| y - model);
    let errors: Vec<f64> = errors.collect();
    let (low, high) = range(measured);
    // A simulation that diverges would flatten what was measured.
    let near = |values: &[f64], (low, high): (f64, f64)| {
        let points = timed(values).into_iter().skip(unknown);
        points
            .filter(|(_, it)| is_near(*it, low, high))
            .collect::<Vec<_>>()
    };
    let spread = high - low;
    let mut plots = vec![
        Plot::new("Measured and simulated output", [TIME, output_title])
            .note("The model is simulated from the input only. Values far outside the measured range are not shown.")
            .linked(RECORD)
            .with(Style::Broad, "measured", timed(measured))
            .line("simulated", near(&simulated, (low, high))),
        Plot::new("Measured less simulated output", [TIME, output_title])
            .note("The part of the output that the model does not explain.")
            .linked(RECORD)
            .line("difference", near(&errors, (-spread, spread))),
        Plot::new("Input", [TIME, input_title])
            .note("Mean over each sampling interval.")
            .linked(RECORD)
            .line("input", timed(input)),
        step(analysis, record, output_title),
    ];
    let rows = analysis.estimate.frequency.as_ref();
    let rows = rows.map(|it| (it.rows(record.sample_time), it.coherence));
    plots.extend(bode(analysis, rows));
    plots.push(map(analysis)?);
    if let Some(tests) = &analysis.residuals {
        plots.push(correlation(
            "Residual autocorrelation",
            "White residuals stay within the bound (99 %).",
            &tests.whiteness,
        ));
        plots.push(correlation(
            "Cross-correlation of residual and input",
            "Outside the bound at positive lags: missing dynamics; at negative lags: feedback.",
            &tests.input,
        ));
    }
    let trajectory = &analysis.trajectory;
    let series = trajectory.names.iter().enumerate().map(|(i, name)| {
        let points = trajectory.points.iter();
        line(name, points.map(|(t, theta)| (*t, theta[i])).collect())
    });
    plots.push(
        Plot::new("Parameter estimates over time", [TIME, "parameter"])
            .note("Estimates of the recursive estimator after each sample.")
            .linked(RECORD)
            .with_all(series),
    );
    Ok(plots)
}

pub(crate) fn correlation(
    title: impl Into<Cow<'static, str>>,
    note: &'static str,
    found: &Correlation,
) -> Plot<'static> {
    let points: Vec<(f64, f64)> = found
        .values
        .iter()
        .map(|(lag, r)| (*lag as f64, *r))
        .collect();
    let within = points
        .iter()
        .map(|(lag, _)| (*lag, -found.bound, found.bound));
    let within: Vec<_> = within.collect();
    Plot::new(title, ["lag [samples]", "correlation"])
        .note(note)
        .linked(LAG)
        .with_all([Series::band("99 %", within)])
        .line("correlation", points)
}

/// The unit circle.
pub(crate) fn unit_circle() -> Series<'static> {
    let angles = (0..=120).map(|i| f64::from(i) * TAU / 120.0);
    bound(
        "unit circle",
        angles.map(|a| (libm::cos(a), libm::sin(a))).collect(),
    )
}

/// Number of samples after which a step response stays within a share of its range about its final value; `None` for an unstable model.
pub(crate) fn settling(estimate: &Estimate, run: usize) -> Option<usize> {
    let reading = Reading::new(estimate, run);
    let poles = reading.poles().ok()?;
    if poles.iter().any(|it| it.value.modulus() > 1.0 + 1e-6) {
        return None;
    }
    let response = reading.step_response(STEP.1);
    let end = *response.last()?;
    let most = response
        .iter()
        .fold(0.0_f64, |most, y| most.max((y - end).abs()));
    let far = response
        .iter()
        .rposition(|y| (y - end).abs() > SETTLED * most.max(end.abs()));
    Some(far.map_or(0, |last| last + 1))
}

/// The model's step response, and the one estimated from the data without a model, each with its band.
/// Half the widest band of the response from the data alone, in ranges of the model's response.
const WIDEST: f64 = 2.0;

pub(crate) fn step<'a>(analysis: &'a Analysis, record: &Record, output_title: &'a str) -> Plot<'a> {
    let estimate = &analysis.estimate;
    let plot = Plot::new("Step response", [SINCE_STEP, output_title]);
    let Some(settled) = settling(estimate, analysis.longest) else {
        return plot.note("The model is unstable: its step response has no final value.");
    };
    let count = (settled + settled / 2).clamp(STEP.0, STEP.1);
    let at = |k: usize| k as f64 * estimate.sample_time;
    let band = |k: usize, value: f64, deviation: f64| {
        let half = SIGMAS_95 * deviation;
        (at(k), value - half, value + half)
    };
    let model = analysis.reading().uncertain_step_response(count);
    let of_model = model.iter().enumerate();
    let plot = plot
        .with_all([Series::band(
            "95 %, model",
            of_model.clone().map(|(k, it)| band(k, it.0, it.1)),
        )])
        .line("model", of_model.map(|(k, it)| (at(k), it.0)));
    let without_model = match analysis.reading().steady_state_gain() {
        None => Err("the model integrates, so its impulse response is not finite".to_owned()),
        Some(_) if analysis.estimate.output_curve.is_some() => Err(
            "the model has a static curve, which an impulse response cannot describe".to_owned(),
        ),
        Some(_) => from_data(analysis, record, count).map_err(|error| error.to_string()),
    };
    // A band wider than the response would flatten everything else.
    let (low, high) = range(&model.iter().map(|it| it.0).collect::<Vec<_>>());
    let is_narrow = |deviation: f64| SIGMAS_95 * deviation <= WIDEST * (high - low);
    let without_model = without_model.and_then(|found| {
        let mut points = found.points;
        let narrow = points.iter().take_while(|it| is_narrow(it.2)).count();
        points.truncate(narrow);
        match points.len() < 3 {
            true => Err(
                "its 95 % interval is more than four times as wide as the response itself"
                    .to_owned(),
            ),
            false => Ok(points),
        }
    });
    match without_model {
        Err(reason) => plot.note(format!(
            "Response to a unit step of the input, from rest, without offset. The response from the data alone is not shown: {reason}."
        )),
        Ok(found) => {
            let points = || found.iter();
            plot.note("Response to a unit step of the input, from rest, without offset. From the data alone, as far as its 95 % interval is at most four times as wide as the response: integral of the least-squares finite impulse response, which feedback in the data would bias.")
                .with_all([Series::band(
                    "95 %, data alone",
                    points().map(|(k, value, deviation)| band(*k, *value, *deviation)),
                )])
                .line("data alone", points().map(|(k, value, _)| (at(*k), *value)))
        }
    }
}

/// The step response without a model, estimated from the segments used for the fit.
fn from_data(analysis: &Analysis, record: &Record, length: usize) -> Result<StepResponse> {
    let record = analysis.of_dynamics(record);
    let segments = analysis.segments.iter();
    let runs = segments.filter_map(|number| record.segments.get(*number)?.run());
    let runs = runs.collect();
    let problem = Problem::new(Structure::of_order(1), record.sample_time, runs)?;
    StepResponse::new(&problem, length)
}

pub(crate) fn map(analysis: &Analysis) -> Result<Plot<'static>> {
    let reading = analysis.reading();
    let (poles, zeros) = (reading.poles()?, reading.zeros()?);
    let at = |found: &[Uncertain]| {
        let found = found.iter().map(|it| (it.value.re, it.value.im));
        found
            .filter(|p| libm::hypot(p.0, p.1) < DRAWN_WITHIN)
            .collect::<Vec<_>>()
    };
    let (artefacts, modes): (Vec<_>, Vec<_>) = poles
        .iter()
        .copied()
        .partition(|it| is_sampling_artefact(it.value));
    // Ellipses as wide as the map would hide everything else.
    let is_shown = |it: &&Uncertain| {
        let deviation = it.magnitude_deviation();
        deviation > 0.0 && deviation < 1.0 && it.value.modulus() < DRAWN_WITHIN
    };
    let regions = |found: &[Uncertain], name: &'static str| {
        let found = found.iter().filter(is_shown).enumerate();
        let region = found.map(|(i, it)| {
            let outline = it.ellipse_95(ELLIPSE).into_iter();
            // Parts of one area: the first has its name.
            let name = if i == 0 { name } else { "" };
            Series::new(Style::Area, name, outline.map(|z| (z.re, z.im)))
        });
        region.collect::<Vec<_>>()
    };
    let regions_of_zeros = regions(&zeros, "95 %, zero");
    Ok(
        Plot::new("Poles and zeros", ["real part", "imaginary part"])
            .note("z plane; points beyond |z| = 4 are not shown.")
            .one_scale()
            .with_all([unit_circle()])
            .with_all(regions(&modes, "95 %, pole"))
            .with(Style::Crosses, "poles", at(&modes))
            .with_all(regions_of_zeros)
            .with(Style::Circles, "zeros", at(&zeros))
            .with_all(
                (!artefacts.is_empty())
                    .then(|| Series::new(Style::Crosses, ARTEFACT, at(&artefacts))),
            ),
    )
}

/// The model's frequency response with its band; with `rows` also the measured response and the smallest coherence that counts.
pub(crate) fn bode(analysis: &Analysis, rows: Option<(Vec<Row>, f64)>) -> Vec<Plot<'static>> {
    let mut responses = frequency_response(&analysis.reading(), analysis.estimate.sample_time);
    let mut reach = "up to half the sampling rate";
    let fitted = analysis.estimate.frequency.as_ref().map(|it| it.band);
    let ends = rows.as_ref().and_then(|(rows, _)| {
        let (first, last) = (rows.first()?, rows.last()?);
        Some((first.omega, last.omega))
    });
    let top = responses.iter().map(|it| it.magnitude(0.0));
    let top = top.fold(f64::NEG_INFINITY, f64::max);
    responses.retain(|it| it.magnitude(0.0) >= top - DEPTH && it.phase >= -TURNS);
    if let Some((low, high)) = fitted.or(ends) {
        responses.retain(|it| (low / BESIDE_BAND..=high * BESIDE_BAND).contains(&it.omega));
        reach = "only near the measured band";
    }
    let banded = |title, axes, of: &dyn Fn(&Response, f64) -> f64| {
        let band = |it: &Response| (it.omega, of(it, -SIGMAS_95), of(it, SIGMAS_95));
        Plot::new(title, axes)
            .log_x()
            .linked(FREQUENCY)
            .with_all([Series::band("95 %", responses.iter().map(band))])
            .line(
                "response",
                responses.iter().map(|it| (it.omega, of(it, 0.0))),
            )
    };
    let phase = |it: &Response, sigmas: f64| {
        it.phase + sigmas * it.value.phase_deviation().min(PI).to_degrees()
    };
    let plots = vec![
        banded("Magnitude", MAGNITUDE, &Response::magnitude)
            .note(format!("Frequency response with its 95 % band, {reach}.")),
        banded("Phase", PHASE, &phase).note("With its 95 % band."),
    ];
    match rows {
        Some((rows, coherence)) => measured(plots, &rows, &responses, coherence),
        None => plots,
    }
}

/// The plots of the model's response together with the measured response, and of the coherence.
pub(crate) fn measured(
    plots: Vec<Plot<'static>>,
    rows: &[Row],
    responses: &[Response],
    least: f64,
) -> Vec<Plot<'static>> {
    // The model's phases begin at the lowest frequency of the plot; those of the rows, at their own.
    let turns = rows.first().zip(rows.first().and_then(|it| it.model));
    let turns = turns.map_or(0.0, |(row, model)| {
        let near = responses.iter().min_by(|p, q| {
            let away = |it: &Response| libm::log(it.omega / row.omega).abs();
            away(p).total_cmp(&away(q))
        });
        near.map_or(0.0, |it| ((it.phase - model.1) / 360.0).round() * 360.0)
    });
    let used: Vec<&Row> = rows.iter().filter(|it| it.is_used).collect();
    let sizes: Vec<(f64, f64)> = (used.iter())
        .map(|it| (it.decibels, it.decibel_deviation))
        .collect();
    let phases = used.iter().map(|it| (it.phase + turns, it.phase_deviation));
    let mut plots: Vec<_> = (plots.into_iter().zip([sizes, phases.collect()]))
        .map(|(plot, values)| {
            let band = used.iter().zip(&values).map(|(it, (value, deviation))| {
                let half = it.sigmas_95 * deviation;
                (it.omega, value - half, value + half)
            });
            let points = used
                .iter()
                .zip(&values)
                .map(|(it, (value, _))| (it.omega, *value));
            plot.with_all([Series::band("95 %, data", band)])
                .with(Style::Dots, "data", points)
        })
        .collect();
    let coherence = rows.iter().map(|it| (it.omega, it.coherence));
    let (low, high) = (rows.first(), rows.last());
    let ends = low
        .zip(high)
        .map(|(low, high)| vec![(low.omega, least), (high.omega, least)]);
    plots.push(
        Plot::new("Coherence", ["frequency [rad/s]", "coherence"])
            .note("The share of the output that follows the input at each frequency; it would be 1 without noise. The measured response is used where the coherence is above the bound.")
            .log_x()
            .linked(FREQUENCY)
            .line("coherence", coherence)
            .with_all(ends.map(|ends| bound("least used", ends))),
    );
    plots
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_identification::analysis::{Options, analyse};
    use planesman_identification::estimators::Method;
    use planesman_testing::content;

    #[test]
    fn a_page_stands_alone_and_says_everything() {
        // A vehicle at 2.1 ft/s, volts to volts: three pulses of its planes.
        let pulse = |k| match k {
            20..40 => 0.2,
            60..80 => -0.2,
            100..120 => 0.1,
            _ => 0.0,
        };
        let planes: Vec<f64> = (0..200).map(pulse).collect();
        let b = [0.0, 0.1214921871, -0.2366258725, 0.1151336854];
        let a = [1.0, -2.828096481, 2.662806429, -0.8346755128];
        let gyro = planesman_identification::filter(&b, &a, &planes);
        let gyro = planesman_identification::with_noise(&gyro, 1, 0.005);
        let gyro = gyro.iter().map(|y| y + 0.025).collect();
        let (inputs, outputs) = (vec![("planes <V>", planes)], vec![("gyro", gyro)]);
        let record = Record::of_run(0.05, inputs, outputs).unwrap();
        for method in [Method::OutputError, Method::Vehicle, Method::Kalman] {
            let options = Options {
                method,
                ..Options::default()
            };
            let analysis = analyse(&record, &options).unwrap();
            let page = page(&analysis, &record, ["planes <V>", "gyro"]).unwrap();
            stands_alone(&page);
            let reason = analysis.reasons[0].to_string();
            assert_eq!(page.matches(&reason).count(), 1, "{method:?}");
            let learnt = if method == Method::OutputError {
                "a1"
            } else {
                "M_theta/J"
            };
            assert!(page.contains(learnt), "{method:?}");
        }
    }

    #[test]
    fn a_measured_response_is_drawn_with_its_coherence_and_the_model() {
        let chirp = |k: u32| libm::sin(0.3 * libm::exp(f64::from(k) * 0.003) / 0.03);
        let u: Vec<f64> = (0..1500).map(chirp).collect();
        let y = planesman_identification::filter(&[0.0, 0.2], &[1.0, -0.9], &u);
        let y = planesman_identification::with_noise(&y, 1, 0.01);
        let record = Record::of_run(0.1, vec![("u", u)], vec![("y", y)]).unwrap();
        let options = Options {
            method: Method::Frf,
            ..Options::default()
        };
        let analysis = analyse(&record, &options).unwrap();
        let page = page(&analysis, &record, ["u", "y"]).unwrap();
        for words in ["Coherence", "95 %, data", "least used", "in s"] {
            assert!(page.contains(words), "{words}");
        }
        assert!(!content(&page).contains("NaN"));
    }

    fn stands_alone(page: &str) {
        for heading in [
            "Measured and simulated",
            "Residual autocorrelation",
            "Cross-correlation of residual and input",
            "Poles and zeros",
            "Magnitude",
            "Phase",
            "Step response",
            "data alone",
            "Parameter estimates over time",
        ] {
            assert!(page.contains(heading), "{heading}");
        }
        assert!(page.contains("planes &lt;V&gt;") && !page.contains("planes <V>"));
        assert!(!content(page).contains("NaN"));
    }
}
