//! The flight on one self-contained HTML page: figures, tables, plots as SVG.

use std::collections::BTreeMap;

use anyhow::Result;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use planesman_linear::Complex;

use crate::flight::Flight;
use crate::plot::{Plot, Series, Style};
use crate::scenario::Scenario;
use crate::summary::{Summary, identified, pole_text};

/// Messages of one topic, as sent and as recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Messages the publisher says it sent, `None` when nobody said.
    pub published: Option<u64>,
    /// Messages in the bag.
    pub recorded: u64,
}

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 54rem; margin: 2rem auto; padding: 0 1rem; color: #1b1f24; background: #fff; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.1rem; margin: 2rem 0 .3rem; }
p.lead { color: #57606a; margin-top: .2rem; }
table { border-collapse: collapse; margin: .5rem 0; } th, td { text-align: right; padding: .2rem .8rem; border-bottom: 1px solid #d8dee4; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
svg { max-width: 100%; height: auto; } p.legend { margin: 0; font-size: 13px; } p.legend span:not(:first-child) { margin-left: 1.2rem; } .warn { background: #fff4e5; border-left: 4px solid #d55e00; padding: .4rem .8rem; }
pre { background: #f6f8fa; padding: .8rem; overflow-x: auto; font-size: 13px; }
";

/// A self-contained page, `own_style` behind the common one.
#[must_use]
pub fn document(title: &str, own_style: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(own_style)) }
            }
            body { (body) }
        }
    }
    .into_string()
}

/// The page's text.
///
/// # Errors
/// When a plot cannot be drawn.
pub fn page(
    flight: &Flight,
    scenario: &Scenario,
    scenario_text: &str,
    summary: &Summary,
    counts: &BTreeMap<String, Count>,
) -> Result<String> {
    let plots = plots(flight, summary)?;
    let body = html! {
        h1 { "Planesman flight" }
        p.lead { (scenario.description) }
        @if let Some(reason) = &flight.truncated {
            p.warn { "The bag is not whole: " (reason) ". What follows is what it holds." }
        }
        (response_table(summary))
        (model_table(summary))
        @for drawn in &plots {
            h2 { (drawn.title) }
            p.lead { (drawn.note) }
            (drawn.legend)
            (PreEscaped(&drawn.svg))
        }
        (count_table(counts))
        h2 { "Scenario" }
        pre { (scenario_text) }
    };
    let title = format!("Planesman: {}", scenario.description);
    Ok(document(&title, "", &body))
}

fn response_table(summary: &Summary) -> Markup {
    let seconds = |v: Option<f64>| v.map_or_else(|| "not reached".into(), |v| format!("{v:.2} s"));
    html! {
        @if let Some(depth) = &summary.depth {
            h2 { "Depth response to " (format!("{:.3}", summary.depth_setpoint)) " m" }
            table {
                tr { th { "rise time (10–90 %)" } td { (seconds(depth.rise_time)) } }
                tr { th { "overshoot" } td { (format!("{:.2} %", depth.overshoot)) } }
                tr { th { "settling time (5 %)" } td { (seconds(depth.settling_time_5)) } }
                tr { th { "steady error" } td { (format!("{:+.4} m", depth.steady_error)) } }
                tr { th { "actuator pulses" } td { (summary.pulses) } }
                tr { th { "ticks without the actuator's answer" } td { (summary.held_ticks) } }
            }
        }
    }
}

fn model_table(summary: &Summary) -> Markup {
    let gain = |g: Option<f64>| g.map_or_else(|| "none".into(), |g| format!("{g:.5}"));
    html! {
        h2 { "Plane angle to pitch rate: identified and true" }
        @match &summary.identified {
            None => p.warn { "No valid model: " (summary.no_model) },
            Some(found) => {
                table {
                    tr { th { "" } th { "identified" } th { "true" } }
                    @for i in 0..found.poles.len().max(summary.truth.poles.len()) {
                        tr {
                            td { "pole " (i + 1) " [1/s]" }
                            td { (cell(&found.poles, i)) }
                            td { (cell(&summary.truth.poles, i)) }
                        }
                    }
                    tr { td { "gain over one sample [1/s]" } td { (format!("{:.5}", found.first_response)) } td { (format!("{:.5}", summary.truth.first_response)) } }
                    tr { td { "gain at rest [1/s]" } td { (gain(found.dc_gain)) } td { (gain(summary.truth.dc_gain)) } }
                }
                @if let Some(error) = summary.pole_error() {
                    p { "The dominant pole lies " (format!("{:.1} %", 100.0 * error)) " of its magnitude from the true one ("
                        (summary.samples) " samples, one-step fit " (format!("{:.2}", summary.fit)) " %)." }
                }
            }
        }
    }
}

fn cell(poles: &[Complex<f64>], i: usize) -> String {
    poles.get(i).map_or_else(String::new, |p| pole_text(*p))
}

fn count_table(counts: &BTreeMap<String, Count>) -> Markup {
    html! {
        h2 { "Messages" }
        table {
            tr { th { "topic" } th { "published" } th { "in the bag" } th { "lost" } }
            @for (topic, count) in counts {
                tr {
                    td { (topic) }
                    td { (count.published.map_or_else(|| "–".into(), |p| p.to_string())) }
                    td { (count.recorded) }
                    td { (count.published.map_or_else(|| "–".into(), |p| p.saturating_sub(count.recorded).to_string())) }
                }
            }
        }
    }
}

/// A plot with what is written around it.
struct Drawn {
    title: &'static str,
    note: &'static str,
    legend: Markup,
    svg: String,
}

/// The series' names with how they are drawn; nothing for a single one.
pub(crate) fn legend(plot: &Plot<'_>) -> Markup {
    html! {
        @if plot.series.len() > 1 {
            p.legend {
                @for (name, colour, style) in plot.legend() {
                    span style=(format!("color:{colour}")) {
                        @match style {
                            Style::Line => "━━",
                            Style::Dashed => "╌╌",
                            Style::Crosses => "×",
                            Style::Circles => "○",
                            Style::Dots => "·",
                        }
                    }
                    " " (name)
                }
            }
        }
    }
}

fn plots(flight: &Flight, summary: &Summary) -> Result<Vec<Drawn>> {
    let degrees = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points
            .into_iter()
            .map(|(t, v)| (t, v.to_degrees()))
            .collect()
    };
    let control = |f: fn(&planesman_msgs::planesman_msgs::msg::ControlState) -> f64| {
        flight
            .controls
            .iter()
            .map(|c| (flight.seconds(&c.header.stamp), f(c)))
            .collect::<Vec<_>>()
    };
    let line = |name, points| Series {
        name,
        points,
        style: Style::Line,
    };
    let dashed = |name, points| Series {
        name,
        points,
        style: Style::Dashed,
    };
    let mut drawn = Vec::new();
    let mut add = |note: &'static str, plot: Plot<'static>| -> Result<()> {
        if plot.series.iter().any(|s| !s.points.is_empty()) {
            drawn.push(Drawn {
                title: plot.title,
                note,
                legend: legend(&plot),
                svg: plot.svg()?,
            });
        }
        Ok(())
    };
    add(
        "The vehicle's true depth, positive down.",
        Plot {
            title: "Depth",
            x: "time [s]",
            y: "depth [m]",
            y_down: true,
            x_shows: &[],
            series: vec![
                line("depth", flight.depth()),
                dashed("setpoint", control(|c| c.depth_setpoint)),
            ],
        },
    )?;
    add(
        "Positive bow up; the command is what the depth loop asks of the pitch loop.",
        Plot {
            title: "Pitch",
            x: "time [s]",
            y: "pitch [deg]",
            y_down: false,
            x_shows: &[],
            series: vec![
                line(
                    "pitch",
                    degrees(
                        flight
                            .states
                            .iter()
                            .map(|s| (flight.seconds(&s.header.stamp), s.pitch))
                            .collect(),
                    ),
                ),
                dashed("command", degrees(control(|c| c.pitch_command))),
            ],
        },
    )?;
    let commanded = degrees(control(|c| c.dive_planes));
    let moved = degrees(flight.plane_angle());
    add(
        "Positive dive. The command includes the identification signal; the actuator follows in quanta.",
        Plot {
            title: "Dive planes",
            x: "time [s]",
            y: "plane angle [deg]",
            y_down: false,
            x_shows: &[],
            series: vec![
                line("planes", moved.clone()),
                dashed("command", commanded.clone()),
            ],
        },
    )?;
    let window = |points: &[(f64, f64)]| {
        points
            .iter()
            .copied()
            .filter(|p| p.0 <= 5.0)
            .collect::<Vec<_>>()
    };
    add(
        "The first five seconds: the ram moves one calibrated volume at a time.",
        Plot {
            title: "Dive planes, close up",
            x: "time [s]",
            y: "plane angle [deg]",
            y_down: false,
            x_shows: &[],
            series: vec![
                line("planes", window(&moved)),
                dashed("command", window(&commanded)),
            ],
        },
    )?;
    add(
        "Differential pressure across the ram at each tick.",
        Plot {
            title: "Actuator pressure",
            x: "time [s]",
            y: "pressure [kPa]",
            y_down: false,
            x_shows: &[],
            series: vec![line(
                "pressure",
                flight
                    .actuator
                    .iter()
                    .map(|a| (flight.seconds(&a.header.stamp), a.pressure * 1e-3))
                    .collect(),
            )],
        },
    )?;
    let history = |part: fn(Complex<f64>) -> f64| -> Vec<(f64, f64)> {
        flight
            .models
            .iter()
            .filter(|m| m.valid)
            .filter_map(|m| {
                identified(m)
                    .dominant()
                    .map(|p| (flight.seconds(&m.header.stamp), part(p)))
            })
            .collect()
    };
    let level = |points: &[(f64, f64)], value: Option<f64>| -> Vec<(f64, f64)> {
        match (points.first(), points.last(), value) {
            (Some(a), Some(b), Some(v)) => vec![(a.0, v), (b.0, v)],
            _ => Vec::new(),
        }
    };
    let (re, im) = (history(|p| p.re), history(|p| p.im));
    let truth = summary.truth.dominant();
    let (true_re, true_im) = (
        level(&re, truth.map(|p| p.re)),
        level(&im, truth.map(|p| p.im)),
    );
    add(
        "The identifier's slowest pole as the samples come in, beside the vehicle's own.",
        Plot {
            title: "Dominant pole, online",
            x: "time [s]",
            y: "[1/s]",
            y_down: false,
            x_shows: &[],
            series: vec![
                line("real part", re),
                line("imaginary part", im),
                dashed("true real part", true_re),
                dashed("true imaginary part", true_im),
            ],
        },
    )?;
    let map = |poles: &[Complex<f64>]| poles.iter().map(|p| (p.re, p.im)).collect::<Vec<_>>();
    add(
        "Continuous poles of plane angle to pitch rate.",
        Plot {
            title: "Pole map",
            x: "real part [1/s]",
            y: "imaginary part [1/s]",
            y_down: false,
            x_shows: &[0.0],
            series: vec![
                Series {
                    name: "identified",
                    points: summary
                        .identified
                        .as_ref()
                        .map_or_else(Vec::new, |f| map(&f.poles)),
                    style: Style::Crosses,
                },
                Series {
                    name: "true",
                    points: map(&summary.truth.poles),
                    style: Style::Circles,
                },
            ],
        },
    )?;
    Ok(drawn)
}
