//! Step responses of a known system: of its model, and from the data alone.

use planesman_identification::estimators::{Estimator, OutputError, StepResponse};
use planesman_identification::{InitialState, Problem, Reading, Run, Structure, filter, noise};

const SAMPLE_TIME: f64 = 0.05;
/// 2/(s^2 + 1.5 s + 2) at 20 Hz, the input held.
const B: [f64; 2] = [0.002_437_626, 0.002_377_438];
const A: [f64; 3] = [1.0, -1.922_928_422, 0.927_743_486];
/// Samples before the first effect of an input.
const DELAY: usize = 12;
/// Samples in which the response settles.
const LENGTH: usize = 200;
/// Standard deviations within which every point is to lie: of some sixty, one beyond 4 comes once in five hundred times.
const SIGMAS: f64 = 4.0;

fn numerator() -> Vec<f64> {
    [&[0.0; DELAY][..], &B].concat()
}

fn truth() -> Vec<f64> {
    filter(&numerator(), &A, &[1.0; LENGTH])
}

/// A PRBS about 5 and the output about 40, in motion from before the record began, with noise of a colour.
fn record(seed: u32, samples: usize) -> (Vec<f64>, Vec<f64>) {
    let before = 300;
    let levels = noise(seed, (samples + before) / 10 + 1);
    let inputs: Vec<f64> = (0..samples + before)
        .map(|k| 5.0 + levels[k / 10].signum())
        .collect();
    let slow = filter(&[0.02], &[1.0, -0.8], &noise(seed + 100, inputs.len()));
    let outputs = filter(&numerator(), &A, &inputs);
    let outputs = outputs.iter().zip(slow).map(|(y, e)| y + e + 35.0);
    (inputs[before..].to_vec(), outputs.skip(before).collect())
}

/// The problem of two records, the second with another offset.
fn with_problem(samples: usize, test: impl FnOnce(&Problem<'_>)) {
    let (first, mut second) = (record(1, samples), record(2, samples));
    second.1.iter_mut().for_each(|y| *y -= 20.0);
    let run = |(inputs, outputs): &(Vec<f64>, Vec<f64>)| {
        assert_eq!(inputs.len(), outputs.len());
        (inputs.clone(), outputs.clone())
    };
    let all = [run(&first), run(&second)];
    let runs = all.iter().map(|(inputs, outputs)| Run {
        inputs,
        outputs,
        ..Run::default()
    });
    let structure = Structure {
        delay: DELAY,
        start: InitialState::Estimated,
        ..Structure::of_order(2)
    };
    test(&Problem::new(structure, SAMPLE_TIME, runs.collect()).expect("a problem"));
}

#[test]
fn without_a_model_it_is_the_true_one_with_offset_delay_and_coloured_noise() {
    with_problem(1500, |problem| {
        let found = StepResponse::new(problem, LENGTH).expect("a response");
        let truth = truth();
        assert!(found.points.len() >= 40, "{}", found.points.len());
        let last = found.points.last().expect("points");
        assert!(last.0 + 10 > LENGTH && last.2 < 0.05, "{last:?}");
        for (k, value, deviation) in &found.points {
            let off = (value - truth[*k]).abs();
            assert!(
                off < SIGMAS * deviation + 2e-3,
                "{k}: {value} ± {deviation}, {}",
                truth[*k]
            );
        }
    });
}

#[test]
fn that_of_the_model_has_the_truth_within_its_band_and_the_slopes_of_differences() {
    with_problem(1500, |problem| {
        let estimate = OutputError.fit(problem).expect("an estimate");
        let found = Reading::new(&estimate, 0).uncertain_step_response(LENGTH);
        for (k, (truth, (value, deviation))) in truth().iter().zip(&found).enumerate() {
            let off = (value - truth).abs();
            assert!(
                off <= SIGMAS * deviation + 1e-12,
                "{k}: {value} ± {deviation}, {truth}"
            );
        }
        // To first order the deviation is that of the covariance carried by differences of the response.
        let count = estimate.theta.len();
        let (at, step) = (60, 1e-7);
        let slopes: Vec<f64> = (0..count)
            .map(|i| {
                let mut moved = estimate.clone();
                moved.theta[i] += step;
                (Reading::new(&moved, 0).step_response(LENGTH)[at] - found[at].0) / step
            })
            .collect();
        let variance: f64 = (0..count)
            .flat_map(|i| (0..count).map(move |j| (i, j)))
            .map(|(i, j)| slopes[i] * estimate.covariance[(i, j)] * slopes[j])
            .sum();
        assert!(
            (variance.sqrt() / found[at].1 - 1.0).abs() < 1e-3,
            "{variance} {:?}",
            found[at]
        );
    });
}

#[test]
fn records_shorter_than_the_response_are_refused() {
    with_problem(150, |problem| {
        let refusal = StepResponse::new(problem, LENGTH).expect_err("too short");
        assert!(refusal.to_string().contains("200 samples"), "{refusal}");
    });
}
