//! A model on one self-contained HTML page: data, comparison, residual tests, poles and zeros with their
//! uncertainty, frequency response with bands, and the parameter estimates over time.

use std::f64::consts::{PI, TAU};

use anyhow::Result;
use maud::{Markup, html};
use planesman_identification::analysis::Analysis;
use planesman_identification::validation::residuals::Correlation;
use planesman_identification::{Reading, Record, SIGMAS_95, Uncertain};
use planesman_plot::{Plot, Series, Style};

use super::simulated::Simulated;
use crate::page::{self, document};

/// Largest number of points drawn of a line.
const POINTS: usize = 2000;
/// Frequencies drawn.
const FREQUENCIES: usize = 200;

/// The axis of a frequency response.
pub(super) const LOG_OMEGA: &str = "log10 of the frequency [rad/s]";

/// The page of a model and the record it is of.
///
/// # Errors
/// When a plot cannot be drawn.
pub(super) fn page(analysis: &Analysis, record: &Record) -> Result<String> {
    let title = format!("{} to {}", analysis.input, analysis.output);
    let plots = plots(analysis, record)?;
    let body = html! {
        h1 { (title) }
        ul { @for sentence in &analysis.verdict { li { (sentence) } } }
        pre { (analysis.findings()) }
        @for plot in plots { (plot) }
    };
    Ok(document(&title, "", &body))
}

pub(super) fn line(name: &str, points: Vec<(f64, f64)>) -> Series<'_> {
    Series {
        name: name.into(),
        points: thinned(points),
        style: Style::Line,
    }
}

pub(super) fn dashed(name: &str, points: Vec<(f64, f64)>) -> Series<'_> {
    Series {
        name: name.into(),
        points: thinned(points),
        style: Style::Dashed,
    }
}

/// A line that takes no colour of its own: a bound, or what others are compared with.
pub(super) fn bound(name: &str, points: Vec<(f64, f64)>) -> Series<'_> {
    Series {
        style: Style::Bound,
        ..line(name, points)
    }
}

/// Every so many points, the last included.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let stride = points.len().div_ceil(POINTS).max(1);
    let last = points.len().saturating_sub(1);
    points
        .into_iter()
        .enumerate()
        .filter(|(i, _)| i % stride == 0 || *i == last)
        .map(|(_, point)| point)
        .collect()
}

pub(super) fn drawn(note: &str, mut plot: Plot<'_>) -> Result<Markup> {
    if plot.is_empty() {
        return Ok(html! {});
    }
    plot.note = note.to_owned().into();
    Ok(html! {
        h2 { (plot.title) }
        (page::drawn(&plot)?)
    })
}

pub(super) fn plot<'a>(
    title: &'a str,
    x: &'a str,
    y: &'a str,
    series: Vec<Series<'a>>,
) -> Plot<'a> {
    let mut plot = Plot::new(title, [x, y]);
    plot.series = series;
    plot
}

fn plots(analysis: &Analysis, record: &Record) -> Result<Vec<Markup>> {
    let Simulated {
        input,
        measured,
        simulated,
        ..
    } = Simulated::of(analysis, record)?;
    let timed = |values: &[f64]| -> Vec<(f64, f64)> {
        values
            .iter()
            .enumerate()
            .map(|(k, v)| (k as f64 * record.sample_time, *v))
            .collect()
    };
    let mut drawings = vec![
        drawn(
            "Input over each sampling interval.",
            plot(
                "Input",
                "time [s]",
                &analysis.input,
                vec![line("input", timed(input))],
            ),
        )?,
        drawn(
            "The model is simulated on the input alone.",
            plot(
                "Measured and simulated output",
                "time [s]",
                &analysis.output,
                vec![
                    line("measured", timed(measured)),
                    line("simulated", timed(&simulated)),
                ],
            ),
        )?,
    ];
    if let Some(tests) = &analysis.residuals {
        drawings.push(correlation(
            "Residual with itself",
            "White when within the bound (99 %).",
            &tests.whiteness,
        )?);
        drawings.push(correlation(
            "Residual with the input",
            "Outside the bound at positive lags: missing dynamics; at negative lags: feedback.",
            &tests.input,
        )?);
    }
    drawings.push(map(analysis)?);
    drawings.extend(bode(analysis)?);
    let trajectory = &analysis.trajectory;
    let series = trajectory
        .names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            line(
                name,
                trajectory
                    .points
                    .iter()
                    .map(|(t, theta)| (*t, theta[i]))
                    .collect(),
            )
        })
        .collect();
    drawings.push(drawn(
        "The recursive form of the estimator, sample by sample.",
        plot(
            "Parameter estimates over time",
            "time [s]",
            "parameter",
            series,
        ),
    )?);
    Ok(drawings)
}

fn correlation(title: &str, note: &str, found: &Correlation) -> Result<Markup> {
    let points: Vec<(f64, f64)> = found
        .values
        .iter()
        .map(|(lag, r)| (*lag as f64, *r))
        .collect();
    let level = |r: f64| points.iter().map(|(lag, _)| (*lag, r)).collect::<Vec<_>>();
    let series = vec![
        Series {
            name: "correlation".into(),
            points: points.clone(),
            style: Style::Crosses,
        },
        dashed("99 %", level(found.bound)),
        dashed("-99 %", level(-found.bound)),
    ];
    drawn(note, plot(title, "lag [samples]", "correlation", series))
}

/// The border of stability in z.
pub(super) fn unit_circle() -> Series<'static> {
    let angles = (0..=120).map(|i| f64::from(i) * TAU / 120.0);
    dashed("unit circle", angles.map(|a| (a.cos(), a.sin())).collect())
}

fn map(analysis: &Analysis) -> Result<Markup> {
    let reading = analysis.reading();
    let poles = reading.poles()?;
    let zeros = reading.zeros()?;
    let at = |found: &[Uncertain]| {
        found
            .iter()
            .map(|it| (it.value.re, it.value.im))
            .collect::<Vec<_>>()
    };
    // Ellipses as wide as the map would hide everything else.
    let outlines = poles
        .iter()
        .chain(&zeros)
        .filter(|it| it.magnitude_deviation() > 0.0 && it.magnitude_deviation() < 1.0)
        .flat_map(|it| it.ellipse_95(60))
        .map(|z| (z.re, z.im))
        .collect();
    let near = |points: Vec<(f64, f64)>| {
        points
            .into_iter()
            .filter(|p| p.0.hypot(p.1) < 4.0)
            .collect::<Vec<_>>()
    };
    let series = vec![
        Series {
            name: "poles".into(),
            points: near(at(&poles)),
            style: Style::Crosses,
        },
        Series {
            name: "zeros".into(),
            points: near(at(&zeros)),
            style: Style::Circles,
        },
        Series {
            name: "95 % regions".into(),
            points: outlines,
            style: Style::Dots,
        },
        unit_circle(),
    ];
    drawn(
        "In the z plane; points beyond |z| = 4 are not shown.",
        plot("Poles and zeros", "real part", "imaginary part", series).one_scale(),
    )
}

/// A frequency response at one frequency.
pub(super) struct Response {
    /// The logarithm to base 10 of the frequency, rad/s.
    pub(super) log_omega: f64,
    /// Output unit per input unit.
    pub(super) value: Uncertain,
    /// Its phase, unwrapped from the lowest frequency on, degrees.
    pub(super) phase: f64,
}

impl Response {
    /// The magnitude, so many standard deviations up, dB.
    pub(super) fn magnitude(&self, sigmas: f64) -> f64 {
        let size = self.value.value.norm();
        let size = (size + sigmas * self.value.magnitude_deviation()).max(1e-3 * size);
        20.0 * size.max(1e-12).log10()
    }
}

/// The response at frequencies from 1/3000 of the Nyquist frequency up to it; those where it is 0 or has no bound left
/// out.
pub(super) fn frequency_response(reading: &Reading<'_>, sample_time: f64) -> Vec<Response> {
    let nyquist = PI / sample_time;
    let mut turned: f64 = 0.0;
    let mut before: Option<f64> = None;
    (0..FREQUENCIES)
        .map(|i| nyquist * 10f64.powf(-3.5 * (1.0 - i as f64 / (FREQUENCIES - 1) as f64)))
        .filter_map(|omega| Some((omega.log10(), reading.response(omega)?)))
        .filter(|(_, it)| it.value.norm() > 0.0)
        .map(|(log_omega, value)| {
            let phase = value.value.arg();
            if let Some(before) = before {
                turned -= ((phase - before) / TAU).round() * TAU;
            }
            before = Some(phase);
            Response {
                log_omega,
                value,
                phase: (phase + turned).to_degrees(),
            }
        })
        .collect()
}

fn bode(analysis: &Analysis) -> Result<Vec<Markup>> {
    let responses = frequency_response(&analysis.reading(), analysis.estimate.sample_time);
    let size = |sigmas: f64| {
        let of = |it: &Response| (it.log_omega, it.magnitude(sigmas));
        responses.iter().map(of).collect::<Vec<_>>()
    };
    let phase = |sigmas: f64| {
        let off = |it: &Response| sigmas * it.value.phase_deviation().min(PI).to_degrees();
        let of = |it: &Response| (it.log_omega, it.phase + off(it));
        responses.iter().map(of).collect::<Vec<_>>()
    };
    let banded = |of: &dyn Fn(f64) -> Vec<(f64, f64)>| {
        vec![
            line("response", of(0.0)),
            dashed("95 %", of(SIGMAS_95)),
            dashed("-95 %", of(-SIGMAS_95)),
        ]
    };
    Ok(vec![
        drawn(
            "With the 95 % band at each frequency.",
            plot("Magnitude", LOG_OMEGA, "magnitude [dB]", banded(&size)),
        )?,
        drawn(
            "The same for the phase.",
            plot("Phase", LOG_OMEGA, "phase [deg]", banded(&phase)),
        )?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use brunner_1988::identification::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME};
    use planesman_identification::analysis::{Options, analyse};
    use planesman_identification::estimators::Method;

    #[test]
    fn a_page_stands_alone_and_says_everything() {
        let run = Run::EightOne;
        let inputs = vec![("planes <V>", run.planes())];
        let outputs = vec![("gyro", run.measured(1, NOISE, BIAS))];
        let record = Record::of_run(SAMPLE_TIME, inputs, outputs).unwrap();
        for method in [Method::OutputError, Method::Vehicle, Method::Kalman] {
            let options = Options {
                method,
                ..Options::default()
            };
            let analysis = analyse(&record, &options).unwrap();
            let page = page(&analysis, &record).unwrap();
            stands_alone(&page);
            assert_eq!(page.matches(&analysis.verdict[0]).count(), 1, "{method:?}");
            let learnt = if method == Method::OutputError {
                "a1"
            } else {
                "M_theta/J"
            };
            assert!(page.contains(learnt), "{method:?}");
        }
    }

    fn stands_alone(page: &str) {
        for heading in [
            "Measured and simulated",
            "Residual with itself",
            "Residual with the input",
            "Poles and zeros",
            "Magnitude",
            "Phase",
            "Parameter estimates over time",
        ] {
            assert!(page.contains(heading), "{heading}");
        }
        assert!(page.contains("planes &lt;V&gt;") && !page.contains("planes <V>"));
        assert!(!page.contains("<script") && !page.contains("<link") && !page.contains("src="));
        assert!(!page.contains("NaN"));
    }
}
