//! Output error and Box-Jenkins, started from approximately known poles.

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::minimise;
use super::normal_equations::{NormalEquations, Search};
use super::output_error::OutputError;
use super::recursive::{self, Kind};
use super::simulator::Simulator;
use super::stability::{drawn_within, held_within, radius_of_memory};
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;

/// Maximum number of rounds of noise model and model; three are usual.
const ROUNDS: usize = 5;
/// Steps of the search by normal equations, before the last steps by QR.
const STEPS: usize = 60;
const MIN_COST_DECREASE: f64 = 1e-9;

/// The smallest output error near given poles.
#[derive(Clone, Debug)]
pub struct WarmStarted {
    /// `a1 ... an`; if their number is not n, those with the smallest output error are used.
    pub poles: Vec<f64>,
    /// Whether to model the noise: `y = (B/A) u + e/D`.
    pub noise: bool,
}

impl Estimator for WarmStarted {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let none = IdentificationError::Search(
            "the search for the smallest output error found no minimum",
        );
        let equations = NormalEquations::new(problem, &[1.0]);
        let whole = equations.whole();
        let samples: usize = whole.iter().map(|part| part.samples.len()).sum();
        let search = Search {
            steps: STEPS,
            enough: MIN_COST_DECREASE,
            radius: radius_of_memory(samples),
        };
        let mut theta = match self.poles.len() == problem.structure.poles {
            true => {
                equations
                    .completed(&drawn_within(&self.poles, search.radius), &whole)
                    .and_then(|start| equations.minimised(start, &whole, search))
                    .ok_or(none)?
                    .0
            }
            false => OutputError.fit(problem)?.theta,
        };
        let mut d = vec![1.0];
        for _ in 0..if self.noise { ROUNDS } else { 0 } {
            d = equations.whitening(&theta);
            let whitened = NormalEquations::new(problem, &d);
            let Some((found, _)) = whitened.minimised(theta.clone(), &whitened.whole(), search)
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
        let (last, at) = minimise(theta.clone(), |theta| simulator.linearised(theta))?;
        let poles = &last.as_slice()[..problem.structure.poles];
        let free = held_within(poles, search.radius) == Some(None);
        let (theta, at) = match free {
            true => (last, at),
            false => {
                let at = simulator.linearised(&theta);
                (theta, at)
            }
        };
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}
