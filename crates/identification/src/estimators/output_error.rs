//! Output error: the model with the least simulation error.
//!
//! The noise never enters the regressors ([`super::simulator`] has the equations), so it leaves no bias; with white
//! noise it is the maximum likelihood estimate (Ljung 1999, sec. 7.3). The search begins at the best of several starts
//! ([`super::starts`]), for the cost has other valleys.

use nalgebra::DVector;

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::{Linearised, minimise};
use super::recursive::{self, Kind};
use super::simulator::Simulator;
use super::starts::starts;
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;

/// Output error.
#[derive(Clone, Copy, Debug)]
pub struct OutputError;

impl Estimator for OutputError {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let simulator = Simulator::new(problem);
        let mut best: Option<(DVector<f64>, Linearised)> = None;
        for start in starts(self, problem, &simulator)? {
            let Ok(found) = minimise(start, |theta| simulator.linearised(theta)) else {
                continue;
            };
            let cost = |of: &(DVector<f64>, Linearised)| of.1.errors.norm_squared();
            if best.as_ref().is_none_or(|best| cost(&found) < cost(best)) {
                best = Some(found);
            }
        }
        let (theta, at) = best.ok_or(IdentificationError::Search(
            "the search for the least output error found no minimum",
        ))?;
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}
