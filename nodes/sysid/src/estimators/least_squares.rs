//! Least squares on the equation error, over whole records by QR.
//!
//! ```text
//! y_k = -a1 y_(k-1) - ... - an y_(k-n) + b1 u_(k-d) + ... + bm u_(k-d-m+1) + constant
//! ```
//! Rows begin where a whole history exists; none is invented, so records may begin in motion.
//! What measurement noise does to it is the point of every other method here: the noise in
//! `y_(k-i)` draws the poles towards a smoother's (Brunner 1988, Table 9: roots near -0.4).

use nalgebra::{DMatrix, DVector};

use super::recursive::{Kind, Recursive};
use super::{Error, Estimate, Estimator, recursion};
use crate::batch::Triangle;
use crate::structure::Problem;

/// Least squares on the equation error, as the thesis.
#[derive(Clone, Copy, Debug)]
pub struct LeastSquares;

impl Estimator for LeastSquares {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate, String> {
        let (phi, outputs) = regression(problem);
        let triangle = Triangle::of(&phi, &outputs)?;
        let theta = triangle.solution()?;
        let noise_variance = triangle.cost / freedom(triangle.rows, theta.len())?;
        let residuals = outputs - phi * &theta;
        Ok(Estimate {
            error: Error::Equation,
            layout: problem.layout(),
            sample_time: problem.sample_time,
            covariance: triangle.unit_covariance()? * noise_variance,
            noise_variance,
            noise_model: Vec::new(),
            residuals: by_run(problem, residuals.as_slice()),
            theta,
            physical: None,
        })
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>, String> {
        recursion(Kind::LeastSquares, problem)
    }
}

/// Rows beyond the parameters.
pub(crate) fn freedom(rows: usize, parameters: usize) -> Result<f64, String> {
    match rows.checked_sub(parameters) {
        Some(freedom) if freedom > 0 => Ok(freedom as f64),
        _ => Err(format!(
            "{rows} rows leave nothing to judge {parameters} parameters by"
        )),
    }
}

/// `Phi` and `y` of all records, one below the other.
pub(crate) fn regression(problem: &Problem<'_>) -> (DMatrix<f64>, DVector<f64>) {
    let layout = problem.layout();
    let (n, first) = (layout.structure.poles, layout.structure.history());
    let rows: usize = problem
        .runs
        .iter()
        .map(|run| run.outputs.len().saturating_sub(first))
        .sum();
    let mut phi = DMatrix::zeros(rows, layout.without_motion());
    let mut outputs = DVector::zeros(rows);
    let mut row = 0;
    for (r, (run, driving)) in problem.runs.iter().zip(problem.driving()).enumerate() {
        for k in first..run.outputs.len() {
            for i in 1..=n {
                phi[(row, i - 1)] = -run.outputs[k - i];
            }
            for (j, at) in layout.b(r).enumerate() {
                phi[(row, at)] = driving[k - j];
            }
            if let Some(at) = layout.offset(r) {
                phi[(row, at)] = 1.0;
            }
            outputs[row] = run.outputs[k];
            row += 1;
        }
    }
    (phi, outputs)
}

/// Numbers, one per row, as each record's.
pub(crate) fn by_run(problem: &Problem<'_>, rows: &[f64]) -> Vec<Vec<f64>> {
    let first = problem.structure.history();
    let mut rest = rows;
    problem
        .runs
        .iter()
        .map(|run| {
            let count = run.outputs.len().saturating_sub(first).min(rest.len());
            let (own, others) = rest.split_at(count);
            rest = others;
            own.to_vec()
        })
        .collect()
}
