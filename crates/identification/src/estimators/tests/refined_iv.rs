//! The search for the least output error, beside a method that reaches the same optimum without a search: refined
//! instrumental variables (SRIV; Young, *Recursive Estimation and Time-Series Analysis*, 2nd ed., 2011, ch. 6).
//!
//! ```text
//! A y_f = B u_f + offset + e,   y_f = y/A, u_f = u/A, from rest
//! phi = [-y_f(k-i), u_f(k-j), 1]      zeta = phi with x_f = x/A in place of y_f
//! theta = (sum zeta phi')^-1 sum zeta y_f
//! ```
//! `x` is the model's own simulated output; filter and instruments are made of the estimate before, until nothing
//! changes. `zeta` is the slope of the simulated output, so what it settles at is a stationary point of the output error.

#![allow(clippy::unwrap_used)]

use nalgebra::DVector;
use planesman_record::{Run, filter, with_noise};

use crate::common::{SAMPLE_TIME, pulses};
use crate::estimators::simulator::Simulator;
use crate::estimators::starts::starts;
use crate::estimators::{Estimator, OutputError};
use crate::structure::{Problem, Structure};
use crate::uncertainty::Reading;

/// Rounds at most.
const ROUNDS: usize = 100;

/// Where the rounds of instrumental variables lead from the best start.
fn settled(problem: &Problem<'_>) -> DVector<f64> {
    let simulator = Simulator::new(problem);
    let mut theta = starts(&OutputError, problem, &simulator).unwrap().remove(0);
    for _ in 0..ROUNDS {
        let next = round(problem, &simulator, &theta);
        let change = (&next - &theta).norm();
        theta = next;
        if change < 1e-9 * theta.norm() {
            return theta;
        }
    }
    panic!("the instrumental variables settle nowhere");
}

/// One round: filter and instruments from `theta`, new parameters out.
fn round(problem: &Problem<'_>, simulator: &Simulator<'_>, theta: &DVector<f64>) -> DVector<f64> {
    let at = problem.layout().offset(0).unwrap();
    let instruments = simulator.linearised(theta).slopes;
    // Without the offset so far, which 1/A would blow up; the next is its correction.
    let y: Vec<f64> = (problem.runs[0].outputs.iter())
        .map(|y| y - theta[at])
        .collect();
    let y = filter(&[1.0], &simulator.denominator(theta), &y);
    let mut phi = instruments.clone();
    for i in 1..=problem.structure.poles {
        for k in 0..y.len() {
            phi[(k, i - 1)] = if k >= i { -y[k - i] } else { 0.0 };
        }
    }
    let products = instruments.tr_mul(&phi);
    let mut next = (products.lu())
        .solve(&instruments.tr_mul(&DVector::from_vec(y)))
        .unwrap();
    next[at] += theta[at];
    next
}

#[test]
fn instrumental_variables_and_output_error_reach_the_same_model_by_different_roads() {
    let inputs = pulses();
    // Poles 0.95 and 0.8, a zero at z = 1.
    let clean = filter(&[0.0, 0.1, -0.1], &[1.0, -1.75, 0.76], &inputs);
    for seed in 0..5 {
        let outputs = with_noise(&clean, seed, 0.0005);
        let structure = Structure::of_order(2).with_zero_at_one();
        let runs = vec![Run {
            inputs: &inputs,
            outputs: &outputs,
        }];
        let problem = Problem::new(structure, SAMPLE_TIME, runs).unwrap();
        let search = OutputError.fit(&problem).unwrap();
        let off = (&search.theta - settled(&problem)).amax();
        assert!(off < 1e-5, "seed {seed}: {off:e}");
        let poles = Reading::new(&search, 0).poles().unwrap();
        for (pole, true_pole) in poles.iter().zip([0.95, 0.8]) {
            let off = (pole.value.re - true_pole).abs() / pole.real_deviation();
            assert!(off < 4.0, "seed {seed}: {off} deviations");
        }
    }
}
