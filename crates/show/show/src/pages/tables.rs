//! Tables that the commands print for fits and comparisons.

use planesman_console::{Format, Table};
use planesman_fit::{Compared, SeveralComparison, Trial, frequency_responses, ranked};
use planesman_identification::analysis::{AHEAD, Analysis};
use planesman_identification::estimators::Estimate;
use planesman_identification::validation::residuals::{Correlation, ResidualTests};
use planesman_identification::{SIGMAS_95, Uncertain};
use planesman_linear::ComplexFunctions as _;
use planesman_linear::digits::value_and_interval;
use planesman_text::{in_one_line, option};

/// Number of frequencies in the table of a frequency response.
const FREQUENCIES: usize = 6;

/// Table with a row per method, within the terminal's width.
pub fn tried(tried: &[Trial]) -> String {
    let ahead = format!("{AHEAD} ahead, %");
    let mut table = Table::new([
        "method",
        "order",
        "delay",
        "held out, %",
        &ahead,
        "white",
        "s",
        "best",
    ]);
    let best = ranked(tried).first().map(|it| it.method);
    for trial in tried {
        let of = |of: &dyn Fn(&Analysis) -> String| trial.found().map_or("-".to_owned(), of);
        table.row([
            trial.method.name().to_owned(),
            of(&|it| order(&it.estimate)),
            of(&|it| it.estimate.layout.structure.delay.to_string()),
            of(&|it| percent(it.held_out.fit)),
            of(&|it| percent(it.predicted_fit)),
            match trial.is_white() {
                None => "-".to_owned(),
                Some(white) => if white { "yes" } else { "no" }.to_owned(),
            },
            format!("{:.2}", trial.seconds),
            if best == Some(trial.method) { "<-" } else { "" }.to_owned(),
        ]);
    }
    table.text(Format::Table)
}

/// Notes on the table.
pub fn notes(tried: &[Trial]) -> String {
    let mut text = String::new();
    for trial in tried {
        if let Err(reason) = &trial.outcome {
            text += &format!("{}: {}\n", trial.method.name(), in_one_line(reason));
        }
    }
    if !tried.iter().any(|it| it.method.is_of_the_vehicle()) {
        let (heave, vehicle) = (option("heave"), option("vehicle"));
        text += &format!("add {heave} or {vehicle} to try also the methods vehicle and kalman.\n");
    }
    text + "The method that is best on one set of held-out data usually does less well on new data.\n"
}

/// A fit as a table cell.
fn percent(fit: Option<f64>) -> String {
    match fit {
        None => "-".to_owned(),
        Some(fit) if fit < -1e5 => format!("{fit:.1e}"),
        Some(fit) => format!("{fit:.2}"),
    }
}

/// The order; for a finite impulse response the number of coefficients.
fn order(of: &Estimate) -> String {
    match planesman_fit::order(of) {
        None => format!("{} (fir)", of.layout.structure.numerator),
        Some(order) => order.to_string(),
    }
}

/// Table of each model's structure and of its fits in simulation and prediction.
pub fn fits(models: &[Compared]) -> Table {
    let ahead = models.first().map_or(&[][..], |it| &it.judgement.predicted);
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(it, _)| format!("{it} ahead, %"))
        .collect();
    let columns = ["model", "method", "order", "delay", "simulated, %"].into_iter();
    let mut table = Table::of(columns.chain(ahead.iter().map(String::as_str)));
    for model in models {
        let first = [
            model.name.clone(),
            model.method.clone(),
            order(&model.judgement.estimate),
            model.delay().to_string(),
            percent(model.judgement.fit),
        ];
        let predicted = model.judgement.predicted.iter();
        table.row(
            first
                .into_iter()
                .chain(predicted.map(|(_, fit)| percent(*fit))),
        );
    }
    table
}

/// Table of how well each model simulates each output, and whether its error is still correlated with the inputs.
#[must_use]
pub fn of_several(found: &SeveralComparison) -> Table {
    let mut table = Table::new([
        "model",
        "output",
        "inputs",
        "simulated, %",
        "uncorrelated with earlier inputs",
        "free of later inputs",
    ]);
    for it in &found.models {
        let all = |of: fn(&ResidualTests) -> Correlation| {
            let tests: Vec<&ResidualTests> = it.judged.residuals.iter().flatten().collect();
            let passes = tests.iter().all(|it| of(it).passes());
            match (tests.is_empty(), passes) {
                (true, _) => "-",
                (false, true) => "yes",
                (false, false) => "no",
            }
        };
        table.row([
            it.name.clone(),
            it.output.clone(),
            it.inputs.join(", "),
            percent(it.judged.fit),
            all(ResidualTests::of_earlier_inputs).to_owned(),
            all(ResidualTests::of_later_inputs).to_owned(),
        ]);
    }
    table
}

/// One table per question: fits, residual tests, poles, steady-state gain, frequency response.
#[must_use]
pub fn tables(models: &[Compared]) -> Vec<Table> {
    vec![
        fits(models),
        tests(models),
        poles(models),
        gains(models),
        responses(models),
    ]
}

/// The columns of residual tests.
pub(crate) const TESTS: [&str; 5] = [
    "residual",
    "passes",
    "lags outside",
    "largest",
    "99 % bound",
];

/// The row of a test.
pub(crate) fn of_test(what: &str, found: &Correlation) -> [String; 5] {
    [
        what.to_owned(),
        if found.passes() { "yes" } else { "no" }.to_owned(),
        format!("{} of {}", found.outside(), found.values.len()),
        format!("{:.3}", found.largest()),
        format!("{:.3}", found.bound),
    ]
}

fn tests(models: &[Compared]) -> Table {
    let mut table = Table::of(["model"].into_iter().chain(TESTS));
    for model in models {
        for (what, found) in model.tests() {
            let name = std::iter::once(model.name.clone());
            table.row(name.chain(of_test(what, &found)));
        }
    }
    table
}

fn poles(models: &[Compared]) -> Table {
    let columns = [
        "pole",
        "model",
        "real, 1/s",
        "± 95 %",
        "imaginary, 1/s",
        "± 95 %",
    ];
    let mut table = Table::new(columns);
    let poles: Vec<Vec<Uncertain>> = models.iter().map(Compared::poles).collect();
    for number in 0..poles.iter().map(Vec::len).max().unwrap_or(0) {
        for (model, poles) in models.iter().zip(&poles) {
            let Some(pole) = poles.get(number) else {
                continue;
            };
            let real = value_and_interval(pole.value.re, SIGMAS_95 * pole.real_deviation());
            let imaginary =
                value_and_interval(pole.value.im, SIGMAS_95 * pole.imaginary_deviation());
            table.row([
                (number + 1).to_string(),
                model.name.clone(),
                real.0,
                real.1,
                imaginary.0,
                imaginary.1,
            ]);
        }
    }
    table
}

fn gains(models: &[Compared]) -> Table {
    let mut table = Table::new(["model", "steady-state gain", "± 95 %"]);
    for model in models {
        let gain = model.reading().steady_state_gain();
        let interval = |it: Uncertain| SIGMAS_95 * it.real_deviation();
        let gain = gain.map(|it| value_and_interval(it.value.re, interval(it)));
        let (gain, interval) = gain.unwrap_or(("none".to_owned(), "-".to_owned()));
        table.row([model.name.clone(), gain, interval]);
    }
    table
}

fn responses(models: &[Compared]) -> Table {
    let columns = [
        "rad/s",
        "model",
        "magnitude, dB",
        "± 95 %",
        "phase, deg",
        "± 95 %",
    ];
    let mut table = Table::new(columns);
    let responses = frequency_responses(models);
    let most = responses.iter().map(Vec::len).max().unwrap_or(0);
    let stride = (most / FREQUENCIES).max(1);
    for at in (0..most)
        .rev()
        .step_by(stride)
        .take(FREQUENCIES)
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
    {
        for (model, responses) in models.iter().zip(&responses) {
            let Some(it) = responses.get(at) else {
                continue;
            };
            let up = it.magnitude(SIGMAS_95) - it.magnitude(0.0);
            let turn = SIGMAS_95 * it.value.phase_deviation().to_degrees();
            table.row([
                format!("{:.4}", it.omega),
                model.name.clone(),
                format!("{:.2}", it.magnitude(0.0)),
                format!("{up:.2}"),
                format!("{:.1}", it.phase),
                format!("{turn:.1}"),
            ]);
        }
    }
    table
}

/// All numbers, one row each.
#[must_use]
pub fn numbers(models: &[Compared]) -> Table {
    let mut table = Table::new(["model", "quantity", "value", "deviation"]);
    for (model, responses) in models.iter().zip(frequency_responses(models)) {
        let mut row = |quantity: String, value: String, deviation: Option<f64>| {
            let deviation = deviation.map_or(String::new(), |it| it.to_string());
            table.row([model.name.clone(), quantity, value, deviation]);
        };
        let fit = |fit: Option<f64>| fit.map_or(String::new(), |it| it.to_string());
        row("method".to_owned(), model.method.clone(), None);
        row("order".to_owned(), order(&model.judgement.estimate), None);
        row("delay".to_owned(), model.delay().to_string(), None);
        row(
            "samples".to_owned(),
            model.judgement.samples.to_string(),
            None,
        );
        row(
            "simulated fit, %".to_owned(),
            fit(model.judgement.fit),
            None,
        );
        for (ahead, of) in &model.judgement.predicted {
            row(format!("fit {ahead} ahead, %"), fit(*of), None);
        }
        for (what, found) in model.tests() {
            row(format!("residual {what}"), found.passes().to_string(), None);
            row(
                format!("residual {what}: lags outside"),
                found.outside().to_string(),
                None,
            );
            row(
                format!("residual {what}: largest"),
                found.largest().to_string(),
                None,
            );
            row(
                format!("residual {what}: bound"),
                found.bound.to_string(),
                None,
            );
        }
        for (i, pole) in (1..).zip(model.poles()) {
            let [re, im] = [pole.value.re, pole.value.im].map(|it| it.to_string());
            row(
                format!("pole {i} real, 1/s"),
                re,
                Some(pole.real_deviation()),
            );
            row(
                format!("pole {i} imaginary, 1/s"),
                im,
                Some(pole.imaginary_deviation()),
            );
        }
        if let Some(gain) = model.reading().steady_state_gain() {
            let deviation = gain.real_deviation();
            row(
                "steady-state gain".to_owned(),
                gain.value.re.to_string(),
                Some(deviation),
            );
        }
        for it in responses {
            let omega = it.omega;
            let size = it.value.value.modulus().to_string();
            let deviation = it.value.magnitude_deviation();
            row(
                format!("magnitude at {omega:.6} rad/s"),
                size,
                Some(deviation),
            );
            let deviation = it.value.phase_deviation().to_degrees();
            row(
                format!("phase at {omega:.6} rad/s, deg"),
                it.phase.to_string(),
                Some(deviation),
            );
        }
    }
    table
}
