//! Output error and Box-Jenkins from poles that are known nearly.

use nalgebra::DVector;

use super::coloured::whitening;
use super::course::{Course, Search};
use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::minimise;
use super::output_error::OutputError;
use super::recursive::{self, Kind};
use super::simulator::Simulator;
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;

/// Rounds of noise model and model; three are usual.
const ROUNDS: usize = 5;
/// The search by normal equations, before the last steps by QR.
const SEARCH: Search = Search {
    steps: 60,
    enough: 1e-9,
    radius: f64::INFINITY,
};

/// The least output error near given poles.
#[derive(Clone, Debug)]
pub struct Near {
    /// `a1 ... an`; those of the least output error where there are not n of them.
    pub poles: Vec<f64>,
    /// Whether the noise is modelled: `y = (B/A) u + e/D`.
    pub noise: bool,
}

impl Estimator for Near {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let none =
            IdentificationError::Search("the search for the least output error found no minimum");
        let course = Course::new(problem, &[1.0]);
        let whole = course.whole();
        let mut theta = match self.poles.len() == problem.structure.poles {
            true => {
                course
                    .completed(&self.poles, &whole)
                    .and_then(|start| course.minimised(start, &whole, SEARCH))
                    .ok_or(none)?
                    .0
            }
            false => OutputError.fit(problem)?.theta,
        };
        let mut d = vec![1.0];
        for _ in 0..if self.noise { ROUNDS } else { 0 } {
            let errors = |run| Course::new(problem, &[1.0]).errors(&theta, run);
            let residuals: Vec<Vec<f64>> = (0..problem.runs.len()).map(errors).collect();
            d = whitening(residuals.iter().map(Vec::as_slice));
            let whitened = Course::new(problem, &d);
            let Some((found, _)) = whitened.minimised(theta.clone(), &whitened.whole(), SEARCH)
            else {
                break;
            };
            let moved = (&found - &theta).norm() > 1e-6 * theta.norm();
            theta = found;
            if !moved || d.len() == 1 {
                break;
            }
        }
        let simulator = Simulator::whitened(problem, d);
        let (theta, at) = last_steps(&simulator, theta)?;
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}

fn last_steps(
    simulator: &Simulator<'_>,
    theta: DVector<f64>,
) -> Result<(DVector<f64>, super::levenberg_marquardt::Linearised)> {
    minimise(theta, |theta| simulator.linearised(theta))
}
