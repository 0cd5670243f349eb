//! Output error: the model with the smallest simulation error.
//!
//! The noise does not enter the regressors ([`super::simulator`] has the equations), so it causes no bias; with white noise this is the
//! maximum likelihood estimate (Ljung 1999, sec. 7.3). The search begins at the best of several starts ([`super::starts`]), because the
//! cost has other local minima.

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::minimise;
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
        let minima = starts(self, problem, &simulator)?
            .into_iter()
            .filter_map(|start| minimise(start, |theta| simulator.linearised(theta)).ok());
        let least = minima.min_by(|p, q| p.1.cost().total_cmp(&q.1.cost()));
        let (theta, at) = least.ok_or(IdentificationError::Search(
            "the search for the smallest output error found no minimum",
        ))?;
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}
