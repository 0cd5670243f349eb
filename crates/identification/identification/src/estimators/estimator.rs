//! The two interfaces of every estimator: over whole records, and sample by sample.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use crate::error::Result;
use crate::structure::Problem;
use planesman_record::Run;

/// An estimator over whole records.
pub trait Estimator: fmt::Debug + Send + Sync {
    /// Finds the unknowns.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError): records that do not determine the unknowns, a search that finds no minimum, a
    /// structure the estimator is not for.
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate>;

    /// The estimator's recursive form before its first sample, to watch it learn.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), when it has none for this problem.
    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>>;
}

/// An estimator that learns while samples arrive.
pub trait Recursive {
    /// Begins the history anew with `output`, which no known input has led to: at the start of
    /// a record and after a gap. What has been learnt stays.
    fn begin(&mut self, output: f64);

    /// Takes the next output, and the input over the interval that ended with it.
    fn push(&mut self, input: f64, output: f64);

    /// The parameters so far.
    fn parameters(&self) -> DVector<f64>;

    /// The parameters' names.
    fn names(&self) -> Vec<String>;

    /// Its covariance, as the estimator computes it; `None` before there are more samples than
    /// unknowns.
    fn covariance(&self) -> Option<DMatrix<f64>>;

    /// By how much the last output missed its prediction, output unit; `None` when there was none.
    fn error(&self) -> Option<f64>;

    /// From now on predicts and learns nothing, or learns again.
    fn set_frozen(&mut self, frozen: bool);

    /// Forgets everything.
    fn reset(&mut self);
}

/// Takes a record from its first sample to its last.
pub fn learn(estimator: &mut (impl Recursive + ?Sized), run: Run<'_>) {
    for (k, output) in run.outputs.iter().enumerate() {
        match k.checked_sub(1).and_then(|before| run.inputs.get(before)) {
            None => estimator.begin(*output),
            Some(input) => estimator.push(*input, *output),
        }
    }
}
