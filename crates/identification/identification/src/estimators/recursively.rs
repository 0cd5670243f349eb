//! Runs a recursive method over whole records, as a batch estimator.

use super::equation::Equation;
use super::estimate::{Error, Estimate};
use super::estimator::{Estimator, Recursive, learn};
use super::recursive::{Kind, Options, Recursion};
use super::rows::{rows_by_run, samples_by_run};
use super::simulator::Simulator;
use crate::error::{IdentificationError, Result};
use crate::structure::{InitialState, Problem};

/// A recursion over whole records, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Recursively {
    /// Which recursion.
    pub kind: Kind,
    /// How it learns.
    pub options: Options,
}

impl Estimator for Recursively {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let structure = problem.structure.clone();
        if structure.own_numerators && problem.runs.len() > 1 {
            return Err(IdentificationError::Option(
                "a recursive method can estimate only one numerator for all records together"
                    .to_owned(),
            ));
        }
        let mut recursion =
            Recursion::new(self.kind, structure, problem.sample_time, self.options)?;
        for run in &problem.runs {
            learn(&mut recursion, *run);
        }
        let found = recursion
            .estimate()
            .ok_or(IdentificationError::Undetermined(
                "the records are too short for a recursion",
            ))?;
        Ok(of_records(problem, found))
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        let structure = problem.structure.clone();
        let recursion = Recursion::new(self.kind, structure, problem.sample_time, self.options)?;
        Ok(Box::new(recursion))
    }
}

/// An estimate of all records, which share one constant, with the residuals of each.
fn of_records(problem: &Problem<'_>, learnt: Estimate) -> Estimate {
    let mut layout = problem.layout();
    layout.structure.start = InitialState::Rest;
    // The constant learnt stands last, and is every record's.
    let last = learnt.theta.len() - 1;
    let places: Vec<usize> = (0..layout.count()).map(|i| i.min(last)).collect();
    let theta = learnt.theta.select_rows(&places);
    let residuals = match learnt.error {
        Error::Equation => {
            let errors = Equation::of(problem).errors(&theta, &learnt.noise_model);
            rows_by_run(problem, &errors)
        }
        Error::Output => {
            let at_rest = Problem {
                structure: layout.structure.clone(),
                ..problem.clone()
            };
            let errors = Simulator::new(&at_rest).linearised(&theta).errors;
            samples_by_run(problem, errors.as_slice())
        }
    };
    Estimate {
        covariance: learnt
            .covariance
            .select_rows(&places)
            .select_columns(&places),
        theta,
        layout,
        residuals,
        ..learnt
    }
}
