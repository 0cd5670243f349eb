//! Refined instrumental variables: least squares with noisy regressors, made consistent by
//! instruments that are not.
//!
//! ```text
//! A y_f = B u_f + offset + M h + e,   y_f = y/A, u_f = u/A, h = impulse/A, from rest
//! phi = [-y_f(k-i), u_f(k-j), 1, h(k-i)]      zeta = phi with x_f = x/A in place of y_f
//! theta = (sum zeta phi')^-1 sum zeta y_f
//! ```
//! `x` is the model's own simulated output; filter and instruments are made of the estimate before,
//! until nothing changes (Young, *Recursive Estimation and Time-Series Analysis*, 2nd ed., 2011,
//! ch. 6: SRIV). `zeta` is the slope of the simulated output, so what it settles at is
//! a stationary point of the output error ([`super::output_error`]), reached without a search.

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::recursive::{self, Kind};
use super::simulator::Simulator;
use super::starts::{cost, starts};
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;
use planesman_record::filter;

/// Rounds at most; fewer than ten are usual.
const ROUNDS: usize = 100;
/// A round that changes no parameter by more than this share of the largest of its kind is the last.
const SETTLED: f64 = 1e-7;
/// Halvings of a step that leads uphill before the rounds are given up.
const HALVINGS: usize = 20;

/// Refined instrumental variables (SRIV).
#[derive(Clone, Copy, Debug)]
pub struct Instruments;

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
            .min_by(|p, q| cost(&p.1).total_cmp(&cost(&q.1)))
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
    let mut least = cost(&simulator.linearised(&theta));
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
            let there = cost(&simulator.linearised(&next));
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
