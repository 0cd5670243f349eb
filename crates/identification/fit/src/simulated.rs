//! The longest run of a model, measured and simulated.

use planesman_identification::analysis::Analysis;
use planesman_identification::{IdentificationError, Record};

/// A run, measured and simulated.
#[derive(Clone, Debug)]
pub struct Simulated<'a> {
    /// The first instant, ns on the data's own clock.
    pub start: i64,
    /// The input over each sampling interval.
    pub input: &'a [f64],
    /// The output at each instant.
    pub measured: &'a [f64],
    /// The output of the model, simulated on the input alone.
    pub simulated: Vec<f64>,
    /// The first samples, which unknown inputs act on: the simulation says nothing of them.
    pub unknown: usize,
}

impl<'a> Simulated<'a> {
    /// The longest run of the record that the model was fitted to.
    ///
    /// # Errors
    /// When the record is another one.
    pub fn new(analysis: &Analysis, record: &'a Record) -> Result<Self, IdentificationError> {
        Self::of_run(analysis, record, analysis.longest)
    }

    /// A run of that record, as [`Analysis::segments`] counts them.
    ///
    /// # Errors
    /// As [`Simulated::new`]; a run that is not there.
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
            .ok_or_else(|| refused("the record does not hold the segment of the model"))?;
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
