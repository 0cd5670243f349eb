//! The two interfaces of every estimator: over whole records, and sample by sample.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use crate::error::Result;
use crate::structure::Problem;
use planesman_record::Run;

/// An estimator over whole records.
pub trait Estimator: fmt::Debug + Send + Sync {
    /// Estimates the unknowns.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if the records do not determine the unknowns, a search finds no minimum, or the
    /// estimator does not support the structure.
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate>;

    /// The estimator's recursive form before its first sample.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if there is none for this problem.
    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>>;
}

/// An estimator that learns while samples arrive.
pub trait Recursive {
    /// Restarts the history with `output`, without a known earlier input: at the start of a record and after a gap. Learnt parameters are kept.
    fn begin(&mut self, output: f64);

    /// Takes the next output, and the input over the interval that ended with it.
    fn push(&mut self, input: f64, output: f64);

    /// The parameters so far.
    fn parameters(&self) -> DVector<f64>;

    /// The parameters' names.
    fn names(&self) -> Vec<String>;

    /// The parameters' covariance, as computed by the estimator; `None` until there are more samples than unknowns.
    fn covariance(&self) -> Option<DMatrix<f64>>;

    /// The last prediction error, output unit; `None` if there was no prediction.
    fn error(&self) -> Option<f64>;

    /// Stops learning (the estimator still predicts), or resumes it.
    fn set_frozen(&mut self, frozen: bool);

    /// Forgets everything.
    fn reset(&mut self);
}

/// Processes a record from its first sample to its last.
pub fn learn(estimator: &mut (impl Recursive + ?Sized), run: Run<'_>) {
    for (k, output) in run.outputs.iter().enumerate() {
        match k.checked_sub(1).and_then(|before| run.inputs.get(before)) {
            None => estimator.begin(*output),
            Some(input) => estimator.push(*input, *output),
        }
    }
}
