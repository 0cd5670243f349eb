//! Records simulated with any parameters: the output error and its slopes.
//!
//! ```text
//! x = (B/A) u + (M/A) impulse,   yhat = x + offset,   e = y - yhat
//! dyhat/da_i = -q^-i x / A,   dyhat/db_j = q^-j u / A,   dyhat/dm_i = q^-i impulse / A
//! ```
//! `u` has been through what is known and delayed; `M` is there for a record that begins in motion.

use nalgebra::{DMatrix, DVector};

use super::estimate::{Error, Estimate};
use super::levenberg_marquardt::{Linearised, unit_covariance};
use super::rows::{freedom, impulse, samples_by_run};
use crate::error::Result;
use crate::structure::{Layout, Problem, filter};

/// The records, ready to be simulated with any parameters.
pub(super) struct Simulator<'a> {
    problem: &'a Problem<'a>,
    layout: Layout,
    driving: Vec<Vec<f64>>,
    rows: usize,
}

impl<'a> Simulator<'a> {
    pub(super) fn new(problem: &'a Problem<'a>) -> Self {
        Self {
            problem,
            layout: problem.layout(),
            driving: problem.driving(),
            rows: problem.runs.iter().map(|run| run.outputs.len()).sum(),
        }
    }

    /// `B/A u` of a record, without offset and motion.
    pub(super) fn caused(&self, theta: &DVector<f64>, run: usize) -> Vec<f64> {
        let b: Vec<f64> = theta.as_slice()[self.layout.b(run)].to_vec();
        filter(&b, &self.denominator(theta), &self.driving[run])
    }

    /// `1, a1 ... an`.
    pub(super) fn denominator(&self, theta: &DVector<f64>) -> Vec<f64> {
        let mut a = vec![1.0];
        a.extend(&theta.as_slice()[self.layout.a()]);
        a
    }

    /// `y - yhat` and its slopes, all records one below the other.
    pub(super) fn linearised(&self, theta: &DVector<f64>) -> Linearised {
        let mut errors = DVector::zeros(self.rows);
        let mut slopes = DMatrix::zeros(self.rows, self.layout.count());
        let a = self.denominator(theta);
        let mut first = 0;
        for (r, run) in self.problem.runs.iter().enumerate() {
            let count = run.outputs.len();
            let motion: Vec<f64> = theta.as_slice()[self.layout.motion(r)].to_vec();
            let impulse = impulse(count);
            let mut x = self.caused(theta, r);
            for (x, m) in x.iter_mut().zip(filter(&motion, &a, &impulse)) {
                *x += m;
            }
            let offset = self.layout.offset(r);
            for k in 0..count {
                errors[first + k] = run.outputs[k] - x[k] - offset.map_or(0.0, |at| theta[at]);
            }
            let mut column = |at: usize, delay: usize, sign: f64, values: &[f64]| {
                for k in delay..count {
                    slopes[(first + k, at)] += sign * values[k - delay];
                }
            };
            let x = filter(&[1.0], &a, &x);
            for (i, at) in self.layout.a().enumerate() {
                column(at, i + 1, -1.0, &x);
            }
            let driving = filter(&[1.0], &a, &self.driving[r]);
            for (j, at) in self.layout.b(r).enumerate() {
                column(at, j, 1.0, &driving);
            }
            if let Some(at) = offset {
                column(at, 0, 1.0, &vec![1.0; count]);
            }
            let impulse = filter(&[1.0], &a, &impulse);
            for (i, at) in self.layout.motion(r).enumerate() {
                column(at, i, 1.0, &impulse);
            }
            first += count;
        }
        Linearised { errors, slopes }
    }

    /// The estimate at `theta`.
    pub(super) fn estimate(&self, theta: DVector<f64>, at: &Linearised) -> Result<Estimate> {
        let freedom = freedom(at.errors.len(), theta.len())?;
        let noise_variance = at.errors.norm_squared() / freedom;
        Ok(Estimate {
            error: Error::Output,
            layout: self.layout.clone(),
            sample_time: self.problem.sample_time,
            covariance: unit_covariance(at)? * noise_variance,
            noise_variance,
            noise_model: Vec::new(),
            residuals: samples_by_run(self.problem, at.errors.as_slice()),
            theta,
            physical: None,
        })
    }
}
