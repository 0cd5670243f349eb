//! Least squares on the equation error, over whole records by QR.
//!
//! ```text
//! y_k = -a1 y_(k-1) - ... - an y_(k-n) + b1 u_(k-d) + ... + bm u_(k-d-m+1) + constant
//! ```
//! Rows begin where a complete history exists, so records may begin in motion. Unlike in the other methods here, measurement noise biases the estimate:
//! the noise in `y_(k-i)` pulls the poles towards a smoother's (Brunner 1988, Table 9: roots near -0.4).

use super::estimate::{Error, Estimate};
use super::estimator::{Estimator, Recursive};
use super::recursive::{self, Kind};
use super::rows::{freedom, regression, rows_by_run};
use crate::batch::Triangle;
use crate::error::Result;
use crate::structure::Problem;

/// Least squares on the equation error, as in the thesis.
#[derive(Clone, Copy, Debug)]
pub struct LeastSquares;

impl Estimator for LeastSquares {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let (phi, outputs) = regression(problem);
        let triangle = Triangle::new(&phi, &outputs)?;
        let theta = triangle.solution()?;
        let noise_variance = triangle.cost / freedom(triangle.rows, theta.len())?;
        let factor = triangle.unit_factor()? * noise_variance.sqrt();
        let residuals = outputs - phi * &theta;
        let residuals = rows_by_run(problem, residuals.as_slice());
        Ok(Estimate::of(
            problem,
            Error::Equation,
            theta,
            factor,
            noise_variance,
            residuals,
        ))
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::LeastSquares, problem)
    }
}
