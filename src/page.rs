//! The flight on one self-contained HTML page: figures, tables, plots as SVG.

use std::borrow::Cow;
use std::collections::BTreeMap;

use anyhow::Result;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use planesman_linear::{Complex, pole_text};
use planesman_text::shown;

use crate::flight::{Flight, Points};
use crate::scenario::Scenario;
use crate::summary::{Summary, distance_text};
use planesman_plot::{Plot, Style};

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

/// A self-contained page, `own_style` behind the common one. Texts of others in it are [`shown`].
#[must_use]
pub fn document(title: &str, own_style: &str, body: &Markup) -> String {
    let page = html! {
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
    .into_string();
    // The page itself has no carriage returns; a file from elsewhere may.
    shown(page.replace('\r', "")).to_string()
}

/// The page's text.
#[must_use]
pub fn page(
    flight: &Flight,
    scenario: &Scenario,
    summary: &Summary,
    counts: &BTreeMap<String, Count>,
) -> String {
    let plots = plots(flight, summary);
    let body = html! {
        h1 { "Planesman flight" }
        p.lead { (scenario.description) }
        @if let Some(reason) = &flight.truncated {
            p.warn { "The bag is not whole: " (reason) ". What follows is what it holds." }
        }
        @for note in &summary.notes {
            p.warn { (note) }
        }
        (response_table(summary))
        (model_table(summary))
        @for (title, plot) in &plots {
            h2 { (title) }
            (plot)
        }
        (count_table(counts))
        h2 { "Scenario" }
        pre { (scenario.source()) }
    };
    let title = format!("Planesman: {}", scenario.description);
    document(&title, "", &body)
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
                    p { "The dominant pole lies " (distance_text(error)) " of its magnitude from the true one ("
                        (summary.samples) " samples, one-step fit " (format!("{:.2}", summary.fit)) " %)." }
                }
            }
        }
    }
}

fn cell(poles: &[Complex<f64>], i: usize) -> String {
    poles.get(i).map_or_else(String::new, |p| pole_text(*p, 4))
}

fn count_table(counts: &BTreeMap<String, Count>) -> Markup {
    let lost = |count: &Count| Some(count.published?.saturating_sub(count.recorded));
    let lacks = counts
        .values()
        .filter_map(lost)
        .fold(0, u64::saturating_add);
    html! {
        h2 { "Messages" }
        @if lacks > 0 {
            p.warn { "The bag lacks " (lacks) " messages that were published." }
        }
        table {
            tr { th { "topic" } th { "published" } th { "in the bag" } th { "lost" } }
            @for (topic, count) in counts {
                tr {
                    td { (topic) }
                    td { (count.published.map_or_else(|| "–".into(), |p| p.to_string())) }
                    td { (count.recorded) }
                    td { (lost(count).map_or_else(|| "–".into(), |lost| lost.to_string())) }
                }
            }
        }
    }
}

/// A plot with its note and legend, under a heading that is not part of it.
///
/// # Errors
/// When it cannot be drawn.
pub(crate) fn drawn(plot: &Plot<'_>) -> Result<Markup> {
    let svg = plot.svg()?;
    Ok(html! {
        p.lead { (plot.note) }
        (legend(plot))
        (PreEscaped(svg))
    })
}

/// The series' names with how they are drawn; nothing for a single one.
fn legend(plot: &Plot<'_>) -> Markup {
    html! {
        @if plot.series.len() > 1 {
            p.legend {
                @for (name, colour, style) in plot.legend() {
                    span style=(format!("color:{colour}")) {
                        @match style {
                            Style::Line => "━━",
                            Style::Dashed | Style::Bound => "╌╌",
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

/// Headings and plots; what there is nothing of is left out. Of one that cannot be drawn, as with numbers beyond all sense,
/// it is said why: the rest of the page stands.
fn plots(flight: &Flight, summary: &Summary) -> Vec<(Cow<'static, str>, Markup)> {
    let plots = [
        depth(flight),
        pitch(flight),
        planes(flight),
        planes_close_up(flight),
        pressure(flight),
        dominant_pole(flight, summary),
        pole_map(summary),
    ];
    let shown = plots.into_iter().filter(|plot| !plot.is_empty());
    let shown = shown.map(|plot| {
        let drawn = drawn(&plot).unwrap_or_else(|error| html! { p.warn { (error) } });
        (plot.title, drawn)
    });
    shown.collect()
}

const TIME: &str = "time [s]";

fn degrees(points: &[(f64, f64)]) -> Points {
    points.iter().map(|(t, v)| (*t, v.to_degrees())).collect()
}

fn depth(flight: &Flight) -> Plot<'static> {
    Plot::new("Depth", [TIME, "depth [m]"])
        .note("The vehicle's true depth, positive down.")
        .y_down()
        .line("depth", flight.courses.depth.clone())
        .dashed("setpoint", flight.courses.depth_setpoint.clone())
}

fn pitch(flight: &Flight) -> Plot<'static> {
    Plot::new("Pitch", [TIME, "pitch [deg]"])
        .note("Positive bow up; the command is what the depth loop asks of the pitch loop.")
        .line("pitch", degrees(&flight.courses.pitch))
        .dashed("command", degrees(&flight.courses.pitch_command))
}

fn planes(flight: &Flight) -> Plot<'static> {
    let [planes, _] = &flight.courses.planes;
    let [command, _] = &flight.courses.plane_command;
    planes_plot("Dive planes", planes, command).note(
        "Positive dive. The command includes the identification signal; the actuator follows in quanta.",
    )
}

fn planes_close_up(flight: &Flight) -> Plot<'static> {
    let [_, planes] = &flight.courses.planes;
    let [_, command] = &flight.courses.plane_command;
    planes_plot("Dive planes, close up", planes, command)
        .note("The first five seconds: the ram moves one calibrated volume at a time.")
}

fn planes_plot(
    title: &'static str,
    planes: &[(f64, f64)],
    command: &[(f64, f64)],
) -> Plot<'static> {
    Plot::new(title, [TIME, "plane angle [deg]"])
        .line("planes", degrees(planes))
        .dashed("command", degrees(command))
}

fn pressure(flight: &Flight) -> Plot<'static> {
    let plot = Plot::new("Actuator pressure", [TIME, "pressure [kPa]"])
        .note("Differential pressure across each ram at each tick.");
    let each = flight.actuators.iter();
    each.fold(plot, |plot, (group, actuator)| {
        let kilo = |(t, pressure): &(f64, f64)| (*t, pressure * 1e-3);
        plot.line(group.replace('_', " "), actuator.pressure.iter().map(kilo))
    })
}

fn dominant_pole(flight: &Flight, summary: &Summary) -> Plot<'static> {
    let [real, imaginary] = &flight.courses.pole;
    let truth = |part: fn(Complex<f64>) -> f64| -> Points {
        let (Some(first), Some(last)) = (real.first(), real.last()) else {
            return Vec::new();
        };
        let pole = summary.truth.dominant();
        pole.map_or_else(Vec::new, |pole| {
            [first.0, last.0].map(|t| (t, part(pole))).to_vec()
        })
    };
    Plot::new("Dominant pole, online", [TIME, "[1/s]"])
        .note("The identifier's slowest pole as the samples come in, beside the vehicle's own.")
        .line("real part", real.clone())
        .line("imaginary part", imaginary.clone())
        .dashed("true real part", truth(|p| p.re))
        .dashed("true imaginary part", truth(|p| p.im))
}

fn pole_map(summary: &Summary) -> Plot<'static> {
    let map = |poles: &[Complex<f64>]| -> Points { poles.iter().map(|p| (p.re, p.im)).collect() };
    let found = summary.identified.as_ref();
    Plot::new("Pole map", ["real part [1/s]", "imaginary part [1/s]"])
        .note("Continuous poles of plane angle to pitch rate.")
        .from_zero()
        .with(
            Style::Crosses,
            "identified",
            found.map_or_else(Vec::new, |f| map(&f.poles)),
        )
        .with(Style::Circles, "true", map(&summary.truth.poles))
}
