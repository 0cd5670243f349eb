//! The output error of several channels over parts of records: its normal equations, its minimum, its slopes.
//!
//! ```text
//! e = D (y - sum (Bi/Ai) u_i - sum (Mi/Ai) impulse - offset),   psi = -de/dtheta
//! ```
//! like the equations for one input: columns of `psi` are shifts of three signals for each channel.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use planesman_linear::polynomial::product;
use planesman_record::{Segment, filter};

use super::layout::Layout;
use crate::estimators::{
    Linearised, Part, Search, Total, correlation, damped, held_within, impulse, information, least,
    shifted_sum, through_poles, whitening,
};
use crate::structure::monic;

/// The signals of a record, whitened.
struct Signals {
    /// The delayed input of each channel.
    driving: Vec<Vec<f64>>,
    outputs: Vec<f64>,
    constant: Vec<f64>,
    impulse: Vec<f64>,
    /// Number of first samples to ignore.
    lead: usize,
}

/// The records, prepared for evaluation with any parameters.
pub(super) struct Equations {
    pub(super) layout: Layout,
    signals: Vec<Signals>,
}

/// The signals of a record at some parameters.
struct Signalled {
    /// `u_i / Ai`, `impulse / Ai` and `(Bi/Ai) u_i + (Mi/Ai) impulse` of each channel.
    channels: Vec<[Vec<f64>; 3]>,
    errors: Vec<f64>,
}

impl Equations {
    /// Prepares records with one output; the residual is whitened by `1, d1, ..., dk`; `[1]` for no whitening.
    pub(super) fn new(segments: &[Segment], layout: Layout, whitening: &[f64]) -> Self {
        Self::from(segments, layout, whitening, 0)
    }

    /// Prepares the records with at least this many first outputs ignored, so that errors of models with different delays are for the same samples.
    pub(super) fn from(
        segments: &[Segment],
        layout: Layout,
        whitening: &[f64],
        first: usize,
    ) -> Self {
        let through = |values: &[f64]| filter(whitening, &[1.0], values);
        let of = |segment: &Segment| {
            let count = segment.len();
            let unknown = layout.unknown(&segment.past);
            let driving = layout.channels.iter().map(|channel| {
                let past = segment.past.get(channel.input);
                let past = past.map_or(&[][..], Vec::as_slice);
                let inputs = &segment.inputs[channel.input];
                through(&channel.structure.driving(past, inputs))
            });
            Signals {
                driving: driving.collect(),
                outputs: through(&segment.outputs[0]),
                constant: through(&vec![1.0; count]),
                impulse: through(&impulse(unknown, count)),
                lead: (unknown.max(first) + whitening.len() - 1).min(count),
            }
        };
        Self {
            signals: segments.iter().map(of).collect(),
            layout,
        }
    }

    /// Every record as one part.
    pub(super) fn whole(&self) -> Vec<Part> {
        let parts = self.signals.iter().enumerate();
        parts
            .map(|(run, of)| Part {
                run,
                samples: 0..of.outputs.len(),
            })
            .collect()
    }

    /// `a1 ... an` of each channel.
    pub(super) fn poles(&self, theta: &DVector<f64>) -> Vec<Vec<f64>> {
        let channels = 0..self.layout.channels.len();
        channels
            .map(|it| theta.as_slice()[self.layout.a(it)].to_vec())
            .collect()
    }

    fn gone_through(&self, theta: &DVector<f64>, run: usize) -> Signalled {
        let of = &self.signals[run];
        let offset = self.layout.offset(run).map_or(0.0, |at| theta[at]);
        let pairs = of.outputs.iter().zip(&of.constant);
        let mut errors: Vec<f64> = pairs.map(|(y, one)| y - offset * one).collect();
        let channels = of.driving.iter().enumerate().map(|(number, driving)| {
            let a = monic(&theta.as_slice()[self.layout.a(number)]);
            let motion = &theta.as_slice()[self.layout.motion(run, number)];
            let by_input = through_poles(&a, driving);
            let by_impulse = match motion {
                [] => Vec::new(),
                _ => through_poles(&a, &of.impulse),
            };
            let b = &theta.as_slice()[self.layout.b(number)];
            let x = shifted_sum(of.outputs.len(), [(b, &by_input), (motion, &by_impulse)]);
            errors.iter_mut().zip(&x).for_each(|(e, x)| *e -= x);
            [by_input, by_impulse, x]
        });
        let channels = channels.collect();
        Signalled { channels, errors }
    }

    /// `e` of a record.
    pub(super) fn errors(&self, theta: &DVector<f64>, run: usize) -> Vec<f64> {
        self.gone_through(theta, run).errors
    }

    /// `e` of all records, without ignored samples.
    pub(super) fn counted_errors(&self, theta: &DVector<f64>) -> Vec<Vec<f64>> {
        let of = |run: usize| self.errors(theta, run).split_off(self.signals[run].lead);
        (0..self.signals.len()).map(of).collect()
    }

    /// The outputs minus a simulation from rest at the first of these samples.
    pub(super) fn errors_from_rest(
        &self,
        theta: &DVector<f64>,
        run: usize,
        samples: Range<usize>,
    ) -> Vec<f64> {
        let (of, layout) = (&self.signals[run], &self.layout);
        let offset = layout.offset(run).map_or(0.0, |at| theta[at]);
        let outputs = of.outputs[samples.clone()].iter();
        let mut left: Vec<f64> = outputs.map(|y| y - offset).collect();
        for (number, driving) in of.driving.iter().enumerate() {
            let a = monic(&theta.as_slice()[layout.a(number)]);
            let b = &theta.as_slice()[layout.b(number)];
            // The numerator looks back to inputs before the first sample, which are known.
            let through = filter(b, &[1.0], driving).split_off(samples.start);
            let simulated = through_poles(&a, &through[..samples.len()]);
            left.iter_mut().zip(simulated).for_each(|(e, x)| *e -= x);
        }
        left
    }

    /// The denominator of all free motions: the product of the channels' denominators.
    pub(super) fn free(&self, theta: &DVector<f64>) -> Vec<f64> {
        let poles = self.poles(theta).into_iter();
        poles.fold(vec![1.0], |free, a| product(&free, &monic(&a)))
    }

    /// `1, d1, ..., dk` that whiten the errors of all records.
    pub(super) fn whitening(&self, theta: &DVector<f64>) -> Vec<f64> {
        whitening(self.counted_errors(theta).iter().map(Vec::as_slice))
    }

    /// The normal equations over parts at `theta`; `None` if a number is not finite.
    pub(super) fn total(&self, theta: &DVector<f64>, parts: &[Part]) -> Option<Total> {
        let layout = &self.layout;
        let mut total = Total {
            information: DMatrix::zeros(theta.len(), theta.len()),
            gradient: DVector::zeros(theta.len()),
            cost: 0.0,
        };
        for (run, of) in self.signals.iter().enumerate() {
            if parts.iter().all(|part| part.run != run) {
                continue;
            }
            let Signalled { channels, errors } = self.gone_through(theta, run);
            let by_pole = channels.iter().enumerate().map(|(number, [.., x])| {
                let a = monic(&theta.as_slice()[layout.a(number)]);
                let mut by_pole = through_poles(&a, x);
                by_pole.iter_mut().for_each(|value| *value = -*value);
                by_pole
            });
            let by_pole: Vec<Vec<f64>> = by_pole.collect();
            let mut families = Vec::new();
            for (number, [by_input, ..]) in channels.iter().enumerate() {
                let structure = &layout.channels[number].structure;
                families.push((by_pole[number].as_slice(), 1..structure.poles + 1));
                families.push((by_input.as_slice(), 0..structure.numerator));
            }
            families.push((
                of.constant.as_slice(),
                0..usize::from(layout.offset(run).is_some()),
            ));
            for (number, [_, by_impulse, _]) in channels.iter().enumerate() {
                families.push((by_impulse.as_slice(), 0..layout.motion(run, number).len()));
            }
            families.retain(|(_, shifts)| !shifts.is_empty());
            let places = layout.places(run);
            for part in parts.iter().filter(|part| part.run == run) {
                let samples =
                    part.samples.start.max(of.lead).min(part.samples.end)..part.samples.end;
                let shifted = families
                    .iter()
                    .flat_map(|(signal, shifts)| shifts.clone().map(move |it| (*signal, it)));
                for (place, (signal, shift)) in places.iter().zip(shifted) {
                    total.gradient[*place] += correlation(signal, shift, &errors, 0, &samples);
                }
                let own = information(&families, places.len(), &samples);
                for (i, row) in places.iter().enumerate() {
                    for (j, column) in places.iter().enumerate() {
                        total.information[(*row, *column)] += own[(i, j)];
                    }
                }
                total.cost += correlation(&errors, 0, &errors, 0, &samples);
            }
        }
        let finite = total.cost.is_finite() && total.information.iter().all(|v| v.is_finite());
        finite.then_some(total)
    }

    /// With given poles of each channel, computes all other parameters, which enter linearly, by least squares over the parts.
    pub(super) fn completed(&self, poles: &[Vec<f64>], parts: &[Part]) -> Option<DVector<f64>> {
        let mut theta = DVector::zeros(self.layout.count());
        let mut is_pole = vec![false; theta.len()];
        for (number, a) in poles.iter().enumerate() {
            for (at, a) in self.layout.a(number).zip(a) {
                (theta[at], is_pole[at]) = (*a, true);
            }
        }
        let linear: Vec<usize> = (0..theta.len()).filter(|at| !is_pole[*at]).collect();
        // The second time mends what the first rounded.
        for _ in 0..2 {
            let at = self.total(&theta, parts)?;
            let count = linear.len();
            let information =
                DMatrix::from_fn(count, count, |i, j| at.information[(linear[i], linear[j])]);
            let gradient = DVector::from_fn(count, |i, _| at.gradient[linear[i]]);
            let step = damped(&information, &gradient, 1e-13)?;
            for (place, step) in linear.iter().zip(step.iter()) {
                theta[*place] += step;
            }
        }
        Some(theta)
    }

    /// Minimises the error over the parts, from `start`; returns the parameters and the sum of squares.
    pub(super) fn minimised(
        &self,
        start: DVector<f64>,
        parts: &[Part],
        search: Search,
    ) -> Option<(DVector<f64>, f64)> {
        let within = |there: DVector<f64>| {
            let (mut poles, mut is_held) = (self.poles(&there), false);
            for a in &mut poles {
                if let Some(held) = held_within(a, search.radius)? {
                    (*a, is_held) = (held, true);
                }
            }
            match is_held {
                false => Some(there),
                true => self.completed(&poles, parts),
            }
        };
        least(start, search, &|theta| self.total(theta, parts), &within)
    }

    /// Errors and slopes of all records, one below the other; 0 for ignored samples.
    pub(super) fn linearised(&self, theta: &DVector<f64>) -> Linearised {
        let layout = &self.layout;
        let rows = self.signals.iter().map(|of| of.outputs.len()).sum();
        let mut errors = DVector::zeros(rows);
        let mut slopes = DMatrix::zeros(rows, theta.len());
        let mut first = 0;
        for (run, of) in self.signals.iter().enumerate() {
            let found = self.gone_through(theta, run);
            let counted = of.lead..of.outputs.len();
            for k in counted.clone() {
                errors[first + k] = found.errors[k];
            }
            let mut fill = |at: usize, shift: usize, sign: f64, signal: &[f64]| {
                for k in counted.clone().filter(|k| *k >= shift) {
                    slopes[(first + k, at)] = sign * signal[k - shift];
                }
            };
            for (number, [by_input, by_impulse, x]) in found.channels.iter().enumerate() {
                let by_pole = through_poles(&monic(&theta.as_slice()[layout.a(number)]), x);
                for (i, at) in layout.a(number).enumerate() {
                    fill(at, i + 1, -1.0, &by_pole);
                }
                for (j, at) in layout.b(number).enumerate() {
                    fill(at, j, 1.0, by_input);
                }
                for (i, at) in layout.motion(run, number).enumerate() {
                    fill(at, i, 1.0, by_impulse);
                }
            }
            if let Some(at) = layout.offset(run) {
                fill(at, 0, 1.0, &of.constant);
            }
            first += of.outputs.len();
        }
        Linearised { errors, slopes }
    }
}
