//! Scaled records, relative to their levels: one output and all inputs.

use planesman_record::{Record, Segment};

use crate::scale::Scale;
use crate::structure::InitialState;

/// The segments of a record that are used, with one output.
#[derive(Clone, Debug)]
pub(super) struct Scaled {
    pub(super) segments: Vec<Segment>,
    pub(super) inputs: Vec<Scale>,
    pub(super) output: Scale,
}

impl Scaled {
    /// Scales segments and one output; uses given scales of other data, if there are any.
    pub(super) fn of(
        segments: &[&Segment],
        output: usize,
        (offset, start): (bool, InitialState),
    ) -> Self {
        let free = offset && start == InitialState::Estimated;
        let inputs = segments.first().map_or(0, |it| it.inputs.len());
        let of_input = |number: usize| {
            let lists: Vec<&[f64]> = segments.iter().map(|it| &it.inputs[number][..]).collect();
            Scale::of(&lists, free)
        };
        let outputs: Vec<&[f64]> = segments.iter().map(|it| &it.outputs[output][..]).collect();
        let scales = Self {
            segments: Vec::new(),
            inputs: (0..inputs).map(of_input).collect(),
            output: Scale::of(&outputs, offset),
        };
        Self {
            segments: segments
                .iter()
                .map(|it| scales.scaled(it, output))
                .collect(),
            ..scales
        }
    }

    /// A segment in these scales.
    pub(super) fn scaled(&self, segment: &Segment, output: usize) -> Segment {
        let of = |lists: &[Vec<f64>]| {
            let lists = lists.iter().zip(&self.inputs);
            lists
                .map(|(values, scale)| scale.taken_off(values))
                .collect()
        };
        Segment {
            source: segment.source,
            start: segment.start,
            past: of(&segment.past),
            inputs: of(&segment.inputs),
            outputs: vec![self.output.taken_off(&segment.outputs[output])],
        }
    }
}

/// The segments of a record that are used.
pub(super) fn used(record: &Record) -> Vec<&Segment> {
    let numbers = record.used().into_iter();
    numbers.map(|number| &record.segments[number]).collect()
}
