//! Page of one flight, or of several for comparison: conclusions, the vehicle's side view, plots, messages and scenario.

use std::collections::BTreeMap;

use crate::plot::{Plot, Series, Style};
use maud::{Markup, PreEscaped, html};
use planesman_identification::Reading;
use planesman_linear::{Complex, pair_text};
use serde_json::json;

use super::cards::{Card, cards};
use super::{document, figures, figures_with_first, poles, space};
use planesman_console::Table;
use planesman_flight::flight::{Flight, Points};
use planesman_flight::scenario::Scenario;
use planesman_flight::summary::{Summary, distance_text};
use planesman_flight::titles;
use planesman_linear::digits::significant;
use planesman_text::grouped;

/// Number of messages of one topic, published and recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Number of messages the publisher reports; `None` without a report.
    pub published: Option<u64>,
    /// Number of messages in the bag.
    pub recorded: u64,
}

impl Count {
    /// Number of published messages missing in the bag; `None` without a report of the publisher.
    #[must_use]
    pub fn lost(&self) -> Option<u64> {
        Some(self.published?.saturating_sub(self.recorded))
    }
}

/// Total number of published messages, and of those missing in the bag; only for topics whose publisher reports them.
#[must_use]
pub fn published_and_lost(counts: &BTreeMap<String, Count>) -> (u64, u64) {
    let known = counts.values().filter_map(|it| it.published.zip(it.lost()));
    known.fold((0, 0), |sum: (u64, u64), it| {
        (sum.0.saturating_add(it.0), sum.1.saturating_add(it.1))
    })
}

/// A flight with its results.
#[derive(Clone, Debug)]
pub struct FlightReport {
    /// Name of the flight, which is the name of its folder.
    pub name: String,
    /// Contents of the bag.
    pub flight: Flight,
    /// The scenario flown.
    pub scenario: Scenario,
    /// The flight's conclusions.
    pub summary: Summary,
    /// Messages per topic.
    pub counts: BTreeMap<String, Count>,
    /// Whether every publisher reported its number of messages.
    pub is_counted: bool,
}

/// Significant digits of energies.
const DIGITS: usize = 4;

const SIDE_VIEW: &str = include_str!("side_view.js");

/// The HTML page of these flights.
#[must_use]
pub fn page(flights: &[FlightReport]) -> String {
    let heading = match flights {
        [flown] => flown.scenario.description(),
        several => {
            let names: Vec<&str> = several.iter().map(|it| it.name.as_str()).collect();
            names.join(", ")
        }
    };
    let alone = flights.len() == 1;
    let plots = plots(flights);
    let body = html! {
        h1 { (heading) }
        div.(if alone { "verdicts" } else { "verdicts columns" }) {
            @for flown in flights {
                div { @if !alone { h2 { (flown.name) } } (conclusions(flown, alone)) }
            }
        }
        @if let [flown] = flights { (cards(&summary(&flown.summary))) }
        (figures_with_first(&plots[..1]))
        div.columns {
            div { (response_table(flights)) @if by_planes(flights) { (modes_table(flights)) } }
            div {
                @for flown in flights {
                    @if !flown.summary.hovers { (side_view(flown, alone)) }
                    (space::view((!alone).then_some(&flown.name), &flown.flight.time_histories, &flown.scenario))
                }
                (energy_table(flights))
            }
        }
        h2 { "Plots" }
        (figures(&plots[1..]))
        @for flown in flights {
            @if !alone { h2 { (flown.name) } }
            (poles_table(flown))
            (count_table(&flown.counts))
            details { summary { "Scenario" } pre { (flown.scenario.to_yaml()) } }
        }
    };
    let (style, script) = (
        [STYLE, space::STYLE].concat(),
        [SIDE_VIEW, space::SCRIPT].join("\n"),
    );
    document(&format!("Planesman: {heading}"), &style, &body, &script)
}

const STYLE: &str = "
.side svg { width: 100%; max-width: 60rem; height: auto; background: var(--surface); display: block; }
.verdicts h2 { margin-top: 1rem; }
.energy td:last-child { width: 12rem; }
.energy td div { height: .8rem; background: var(--accent); }
.side .controls { display: flex; flex-wrap: wrap; gap: .8rem; align-items: center; max-width: 60rem; margin: .3rem 0; }
.side input { flex: 1; min-width: 8rem; accent-color: var(--accent); }
.side output { font-variant-numeric: tabular-nums; }
";

/// Fields shown on the cards.
const FIRST: [&str; 5] = [
    "settling_time_2",
    "overshoot",
    "steady_error",
    "pole_error",
    "energy_supply",
];

/// Cards with a flight's most important numbers.
fn summary(of: &Summary) -> Vec<Card> {
    let quantities = of.quantities();
    let known = FIRST.iter().filter_map(|field| {
        quantities
            .iter()
            .find(|it| it.field == *field && it.is_known())
    });
    known
        .map(|it| Card::new(titles::name(it.field), it.text()))
        .collect()
}

/// The conclusions, one sentence each.
fn conclusions(flown: &FlightReport, alone: bool) -> Markup {
    html! {
        @if let Some(reason) = &flown.flight.truncated {
            p.warn { (format!("The bag is incomplete: {}; this page shows the messages that the bag contains.", reason.trim_start_matches("incomplete: "))) }
        }
        @for note in &flown.summary.notes {
            p.warn { (note) }
        }
        ul.verdict {
            @for sentence in flown.summary.conclusions() { li { (sentence) } }
            @if alone { @if let Some(lacks) = kept(flown) { li { (lacks) } } }
        }
    }
}

/// A sentence on whether the bag contains every published message. For an incomplete bag, or without the publishers' reports: the number of
/// messages in the bag. `None` for a complete bag without any report.
#[must_use]
pub fn kept(flown: &FlightReport) -> Option<String> {
    let counts = &flown.counts;
    let topics = counts.values().filter(|it| it.recorded > 0).count();
    let all = grouped(counts.values().map(|it| it.recorded).sum());
    let is_whole = flown.flight.truncated.is_none();
    match published_and_lost(counts) {
        (0, _) if is_whole => None,
        (published, lacks) if lacks > 0 => Some(format!(
            "The bag LACKS {} of {} published messages.",
            grouped(lacks),
            grouped(published)
        )),
        _ if is_whole && flown.is_counted => Some(format!(
            "All {all} messages of {topics} topics are in the bag."
        )),
        _ => Some(format!("{all} messages of {topics} topics are in the bag.")),
    }
}

/// Table comparing flights, with a quantity per row; for two flights also the second value minus the first.
#[must_use]
pub fn comparison(flights: &[FlightReport]) -> Table {
    let names = flights.iter().map(|it| it.name.as_str());
    let pair = match flights {
        [first, second] => Some((first, second)),
        _ => None,
    };
    let columns = [""].into_iter().chain(names);
    let mut table = Table::of(columns.chain(pair.map(|_| "difference")));
    let quantities: Vec<_> = flights.iter().map(|it| it.summary.quantities()).collect();
    for row in 0..quantities.first().map_or(0, Vec::len) {
        let values: Vec<_> = quantities.iter().map(|it| &it[row]).collect();
        if !values.iter().any(|it| it.applies) {
            continue;
        }
        let difference = pair.map(|_| values[1].less(values[0]));
        let name = [titles::name(values[0].field)].into_iter();
        let values = values.iter().map(|it| it.text());
        table.row(name.chain(values).chain(difference));
    }
    table
}

/// A sentence that explains the difference column; `None` unless there are two flights.
#[must_use]
pub fn difference_note(flights: &[FlightReport]) -> Option<String> {
    match flights {
        [first, second] => Some(format!("Difference: {} less {}.", second.name, first.name)),
        _ => None,
    }
}

fn response_table(flights: &[FlightReport]) -> Markup {
    html! {
        h2 { "Depth response" }
        (comparison(flights).html())
        @if let Some(note) = difference_note(flights) { p { (note) } }
    }
}

/// Whether at least one vehicle is moved by planes.
fn by_planes(flights: &[FlightReport]) -> bool {
    flights.iter().any(|it| !it.summary.hovers)
}

/// Natural frequency, damping ratio and time constants of the pitch response, identified and true.
fn modes_table(flights: &[FlightReport]) -> Markup {
    html! {
        h2 { "Pitch response to the planes" }
        div.scroll { table.words {
            thead { tr {
                @if flights.len() > 1 { th { "flight" } }
                th { "identified" } th { "true" }
            } }
            @for flown in flights {
                @let truth = flown.summary.truth.modes();
                @match &flown.summary.identified {
                    None => tr {
                        @if flights.len() > 1 { td { (flown.name) } }
                        td { "no valid model: " (flown.summary.no_model) } td { (truth.join("; ")) }
                    },
                    Some(found) => {
                        @let estimate = flown.flight.model.as_ref().and_then(planesman_identifier::estimate_of);
                        @let found = estimate.map_or_else(|| found.modes(), |it| Reading::new(&it, 0).modes());
                        @for i in 0..found.len().max(truth.len()) {
                            tr {
                                @if flights.len() > 1 { td { (flown.name) } }
                                td { (found.get(i).map_or("", String::as_str)) }
                                td { (truth.get(i).map_or("", String::as_str)) }
                            }
                        }
                    }
                }
            }
        } }
    }
}

/// Distribution of the supply's energy, each term with a bar; below that electrical energy and efficiencies.
fn energy_table(flights: &[FlightReport]) -> Markup {
    let known = |flown: &'_ FlightReport| {
        let Summary {
            energy,
            proportional,
            ..
        } = &flown.summary;
        Some((flown.name.clone(), (*energy)?, *proportional))
    };
    let energies: Vec<_> = flights.iter().filter_map(known).collect();
    html! {
        @if !energies.is_empty() { h2 { "Energy of the actuators" } }
        @for (name, energy, proportional) in &energies {
            @if flights.len() > 1 { h3 { (name) } }
            div.scroll { table.energy {
                thead { tr { td {} th { "J" } th { "of the supply" } td {} } }
                @for (term, joule) in energy.terms().iter().filter(|(_, joule)| *joule != 0.0) {
                    @let share = 100.0 * joule / energy.supply;
                    tr {
                        td { (term) } td { (significant(*joule, DIGITS)) } td { (format!("{share:.2} %")) }
                        td { div style=(format!("width:{:.2}%", share.abs().min(100.0))) {} }
                    }
                }
                tr { td { "work of the supply" } td { (significant(energy.supply, DIGITS)) } td { "100 %" } td {} }
            } }
            p { (format!("The sum of the terms equals the work of the supply within a relative error of {:.0e}. The load is the mass and the viscous damping of the actuator's file.", energy.closure().unwrap_or_default())) }
            @if let Some(joule) = proportional {
                p { (format!(
                    "For the same motion an ideal proportional valve would need {} J in the same circuit (load {:.1} %). An ideal 4-way valve, which returns the smaller chamber's oil to the tank and not to the supply, would need {} J.",
                    significant(*joule, DIGITS), 100.0 * energy.load() / joule, significant(energy.proportional_valve, DIGITS)
                )) }
            }
        }
    }
}

fn poles_table(flown: &FlightReport) -> Markup {
    let summary = &flown.summary;
    if summary.identified.is_none() {
        return html! {};
    }
    let truth = &summary.truth;
    let true_poles: Vec<String> = (truth.poles.iter().filter(|it| it.im >= 0.0))
        .map(|it| pair_text(*it, 4))
        .collect();
    let estimate = flown
        .flight
        .model
        .as_ref()
        .and_then(planesman_identifier::estimate_of);
    html! {
        details {
            summary { "Poles and gains of plane angle to pitch rate" }
            @match &estimate {
                Some(estimate) => (poles::table_with_note(&[("", Reading::new(estimate, 0))], |cell| html! { (cell) })),
                None => p { "The model has no covariance: its poles have no intervals." },
            }
            p { "True poles in s [1/s]: " (true_poles.join(", ")) "." }
            div.scroll { table {
                thead { tr { td {} th { "identified" } th { "true" } } }
                @for (name, found, truth) in summary.gains() {
                    tr { td { (name) " [1/s]" } td { (found) } td { (truth) } }
                }
            } }
            @if let Some(error) = summary.pole_error() {
                p { (format!(
                    "The identified dominant pole differs from the true pole by {} of its magnitude ({} samples, one-step fit {:.2} %).",
                    distance_text(error), summary.samples, summary.fit
                )) }
            }
        }
    }
}

fn count_table(counts: &BTreeMap<String, Count>) -> Markup {
    html! {
        details {
            summary { "Messages" }
            div.scroll { table {
                thead { tr { th { "topic" } th { "published" } th { "in the bag" } th { "lost" } } }
                @for (topic, count) in counts {
                    tr {
                        td { (topic) }
                        td { (count.published.map_or_else(|| "–".into(), |p| p.to_string())) }
                        td { (count.recorded) }
                        td { (count.lost().map_or_else(|| "–".into(), |lost| lost.to_string())) }
                    }
                }
            } }
        }
    }
}

/// Size of the picture: width, and the lines of smallest and largest depth, in its own units.
const WIDTH: f64 = 900.0;
const SURFACE: f64 = 30.0;
const BOTTOM: f64 = 230.0;

/// Side view of the vehicle: depth over time, and pitch and planes at one instant, chosen by a slider or by the cursor of the plots.
fn side_view(flown: &FlightReport, alone: bool) -> Markup {
    let drawn = &flown.flight.time_histories;
    let (Some(first), Some(last)) = (drawn.depth.first(), drawn.depth.last()) else {
        return html! {};
    };
    let (from, to) = (first.0, last.0.max(first.0 + 1e-9));
    let all = drawn.depth.iter().chain(&drawn.depth_setpoint);
    let deepest = all.map(|p| p.1).filter(|it| it.is_finite());
    let deepest = 1.2 * deepest.fold(0.1, f64::max).min(1e6);
    let across = |t: f64| 60.0 + (WIDTH - 120.0) * (t - from) / (to - from);
    let down = |depth: f64| SURFACE + (BOTTOM - SURFACE) * depth / deepest;
    let path = |points: &Points| {
        let every = points.len().div_ceil(1000).max(1);
        let points = points.iter().step_by(every).enumerate();
        let step = |(k, (t, depth)): (usize, &(f64, f64))| {
            let letter = if k == 0 { 'M' } else { 'L' };
            format!(
                "{letter}{:.1} {:.1}",
                across(*t),
                down(depth.clamp(-deepest, 2.0 * deepest))
            )
        };
        points.map(step).collect::<String>()
    };
    // What the script needs of each instant.
    const INSTANTS: u32 = 400;
    let instants: Vec<_> = (0..=INSTANTS)
        .map(|k| {
            let t = from + (to - from) * f64::from(k) / f64::from(INSTANTS);
            let depth = space::held(&drawn.depth, t);
            let angle = |points: &Points| (1e2 * space::held(points, t).to_degrees()).round() / 1e2;
            let place = [across(t), down(depth)].map(|it| (10.0 * it).round() / 10.0);
            let round = |it: f64| (1e4 * it).round() / 1e4;
            json!([
                round(t),
                round(depth),
                angle(&drawn.pitch),
                angle(&drawn.planes[0]),
                place[0],
                place[1]
            ])
        })
        .collect();
    html! {
        figure.side {
            h2 { "Side view" @if !alone { ": " (flown.name) } }
            svg viewBox=(format!("0 0 {WIDTH} {}", BOTTOM + 30.0)) role="img" aria-label="the vehicle's depth over time, with its pitch and planes" {
                path d=(format!("M0 {SURFACE}H{WIDTH}")) stroke="var(--accent)" stroke-width="2" {}
                text x="4" y="20" font-size="18" fill="var(--muted)" { "surface" }
                text x="4" y=(BOTTOM + 24.0) font-size="18" fill="var(--muted)" { (format!("{deepest:.2} m")) }
                path d=(path(&drawn.depth_setpoint)) fill="none" stroke="var(--series-2)" stroke-dasharray="6 4" {}
                path d=(path(&drawn.depth)) fill="none" stroke="var(--series-1)" stroke-width="1.5" {}
                // Bow to the right. Planes at a third of the length before and behind the middle.
                g.hull {
                    path d="M-48 0C-48 -9 -36 -10 -30 -10H34C44 -10 50 -5 50 0C50 5 44 10 34 10H-30C-36 10 -48 9 -48 0Z" fill="var(--series-6)" stroke="var(--text)" {}
                    path d="M-46 0L-58 -11H-50L-38 -8M-46 0L-58 11H-50L-38 8" fill="none" stroke="var(--text)" {}
                    g.bow transform="translate(30 0)" { path.plane d="M-9 0H9" stroke="var(--bad)" stroke-width="4" stroke-linecap="round" {} }
                    g.stern transform="translate(-30 0)" { path.plane d="M-9 0H9" stroke="var(--bad)" stroke-width="4" stroke-linecap="round" {} }
                }
            }
            div.controls {
                button type="button" { "Play" }
                input type="range" min="0" max=(INSTANTS) value=(INSTANTS) aria-label="time";
                output {}
            }
            script type="application/json" { (PreEscaped(json!(instants).to_string())) }
        }
    }
}

const TIME: &str = "time [s]";
/// Plots over the flight's time share one x axis.
const LINK: &str = "flight";

/// Style, name and points of a plotted quantity.
type Drawn = (Style, &'static str, fn(&FlightReport) -> Points);

/// The series of a plot for all flights.
fn over(flights: &[FlightReport], plot: Plot<'static>, series: &[Drawn]) -> Plot<'static> {
    let name = |flown: &FlightReport, what: &str| match flights.len() {
        1 => what.to_owned(),
        _ => format!("{what}, {}", flown.name),
    };
    let each = flights.iter().flat_map(|flown| {
        let series = series.iter();
        series.map(move |(style, what, of)| Series::new(*style, name(flown, what), of(flown)))
    });
    let drawn: Vec<_> = each.filter(|it| !it.points.is_empty()).collect();
    plot.with_all(drawn)
}

fn plots(flights: &[FlightReport]) -> Vec<Plot<'static>> {
    let time = |title: &'static str, y: &'static str| Plot::new(title, [TIME, y]);
    let mut plots = vec![
        over(
            flights,
            time("Depth", "depth [m]").y_down().linked(LINK).note("True depth of the vehicle, positive down."),
            &[
                (Style::Line, "depth", |it| it.flight.time_histories.depth.clone()),
                (Style::Dashed, "setpoint", |it| it.flight.time_histories.depth_setpoint.clone()),
            ],
        ),
        over(
            flights,
            time("Pitch", "pitch [deg]").linked(LINK).note("Positive bow up; the command comes from the depth loop."),
            &[
                (Style::Line, "pitch", |it| degrees(&it.flight.time_histories.pitch)),
                (Style::Dashed, "command", |it| degrees(&it.flight.time_histories.pitch_command)),
            ],
        ),
        over(
            flights,
            time("Dive planes", "plane angle [deg]").linked(LINK).note("Positive to dive. The command includes the test signal for identification; the actuator follows it in steps."),
            &[
                (Style::Line, "planes", |it| degrees(&it.flight.time_histories.planes[0])),
                (Style::Dashed, "command", |it| degrees(&it.flight.time_histories.plane_command[0])),
            ],
        ),
        over(
            flights,
            time("Dive planes, close up", "plane angle [deg]").note("The first five seconds show the steps of the actuator."),
            &[
                (Style::Line, "planes", |it| degrees(&it.flight.time_histories.planes[1])),
                (Style::Dashed, "command", |it| degrees(&it.flight.time_histories.plane_command[1])),
            ],
        ),
        pressure(flights),
    ];
    if !by_planes(flights) {
        // Depth alone: what the planes do and cause stands still.
        plots.truncate(1);
    }
    if (flights.iter()).any(|it| space::leaves_the_plane(&it.flight.time_histories)) {
        plots.splice(1..1, out_of_the_plane(flights));
    }
    if flights.iter().any(|it| it.summary.identified.is_some()) {
        plots.push(dominant_pole(flights));
    }
    if by_planes(flights) {
        plots.push(pole_map(flights));
    }
    plots
}

/// Plots of the track from above, heading, roll, speed, rudder and thrusters.
fn out_of_the_plane(flights: &[FlightReport]) -> Vec<Plot<'static>> {
    let time = |title: &'static str, y: &'static str| Plot::new(title, [TIME, y]).linked(LINK);
    let mut plots = vec![
        over(
            flights,
            Plot::new(
                "Track, from above",
                ["to starboard of the initial heading [m]", "along it [m]"],
            )
            .plane()
            .one_scale()
            .note("Position of the body's origin."),
            &[(Style::Line, "track", |it| {
                let instants = space::instants(&it.flight.time_histories);
                instants.iter().map(|[_, x, y, ..]| (*y, *x)).collect()
            })],
        ),
        over(
            flights,
            time("Heading", "heading [deg]")
                .note("From the initial heading, positive to starboard, within ±180 deg."),
            &[
                (Style::Line, "heading", |it| {
                    degrees(&it.flight.time_histories.yaw)
                }),
                (Style::Dashed, "setpoint", |it| {
                    wrapped(&it.flight.time_histories.heading_setpoint)
                }),
            ],
        ),
        over(
            flights,
            time("Roll and rudder", "angle [deg]")
                .note("Roll: positive starboard side down; rudder command: positive to starboard."),
            &[
                (Style::Line, "roll", |it| {
                    degrees(&it.flight.time_histories.roll)
                }),
                (Style::Dashed, "rudder", |it| {
                    degrees(&it.flight.time_histories.rudder)
                }),
            ],
        ),
        over(
            flights,
            time("Speed", "speed [m/s]")
                .note("Forward speed through the water, and the commanded thrust as a share of full thrust."),
            &[
                (Style::Line, "speed", |it| {
                    it.flight.time_histories.speed.clone()
                }),
                (Style::Dashed, "thrust [1]", |it| {
                    it.flight.time_histories.thrust.clone()
                }),
            ],
        ),
    ];
    if let [flown] = flights
        && !flown.flight.time_histories.thrusters.is_empty()
    {
        let each = flown.flight.time_histories.thrusters.iter();
        let lines = each
            .map(|(name, points)| Series::new(Style::Line, name.replace('_', " "), points.clone()));
        plots.push(
            time("Thrusters", "command [1]")
                .note("Thruster commands as shares of full command.")
                .with_all(lines.collect::<Vec<_>>()),
        );
    }
    plots
}

/// Angles in degrees, wrapped to ±180.
fn wrapped(points: &[(f64, f64)]) -> Points {
    use std::f64::consts::{PI, TAU};
    let near = |v: f64| (v + PI).rem_euclid(TAU) - PI;
    points
        .iter()
        .map(|(t, v)| (*t, near(*v).to_degrees()))
        .collect()
}

fn degrees(points: &[(f64, f64)]) -> Points {
    points.iter().map(|(t, v)| (*t, v.to_degrees())).collect()
}

fn pressure(flights: &[FlightReport]) -> Plot<'static> {
    let mut plot = Plot::new("Actuator pressure", [TIME, "pressure [kPa]"]).linked(LINK);
    let mut moves = false;
    for flown in flights {
        for (group, actuator) in &flown.flight.actuators {
            let name = match flights.len() {
                1 => group.replace('_', " "),
                _ => format!("{}, {}", group.replace('_', " "), flown.name),
            };
            moves |= actuator.pressure.iter().any(|(_, it)| *it != 0.0);
            let kilo = |(t, pressure): &(f64, f64)| (*t, pressure * 1e-3);
            plot = plot.line(name, actuator.pressure.iter().map(kilo));
        }
    }
    plot.note(if moves {
        "Differential pressure across each ram at each tick."
    } else {
        "Differential pressure across each ram at each tick; it is always zero."
    })
}

/// Real or imaginary part of the true dominant pole, over the time in which a pole is identified.
fn true_pole(flown: &FlightReport, part: fn(Complex<f64>) -> f64) -> Points {
    let [real, _] = &flown.flight.time_histories.pole;
    let (Some(first), Some(last)) = (real.first(), real.last()) else {
        return Vec::new();
    };
    let pole = flown.summary.truth.dominant();
    pole.map_or_else(Vec::new, |pole| {
        [first.0, last.0].map(|t| (t, part(pole))).to_vec()
    })
}

fn dominant_pole(flights: &[FlightReport]) -> Plot<'static> {
    over(
        flights,
        Plot::new("Dominant pole, online", [TIME, "[1/s]"])
            .linked(LINK)
            .note("The slowest pole of the online estimate, and the true pole."),
        &[
            (Style::Line, "real part", |it| {
                it.flight.time_histories.pole[0].clone()
            }),
            (Style::Line, "imaginary part", |it| {
                it.flight.time_histories.pole[1].clone()
            }),
            (Style::Dashed, "true real part", |it| {
                true_pole(it, |p| p.re)
            }),
            (Style::Dashed, "true imaginary part", |it| {
                true_pole(it, |p| p.im)
            }),
        ],
    )
}

fn pole_map(flights: &[FlightReport]) -> Plot<'static> {
    fn map(poles: &[Complex<f64>]) -> Points {
        poles.iter().map(|p| (p.re, p.im)).collect()
    }
    over(
        flights,
        Plot::new("Pole map", ["real part [1/s]", "imaginary part [1/s]"])
            .note("Continuous-time poles from plane angle to pitch rate.")
            .from_zero()
            .one_scale(),
        &[
            (Style::Crosses, "identified", |it| {
                let found = it.summary.identified.as_ref();
                found.map_or_else(Vec::new, |found| map(&found.poles))
            }),
            (Style::Circles, "true", |it| map(&it.summary.truth.poles)),
        ],
    )
}
