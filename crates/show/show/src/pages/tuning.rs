//! Gains for a model: text for a terminal, and a page with responses, margins and their distribution over the model's uncertainty.

use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_console::{Format, Outcome, Table};
use planesman_linear::digits::{significant, with_interval};
use planesman_linear::{ComplexFunctions as _, unwrapped_phases};
use planesman_text::option;
use planesman_tuning::{Band, Distribution, MISSED, PlantResponse, Tuning};

use crate::pages::cards::{Card, Tone, cards};
use crate::pages::fit::{FREQUENCY, MAGNITUDE, PHASE, SINCE_STEP};
use crate::pages::{document, figures, figures_with_first};
use planesman_flight::titles;
use planesman_identification::SIGMAS_95;

/// Significant digits of gains and times.
const DIGITS: usize = 4;
/// Standard deviation of the phase margin below which no further experiment is proposed, degrees.
const WELL_KNOWN: f64 = 1.0;
/// Number of bars of a histogram.
const COLUMNS: usize = 30;
/// Largest magnitude shown in a Nyquist plot, and the number of plotted plants.
const EXTENT: f64 = 3.0;
const LOOPS: usize = 40;
/// Range of a Bode plot below and above the crossover, a factor.
const AROUND: f64 = 30.0;
/// Plots over the time after a step share one x axis.
const STEP: &str = "step";

/// The gains with their verdict, margins and responses; with `verbose` also the model, the method, and the property that limits the margins.
#[must_use]
pub fn outcome(of: &Tuning, verbose: bool) -> Outcome {
    let kind = match of.controller.kd {
        0.0 => "PI",
        _ => "PID",
    };
    let mut notes = String::new();
    let mut line = |name: &str, value: String| notes += &format!("{name:13}{value}\n");
    for note in &of.notes {
        line("note", note.clone());
    }
    if verbose {
        let delay = match of.sampling.computing_delay {
            0.0 => String::new(),
            delay => format!(
                ", each command is applied {} s after its sample",
                number(delay)
            ),
        };
        line(
            "model",
            format!(
                "{} to {}: {}",
                of.model.input, of.model.output, of.model.description
            ),
        );
        line(
            "controller",
            format!("every {} s{delay}", number(of.sampling.tick)),
        );
        if let Some(reduced) = reduced_text(of) {
            line("reduced", reduced);
        }
        line("method", method_text(of));
    }
    let mut outcome = Outcome::new(format!(
        "{kind} gains: {}; {}\n{}",
        parallel_text(of),
        ideal_text(of),
        verdict(of)
    ))
    .numbers(margins(of).text(Format::Table))
    .numbers(responses(of).text(Format::Table))
    .numbers(notes);
    if verbose && !of.causes.is_empty() {
        outcome = outcome
            .numbers(limiting(of))
            .numbers(causes(of).text(Format::Table));
    }
    outcome
}

/// The HTML page of a tuning.
#[must_use]
pub fn page(of: &Tuning) -> String {
    let title = format!(
        "Gains for {} to {}",
        titles::name(&of.model.input),
        titles::name(&of.model.output)
    );
    let [input, output] = [&of.model.input, &of.model.output].map(|it| titles::title(it));
    let plots = plots(of, &input, &output);
    let body = html! {
        h1 { (title) }
        (cards(&summary(of)))
        (figures_with_first(&plots[..1]))
        h2 { "Notes" }
        ul.findings.notes {
            @if !of.causes.is_empty() { li { (limiting(of)) } }
            @for note in &of.notes { li { (note) } }
        }
        h2 { "The controller" }
        div.scroll { table.words {
            tr { td { "parallel form" } td { (parallel_text(of)) } }
            tr { td { "ideal form" } td { (ideal_text(of)) } }
            tr { td { "sample time" } td { (number(of.sampling.tick)) " s, computing delay " (number(of.sampling.computing_delay)) " s" } }
            tr { td { "method" } td { (method_text(of)) } }
            tr { td { "model" } td { (of.model.description) } }
            @if let Some(reduced) = reduced_text(of) { tr { td { "reduced" } td { (reduced) } } }
        } }
        div.columns {
            div { h2 { "Margins" } (margins(of).html()) }
            div { h2 { "After steps" } (responses(of).html()) }
            @if !of.causes.is_empty() { div { h2 { "What limits the margins" } (causes(of).html()) } }
        }
        h2 { "Plots" }
        (figures(&plots[1..]))
    };
    document(&title, "", &body, "")
}

/// Cards: the verdict, the gains, and the worst margins.
fn summary(of: &Tuning) -> Vec<Card> {
    let robustness = &of.robustness;
    let worst = |spread: &Distribution| match robustness.draws.is_empty() {
        true => spread.model,
        false => spread.quantile(MISSED),
    };
    let (tone, words) = match of.keeps_limits() {
        true => (Tone::Good, "limits kept"),
        false => (Tone::Bad, "limits not kept"),
    };
    let of_worst = match robustness.draws.len() {
        0 => "of the model",
        _ => "worst of 95 % of the plants",
    };
    let overshoot = of.steps.overshoot.model;
    vec![
        Card::new("verdict", words).toned(tone).note(verdict(of)),
        Card::new("gains, parallel form", parallel_text(of)),
        Card::new(
            format!("phase margin, {of_worst}"),
            cell(worst(&robustness.phase()), 1) + " deg",
        ),
        Card::new(
            format!("gain margin, {of_worst}"),
            cell(worst(&robustness.gain()), 1) + " dB",
        ),
        Card::new("overshoot of the model", cell(overshoot, 1) + " %"),
    ]
}

pub(crate) fn number(value: f64) -> String {
    let text = significant(value, DIGITS);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

pub(crate) fn method_text(of: &Tuning) -> String {
    let mut text = of.method.name().to_owned();
    if let Some((name, value)) = of.pace {
        text += &format!(", {name} {} s", number(value));
    }
    if let Some(why) = &of.why {
        text += &format!(": {why}");
    }
    text
}

pub(crate) fn reduced_text(of: &Tuning) -> Option<String> {
    let reduced = of.reduced.as_ref()?;
    let lags = reduced.time_constants.iter().filter(|tau| tau.is_finite());
    let integrators = match reduced.integrators() {
        0 => None,
        1 => Some("s".to_owned()),
        n => Some(format!("s^{n}")),
    };
    let lags = lags.map(|tau| format!("({} s + 1)", number(*tau)));
    let factors: Vec<String> = integrators.into_iter().chain(lags).collect();
    Some(format!(
        "{} e^(-{} s) / [{}], reduced by the half rule; the dead time includes half a sample for the hold",
        number(reduced.gain),
        number(reduced.delay),
        factors.join(" ")
    ))
}

pub(crate) fn parallel_text(of: &Tuning) -> String {
    let gains = &of.controller;
    let mut text = format!("kp {}, ki {} 1/s", number(gains.kp), number(gains.ki));
    if gains.kd != 0.0 {
        text += &format!(
            ", kd {} s, derivative filter {} s",
            number(gains.kd),
            number(gains.filter)
        );
    }
    text
}

pub(crate) fn ideal_text(of: &Tuning) -> String {
    let gains = &of.controller;
    let mut text = format!("K {}, Ti {} s", number(gains.kp), number(gains.ti()));
    if gains.kd != 0.0 {
        text += &format!(
            ", Td {} s, N {}",
            number(gains.td()),
            match gains.filter {
                0.0 => "without limit".to_owned(),
                filter => format!("{:.1}", gains.td() / filter),
            }
        );
    }
    text + " (ideal form)"
}

fn cell(value: f64, decimals: usize) -> String {
    match value {
        f64::INFINITY => "none".to_owned(),
        f64::NEG_INFINITY => "unstable".to_owned(),
        value => format!("{value:.decimals$}"),
    }
}

/// Table of the margins of the model and of the drawn plants.
pub(crate) fn margins(of: &Tuning) -> Table {
    let robustness = &of.robustness;
    let has_draws = !robustness.draws.is_empty();
    let mut table = Table::of(["margin", "model", "worst of 95 %", "median", "limit"]);
    let rows = [
        (
            "phase margin, deg",
            robustness.phase(),
            MISSED,
            1,
            format!("{:.1}", of.limits.phase.to_degrees()),
        ),
        (
            "gain margin, dB",
            robustness.gain(),
            MISSED,
            1,
            format!("{:.1}", 20.0 * libm::log10(of.limits.gain)),
        ),
        (
            "sensitivity peak Ms",
            robustness.sensitivity(),
            1.0 - MISSED,
            2,
            format!("{:.2}", of.limits.sensitivity),
        ),
    ];
    for (name, spread, worst, decimals, limit) in rows {
        let drawn = |share: f64| match has_draws {
            true => unstable_or(spread.quantile(share), decimals, worst > 0.5),
            false => "-".to_owned(),
        };
        table.row([
            name.to_owned(),
            unstable_or(spread.model, decimals, worst > 0.5),
            drawn(worst),
            drawn(0.5),
            limit,
        ]);
    }
    let crossover = robustness.crossover();
    let drawn = |share: f64| match has_draws {
        true => number(crossover.quantile(share)),
        false => "-".to_owned(),
    };
    table.row([
        "crossover, rad/s".to_owned(),
        number(crossover.model),
        drawn(MISSED),
        drawn(0.5),
        "-".to_owned(),
    ]);
    table
}

/// A margin as text; plus or minus infinity is printed as unstable.
fn unstable_or(value: f64, decimals: usize, is_peak: bool) -> String {
    match is_peak && value == f64::INFINITY {
        true => "unstable".to_owned(),
        false => cell(value, decimals),
    }
}

/// A sentence on whether the limits are kept.
pub(crate) fn verdict(of: &Tuning) -> String {
    let drawn = of.robustness.draws.len();
    let share = of.robustness.unstable();
    let over = match drawn {
        0 => "the model, which is assumed to be exact,".to_owned(),
        n => format!("95 % of {n} plants drawn from the model's covariance"),
    };
    let stable = match (drawn, share > 0.0) {
        (0, _) | (_, false) => String::new(),
        _ => format!("; {:.1} % are unstable", 100.0 * share),
    };
    match of.keeps_limits() {
        true => format!("Limits kept by {over}{stable}."),
        false => format!(
            "LIMITS NOT KEPT by {over}{stable}. Next: leave out {} and {}, so that the method chooses the speed of the loop",
            option("closed_loop_time"),
            option("crossover")
        ),
    }
}

pub(crate) fn responses(of: &Tuning) -> Table {
    let steps = &of.steps;
    let has_draws = !of.robustness.draws.is_empty();
    let mut table = Table::of(["after a step", "model", "5 %", "median", "95 %"]);
    let mut row = |name: String, spread: &Distribution| {
        let shown = |value: f64| match value.is_finite() {
            true => number(value),
            false => "-".to_owned(),
        };
        let drawn = |share: f64| match has_draws {
            true => shown(spread.quantile(share)),
            false => "-".to_owned(),
        };
        table.row([
            name,
            shown(spread.model),
            drawn(MISSED),
            drawn(0.5),
            drawn(1.0 - MISSED),
        ]);
    };
    row("overshoot, %".to_owned(), &steps.overshoot);
    row("settling time (2 %), s".to_owned(), &steps.settling);
    row(
        format!("largest input for a step of {}", number(steps.step)),
        &steps.peak_input,
    );
    row("travel of the input".to_owned(), &steps.travel);
    if steps.at_limit.sorted.iter().any(|it| *it > 0.0) || steps.at_limit.model > 0.0 {
        row("time at the input's limit, %".to_owned(), &steps.at_limit);
    }
    row(
        "error after a unit load (IAE)".to_owned(),
        &steps.load_error,
    );
    table
}

/// Sentences on the property that limits the margins.
pub(crate) fn limiting(of: &Tuning) -> String {
    let Some(first) = of.causes.first() else {
        return String::new();
    };
    let half = SIGMAS_95 * first.margin_deviation.to_degrees();
    if half < WELL_KNOWN {
        return format!(
            "limited by the plant itself: the model is known well enough (phase margin to within ± {})",
            with_degrees(half)
        );
    }
    format!(
        "limited by the uncertainty of: {} ({:.0} % of the phase margin's variance; the phase margin is known to within ± {}). To reduce it: {}. A record four times as long halves the interval",
        first.name,
        100.0 * first.share,
        with_degrees(half),
        first.experiment
    )
}

fn with_degrees(half: f64) -> String {
    format!("{} deg", significant(half, 2))
}

pub(crate) fn causes(of: &Tuning) -> Table {
    let mut table = Table::of([
        "property",
        "value, 95 %",
        "unit",
        "share of the variance, %",
    ]);
    for cause in &of.causes {
        table.row([
            cause.name.clone(),
            with_interval(cause.value, SIGMAS_95 * cause.deviation),
            cause.unit.to_owned(),
            format!("{:.0}", 100.0 * cause.share),
        ]);
    }
    table
}

fn plots<'a>(of: &'a Tuning, input: &'a str, output: &'a str) -> Vec<Plot<'a>> {
    let mut plots = after_steps(of, input, output);
    plots.extend(of_margins(of));
    plots
}

/// A line for the model with the band of the drawn plants.
pub(crate) fn banded<'a>(plot: Plot<'a>, band: &Band) -> Plot<'a> {
    let times = || band.times.iter().copied();
    let range = times().zip(&band.range);
    let range = range.map(|(t, (low, high))| (t, *low, *high));
    plot.with_all([Series::band("90 % of plants", range)])
        .line("model", times().zip(band.model.iter().copied()))
}

/// Plots of outputs and input after steps.
pub(crate) fn after_steps<'a>(of: &Tuning, input: &'a str, output: &'a str) -> Vec<Plot<'a>> {
    let steps = &of.steps;
    let over = "The band contains 90 % of the plants drawn from the model's covariance.";
    let ends = [0.0, steps.output.times.last().copied().unwrap_or(0.0)];
    let plot = |title, axis| Plot::new(title, [SINCE_STEP, axis]).linked(STEP);
    vec![
        banded(
            plot("Output after a step of the setpoint", output).note(over),
            &steps.output,
        )
        .with(Style::Bound, "setpoint", ends.map(|t| (t, steps.step))),
        banded(
            plot("Input after a step of the setpoint", input),
            &steps.input,
        ),
        banded(
            plot("Output after a unit step of the load", output)
                .note("The load acts at the plant's input."),
            &steps.load,
        ),
    ]
}

/// Plots of the open loop, and the distribution of its phase margin.
pub(crate) fn of_margins(of: &Tuning) -> Vec<Plot<'static>> {
    let mut plots = Vec::from(bode(of));
    plots.push(nyquist(of));
    plots.extend(histogram(&of.robustness.phase(), of.limits.phase));
    plots
}

/// The open loop of the model and the band of the drawn plants.
fn bode(of: &Tuning) -> [Plot<'static>; 2] {
    let crossover = of
        .robustness
        .model
        .crossover
        .unwrap_or(of.seen.plant.nyquist());
    let shown = crossover / AROUND..crossover * AROUND;
    // Magnitude, dB, and phase, degrees; every second frequency is enough.
    let seen = |seen: &PlantResponse| {
        let open = seen.open_loop(&of.controller);
        let phases = unwrapped_phases(open.iter().map(|it| it.1));
        let each = open
            .into_iter()
            .zip(phases)
            .filter(|((w, _), _)| shown.contains(w))
            .step_by(2);
        each.map(|((w, l), phase)| (w, 20.0 * libm::log10(l.modulus()), phase.to_degrees()))
            .collect::<Vec<_>>()
    };
    let model = seen(&of.seen);
    let draws: Vec<_> = of.draws.iter().map(seen).collect();
    let band = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
        let each = (0..model.len()).map(|k| {
            let drawn = draws.iter().filter_map(|it| it.get(k)).map(value);
            let spread = Distribution::new(value(&model[k]), drawn);
            (
                model[k].0,
                spread.quantile(MISSED),
                spread.quantile(1.0 - MISSED),
            )
        });
        Series::band("90 % of plants", each.collect::<Vec<_>>())
    };
    let ends = [shown.start, shown.end.min(of.seen.plant.nyquist())];
    let plot = |title,
                axes: [&'static str; 2],
                value: &dyn Fn(&(f64, f64, f64)) -> f64,
                bound: f64,
                name: &'static str| {
        Plot::new(title, axes)
            .log_x()
            .linked(FREQUENCY)
            .with_all([band(value)])
            .line(
                "model",
                model.iter().map(|it| (it.0, value(it))).collect::<Vec<_>>(),
            )
            .with(Style::Bound, name, ends.map(|w| (w, bound)))
    };
    [
        plot(
            "Magnitude of the open loop",
            MAGNITUDE,
            &|it| it.1,
            0.0,
            "0 dB",
        ),
        plot(
            "Phase of the open loop",
            PHASE,
            &|it| it.2,
            -180.0,
            "-180 deg",
        )
        .note("The phase margin is the distance from -180 degrees where the magnitude is 0 dB."),
    ]
}

fn nyquist(of: &Tuning) -> Plot<'static> {
    let near = |seen: &PlantResponse| {
        let open = seen.open_loop(&of.controller).into_iter();
        let near = open.filter(|(_, l)| l.modulus() < EXTENT);
        near.map(|(_, l)| (l.re, l.im)).collect::<Vec<_>>()
    };
    let drawn = of.draws.iter().take(LOOPS).enumerate();
    let drawn = drawn.map(|(i, it)| {
        // One name for all of them.
        let name = if i == 0 { "drawn plants" } else { "" };
        Series::new(Style::Grid, name, near(it))
    });
    let radius = 1.0 / of.limits.sensitivity;
    let circle = (0..=120).map(|i| f64::from(i) * std::f64::consts::TAU / 120.0);
    Plot::new(
        "Nyquist plot of the open loop",
        ["real part", "imaginary part"],
    )
    .note("The loop keeps the limit on its sensitivity peak if the curve stays outside the circle around -1.")
    .one_scale()
    .with_all(drawn)
    .line("model", near(&of.seen))
    .with(
        Style::Bound,
        format!("Ms {:.2}", of.limits.sensitivity),
        circle.map(|a| (radius * libm::cos(a) - 1.0, radius * libm::sin(a))),
    )
    .with(Style::Crosses, "-1", [(-1.0, 0.0)])
}

/// Histogram of the drawn plants' phase margins, with the required minimum, rad.
pub(crate) fn histogram(spread: &Distribution, least: f64) -> Option<Plot<'static>> {
    let finite: Vec<f64> = spread
        .sorted
        .iter()
        .copied()
        .filter(|it| it.is_finite())
        .collect();
    let (first, last) = (*finite.first()?, *finite.last()?);
    let width = ((last - first) / COLUMNS as f64).max(1e-6);
    let mut counts = vec![0.0; COLUMNS];
    for margin in &finite {
        let column = ((margin - first) / width) as usize;
        counts[column.min(COLUMNS - 1)] += 100.0 / spread.sorted.len() as f64;
    }
    let steps = counts.iter().enumerate().flat_map(|(i, count)| {
        let left = first + i as f64 * width;
        [(left, *count), (left + width, *count)]
    });
    let highest = counts.iter().fold(0.0_f64, |most, it| most.max(*it));
    let at = |x: f64| [(x, 0.0), (x, highest)];
    let outline: Vec<_> = [(first, 0.0)]
        .into_iter()
        .chain(steps)
        .chain([(last, 0.0)])
        .collect();
    Some(
        Plot::new(
            "Phase margins of the drawn plants",
            ["phase margin [deg]", "share of plants [%]"],
        )
        .note("5 % of the plants are below the dashed line (worst of 95 %).")
        .plane()
        .with(Style::Area, "share", outline.clone())
        .line("plants", outline)
        .with(Style::Dashed, "limit", at(least.to_degrees()))
        .with(Style::Bound, "worst of 95 %", at(spread.quantile(MISSED))),
    )
}
