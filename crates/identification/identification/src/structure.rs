//! The unknowns and the data: the transfer function's structure, the records, and the place of every unknown in the parameter vector.
//!
//! ```text
//!                    N(q)   b1 + b2 q^-1 + ... + bm q^-(m-1)
//! y_k = q^-delay  *  ---- * -------------------------------- u_k  +  offset  +  noise_k
//!                    D(q)     1 + a1 q^-1 + ... + an q^-n
//! ```
//! `N/D` is the known part, in powers of `q^-1`: for example `1 - q^-1` in N for the zero at z = 1 that a vehicle with restoring moment has
//! from planes to pitch rate, or in D for an integrator. `N/D` filters the input before the estimation.
//!
//! Several records may share one model. Each has its own offset, and its own numerator if only the poles are common.

use std::ops::Range;

use planesman_linear::polynomial::product;
use planesman_record::{Run, filter};

use crate::error::{IdentificationError, Result};
use crate::model::Model;

/// In records longer than this many samples, structure and initial guess are searched in a part of this length.
pub const PART: usize = 10_000;

/// Half a 95 % interval of a normal distribution, in standard deviations.
pub const SIGMAS_95: f64 = 1.959_964;

/// The filter for an input that is linear between its samples, powers of `q^-1`.
const LINES: [f64; 2] = [0.5, 0.5];

/// The mean squared distance from the mean.
pub(crate) fn variance(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count
}

/// The minimum and the maximum.
pub(crate) fn extremes(values: &[f64]) -> (f64, f64) {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (least, largest)
}

/// The maximum minus the minimum.
pub(crate) fn range(values: &[f64]) -> f64 {
    let (least, largest) = extremes(values);
    largest - least
}

/// The initial state of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InitialState {
    /// The record begins at rest: no input before the first sample, no motion except the offset.
    #[default]
    Rest,
    /// The record begins in motion: the n numbers of the initial motion are also estimated, if an estimator needs them.
    Estimated,
}

/// The unknowns of the transfer function.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// `n`, unknown poles.
    pub poles: usize,
    /// `m`, unknown coefficients of the numerator.
    pub numerator: usize,
    /// Samples from an input to its first effect; 0 for direct feedthrough.
    pub delay: usize,
    /// Whether the output has an unknown offset.
    pub offset: bool,
    /// `N`, powers of `q^-1` from 0; `[1]` if no zero is known.
    pub known_numerator: Vec<f64>,
    /// `D`, powers of `q^-1` from 0, the first 1; `[1]` if no pole is known.
    pub known_denominator: Vec<f64>,
    /// The initial state of the records.
    pub start: InitialState,
    /// Whether the records have only their poles in common.
    pub own_numerators: bool,
}

impl Structure {
    /// n poles and n numerator coefficients, a delay of one sample, an unknown offset.
    #[must_use]
    pub fn of_order(order: usize) -> Self {
        Self {
            poles: order,
            numerator: order,
            delay: 1,
            offset: true,
            known_numerator: vec![1.0],
            known_denominator: vec![1.0],
            start: InitialState::Rest,
            own_numerators: false,
        }
    }

    /// The structure with one of its zeros known to be at z = 1.
    #[must_use]
    pub fn with_zero_at_one(mut self) -> Self {
        self.known_numerator = product(&self.known_numerator, &[1.0, -1.0]);
        self.numerator = self.numerator.saturating_sub(1).max(1);
        self
    }

    /// The structure with one of its poles known to be at z = 1.
    #[must_use]
    pub fn with_integrator(mut self) -> Self {
        self.known_denominator = product(&self.known_denominator, &[1.0, -1.0]);
        self.poles = self.poles.saturating_sub(1);
        self
    }

    /// The structure for an input that is linear between its samples: in each interval the input's mean acts, `(1 + q^-1)/2` of the sample at the
    /// interval's end.
    #[must_use]
    pub fn with_lines(mut self) -> Self {
        self.known_numerator = product(&self.known_numerator, &LINES);
        self
    }

    /// Whether the input is linear between its samples: no other known factor has a zero at z = -1.
    #[must_use]
    pub fn has_lines(&self) -> bool {
        self.without_lines() != self.known_numerator
    }

    /// `N` without the factor for the input between its samples.
    fn without_lines(&self) -> Vec<f64> {
        let alternating = self.known_numerator.iter().rev().enumerate();
        let at_minus_one: f64 = alternating
            .map(|(k, c)| if k % 2 == 0 { *c } else { -c })
            .sum();
        if self.known_numerator.len() < LINES.len() || at_minus_one != 0.0 {
            return self.known_numerator.clone();
        }
        // Division by (1 + q^-1)/2.
        let mut quotient: Vec<f64> = Vec::new();
        for c in &self.known_numerator[..self.known_numerator.len() - 1] {
            quotient.push(c / LINES[0] - quotient.last().copied().unwrap_or_default());
        }
        quotient
    }

    /// The structure from the input's mean over each interval to the output: without the factor for straight lines, and with one interval
    /// of delay.
    #[must_use]
    pub(crate) fn of_means(&self) -> Self {
        let known_numerator = self.without_lines();
        Self {
            delay: self.delay + usize::from(known_numerator != self.known_numerator),
            known_numerator,
            ..self.clone()
        }
    }

    /// The structure without an offset.
    #[must_use]
    pub fn without_offset(mut self) -> Self {
        self.offset = false;
        self
    }

    /// A record's input after the known factors, delayed so that element k first acts on output k. For a record in motion, the earlier input is its
    /// known past. If that is not known, it is assumed constant at its first known value: adding a constant changes only the offset. Outputs that
    /// depend on unknown inputs are not used ([`Self::unknown`]).
    #[must_use]
    pub fn driving(&self, past: &[f64], inputs: &[f64]) -> Vec<f64> {
        let past = match self.start {
            InitialState::Rest => &[],
            InitialState::Estimated => past,
        };
        let all = [past, inputs].concat();
        let through = filter(&self.known_numerator, &self.known_denominator, &all);
        let before = match self.start {
            InitialState::Rest => 0.0,
            InitialState::Estimated => through.first().copied().unwrap_or_default(),
        };
        let mut driving = vec![before; self.delay.saturating_sub(past.len())];
        driving.extend(&through[past.len().saturating_sub(self.delay)..]);
        driving.truncate(inputs.len());
        driving
    }

    /// The driving input for a record before which the unknown input is assumed constant at its first known value. For a record in motion an
    /// integrated input starts at the first sample.
    #[must_use]
    pub(crate) fn driving_from_standing(&self, past: &[f64], inputs: &[f64]) -> Vec<f64> {
        let (InitialState::Estimated, Some(first)) = (self.start, past.first().or(inputs.first()))
        else {
            return self.driving(past, inputs);
        };
        let missing = (self.delay + self.numerator).saturating_sub(past.len());
        let past = [vec![*first; missing], past.to_vec()].concat();
        let mut driving = self.driving(&past, inputs);
        if self.known_denominator != [1.0] {
            let anchor = past.iter().sum::<f64>() + inputs.first().copied().unwrap_or_default();
            driving.iter_mut().for_each(|it| *it -= anchor);
        }
        driving
    }

    /// The number of initial outputs of a record in motion that depend on unknown inputs, given this number of known earlier inputs; they are
    /// ignored. Outputs that an initial state of the poles can explain do not count.
    #[must_use]
    pub fn unknown(&self, past: usize) -> usize {
        let beyond_state = (self.numerator - 1).saturating_sub(self.poles);
        match self.start {
            InitialState::Rest => 0,
            InitialState::Estimated => {
                (self.delay + self.known_numerator.len() - 1 + beyond_state).saturating_sub(past)
            }
        }
    }

    /// The number of earlier samples that a row of the difference equation needs.
    #[must_use]
    pub fn history(&self) -> usize {
        let inputs = self.delay + self.numerator - 1;
        self.poles
            .max(inputs + self.known_numerator.len() - 1)
            .max(self.known_denominator.len() - 1)
    }
}

/// A structure, the sampling interval and the records, from which the unknowns are estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem<'a> {
    /// The unknowns.
    pub structure: Structure,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The records.
    pub runs: Vec<Run<'a>>,
}

impl<'a> Problem<'a> {
    /// # Errors
    /// [`IdentificationError`]: a structure without numerator, a record whose inputs and outputs differ
    /// in number, or a number is not finite.
    pub fn new(structure: Structure, sample_time: f64, runs: Vec<Run<'a>>) -> Result<Self> {
        let option = |reason| Err(IdentificationError::Option(reason));
        let record = |reason| Err(IdentificationError::Record(reason));
        if structure.numerator == 0 {
            return option("the structure has no numerator".to_owned());
        }
        let monic = structure.known_denominator.first() == Some(&1.0);
        if !monic || structure.known_numerator.is_empty() {
            return option("the known poles' polynomial must begin with 1".to_owned());
        }
        if !(sample_time > 0.0 && sample_time.is_finite()) {
            return option(format!("sampling interval {sample_time} s refused"));
        }
        if runs.is_empty() {
            return record("there are no records".to_owned());
        }
        for run in &runs {
            if run.inputs.len() != run.outputs.len() {
                return record(format!(
                    "a record has {} inputs and {} outputs",
                    run.inputs.len(),
                    run.outputs.len()
                ));
            }
            if [run.past, run.inputs, run.outputs]
                .concat()
                .iter()
                .any(|v| !v.is_finite())
            {
                return record("a record contains numbers that are not finite".to_owned());
            }
        }
        Ok(Self {
            structure,
            sample_time,
            runs,
        })
    }

    /// A part of the records for the search, if they are longer than [`PART`]: as many samples of the longest, where its input varies most,
    /// in motion. `None` if they are short.
    #[must_use]
    pub fn part(&self) -> Option<Self> {
        let longest = self.runs.iter().max_by_key(|run| run.outputs.len())?;
        let all: usize = self.runs.iter().map(|run| run.outputs.len()).sum();
        if all <= PART || longest.outputs.len() < PART / 4 {
            return None;
        }
        let count = longest.outputs.len().min(PART);
        let first = (0..=longest.outputs.len() - count)
            .step_by(PART / 4)
            .max_by(|p, q| {
                let variance = |first: &usize| variance(&longest.inputs[*first..first + count]);
                variance(p).total_cmp(&variance(q))
            })?;
        let run = Run {
            past: match first {
                0 => longest.past,
                _ => &longest.inputs[..first],
            },
            inputs: &longest.inputs[first..first + count],
            outputs: &longest.outputs[first..first + count],
        };
        let structure = Structure {
            start: InitialState::Estimated,
            ..self.structure.clone()
        };
        Some(Self {
            structure,
            sample_time: self.sample_time,
            runs: vec![run],
        })
    }

    /// The last samples of the longest record, in motion, at most this many.
    pub(crate) fn last_samples(&self, most: usize) -> Self {
        let longest = self.runs.iter().max_by_key(|run| run.outputs.len());
        let run = longest.copied().unwrap_or_default();
        let first = run.outputs.len().saturating_sub(most);
        let run = Run {
            past: match first {
                0 => run.past,
                _ => &run.inputs[..first],
            },
            inputs: &run.inputs[first..],
            outputs: &run.outputs[first..],
        };
        let start = match first {
            0 => self.structure.start,
            _ => InitialState::Estimated,
        };
        Self {
            structure: Structure {
                start,
                ..self.structure.clone()
            },
            runs: vec![run],
            ..self.clone()
        }
    }

    /// The place of each unknown.
    #[must_use]
    pub fn layout(&self) -> Layout {
        Layout {
            structure: self.structure.clone(),
            runs: self.runs.len(),
        }
    }

    /// For each record, the number of outputs that depend on unknown inputs.
    #[must_use]
    pub fn unknown(&self) -> Vec<usize> {
        let runs = self.runs.iter();
        runs.map(|run| self.structure.unknown(run.past.len()))
            .collect()
    }

    /// Each record's input, filtered and delayed as in [`Structure::driving`].
    #[must_use]
    pub fn driving(&self) -> Vec<Vec<f64>> {
        let runs = self.runs.iter();
        runs.map(|run| self.structure.driving(run.past, run.inputs))
            .collect()
    }
}

/// The place of each unknown in theta: `[a, b (of each record), offset of each record, motion at each record's beginning]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The unknowns.
    pub structure: Structure,
    /// The number of records.
    pub runs: usize,
}

impl Layout {
    /// `a1 ... an`.
    #[must_use]
    pub fn a(&self) -> Range<usize> {
        0..self.structure.poles
    }

    /// `1, a1 ... an`.
    #[must_use]
    pub fn denominator(&self, theta: &[f64]) -> Vec<f64> {
        monic(&theta[self.a()])
    }

    /// `b1 ... bm` of a record.
    #[must_use]
    pub fn b(&self, run: usize) -> Range<usize> {
        let own = if self.structure.own_numerators {
            run
        } else {
            0
        };
        let first = self.structure.poles + own * self.structure.numerator;
        first..first + self.structure.numerator
    }

    /// The record's offset.
    #[must_use]
    pub fn offset(&self, run: usize) -> Option<usize> {
        self.structure
            .offset
            .then(|| self.b(self.runs - 1).end + run)
    }

    /// The initial motion of a record; empty if all begin at rest.
    #[must_use]
    pub fn motion(&self, run: usize) -> Range<usize> {
        let first = self.without_motion();
        match self.structure.start {
            InitialState::Rest => first..first,
            InitialState::Estimated => {
                let n = self.structure.poles;
                first + run * n..first + (run + 1) * n
            }
        }
    }

    /// The number of parameters of the difference equation, without initial motions.
    #[must_use]
    pub fn without_motion(&self) -> usize {
        self.b(self.runs - 1).end + if self.structure.offset { self.runs } else { 0 }
    }

    /// All parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        self.motion(self.runs - 1).end
    }

    /// The complete model of a record: known factors multiplied in, the delay as leading zeros, as many numerator coefficients as poles,
    /// including poles at z = 0 that a long numerator or delay causes.
    #[must_use]
    pub fn model(&self, theta: &[f64], run: usize, sample_time: f64) -> Model {
        let s = &self.structure;
        let mut a = product(&self.denominator(theta), &s.known_denominator);
        a.remove(0);
        let mut b = vec![0.0; s.delay];
        b.extend(product(&theta[self.b(run)], &s.known_numerator));
        let feedthrough = b.remove(0);
        let order = a.len().max(b.len());
        a.resize(order, 0.0);
        b.resize(order, 0.0);
        Model {
            sample_time,
            a,
            feedthrough,
            b,
            c: Vec::new(),
            bias: 0.0,
        }
    }
}

/// `1, a1, ..., an`.
pub(crate) fn monic(a: &[f64]) -> Vec<f64> {
    std::iter::once(1.0).chain(a.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unknown_has_a_place_of_its_own() {
        let mut structure = Structure::of_order(3).with_zero_at_one();
        structure.start = InitialState::Estimated;
        for own in [false, true] {
            structure.own_numerators = own;
            let layout = Layout {
                structure: structure.clone(),
                runs: 2,
            };
            let mut places: Vec<usize> = layout.a().collect();
            for run in 0..2 {
                places.extend(layout.b(run).filter(|_| own || run == 0));
                places.extend(layout.offset(run));
                places.extend(layout.motion(run));
            }
            places.sort_unstable();
            assert_eq!(places, (0..layout.count()).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_full_model_holds_what_is_known() {
        let mut structure = Structure::of_order(2).with_zero_at_one().with_integrator();
        structure.delay = 2;
        let layout = Layout { structure, runs: 1 };
        let model = layout.model(&[-0.5, 3.0, 9.9], 0, 0.1);
        assert_eq!(model.a, vec![-1.5, 0.5, 0.0]);
        assert_eq!(model.b, vec![0.0, 3.0, -3.0]);
    }

    #[test]
    fn an_input_on_lines_comes_off_again() {
        let held = Structure::of_order(3).with_zero_at_one();
        assert!(!held.has_lines());
        let lines = Structure {
            delay: 0,
            ..held.clone()
        }
        .with_lines();
        assert_eq!(lines.known_numerator, vec![0.5, 0.0, -0.5]);
        assert!(lines.has_lines());
        assert_eq!(lines.of_means(), held);
        assert_eq!(held.of_means(), held);
    }

    #[test]
    fn records_that_are_none_are_refused() {
        let run = Run {
            inputs: &[1.0],
            outputs: &[1.0, 2.0],
            ..Run::default()
        };
        assert!(Problem::new(Structure::of_order(1), 0.1, vec![run]).is_err());
        assert!(Problem::new(Structure::of_order(1), 0.1, vec![]).is_err());
        let run = Run {
            inputs: &[f64::NAN],
            outputs: &[1.0],
            ..Run::default()
        };
        assert!(Problem::new(Structure::of_order(1), 0.1, vec![run]).is_err());
        assert!(Problem::new(Structure::of_order(1), 0.0, vec![]).is_err());
    }
}
