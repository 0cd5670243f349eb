//! Fits of equations whose truth is known.

use planesman_identification::SIGMAS_95;
use planesman_record::noise;

use crate::{
    Between, Equations, EquationsError, EquationsFit, Run, Track, TransferOptions, fit,
    fit_transfer, text_of,
};

fn equations(text: &str) -> Result<Equations, EquationsError> {
    Equations::new(text_of(text).unwrap())
}

/// Times that come unevenly, s.
fn times(count: usize) -> Vec<f64> {
    let mut time = 0.0;
    let steps = noise(9, count).into_iter();
    steps
        .map(|it| {
            let now = time;
            time += 0.1 + 0.05 * libm::sin(it);
            now
        })
        .collect()
}

/// Steps of an input at times of its own.
fn input(end: f64) -> Track {
    let values = noise(4, (end / 0.7) as usize + 1);
    Track {
        times: (0..values.len()).map(|k| 0.7 * k as f64).collect(),
        values,
    }
}

/// x_dot = -a x + b u in closed form, from one change of the input to the next.
fn first_order(a: f64, b: f64, x0: f64, input: &Track, times: &[f64]) -> Vec<f64> {
    let of = |time: f64| {
        let mut x = x0;
        for (k, begin) in input.times.iter().enumerate().filter(|it| *it.1 < time) {
            let end = input.times.get(k + 1).map_or(time, |it| it.min(time));
            let share = libm::exp(-a * (end - begin));
            x = x * share + b / a * input.values[k] * (1.0 - share);
        }
        x
    };
    times.iter().map(|it| of(*it)).collect()
}

fn run(values: Vec<f64>, times: &[f64], input: &Track) -> Run {
    let times = times.to_vec();
    Run {
        inputs: vec![input.clone()],
        outputs: vec![Track { times, values }],
        between: Between::Held,
    }
}

/// 400 samples of a first-order system in noise.
fn noisy(deviation: f64) -> Run {
    let times = times(400);
    let input = input(times[399]);
    let clean = first_order(1.3, 2.1, 0.8, &input, &times);
    let noise = noise(17, 400).into_iter();
    let values = clean.iter().zip(noise).map(|(y, e)| y + deviation * e);
    run(values.collect(), &times, &input)
}

const FIRST_ORDER: &str = "
inputs: [u]
outputs: {y: {equation: x}}
states: {x: {derivative: -a*x + b*u}}
parameters: {a: {start: 0.3, min: 0.01}, b: {start: 1}}
";

fn near(found: &EquationsFit, name: &str, truth: f64) {
    let of = found
        .parameters
        .iter()
        .find(|it| it.unknown.name == name)
        .unwrap();
    let half = SIGMAS_95 * of.deviation.unwrap();
    assert!(
        (of.value - truth).abs() < 1.5 * half && half < 0.1 * truth.abs(),
        "{name} {} ± {half}, {truth}",
        of.value
    );
}

#[test]
fn a_first_order_system_at_uneven_stamps_is_found_as_its_closed_form_has_it() {
    let exact = fit(&equations(FIRST_ORDER).unwrap(), &[noisy(0.0)], &[]).unwrap();
    for (of, truth) in exact.parameters.iter().zip([1.3, 2.1]) {
        assert!((of.value - truth).abs() < 1e-5, "{} {truth}", of.value);
    }
    assert!((exact.initial[0][0].value - 0.8).abs() < 1e-5);
    let found = fit(&equations(FIRST_ORDER).unwrap(), &[noisy(0.1)], &[]).unwrap();
    near(&found, "a", 1.3);
    near(&found, "b", 2.1);
    assert!((found.outputs[0].left - 0.1).abs() < 0.01);
}

#[test]
fn where_only_a_ratio_acts_the_ratio_is_named_with_its_interval() {
    let text = FIRST_ORDER
        .replace("-a*x + b*u", "-a*x + K*u/J")
        .replace("b: {start: 1}", "K: {start: 1}, J: {start: 3, min: 0.1}");
    let found = fit(&equations(&text).unwrap(), &[noisy(0.1)], &[]).unwrap();
    near(&found, "a", 1.3);
    let [of] = &found.undetermined[..] else {
        panic!("{:?}", found.undetermined);
    };
    assert_eq!(of.names, ["K", "J"]);
    let (name, value, deviation) = &of.kept[0];
    assert_eq!(name, "K/J");
    assert!(
        (value - 2.1).abs() < 4.0 * deviation && *deviation < 0.1,
        "{of}"
    );
    assert!(found.parameters[1].deviation.is_none());
    let verdict = found.verdict.to_string();
    assert!(
        verdict.contains("does not determine every parameter"),
        "{verdict}"
    );
}

#[test]
fn sums_and_idle_parameters_are_named_too() {
    let text = FIRST_ORDER
        .replace("-a*x + b*u", "-(a + c)*x + b*u + 0*d")
        .replace(
            "b: {start: 1}",
            "b: {start: 1}, c: {start: 0.2}, d: {start: 1}",
        );
    let found = fit(&equations(&text).unwrap(), &[noisy(0.1)], &[]).unwrap();
    let told: Vec<String> = found.undetermined.iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].starts_with("d changes no output"), "{told:?}");
    assert!(
        told[1].starts_with("the data does not determine a, c separately, only a + c = 1.3"),
        "{told:?}"
    );
}

#[test]
fn bounds_hold_and_are_told_and_the_best_of_several_starts_counts() {
    let text = FIRST_ORDER.replace("b: {start: 1}", "b: {start: 1, max: 1.5}");
    let found = fit(&equations(&text).unwrap(), &[noisy(0.1)], &[]).unwrap();
    assert_eq!(found.parameters[1].value, 1.5);
    assert!(
        found
            .reasons
            .iter()
            .any(|it| it.contains("b is at its bound 1.5"))
    );
    let text = FIRST_ORDER.replace("{start: 0.3, min: 0.01}", "{min: 0.01, max: 100}");
    let found = fit(&equations(&text).unwrap(), &[noisy(0.1)], &[]).unwrap();
    near(&found, "a", 1.3);
    assert!(found.searches.1 > 1);
}

#[test]
fn what_is_no_model_is_refused_with_entry_and_remedy() {
    let change = |from: &str, to: &str| {
        let text = FIRST_ORDER.replace(from, to);
        equations(&text).unwrap_err().to_string()
    };
    for (from, to, said) in [
        (
            "-a*x",
            "-alpha*x",
            "states: x: derivative: character 2: 'alpha' is not an input",
        ),
        (
            "b*u",
            "b*u*k",
            "'k' is not an input, state, parameter or definition",
        ),
        (
            "-a*x + b*u",
            "-a*x + u",
            "parameters: b: no equation uses this name",
        ),
        (
            "-a*x + b*u",
            "-a*x + b",
            "inputs: u: no equation uses this name",
        ),
        (
            "start: 0.3",
            "start: 0.001",
            "parameters: a: start 0.001 is not within 0.01..inf",
        ),
        (
            "{start: 1}",
            "{min: 1}",
            "parameters: b: give a start value (start: VALUE, or min and max)",
        ),
        (
            "{start: 1}",
            "{min: -.inf, max: 2}",
            "parameters: b: min: -inf refused: a number from -1e100 to 1e100 is expected; for no bound leave out min",
        ),
        (
            "{start: 1}",
            "{start: 1e200}",
            "parameters: b: start: 1e200 refused",
        ),
        (
            "{start: 1}",
            "{fixed: .nan}",
            "parameters: b: fixed: NaN refused",
        ),
        ("b: {", "x: {", "parameters: x: states has this name too"),
        (
            "b: {",
            "sin: {",
            "parameters: sin: this is the name of a function",
        ),
        (
            "parameters:",
            "definitions: {p: q + 1, q: p*2}\nparameters:",
            "definitions are circular: p -> q -> p",
        ),
    ] {
        let refusal = change(from, to);
        assert!(refusal.contains(said), "{to}: {refusal}");
    }
    let divided = FIRST_ORDER.replace("-a*x", "-a*x/(b - 1)");
    let refusal = fit(&equations(&divided).unwrap(), &[noisy(0.1)], &[])
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("states: x: derivative is not finite at the start, with"),
        "{refusal}"
    );
    assert!(refusal.contains("b = 1"), "{refusal}");
    let stiff = FIRST_ORDER.replace("-a*x", "-1e9*a*x");
    let refusal = fit(&equations(&stiff).unwrap(), &[noisy(0.1)], &[])
        .unwrap_err()
        .to_string();
    assert!(refusal.contains("the simulation ends at t = "), "{refusal}");
    assert!(
        refusal.contains("stiff") && !refusal.contains("division"),
        "{refusal}"
    );
    // Finite at the start, and no number later.
    let divided = FIRST_ORDER.replace("-a*x", "-a*x + sqrt(0.55 - t)");
    let refusal = fit(&equations(&divided).unwrap(), &[noisy(0.1)], &[])
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("the simulation ends at t = 0."),
        "{refusal}"
    );
    assert!(refusal.contains("division by 0"), "{refusal}");
}

#[test]
fn a_transfer_function_with_dead_time_is_found_at_uneven_stamps() {
    let times = times(400);
    let input = input(times[399]);
    let mut late = input.clone();
    late.times.iter_mut().for_each(|it| *it += 0.37);
    // Before its first sample the input has that value: it is steady until the second.
    let steady = 2.1 / 1.3 * input.values[0];
    late.times[0] = 0.0;
    let clean = first_order(1.3, 2.1, steady, &late, &times);
    let options = TransferOptions {
        order: Some(1),
        ..TransferOptions::default()
    };
    for (deviation, within) in [(0.0, 1e-4), (0.1, 0.2)] {
        let noise = noise(17, 400).into_iter();
        let values = clean
            .iter()
            .zip(noise)
            .map(|(y, e)| 0.5 + y + deviation * e);
        let run = run(values.collect(), &times, &input);
        let found = fit_transfer(&[run], &[], options).unwrap();
        for (at, truth) in [1.3, 2.1, 0.37].into_iter().enumerate() {
            let of = found.parameters[at];
            let sigma = found.covariance[(at, at)].sqrt();
            assert!(
                (of - truth).abs() < within && (of - truth).abs() < 3.0 * sigma + 1e-4,
                "{of} ± {sigma}, {truth}"
            );
        }
        assert!(
            (found.offsets[0] - 0.5).abs() < within,
            "{:?}",
            found.offsets
        );
        let (gain, sigma) = found.gain();
        assert!((gain - 2.1 / 1.3).abs() < 3.0 * sigma + 1e-4 && sigma < 0.1);
    }
}
