//! Blocks of the records that are left out in cross-validation, and the errors on them.

use std::ops::Range;

use planesman_linear::polynomial::product;

use crate::estimators::Part;
use crate::free_motion::{STATE_SAMPLES, STATE_SHARE, carried_on, without_free_motion};
use crate::structure::{Problem, monic, variance};
use planesman_record::{Run, filter};

/// Blocks of half a record.
pub(crate) const HALVES: usize = 2;
/// The boundaries of a record's parts, in tenths; halves and fifths consist of these parts.
const TENTHS: [usize; 7] = [0, 2, 4, 5, 6, 8, 10];
/// The blocks, in tenths.
const BLOCKS: [Range<usize>; 7] = [0..5, 5..10, 0..2, 2..4, 4..6, 6..8, 8..10];

/// The parts of the records and the blocks made of them.
pub(crate) struct Folds {
    pub(super) parts: Vec<Part>,
    /// The range of samples that is divided, for each record.
    samples: Vec<Range<usize>>,
    variance: f64,
}

impl Folds {
    /// Divides records whose first `unknown` outputs depend on unknown inputs.
    pub(crate) fn of(runs: &[Run<'_>], unknown: &[usize]) -> Self {
        let counts = runs.iter().map(|run| run.outputs.len());
        let samples = counts
            .zip(unknown)
            .map(|(count, first)| (*first).min(count)..count);
        let samples: Vec<Range<usize>> = samples.collect();
        let parts = samples.iter().enumerate().flat_map(|(run, of)| {
            TENTHS.windows(2).map(move |pair| Part {
                run,
                samples: tenth(of, pair[0])..tenth(of, pair[1]),
            })
        });
        Self {
            parts: parts.collect(),
            samples,
            variance: runs
                .iter()
                .map(|run| variance(run.outputs))
                .fold(0.0, f64::max),
        }
    }

    pub(crate) fn count(&self) -> usize {
        BLOCKS.len()
    }

    /// The largest variance of an output.
    pub(crate) fn variance(&self) -> f64 {
        self.variance
    }

    /// The samples of each record that a block leaves out.
    pub(crate) fn blocks(&self, fold: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
        let Range { start, end } = BLOCKS[fold];
        let samples = self.samples.iter().enumerate();
        samples.map(move |(run, of)| (run, tenth(of, start)..tenth(of, end)))
    }

    /// Whether a part belongs to the block.
    pub(super) fn is_left_out(&self, fold: usize, part: usize) -> bool {
        let tenths = TENTHS[part % (TENTHS.len() - 1)];
        BLOCKS[fold].contains(&tenths)
    }

    /// The parts that are kept; those after the block without their first `lead` samples, whose residual depends on the block.
    pub(crate) fn kept(&self, fold: usize, lead: usize) -> Vec<Part> {
        let parts = self.parts.iter().enumerate();
        parts
            .filter(|(i, _)| !self.is_left_out(fold, *i))
            .map(|(i, part)| {
                let behind =
                    i > 0 && self.parts[i - 1].run == part.run && self.is_left_out(fold, i - 1);
                let Range { start, end } = part.samples;
                let start = if behind {
                    (start + lead).min(end)
                } else {
                    start
                };
                Part {
                    run: part.run,
                    samples: start..end,
                }
            })
            .collect()
    }

    /// The parts before and after the block in each record, as separate records, if they are at least a tenth of the record.
    pub(super) fn around<'a>(&self, fold: usize, runs: &[Run<'a>]) -> Vec<Run<'a>> {
        let of = runs.iter().zip(&self.samples).flat_map(|(run, samples)| {
            let Range { start, end } = BLOCKS[fold];
            let (begin, end) = (tenth(samples, start), tenth(samples, end));
            let piece = |of: Range<usize>| Run {
                past: if of.start == 0 {
                    run.past
                } else {
                    &run.inputs[..of.start]
                },
                inputs: &run.inputs[of.clone()],
                outputs: &run.outputs[of],
            };
            let pieces = [0..begin, end..run.outputs.len()].into_iter();
            let least = samples.len() / 10;
            pieces.filter(move |of| of.len() >= least.max(1)).map(piece)
        });
        of.collect()
    }

    /// The mean squared simulation error over the block, per degree of freedom, over the output's variance.
    pub(super) fn error(
        &self,
        fold: usize,
        problem: &Problem<'_>,
        driving: &[Vec<f64>],
        model: &Fold<'_>,
        state: State<'_>,
    ) -> f64 {
        let monic = monic(model.a);
        let free = product(&monic, &problem.structure.known_denominator);
        let order = free.len() - 1;
        let (mut squares, mut samples) = (0.0, 0);
        for (run, of) in problem.runs.iter().enumerate() {
            let Range { start, end } = BLOCKS[fold];
            let divided = &self.samples[run];
            let unknown = problem.structure.unknown(of.past.len());
            let end = tenth(divided, end);
            let begin = tenth(divided, start).max(unknown).min(end);
            // What a simulation from rest at the first of the samples leaves.
            let left = |of_samples: Range<usize>| -> Vec<f64> {
                let input = &driving[run][of_samples.clone()];
                let simulated = filter((model.numerator)(run), &monic, input);
                let offset = (model.offset)(run);
                let pairs = of.outputs[of_samples].iter().zip(&simulated);
                pairs.map(|(y, x)| y - x - offset).collect()
            };
            let before = (divided.len() / STATE_SHARE).max(STATE_SAMPLES * order);
            match state {
                State::Through(errors) if begin > unknown => {
                    squares += errors[run][begin..end].iter().map(|e| e * e).sum::<f64>();
                    samples += end - begin;
                }
                State::Before if begin >= unknown + before => {
                    let errors = left(begin - before..end);
                    squares += carried_on(&errors, before, &free).unwrap_or(f64::INFINITY);
                    samples += end - begin;
                }
                _ => {
                    let window = match state {
                        State::Fitted(Some(window)) => window,
                        _ => usize::MAX,
                    };
                    let windows = ((end - begin) / window).max(1);
                    for at in 0..windows {
                        let [first, end] =
                            [at, at + 1].map(|at| begin + (end - begin) * at / windows);
                        squares += without_free_motion(&left(first..end), &free);
                        samples += (end - first).saturating_sub(order);
                    }
                }
            }
        }
        let mean = squares / samples.max(1) as f64 / self.variance;
        if mean.is_finite() {
            mean
        } else {
            f64::INFINITY
        }
    }
}

/// The initial state of a block; it is fitted in the block if the input before the block is not known.
#[derive(Clone, Copy, Debug)]
pub(super) enum State<'a> {
    /// The state comes from a simulation through the whole records, with these errors.
    Through(&'a [Vec<f64>]),
    /// The state is fitted to the samples just before the block.
    Before,
    /// The state is fitted in the block, or again in every window of this many samples.
    Fitted(Option<usize>),
}

/// The sample this many tenths into a range.
fn tenth(of: &Range<usize>, tenths: usize) -> usize {
    of.start + of.len() * tenths / 10
}

/// A model fitted with a block left out.
pub(super) struct Fold<'a> {
    pub(super) a: &'a [f64],
    /// `b1 ... bm` of a record.
    pub(super) numerator: &'a dyn Fn(usize) -> &'a [f64],
    pub(super) offset: &'a dyn Fn(usize) -> f64,
}
