//! Page of a sweep: a heat map over the first two parameters, and the trade-off between settling time and plane travel.

use std::collections::BTreeMap;

use crate::plot::{HeatMap, Plot, Style};
use maud::{Markup, html};
use planesman_flight::scenario::{Scenario, plain};
use planesman_flight::summary::TestSignal;
use planesman_flight::sweep::case::{COLUMNS, SETTLING, TRAVEL};
use planesman_flight::sweep::outcomes::{Combination, Mean, Outcomes, Settled};
use planesman_flight::sweep::space::{Axis, Space};
use planesman_linear::digits::significant;
use planesman_text::number;

use super::cards::{Card, cards};
use super::{document, figure, heat_map};
use planesman_flight::titles::title;

/// Digits of settling times and plane travel.
const DIGITS: usize = 4;

/// Maximum number of plotted points that are not on the Pareto front; of more points every n-th is plotted.
const DRAWN: usize = 4000;

/// Maximum number of listed combinations of the Pareto front.
const LISTED: usize = 30;

/// The HTML page of a scenario's cases; `signal`: the test signal they were flown with.
#[must_use]
pub fn page(
    scenario: &Scenario,
    signal: Option<&TestSignal>,
    space: &Space,
    outcomes: &Outcomes,
) -> String {
    let found = &outcomes.combinations;
    let all = space.combinations() * u64::from(space.seeds);
    let body = html! {
        h1 { "Planesman sweep" }
        p.lead { (scenario.description()) }
        (cards(&summary(space, outcomes)))
        @if let Some(signal) = signal {
            p { (format!("All flights have a test signal, {signal}; {}.", signal.effect())) }
        }
        p { (outcomes.cases) " of " (all) " cases"
            @if outcomes.failed > 0 { "; " (outcomes.failed) " broke off" }
            ". Each mean is taken over the seeds and over all varied parameters that are not an axis of the plot; a case that does not settle has no settling time. \
             The best field has the smallest mean among the fields in which every case settles." }
        h2 { "Plots" }
        div.plots { @for plot in maps(space, found) { (plot) } }
        (pareto(space, outcomes))
        details { summary { "Scenario" } pre { (scenario.to_yaml()) } }
    };
    document("Planesman sweep", "", &body, "")
}

/// The fastest combination, the combination with the least plane travel, and the number that settle.
fn summary(space: &Space, outcomes: &Outcomes) -> Vec<Card> {
    let settled = outcomes.settled();
    let values = |of: &Settled| {
        let each = (space.axes.iter().zip(space.places(of.combination)))
            .map(|(axis, place)| format!("{} {}", axis.label(), labels(axis)[place]));
        each.collect::<Vec<_>>().join(", ")
    };
    let least = |of: fn(&Settled) -> f64| {
        settled
            .iter()
            .min_by(|one, other| of(one).total_cmp(&of(other)))
    };
    let card = |label: &str, found: Option<&Settled>, unit: &str, of: fn(&Settled) -> f64| {
        let found = found?;
        let value = format!("{} {unit}", significant(of(found), DIGITS));
        Some(Card::new(label, value).note(values(found)))
    };
    let count = format!("{} of {}", settled.len(), outcomes.combinations.len());
    [
        card(
            "fastest, settling time (5 %)",
            least(|it| it.settling),
            "s",
            |it| it.settling,
        ),
        card("least plane travel", least(|it| it.travel), "rad", |it| {
            it.travel
        }),
        Some(Card::new("settle in every flight", count)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn labels(axis: &Axis) -> Vec<String> {
    match axis.numbers() {
        Some(numbers) => numbers.into_iter().map(number).collect(),
        None => axis.values.iter().map(plain).collect(),
    }
}

/// Settling time and plane travel over the first two parameters of the grid, or over the only one.
fn maps(space: &Space, found: &BTreeMap<u64, Combination>) -> Vec<Markup> {
    let grid: Vec<usize> = (0..space.axes.len())
        .filter(|place| !space.axes[*place].is_sampled && space.axes[*place].values.len() > 1)
        .collect();
    let of = |what: usize, mean: fn(&Combination) -> Mean| match grid[..] {
        [] => None,
        [x] => {
            let mut means = vec![Mean::default(); space.axes[x].values.len()];
            for (combination, it) in found {
                means[space.places(*combination)[x]].take(mean(it).value());
            }
            let numbers = space.axes[x].numbers()?;
            let points = numbers.into_iter().zip(means);
            let points = points.filter_map(|(at, mean)| Some((at, mean.value()?)));
            let axis = space.axes[x].label();
            let quantity = title(COLUMNS[what]);
            let plot = Plot::new(&quantity, [&axis, &quantity]).line("mean", points);
            Some(figure(&plot))
        }
        [x, y, ..] => {
            let (of_x, of_y) = (&space.axes[x], &space.axes[y]);
            let mut means = vec![vec![Mean::default(); of_x.values.len()]; of_y.values.len()];
            let mut unsettled = vec![vec![0; of_x.values.len()]; of_y.values.len()];
            for (combination, it) in found {
                let places = space.places(*combination);
                let (row, column) = (places[y], places[x]);
                means[row][column].take(mean(it).value());
                unsettled[row][column] += it.cases - it.settling.count;
            }
            let fields = (0..of_y.values.len())
                .flat_map(|row| (0..of_x.values.len()).map(move |column| [row, column]));
            let settled = fields.filter(|[row, column]| unsettled[*row][*column] == 0);
            let best = settled
                .filter_map(|at| Some((means[at[0]][at[1]].value()?, at)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let map = HeatMap {
                axes: [of_x.label(), of_y.label()],
                columns: labels(of_x),
                rows: labels(of_y),
                values: means
                    .into_iter()
                    .map(|row| row.iter().map(Mean::value).collect())
                    .collect(),
                quantity: title(COLUMNS[what]),
                best: best.map(|(_, at)| at),
            };
            Some(heat_map(&map.quantity, &map))
        }
    };
    let maps = [of(SETTLING, |it| it.settling), of(TRAVEL, |it| it.travel)];
    maps.into_iter().flatten().collect()
}

/// Plot and list of the combinations that settle with every seed; the Pareto front in settling time and plane travel is marked.
fn pareto(space: &Space, outcomes: &Outcomes) -> Markup {
    let points = outcomes.settled();
    let front: Vec<_> = points.iter().filter(|it| it.is_on_front).collect();
    let every = points.len().div_ceil(DRAWN).max(1);
    let axes = [COLUMNS[SETTLING], COLUMNS[TRAVEL]].map(title);
    let of = |it: &Settled| (it.settling, it.travel);
    let plot = Plot::new("Settling time and plane travel", [&axes[0], &axes[1]])
        .plane()
        .note("All combinations of parameters that settle with every seed. No other combination is better than those on the line in both quantities.")
        .with(Style::Circles, "combinations", points.iter().step_by(every).map(of))
        .with(Style::Crosses, "not beaten", front.iter().map(|it| of(it)))
        .with(Style::Bound, "front", front.iter().map(|it| of(it)));
    html! {
        @if !front.is_empty() {
            (figure(&plot))
            div.scroll { table {
                thead { tr {
                    th { (axes[0]) } th { (axes[1]) }
                    @for axis in &space.axes { th { (axis.label()) } }
                } }
                @for it in front.iter().take(LISTED) {
                    tr {
                        td { (significant(it.settling, DIGITS)) } td { (significant(it.travel, DIGITS)) }
                        @for (axis, place) in space.axes.iter().zip(space.places(it.combination)) {
                            td { (labels(axis)[place]) }
                        }
                    }
                }
            } }
            @if front.len() > LISTED { p { (format!("{} more combinations are on this line.", front.len() - LISTED)) } }
        } @else {
            p { "No combination settles within 5 % in every flight: there is no Pareto plot of settling time and plane travel." }
        }
    }
}
