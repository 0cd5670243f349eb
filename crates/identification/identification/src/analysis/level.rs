//! Levels of input and output far from 0.

use std::borrow::Cow;

use planesman_record::{Record, Segment};

use super::Options;
use crate::estimators::{Error, Estimate};
use crate::structure::InitialState;

/// A mean further from 0 than this number of standard deviations is subtracted.
const LARGE_MEAN_DEVIATIONS: f64 = 10.0;

/// Levels of input and output far from 0, where rounding would dominate; they are subtracted before the estimation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Level {
    pub(super) input: f64,
    pub(super) output: f64,
}

impl Level {
    /// `None` if the model or the method handles the level itself.
    pub(super) fn of(record: &Record, options: &Options) -> Self {
        let free = options.offset
            && options.start == InitialState::Estimated
            && options.integrators == 0
            && !options.method.is_of_the_vehicle();
        let level = |of: fn(&Segment) -> Option<&Vec<f64>>| -> f64 {
            let values = || record.segments.iter().filter_map(of).flatten().copied();
            let count = values().count().max(1) as f64;
            let mean = values().sum::<f64>() / count;
            let deviation = (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
            if free && mean.abs() > LARGE_MEAN_DEVIATIONS * deviation {
                mean
            } else {
                0.0
            }
        };
        Self {
            input: level(|segment| segment.inputs.first()),
            output: level(|segment| segment.outputs.first()),
        }
    }

    pub(super) fn taken_off(self, record: &Record) -> Cow<'_, Record> {
        if self == Self::default() {
            return Cow::Borrowed(record);
        }
        let mut record = record.clone();
        for segment in &mut record.segments {
            let sides = [
                (segment.past.first_mut(), self.input),
                (segment.inputs.first_mut(), self.input),
                (segment.outputs.first_mut(), self.output),
            ];
            for (signal, level) in sides {
                signal
                    .into_iter()
                    .flatten()
                    .for_each(|value| *value -= level);
            }
        }
        Cow::Owned(record)
    }

    /// Adds the subtracted level to an estimate again.
    pub(super) fn restore_units(self, estimate: &mut Estimate) {
        estimate.input_level += self.input;
        let steady = match estimate.error {
            Error::Equation => {
                let a = estimate.layout.denominator(estimate.theta.as_slice());
                a.iter().sum()
            }
            Error::Output => 1.0,
        };
        for run in 0..estimate.layout.runs {
            if let Some(at) = estimate.layout.offset(run) {
                estimate.theta[at] += self.output * steady;
            }
        }
    }
}
