//! Process models from step tests whose responses are written down in closed form.

use planesman_identification::analysis::{Analysis, Options, analyse};
use planesman_identification::estimators::{Form, Knowledge, Method, ProcessModel};
use planesman_identification::{
    GivenModel, Input, Record, Run, SIGMAS_95, Structure, filter, noise, with_noise,
};

const SAMPLE_TIME: f64 = 0.1;

/// The response of a process to a unit step, `time` s after its dead time.
type Response = fn(f64) -> f64;

/// A step from 3 to 5 at 3 s; the output rests at 20, and moves by 2 `gain` times the response.
fn step_test(gain: f64, response: Response, dead_time: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let times = (0..count).map(|k| k as f64 * SAMPLE_TIME);
    let input = times.clone().map(|t| if t > 2.95 { 5.0 } else { 3.0 });
    let output = times.map(|t| {
        let since = t - 3.0 - dead_time;
        20.0 + if since > 0.0 {
            2.0 * gain * response(since)
        } else {
            0.0
        }
    });
    (input.collect(), output.collect())
}

fn record(input: Vec<f64>, output: Vec<f64>) -> Record {
    Record::of_run(SAMPLE_TIME, vec![("u", input)], vec![("y", output)]).unwrap()
}

fn process(record: &Record, form: Option<Form>) -> Analysis {
    let options = Options {
        method: Method::Process,
        knowledge: Knowledge {
            process: form,
            ..Knowledge::default()
        },
        ..Options::default()
    };
    analyse(record, &options).unwrap()
}

fn model(found: &Analysis) -> &ProcessModel {
    found.estimate.process.as_ref().unwrap()
}

/// `1 - (T1 e^(-t/T1) - T2 e^(-t/T2)) / (T1 - T2)`, T1 = 4 s, T2 = 1 s.
fn two_lags(t: f64) -> f64 {
    1.0 - (4.0 * libm::exp(-t / 4.0) - libm::exp(-t)) / 3.0
}

/// wn = 1 rad/s, zeta = 0.4.
fn underdamped(t: f64) -> f64 {
    let rate = (1.0_f64 - 0.16).sqrt();
    1.0 - libm::exp(-0.4 * t) * (libm::cos(rate * t) + 0.4 / rate * libm::sin(rate * t))
}

#[test]
fn a_clean_step_test_gives_its_form_gain_time_constants_and_dead_time() {
    let first: Response = |t| 1.0 - libm::exp(-t / 2.5);
    let lagged: Response = |t| t - 1.5 * (1.0 - libm::exp(-t / 1.5));
    let cases: [(Form, Response, &[f64]); 5] = [
        (Form::First, first, &[2.5]),
        (Form::Second, two_lags, &[4.0, 1.0]),
        (Form::Underdamped, underdamped, &[1.0, 0.4]),
        (Form::Integrator, |t| t, &[]),
        (Form::IntegratorWithLag, lagged, &[1.5]),
    ];
    for (form, response, shape) in cases {
        // A dead time of 7 samples and a third.
        let (input, output) = step_test(-1.7, response, 0.7333, 240);
        let found = process(&record(input, with_noise(&output, 3, 1e-4)), None);
        assert_eq!(model(&found).form, form, "{}", found.text());
        let expected = [&[-1.7], shape, &[0.7333]].concat();
        for (value, expected) in model(&found).values.iter().zip(&expected) {
            let off = (value / expected - 1.0).abs();
            assert!(off < 2e-3, "{} {value} {expected}", form.name());
        }
        // The sampled model has the same response: y(k) of the step response, in closed form.
        let sampled = found.model();
        let steps = vec![Input::held(1.0); 60];
        for (k, y) in sampled.simulate(&steps, 60).into_iter().enumerate() {
            let since = k as f64 * SAMPLE_TIME - 0.7333;
            let exact = if since > 0.0 {
                -1.7 * response(since)
            } else {
                0.0
            };
            assert!((y - exact).abs() < 5e-3, "{} {k}: {y} {exact}", form.name());
        }
    }
}

#[test]
fn the_default_takes_a_step_test_that_ends_at_rest_for_what_it_is() {
    for (seed, response, gain) in [(1, two_lags as Response, 0.6), (2, underdamped, -30.0)] {
        let (input, output) = step_test(gain, response, 0.43, 500);
        let record = record(input, with_noise(&output, seed, 0.04 * gain));
        let found = analyse(&record, &Options::default()).unwrap();
        let verdict = found.verdict.to_string();
        assert!(verdict.starts_with("verdict: good"), "{}", found.text());
        let known = found.reading().steady_state_gain().unwrap();
        assert!(
            (known.value.re / gain - 1.0).abs() < 0.02,
            "{}",
            found.text()
        );
        assert!(found.text().contains("theta"), "{}", found.text());
    }
}

#[test]
fn an_output_that_the_step_does_not_move_gives_no_usable_model() {
    let (input, still) = step_test(0.0, |t| t, 0.0, 400);
    let drifts = filter(&[1.0], &[1.0, -0.98], &noise(5, 400));
    let walks = filter(&[1.0], &[1.0, -1.0], &noise(6, 400));
    for output in [with_noise(&still, 4, 1.0), drifts, walks] {
        let found = analyse(&record(input.clone(), output), &Options::default()).unwrap();
        let verdict = found.verdict.to_string();
        let is_taken = ["verdict: good", "verdict: usable. "].map(|it| verdict.starts_with(it));
        assert_eq!(is_taken, [false; 2], "{}", found.text());
    }
}

#[test]
fn the_intervals_hold_the_truth_in_white_and_in_coloured_noise() {
    let (input, output) = step_test(2.0, |t| 1.0 - libm::exp(-t / 1.5), 0.47, 150);
    let truth = [2.0, 1.5, 0.47];
    for pole in [0.0, 0.7_f64] {
        let mut held = [0; 3];
        const RECORDS: u32 = 25;
        for seed in 0..RECORDS {
            let size = 0.08 * (1.0 - pole * pole).sqrt();
            let coloured = filter(&[size], &[1.0, -pole], &noise(100 + seed, 250));
            let noisy = output.iter().zip(&coloured[100..]).map(|(y, e)| y + e);
            let found = process(&record(input.clone(), noisy.collect()), Some(Form::First));
            let named: Vec<_> = model(&found).named().collect();
            for (held, ((_, _, value, deviation), truth)) in
                held.iter_mut().zip(named.into_iter().zip(truth))
            {
                *held += u32::from((value - truth).abs() < SIGMAS_95 * deviation);
            }
        }
        // Of 25 fewer than 19 have a probability of 0.1 % with 95 % each.
        assert!(held.iter().all(|it| *it >= 19), "{pole}: {held:?}");
    }
}

#[test]
fn a_level_that_rises_before_the_step_tells_where_it_would_stand() {
    // y' = 0.3 (u - 3.4), held on a second record with other inputs.
    let (input, _) = step_test(1.0, |t| t, 0.0, 200);
    let level = |input: &[f64]| {
        let mut y = vec![7.0];
        for u in &input[..input.len() - 1] {
            y.push(y[y.len() - 1] + 0.3 * (u - 3.4) * SAMPLE_TIME);
        }
        y
    };
    let output = level(&input);
    let found = process(&record(input, with_noise(&output, 2, 0.01)), None);
    assert_eq!(model(&found).form, Form::Integrator, "{}", found.text());
    let given = GivenModel::new(&found.estimate, found.longest);
    assert!(
        (given.input_level - 3.4).abs() < 0.02,
        "{}",
        given.input_level
    );
    let other: Vec<f64> = noise(9, 300).iter().map(|u| 3.0 + u).collect();
    let judged = given
        .on(&record(other.clone(), level(&other)), &[1])
        .unwrap();
    assert!(judged.fit.unwrap() > 95.0, "{:?}", judged.fit);
}

#[test]
fn two_records_share_one_process_and_each_has_its_offset_and_its_start() {
    let (input, output) = step_test(1.2, |t| 1.0 - libm::exp(-t / 2.0), 0.25, 160);
    let moving: Vec<f64> = (output.iter().enumerate())
        .map(|(k, y)| y - 50.0 + 3.0 * libm::exp(-(k as f64) * SAMPLE_TIME / 2.0))
        .collect();
    let outputs = [with_noise(&output, 11, 0.01), with_noise(&moving, 12, 0.01)];
    let runs = outputs.iter().map(|outputs| Run {
        past: &[],
        inputs: &input,
        outputs,
    });
    let structure = Structure {
        start: planesman_identification::InitialState::Estimated,
        ..Structure::of_order(1)
    };
    let problem =
        planesman_identification::Problem::new(structure, SAMPLE_TIME, runs.collect()).unwrap();
    let estimator = Method::Process.estimator(&Knowledge {
        process: Some(Form::First),
        ..Knowledge::default()
    });
    let found = estimator.fit(&problem).unwrap();
    for (value, truth) in found
        .process
        .iter()
        .flat_map(|it| it.values.iter())
        .zip([1.2, 2.0, 0.25])
    {
        assert!((value / truth - 1.0).abs() < 0.02, "{value} {truth}");
    }
    for (run, outputs) in outputs.iter().enumerate() {
        let simulated = found.simulate(run, problem.runs[run]);
        let worst = outputs
            .iter()
            .zip(&simulated)
            .map(|(y, x)| (y - x).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.05, "{run}: {worst}");
    }
}

/// A motor's position, 8/(s (0.12 s + 1)), with a constant beside its input: a model with a pole at z = 1 has a constant at its output
/// alone, and followed the drift by its poles.
#[test]
fn the_default_finds_an_integrator_with_a_constant_at_its_input() {
    let step = 0.01;
    let decay = libm::exp(-step / 0.12);
    for (seed, count) in [(13, 2000), (14, 1500)] {
        let signs = noise(seed, count / 50);
        let input: Vec<f64> = (0..count).map(|k| 0.5 * signs[k / 50].signum()).collect();
        let (mut position, mut rate) = (0.0, 0.0);
        let output: Vec<f64> = input
            .iter()
            .map(|u| {
                let before = position;
                let steady = 8.0 * (u + 0.067);
                position += steady * step + (rate - steady) * 0.12 * (1.0 - decay);
                rate = steady + (rate - steady) * decay;
                before
            })
            .collect();
        let output = with_noise(&output, seed + 100, 0.05);
        let of = Record::of_run(step, vec![("u", input)], vec![("y", output)]).unwrap();
        let found = analyse(&of, &Options::default()).unwrap();
        let verdict = found.verdict.to_string();
        assert!(verdict.starts_with("verdict: good"), "{}", found.text());
        assert_eq!(model(&found).form, Form::IntegratorWithLag);
        let gain = model(&found).values[0];
        assert!((gain / 8.0 - 1.0).abs() < 0.01, "{}", found.text());
    }
}
