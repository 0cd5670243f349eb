//! ARMAX: the difference equation with a model of its noise.
//!
//! ```text
//! A y = B u + constant + C e,   C = 1 + c1 q^-1 + ... + cn q^-n
//! ```
//! Noise on the gyro alone is `C = A`, which this contains. The search starts with iterated extended least squares: each round regresses on the
//! residuals of the previous round. Then the one-step prediction error is minimised (Ljung 1999, sec. 7.2 and 10.2).

use nalgebra::DVector;

use super::equation::Equation;
use super::estimate::{Error, Estimate};
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::{minimise, unit_factor};
use super::output_error::OutputError;
use super::recursive::{self, Kind};
use super::rows::{freedom, rows_by_run};
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;

/// Initial roots of C, as a factor of the roots of A.
const NOISE_ROOT_SHARE: f64 = 0.98;

/// ARMAX: the equation error with a model of the noise.
#[derive(Clone, Copy, Debug)]
pub struct Armax;

impl Estimator for Armax {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let model = Equation::of(problem);
        let starts = match problem.part() {
            Some(part) => vec![model.continued(&self.fit(&part)?)],
            None => {
                let mut starts = model.starts()?;
                starts.extend(of_simulation(problem));
                starts
            }
        };
        let (theta, at) = starts
            .into_iter()
            .filter_map(|start| minimise(start, |theta| model.linearised(theta)).ok())
            .min_by(|p, q| {
                p.1.errors
                    .norm_squared()
                    .total_cmp(&q.1.errors.norm_squared())
            })
            .ok_or(IdentificationError::Search(
                "the search for the smallest prediction error found no minimum",
            ))?;
        let noise_variance = at.errors.norm_squared() / freedom(at.errors.len(), theta.len())?;
        let factor = unit_factor(&at)? * noise_variance.sqrt();
        let plain = problem.layout().without_motion();
        let factor = factor.rows(0, plain).into_owned();
        let residuals = rows_by_run(problem, at.errors.as_slice());
        let noise_model = theta.rows(plain, problem.structure.poles);
        let noise_model = noise_model.iter().copied().collect();
        let theta = theta.rows(0, plain).into_owned();
        let error = Error::Equation;
        Ok(Estimate {
            noise_model,
            ..Estimate::of(problem, error, theta, factor, noise_variance, residuals)
        })
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::PredictionError, problem)
    }
}

/// The start for noise on the gyro alone: the best simulation, with `C` near `A`.
fn of_simulation(problem: &Problem<'_>) -> Option<DVector<f64>> {
    let n = problem.structure.poles;
    let plain = problem.layout().without_motion();
    let simulation = OutputError.fit(problem).ok()?;
    let mut theta = simulation.theta.rows(0, plain).into_owned();
    let a: Vec<f64> = theta.rows(0, n).iter().copied().collect();
    let steady = 1.0 + a.iter().sum::<f64>();
    for run in 0..problem.runs.len() {
        if let Some(at) = simulation.layout.offset(run) {
            theta[at] *= steady;
        }
    }
    let theta = theta.insert_rows(plain, n, 0.0);
    // Roots of C a little inside those of A: c_i = rho^i a_i.
    Some(DVector::from_fn(plain + n, |i, _| {
        match i.checked_sub(plain) {
            Some(i) => NOISE_ROOT_SHARE.powi(i as i32 + 1) * a[i],
            None => theta[i],
        }
    }))
}
