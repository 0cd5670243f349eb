//! The longest run of a model, measured and simulated.

use planesman_identification::analysis::Analysis;
use planesman_identification::{IdentificationError, Record};

/// A run, measured and simulated.
#[derive(Clone, Debug)]
pub struct Simulated<'a> {
    /// Time of the first sample, ns on the data's clock.
    pub start: i64,
    /// The input over each sampling interval.
    pub input: &'a [f64],
    /// The output at each instant.
    pub measured: &'a [f64],
    /// The model's output, simulated from the input alone.
    pub simulated: Vec<f64>,
    /// Number of first samples affected by unknown inputs; the simulation is not valid there.
    pub unknown: usize,
}

impl<'a> Simulated<'a> {
    /// The longest run of the record to which the model was fitted.
    ///
    /// # Errors
    /// If the record is a different one.
    pub fn new(analysis: &Analysis, record: &'a Record) -> Result<Self, IdentificationError> {
        Self::of_run(analysis, record, analysis.longest)
    }

    /// One run of the record, numbered as in [`Analysis::segments`].
    ///
    /// # Errors
    /// Like [`Simulated::new`]; also if the run does not exist.
    pub fn of_run(
        analysis: &Analysis,
        record: &'a Record,
        run: usize,
    ) -> Result<Self, IdentificationError> {
        let refused = |reason: &str| IdentificationError::Record(reason.to_owned());
        let segment = analysis
            .segments
            .get(run)
            .and_then(|number| record.segments.get(*number))
            .ok_or_else(|| refused("the record lacks the segment of the model"))?;
        let values = segment
            .run()
            .ok_or_else(|| refused("the record has no input or no output"))?;
        Ok(Self {
            start: segment.start,
            input: values.inputs,
            measured: values.outputs,
            simulated: analysis.simulate(run, values),
            unknown: analysis.estimate.unknown(values),
        })
    }
}
