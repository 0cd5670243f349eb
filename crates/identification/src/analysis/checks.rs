//! Figures that a verdict rests on: how much of the output the input causes, how well the model predicts, and the
//! noise by a measure that does not depend on the model.

use std::ops::RangeInclusive;

use planesman_linear::polynomial::product;

use crate::estimators::{Error, Estimate};
use crate::fit::{Spread, fit};
use crate::free_motion::without_free_motion;
use crate::selection::innovation_variance;
use crate::structure::{Problem, Run, filter, variance};

/// Samples of a prediction.
pub const AHEAD: usize = 10;

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

/// The fit of predictions of [`AHEAD`] samples from the measured output and the input in between, %; `None` when the
/// output did not move.
pub(super) fn predicted_fit(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
    if found.error == Error::Output {
        return predicted_with_noise_model(found, number, run);
    }
    let model = found.model(number);
    let mut num = model.numerator(true);
    let order = model.a.len();
    num.resize(order + 1, 0.0);
    let constant = found
        .layout
        .offset(number)
        .map_or(0.0, |at| found.theta[at]);
    let (u, y) = (run.inputs, run.outputs);
    let first = order + AHEAD - 1;
    let stride = (y.len() / 20_000).max(1);
    let mut spread = Spread::default();
    let mut squares = 0.0;
    for end in (first..y.len()).step_by(stride) {
        // From measured outputs up to end - AHEAD.
        let start = end + 1 - AHEAD;
        let forced = |k: usize| -> f64 {
            let terms = (0..=order).map(|j| num[j] * u[k - j]);
            terms.sum::<f64>() + constant
        };
        let predicted = extrapolated(y, &model.a, start..=end, forced);
        spread.update(y[end], 1.0);
        squares += (y[end] - predicted).powi(2);
    }
    fit(squares, spread.sum_of_squares())
}

/// The same of a simulation, and what the noise model says of its error from the errors before.
fn predicted_with_noise_model(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
    let simulated = found.simulate(number, run.inputs);
    let errors: Vec<f64> = (run.outputs.iter().zip(&simulated))
        .map(|(y, x)| y - x)
        .collect();
    let d = &found.noise_denominator;
    let mut spread = Spread::default();
    let mut squares = 0.0;
    for end in d.len() + AHEAD - 1..errors.len() {
        let start = end + 1 - AHEAD;
        let predicted = extrapolated(&errors, d, start..=end, |_| 0.0);
        spread.update(run.outputs[end], 1.0);
        squares += (errors[end] - predicted).powi(2);
    }
    fit(squares, spread.sum_of_squares())
}

/// The last of some samples by `y_k = forced(k) - a1 y_(k-1) - ... - an y_(k-n)`, from the values before them.
fn extrapolated(
    values: &[f64],
    a: &[f64],
    samples: RangeInclusive<usize>,
    forced: impl Fn(usize) -> f64,
) -> f64 {
    let start = *samples.start();
    let mut past: Vec<f64> = values[start - a.len()..start].to_vec();
    for k in samples {
        let free: f64 = a.iter().zip(past.iter().rev()).map(|(a, y)| a * y).sum();
        past.push(forced(k) - free);
    }
    past.last().copied().unwrap_or_default()
}

/// The fit that the noise leaves to the best of models over the held-out data, %: the noise is what an equation of high
/// order leaves of all of the record. `None` where that is not known.
pub(super) fn attainable_fit(problem: &Problem<'_>, held_out: &[f64]) -> Option<f64> {
    let noise = innovation_variance(problem)? * held_out.len() as f64;
    fit(noise, variance(held_out) * held_out.len() as f64).or(Some(f64::NEG_INFINITY))
}

/// The share of the output's variation that a straight line explains, 0 to 1.
pub(super) fn share_of_line(outputs: &[f64]) -> f64 {
    let count = outputs.len() as f64;
    let (middle, mean) = (0.5 * (count - 1.0), outputs.iter().sum::<f64>() / count);
    let pairs = || {
        outputs
            .iter()
            .enumerate()
            .map(|(k, y)| (k as f64 - middle, y - mean))
    };
    let product: f64 = pairs().map(|(t, y)| t * y).sum();
    let squares: [f64; 2] = [
        pairs().map(|(t, _)| t * t).sum(),
        pairs().map(|(_, y)| y * y).sum(),
    ];
    let share = product * product / (squares[0] * squares[1]);
    if share.is_finite() { share } else { 0.0 }
}
