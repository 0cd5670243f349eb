//! The search for the least output error, beside a method that reaches the same optimum without a search: refined
//! instrumental variables (SRIV; Young, *Recursive Estimation and Time-Series Analysis*, 2nd ed., 2011, ch. 6).
//!
//! ```text
//! A y_f = B u_f + offset + M h + e,   y_f = y/A, u_f = u/A, h = impulse/A, from rest
//! phi = [-y_f(k-i), u_f(k-j), 1, h(k-i)]      zeta = phi with x_f = x/A in place of y_f
//! theta = (sum zeta phi')^-1 sum zeta y_f
//! ```
//! `x` is the model's own simulated output; filter and instruments are made of the estimate before, until nothing
//! changes. `zeta` is the slope of the simulated output, so what it settles at is a stationary point of the output error.

#![allow(clippy::unwrap_used)]

use nalgebra::{DMatrix, DVector};
use planesman_linear::Complex;
use planesman_record::{Run, filter, with_noise};

use crate::common::{A, SAMPLE_TIME, clean, pulses};
use crate::error::{IdentificationError, Result};
use crate::estimators::OutputError;
use crate::estimators::estimate::Estimate;
use crate::estimators::estimator::{Estimator, Recursive};
use crate::estimators::recursive::{self, Kind};
use crate::estimators::simulator::Simulator;
use crate::estimators::starts::starts;
use crate::structure::{InitialState, Problem, Structure};
use crate::uncertainty::Reading;

/// Rounds at most; fewer than ten are usual.
const ROUNDS: usize = 100;
/// A round that changes no parameter by more than this share of the largest of its kind is the last.
const SETTLED: f64 = 1e-7;
/// Halvings of a step that leads uphill before the rounds are given up.
const HALVINGS: usize = 20;

/// Refined instrumental variables (SRIV).
#[derive(Clone, Copy, Debug)]
struct Instruments;

impl Estimator for Instruments {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let simulator = Simulator::new(problem);
        let (theta, at) = starts(self, problem, &simulator)?
            .into_iter()
            .filter_map(|start| settle(problem, &simulator, start))
            .map(|theta| {
                let at = simulator.linearised(&theta);
                (theta, at)
            })
            .min_by(|p, q| p.1.cost().total_cmp(&q.1.cost()))
            .ok_or(IdentificationError::Search(
                "the instrumental variables settle nowhere",
            ))?;
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}

/// The rounds of instruments from a start; `None` when they settle nowhere.
fn settle(
    problem: &Problem<'_>,
    simulator: &Simulator<'_>,
    start: DVector<f64>,
) -> Option<DVector<f64>> {
    let n = problem.structure.poles;
    let mut theta = start;
    let mut least = simulator.linearised(&theta).cost();
    for _ in 0..ROUNDS {
        let mut step = round(problem, simulator, &theta)? - &theta;
        let change = |range: std::ops::Range<usize>| {
            let largest = theta.as_slice()[range.clone()]
                .iter()
                .fold(1e-300_f64, |m, v| m.max(v.abs()));
            step.as_slice()[range]
                .iter()
                .fold(0.0_f64, |m, v| m.max(v.abs()))
                / largest
        };
        if change(0..n).max(change(n..theta.len())) < SETTLED {
            return Some(theta);
        }
        // The step points downhill, but may lead beyond the valley.
        let mut halvings = 0;
        loop {
            let next = &theta + &step;
            let there = simulator.linearised(&next).cost();
            if there <= least * (1.0 + 1e-9) {
                (theta, least) = (next, there);
                break;
            }
            if halvings == HALVINGS {
                return None;
            }
            step *= 0.5;
            halvings += 1;
        }
    }
    None
}

/// One round: filter and instruments from `theta`, new parameters out.
fn round(
    problem: &Problem<'_>,
    simulator: &Simulator<'_>,
    theta: &DVector<f64>,
) -> Option<DVector<f64>> {
    let n = problem.structure.poles;
    let instruments = simulator.linearised(theta).slopes;
    let mut phi = instruments.clone();
    let mut outputs = DVector::zeros(phi.nrows());
    let a = simulator.denominator(theta);
    let mut first = 0;
    let layout = problem.layout();
    for (r, run) in problem.runs.iter().enumerate() {
        // Without the offset found so far, which 1/A would blow up; the next is its correction.
        let offset = layout.offset(r).map_or(0.0, |at| theta[at]);
        let y: Vec<f64> = run.outputs.iter().map(|y| y - offset).collect();
        let y = filter(&[1.0], &a, &y);
        for (k, value) in y.iter().enumerate() {
            outputs[first + k] = *value;
            for i in 1..=n {
                phi[(first + k, i - 1)] = if k >= i { -y[k - i] } else { 0.0 };
            }
        }
        first += y.len();
    }
    if phi.iter().chain(instruments.iter()).any(|v| !v.is_finite()) {
        return None;
    }
    // Q of the instruments in their place: the same equations, not squared.
    let q: DMatrix<f64> = instruments.qr().q();
    let mut found = q.tr_mul(&phi).lu().solve(&q.tr_mul(&outputs))?;
    for at in (0..problem.runs.len()).filter_map(|run| layout.offset(run)) {
        found[at] += theta[at];
    }
    found.iter().all(|v| v.is_finite()).then_some(found)
}

fn fit(
    estimator: &dyn Estimator,
    structure: Structure,
    records: &[(Vec<f64>, Vec<f64>)],
) -> Estimate {
    let runs = records
        .iter()
        .map(|(inputs, outputs)| Run {
            inputs,
            outputs,
            ..Run::default()
        })
        .collect();
    estimator
        .fit(&Problem::new(structure, SAMPLE_TIME, runs).unwrap())
        .unwrap()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max)
}

/// Four pulses of 2.5 s without a pause, as the thesis' run 7/5 has them.
fn long_pulses() -> Vec<f64> {
    let mut pulses = vec![0.0; 300];
    for (at, level) in [(20, 0.2), (70, -0.2), (120, 0.2), (170, -0.2)] {
        pulses[at..at + 50].fill(level);
    }
    pulses
}

/// A gyro's noise beside them.
const NOISE: f64 = 0.005;

/// Second order with a zero at z = 1: poles 0.95 and 0.8.
fn second_order(inputs: &[f64]) -> Vec<f64> {
    filter(&[0.0, 0.1, -0.1], &[1.0, -1.75, 0.76], inputs)
}

#[test]
fn instrumental_variables_and_output_error_reach_the_same_model_by_different_roads() {
    for seed in 0..5 {
        let planes = long_pulses();
        let record = [(
            planes.clone(),
            with_noise(&second_order(&planes), seed, NOISE),
        )];
        let structure = Structure::of_order(2).with_zero_at_one();
        let search = fit(&OutputError, structure.clone(), &record);
        let rounds = fit(&Instruments, structure, &record);
        let off = distance(search.theta.as_slice(), rounds.theta.as_slice());
        assert!(off < 1e-5, "seed {seed}: {off:e}");
        let poles = Reading::new(&search, 0).poles().unwrap();
        for (pole, true_pole) in poles.iter().zip([0.95, 0.8]) {
            let off = (pole.value.re - true_pole).abs() / pole.real_deviation();
            assert!(off < 4.0, "seed {seed}: {off} deviations");
        }
    }
}

#[test]
fn both_find_a_record_that_begins_in_motion() {
    let record = [(pulses()[30..].to_vec(), clean()[30..].to_vec())];
    let structure = Structure {
        start: InitialState::Estimated,
        ..Structure::of_order(3)
    };
    for method in [&OutputError as &dyn Estimator, &Instruments] {
        let off = distance(&fit(method, structure.clone(), &record).model(0).a, &A[1..]);
        assert!(off < 1e-4, "{method:?}: {off:e}");
    }
}

#[test]
fn both_find_the_poles_that_records_share_and_the_numerators_that_they_do_not() {
    let doubled: Vec<f64> = clean().iter().map(|y| 2.0 * y).collect();
    let records = [(pulses(), clean()), (pulses(), doubled)];
    let structure = Structure {
        own_numerators: true,
        ..Structure::of_order(3)
    };
    for method in [&OutputError as &dyn Estimator, &Instruments] {
        let found = fit(method, structure.clone(), &records);
        let ratio = found.model(1).b[0] / found.model(0).b[0];
        assert!((ratio - 2.0).abs() < 1e-4, "{method:?}: {ratio}");
        assert!(distance(&found.model(0).a, &A[1..]) < 1e-4, "{method:?}");
        assert_eq!(found.residuals.len(), 2);
    }
}

#[test]
fn both_keep_a_known_integrator_and_a_delay() {
    // 0.02 q^-3 / ((1 - q^-1)(1 - 0.9 q^-1))
    let outputs = filter(&[0.0, 0.0, 0.0, 0.02], &[1.0, -1.9, 0.9], &pulses());
    let structure = Structure {
        delay: 3,
        numerator: 1,
        ..Structure::of_order(2)
    }
    .with_integrator();
    for method in [&OutputError as &dyn Estimator, &Instruments] {
        let found = fit(method, structure.clone(), &[(pulses(), outputs.clone())]);
        let model = found.model(0);
        assert!(distance(&model.a, &[-1.9, 0.9, 0.0]) < 1e-6, "{method:?}");
        assert!(distance(&model.b, &[0.0, 0.0, 0.02]) < 1e-7, "{method:?}");
        let poles = Reading::new(&found, 0).poles().unwrap();
        assert_eq!(poles[1].value, Complex::new(1.0, 0.0));
        assert_eq!(poles[1].real_deviation(), 0.0);
    }
}

#[test]
fn noise_draws_the_instruments_nowhere() {
    const RECORDS: u32 = 20;
    let planes = long_pulses();
    let poles: Vec<f64> = (0..RECORDS)
        .map(|seed| {
            let outputs = with_noise(&second_order(&planes), 7 + 1000 * seed, NOISE);
            let structure = Structure::of_order(2).without_offset();
            let found = fit(&Instruments, structure, &[(planes.clone(), outputs)]);
            Reading::new(&found, 0).poles().unwrap()[1].value.re
        })
        .collect();
    let mean = poles.iter().sum::<f64>() / f64::from(RECORDS);
    let squares: f64 = poles.iter().map(|pole| (pole - mean).powi(2)).sum();
    let off = (mean - 0.8) / (squares / f64::from(RECORDS) / f64::from(RECORDS)).sqrt();
    assert!(off.abs() < 4.0, "{mean}: {off} deviations");
}
