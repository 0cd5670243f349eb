//! Figures that a verdict rests on: how much of the output the input causes, and the noise by a measure that does not
//! depend on the model.

use planesman_linear::polynomial::product;

use crate::estimators::Estimate;
use crate::free_motion::without_free_motion;
use crate::selection::innovation_variance;
use crate::structure::{Problem, Run, filter, variance};

/// Smallest variance of the held-out output for a validation, in those of the noise.
const BEYOND_NOISE: f64 = 4.0;

/// The share of the output's squares, beyond constant and free motion, that the input accounts for, 0 to 1; negative
/// when the model makes it worse. `None` when nothing is left for the input.
pub(super) fn share_of_input(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
    let structure = &found.layout.structure;
    let a = found.layout.denominator(found.theta.as_slice());
    let b = &found.theta.as_slice()[found.layout.b(number)];
    // A constant is one more free motion, at z = 1.
    let free = product(&product(&a, &structure.known_denominator), &[1.0, -1.0]);
    let mean = run.outputs.iter().sum::<f64>() / run.outputs.len().max(1) as f64;
    let caused = filter(b, &a, &structure.driving(run.inputs));
    let level = caused.first().copied().unwrap_or_default();
    let alone: Vec<f64> = run.outputs.iter().map(|y| y - mean).collect();
    let with: Vec<f64> = (alone.iter().zip(&caused))
        .map(|(y, x)| y - (x - level))
        .collect();
    let (alone, with) = (
        without_free_motion(&alone, &free),
        without_free_motion(&with, &free),
    );
    let total = variance(run.outputs) * run.outputs.len() as f64;
    let share = (alone - with) / total;
    (total > 0.0 && share.is_finite()).then_some(share)
}

/// Whether the held-out output moves beyond the noise, which an equation of high order tells for all of the record.
pub(super) fn moves(problem: &Problem<'_>, held_out: &[f64]) -> bool {
    innovation_variance(problem).is_none_or(|noise| variance(held_out) > BEYOND_NOISE * noise)
}
