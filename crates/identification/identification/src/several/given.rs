//! A given model of several inputs on a record: simulated with a state fitted to each segment and its own offset.

use nalgebra::DVector;
use planesman_record::{Record, Segment};

use super::equations::Equations;
use super::layout::{Channel, Layout};
use super::scaled::used;
use crate::comparison::{GivenModel, check_sample_time};
use crate::error::{IdentificationError, Result};
use crate::fit::fit;
use crate::free_motion::{free_motion, without_free_motion};
use crate::structure::variance;
use crate::validation::residuals::ResidualTests;
use planesman_record::filter;

/// A model of one output, from any source.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownStructure {
    /// The number of each channel's input in a record, and its transfer function.
    pub channels: Vec<(usize, GivenModel)>,
    /// The output's offset where every input is 0, output unit.
    pub offset: f64,
    /// The interval between samples, s.
    pub sample_time: f64,
}

/// The performance of such a model on a record.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The simulated fit, %.
    pub fit: Option<f64>,
    /// Number of samples.
    pub samples: usize,
    /// The simulated output of each segment used.
    pub simulated: Vec<Vec<f64>>,
    /// The longest segment's number in the record.
    pub longest: usize,
    /// The tests of the error against each channel's input.
    pub residuals: Vec<Option<ResidualTests>>,
}

impl KnownStructure {
    /// The judgement on one output of a record.
    ///
    /// # Errors
    /// [`IdentificationError`]: another sampling interval, a record without the signals, a channel without coefficients.
    pub fn on(&self, record: &Record, output: usize) -> Result<Judged> {
        check_sample_time(self.sample_time, record)?;
        let segments = used(record);
        let inputs = self.channels.iter().map(|it| it.0).max().unwrap_or(0);
        let lacks = |it: &&Segment| it.inputs.len() <= inputs || it.outputs.len() <= output;
        if segments.is_empty() || segments.iter().any(lacks) {
            return Err(IdentificationError::Record(
                "the record must contain every input and output of the model".to_owned(),
            ));
        }
        let of_one = |it: &&Segment| Segment {
            outputs: vec![it.outputs[output].clone()],
            ..(*it).clone()
        };
        let one: Vec<Segment> = segments.iter().map(of_one).collect();
        let (mut channels, mut coefficients) = (Vec::new(), Vec::new());
        for (input, model) in &self.channels {
            let estimate = model.estimate(1)?;
            let layout = &estimate.layout;
            let own = [layout.a(), layout.b(0)].map(|it| estimate.theta.as_slice()[it].to_vec());
            coefficients.extend(own.concat());
            let mut structure = layout.structure.clone();
            structure.offset = false;
            channels.push(Channel {
                input: *input,
                structure,
            });
        }
        let layout = Layout {
            channels,
            offset: true,
            runs: one.len(),
        };
        let mut theta = DVector::zeros(layout.count());
        for (at, value) in coefficients.into_iter().enumerate() {
            theta[at] = value;
        }
        for at in (0..one.len()).filter_map(|run| layout.offset(run)) {
            theta[at] = self.offset;
        }
        let equations = Equations::new(&one, layout, &[1.0]);
        let free = equations.free(&theta);
        let (mut left, mut outputs, mut simulated) = (0.0, Vec::new(), Vec::new());
        let mut errors_of = Vec::new();
        for (run, segment) in one.iter().enumerate() {
            let measured = &segment.outputs[0];
            let first = equations.layout.unknown(&segment.past).min(segment.len());
            let errors = equations.errors_from_rest(&theta, run, first..segment.len());
            left += without_free_motion(&errors, &free);
            let motion = free_motion(&errors, &free).unwrap_or_default();
            let mut impulse = motion;
            impulse.resize(errors.len(), 0.0);
            let moving = filter(&[1.0], &free, &impulse);
            let errors: Vec<f64> = errors.iter().zip(moving).map(|(e, m)| e - m).collect();
            let later = measured[first..].iter().zip(&errors).map(|(y, e)| y - e);
            simulated.push(measured[..first].iter().copied().chain(later).collect());
            outputs.extend_from_slice(&measured[first..]);
            errors_of.push((first, errors));
        }
        let lengths = one.iter().map(Segment::len).enumerate();
        let longest = lengths.rev().max_by_key(|it| it.1).map_or(0, |it| it.0);
        let (first, errors) = &errors_of[longest];
        let residuals = self
            .channels
            .iter()
            .map(|(input, _)| ResidualTests::new(errors, &one[longest].inputs[*input][*first..]));
        Ok(Judged {
            fit: fit(left, variance(&outputs) * outputs.len() as f64),
            samples: outputs.len(),
            simulated,
            longest: record.used()[longest],
            residuals: residuals.collect(),
        })
    }
}
