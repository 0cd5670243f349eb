//! Blocks of the records that are left out, and the error there.

use std::ops::Range;

use planesman_linear::polynomial::product;

use crate::estimators::Part;
use crate::free_motion::without_free_motion;
use crate::structure::{Problem, monic, variance};
use planesman_record::{Run, filter};

/// Blocks of half a record.
pub(super) const HALVES: usize = 2;
/// Where the parts of a record begin and end, in tenths: halves and fifths are made of them.
const TENTHS: [usize; 7] = [0, 2, 4, 5, 6, 8, 10];
/// The blocks, in tenths.
const BLOCKS: [Range<usize>; 7] = [0..5, 5..10, 0..2, 2..4, 4..6, 6..8, 8..10];

/// The parts of the records and the blocks made of them.
pub(super) struct Folds {
    pub(super) parts: Vec<Part>,
    /// The samples of each record that are divided.
    samples: Vec<Range<usize>>,
    variance: f64,
}

impl Folds {
    /// Of records of which so many outputs at the beginning are driven by inputs that are not known.
    pub(super) fn of(runs: &[Run<'_>], unknown: &[usize]) -> Self {
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

    pub(super) fn count(&self) -> usize {
        BLOCKS.len()
    }

    /// Whether a part belongs to the block.
    pub(super) fn is_left_out(&self, fold: usize, part: usize) -> bool {
        let tenths = TENTHS[part % (TENTHS.len() - 1)];
        BLOCKS[fold].contains(&tenths)
    }

    /// The parts that are kept; those behind the block without their first `lead` samples, whose residual would know
    /// of it.
    pub(super) fn kept(&self, fold: usize, lead: usize) -> Vec<Part> {
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

    /// The mean squared simulation error over the block, for each degree of freedom left, over the output's variance.
    /// With the errors of a simulation through the whole record, `through`, the state that the samples before the block
    /// led to is kept; without, and where no sample before it is known to be driven, the state there is fitted.
    pub(super) fn error(
        &self,
        fold: usize,
        problem: &Problem<'_>,
        driving: &[Vec<f64>],
        model: &Fold<'_>,
        through: Option<&[Vec<f64>]>,
    ) -> f64 {
        let monic = monic(model.a);
        let free = product(&monic, &problem.structure.known_denominator);
        let (mut squares, mut samples) = (0.0, 0);
        for (run, of) in problem.runs.iter().enumerate() {
            let Range { start, end } = BLOCKS[fold];
            let (begins, end) = (
                tenth(&self.samples[run], start),
                tenth(&self.samples[run], end),
            );
            let unknown = problem.structure.unknown(of.past.len());
            let block = begins.max(unknown).min(end)..end;
            if let Some(through) = through
                && begins > unknown
            {
                squares += through[run][block.clone()]
                    .iter()
                    .map(|e| e * e)
                    .sum::<f64>();
                samples += block.len();
                continue;
            }
            let simulated = filter((model.numerator)(run), &monic, &driving[run][block.clone()]);
            let offset = (model.offset)(run);
            let left = of.outputs[block.clone()].iter().zip(&simulated);
            let left: Vec<f64> = left.map(|(y, x)| y - x - offset).collect();
            squares += without_free_motion(&left, &free);
            samples += block.len().saturating_sub(free.len() - 1);
        }
        let mean = squares / samples.max(1) as f64 / self.variance;
        if mean.is_finite() {
            mean
        } else {
            f64::INFINITY
        }
    }
}

/// So many tenths into a range.
fn tenth(of: &Range<usize>, tenths: usize) -> usize {
    of.start + of.len() * tenths / 10
}

/// A model that was fitted with a block left out.
pub(super) struct Fold<'a> {
    pub(super) a: &'a [f64],
    /// `b1 ... bm` of a record.
    pub(super) numerator: &'a dyn Fn(usize) -> &'a [f64],
    pub(super) offset: &'a dyn Fn(usize) -> f64,
}
