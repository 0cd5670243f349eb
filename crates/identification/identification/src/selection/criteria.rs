//! Order and delay for any estimator, by information criteria and held-out data. [`select`](super::select) needs a candidate's normal
//! equations, which not every estimator has.
//!
//! Every candidate is fitted to the first part of each record, and validated on the rest by simulation. For the criteria it is fitted to all data
//! (Ljung 1999, sec. 16.4)
//! ```text
//! AIC = N ln V + 2 p,   BIC = N ln V + p ln N,   V = mean of the squared residuals
//! ```
//! N the rows, p the parameters. A one-step fit always grows with the order, but these criteria can fall.

use serde::Serialize;

use crate::estimators::Estimator;
use crate::structure::{Problem, Structure};
use planesman_record::Run;

/// The share of each record to which candidates are fitted before validation on the rest.
pub const FITTED_SHARE: f64 = 0.7;

/// A difference of the BIC below which two candidates are equally good (Kass and Raftery, *J. Amer. Statist. Assoc.* 90, 1995, call it
/// hardly worth a mention).
const AS_GOOD: f64 = 2.0;

/// Percentage points by which a candidate's held-out fit may be below the best fit.
const WORSE: f64 = 3.0;

/// One candidate with its criteria.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Number of poles, not counting known poles.
    pub order: usize,
    /// Samples from input to first effect.
    pub delay: usize,
    /// Parameters.
    pub parameters: usize,
    /// Akaike's criterion.
    pub aic: f64,
    /// The Bayesian criterion.
    pub bic: f64,
    /// The simulated fit on held-out data, %; `None` if the output is constant there.
    pub held_out_fit: Option<f64>,
}

/// The candidates, lowest BIC first. Candidates that the records do not determine are left out.
#[must_use]
pub fn search(
    problem: &Problem<'_>,
    estimator: &dyn Estimator,
    structures: impl Iterator<Item = Structure>,
) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = structures
        .filter_map(|structure| candidate(problem, estimator, structure))
        .collect();
    candidates.sort_by(|p, q| p.bic.total_cmp(&q.bic));
    candidates
}

fn candidate(
    problem: &Problem<'_>,
    estimator: &dyn Estimator,
    structure: Structure,
) -> Option<Candidate> {
    let (order, delay) = (structure.poles, structure.delay);
    let of = |runs: Vec<Run<'_>>| {
        let problem = Problem::new(structure.clone(), problem.sample_time, runs).ok()?;
        estimator.fit(&problem).ok()
    };
    let whole = of(problem.runs.clone())?;
    let rows: usize = whole.residuals.iter().map(Vec::len).sum();
    let cost: f64 = whole.residuals.iter().flatten().map(|e| e * e).sum();
    let parameters = whole.theta.len() + whole.noise_model.len();
    let n = rows as f64;
    let likelihood = n * libm::log((cost / n).max(f64::MIN_POSITIVE));
    let fitted: Vec<Run<'_>> = problem.runs.iter().map(|run| first_part(run)).collect();
    let held_out_fit = of(fitted.clone()).and_then(|part| {
        let fits: Vec<f64> = problem
            .runs
            .iter()
            .zip(&fitted)
            .enumerate()
            .filter_map(|(r, (run, fitted))| part.simulated_fit(r, *run, fitted.outputs.len()))
            .collect();
        (!fits.is_empty()).then(|| fits.iter().sum::<f64>() / fits.len() as f64)
    });
    Some(Candidate {
        order,
        delay,
        parameters,
        aic: likelihood + 2.0 * parameters as f64,
        bic: likelihood + parameters as f64 * libm::log(n),
        held_out_fit,
    })
}

/// The part of a record that candidates are fitted to.
#[must_use]
pub fn first_part<'a>(run: &Run<'a>) -> Run<'a> {
    let kept = (run.outputs.len() as f64 * FITTED_SHARE) as usize;
    Run {
        inputs: &run.inputs[..kept],
        outputs: &run.outputs[..kept],
        ..*run
    }
}

/// Chooses the order: among candidates that simulate held-out data nearly as well as the best, and whose BIC equals the lowest of these within a margin, the
/// candidate with the fewest parameters.
#[must_use]
pub fn choice(candidates: &[Candidate]) -> Option<&Candidate> {
    let fits = candidates.iter().filter_map(|of| of.held_out_fit);
    let largest = fits.fold(f64::NEG_INFINITY, f64::max);
    let simulates = |of: &&Candidate| {
        largest == f64::NEG_INFINITY || of.held_out_fit.is_some_and(|fit| fit >= largest - WORSE)
    };
    let best = candidates.iter().find(simulates)?.bic;
    candidates
        .iter()
        .filter(simulates)
        .filter(|candidate| candidate.bic - best < AS_GOOD)
        .min_by_key(|candidate| candidate.parameters)
}
