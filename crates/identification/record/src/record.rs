//! A record: inputs and outputs on one uniform grid of instants, the form that every estimator uses.
//!
//! A record is a list of *segments*, each without a gap. Between two segments data is missing, or a new run begins: an estimator restarts its history at
//! each segment, and all segments have the same parameters. Several runs of one vehicle form one record in the same way.
//!
//! Within a segment the output is known at the instants `t_k = start + k * sample_time`, and
//! `inputs[..][k]` acts over the interval from t_k to t_(k+1).

use crate::error::RecordError;

/// Maximum number of segments used, each with its own offset, and minimum number of samples in a segment.
const SEGMENTS: usize = 40;
const SHORTEST: usize = 30;

/// Maximum number of intervals for which a segment keeps the input before its first instant.
pub const LONGEST_PAST: usize = 1100;

/// One record on a uniform grid: `inputs[k]` acts over the interval that begins with `outputs[k]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Run<'a> {
    /// The input's means over the intervals before the first output, latest last, if they are known.
    pub past: &'a [f64],
    /// The input's mean over each interval, the input's unit.
    pub inputs: &'a [f64],
    /// The output at the beginning of each interval, the output's unit.
    pub outputs: &'a [f64],
}

/// Inputs and outputs on one uniform grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The interval between instants, s.
    pub sample_time: f64,
    /// The names of the inputs, in the order of each segment's `inputs`.
    pub inputs: Vec<String>,
    /// The names of the outputs, in the order of each segment's `outputs`.
    pub outputs: Vec<String>,
    /// The numbers, in the order of time.
    pub segments: Vec<Segment>,
}

/// Numbers without a gap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segment {
    /// Index of the data source, from 0.
    pub source: usize,
    /// The first instant, ns on the data's own clock.
    pub start: i64,
    /// `past[i]`: input i over the intervals before the first instant, latest last, if they are known. Empty, or one list for each input.
    pub past: Vec<Vec<f64>>,
    /// `inputs[i][k]`: input i over the interval that begins at instant k. All lists are as long as the outputs.
    pub inputs: Vec<Vec<f64>>,
    /// `outputs[i][k]`: output i at instant k.
    pub outputs: Vec<Vec<f64>>,
}

impl Segment {
    /// The number of instants.
    #[must_use]
    pub fn len(&self) -> usize {
        self.outputs.first().map_or(0, Vec::len)
    }

    /// The part of the segment with the instants from `first` up to `end`; earlier inputs become its past.
    #[must_use]
    pub fn part(&self, first: usize, end: usize, sample_time: f64) -> Self {
        let cut = |lists: &[Vec<f64>]| lists.iter().map(|it| it[first..end].to_vec()).collect();
        let past = |(number, input): (usize, &Vec<f64>)| {
            let before = self.past.get(number).map_or(&[][..], Vec::as_slice);
            let past = [before, &input[..first]].concat();
            past[past.len().saturating_sub(LONGEST_PAST)..].to_vec()
        };
        let later = (first as f64 * sample_time * 1e9).round() as i64;
        Self {
            source: self.source,
            start: self.start.saturating_add(later),
            past: self.inputs.iter().enumerate().map(past).collect(),
            inputs: cut(&self.inputs),
            outputs: cut(&self.outputs),
        }
    }

    /// The segment's first input and first output; `None` if one is missing.
    #[must_use]
    pub fn run(&self) -> Option<Run<'_>> {
        Some(Run {
            past: self.past.first().map_or(&[], Vec::as_slice),
            inputs: self.inputs.first()?,
            outputs: self.outputs.first()?,
        })
    }

    /// Whether there are no instants.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Record {
    /// A record of one segment that begins at time 0, from numbers on the grid.
    ///
    /// # Errors
    /// [`RecordError`], if a name and its numbers do not match, signals differ in length, or the sampling interval is not a positive
    /// number.
    pub fn of_run(
        sample_time: f64,
        inputs: Vec<(&str, Vec<f64>)>,
        outputs: Vec<(&str, Vec<f64>)>,
    ) -> Result<Self, RecordError> {
        let [inputs, outputs] = [inputs, outputs].map(|signals| {
            let (names, numbers): (Vec<_>, Vec<_>) = signals.into_iter().unzip();
            let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
            (names, numbers)
        });
        let record = Self {
            sample_time,
            inputs: inputs.0,
            outputs: outputs.0,
            segments: vec![Segment {
                inputs: inputs.1,
                outputs: outputs.1,
                ..Segment::default()
            }],
        };
        record.check()?;
        Ok(record)
    }

    /// Checks the record: a positive sampling interval, at least one output, and in every segment as many lists as signals, all of the same
    /// length and finite.
    ///
    /// # Errors
    /// [`RecordError`].
    pub fn check(&self) -> Result<(), RecordError> {
        if !(self.sample_time > 0.0 && self.sample_time.is_finite()) {
            return Err(RecordError::SampleTime(self.sample_time));
        }
        if self.outputs.is_empty() {
            return Err(RecordError::NoOutput);
        }
        for (segment, numbers) in self.segments.iter().enumerate() {
            let sides = [
                (&self.inputs, &numbers.inputs),
                (&self.outputs, &numbers.outputs),
            ];
            for (names, lists) in sides {
                if names.len() != lists.len() {
                    return Err(RecordError::Lists {
                        segment,
                        lists: lists.len(),
                        signals: names.len(),
                    });
                }
                for (name, list) in names.iter().zip(lists) {
                    let signal = || name.clone();
                    if list.len() != numbers.len() {
                        return Err(RecordError::Length {
                            segment,
                            signal: signal(),
                            samples: list.len(),
                            expected: numbers.len(),
                        });
                    }
                    if let Some(sample) = list.iter().position(|value| !value.is_finite()) {
                        return Err(RecordError::NotFinite {
                            segment,
                            signal: signal(),
                            sample,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// The number of instants in all segments.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.segments.iter().map(Segment::len).sum()
    }

    /// The total length of the segments, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples() as f64 * self.sample_time
    }

    /// The numbers of the used segments, in the order of time: the longest segments, without segments too short to determine more than their own
    /// offset.
    #[must_use]
    pub fn used(&self) -> Vec<usize> {
        let length = |number: &usize| self.segments[*number].len();
        let mut numbers: Vec<usize> = (0..self.segments.len()).collect();
        numbers.sort_by_key(|number| std::cmp::Reverse(length(number)));
        numbers.truncate(SEGMENTS);
        let most = numbers.first().map_or(0, length);
        numbers.retain(|number| length(number) >= SHORTEST.min(most));
        numbers.sort_unstable();
        numbers
    }

    /// The first input and output of each segment used.
    #[must_use]
    pub fn runs(&self) -> Option<Vec<Run<'_>>> {
        let numbers = self.used();
        numbers
            .into_iter()
            .map(|number| self.segments[number].run())
            .collect()
    }

    /// The segment with the most instants; if several are equally long, the earliest.
    #[must_use]
    pub fn longest(&self) -> Option<&Segment> {
        self.segments
            .iter()
            .rev()
            .max_by_key(|segment| segment.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_a_record_of_one_segment() {
        let record = Record::of_run(
            0.5,
            vec![("u", vec![1.0, 2.0])],
            vec![("y", vec![0.0, 3.0])],
        )
        .unwrap();
        assert_eq!((record.samples(), record.duration()), (2, 1.0));
        assert_eq!(record.longest().unwrap().outputs[0][1], 3.0);
        assert_eq!(record.inputs[0], "u");
    }

    #[test]
    fn what_does_not_fit_together_is_refused_with_the_signals_name() {
        let u = || vec![("u", vec![1.0, 2.0])];
        for (sample_time, y, reason) in [
            (0.0, vec![("y", vec![0.0, 3.0])], "sampling interval"),
            (f64::NAN, vec![("y", vec![0.0, 3.0])], "sampling interval"),
            (0.5, vec![], "needs an output"),
            (0.5, vec![("y", vec![0.0])], "u has 2 samples"),
            (
                0.5,
                vec![("y", vec![0.0, f64::NAN])],
                "y is not finite at sample 1",
            ),
        ] {
            let refusal = Record::of_run(sample_time, u(), y).unwrap_err().to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
