//! Figures that a verdict rests on: how much of the output the input causes, and the noise by a measure that does not
//! depend on the model.

use planesman_linear::polynomial::product;

use crate::estimators::{Estimate, whitening};
use crate::fit::fit;
use crate::free_motion::without_free_motion;
use crate::selection::innovation_variance;
use crate::structure::{InitialState, Problem, variance};
use planesman_record::{Record, Run, filter};

/// A step is in the first samples of a record up to this one.
const FIRST_SAMPLES: usize = 20;
/// The share of the output's range within which it stands still.
const STANDS_STILL: f64 = 0.05;

/// What the input accounts for in the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputPart {
    /// The share of the output's squares beyond constant and free motion, 0 to 1; negative when the model makes it worse.
    pub share: f64,
    /// The same for each coefficient of the numerator, over the variance of the noise: the F statistic. Of a noise with colour
    /// its slow variance counts, which a response is taken for most easily.
    pub f: f64,
}

/// What the input accounts for in a record. `None` when nothing is left for it.
pub(super) fn part_of_input(found: &Estimate, number: usize, run: Run<'_>) -> Option<InputPart> {
    let structure = &found.layout.structure;
    let a = found.layout.denominator(found.theta.as_slice());
    let b = &found.theta.as_slice()[found.layout.b(number)];
    // A constant is one more free motion, at z = 1.
    let free = match structure.start {
        InitialState::Rest => vec![1.0, -1.0],
        InitialState::Estimated => {
            let mut free = product(&product(&a, &structure.known_denominator), &[1.0, -1.0]);
            free.resize(free.len().max(structure.numerator + 1), 0.0);
            free
        }
    };
    let unknown = found.unknown(run).min(run.outputs.len());
    let outputs = &run.outputs[unknown..];
    let mean = outputs.iter().sum::<f64>() / outputs.len().max(1) as f64;
    let caused = filter(b, &a, &found.driving(run)[unknown..]);
    let level = caused.first().copied().unwrap_or_default();
    let centred: Vec<f64> = outputs.iter().map(|y| y - mean).collect();
    let with: Vec<f64> = (centred.iter().zip(&caused))
        .map(|(y, x)| y - (x - level))
        .collect();
    let (alone, with) = (
        without_free_motion(&centred, &free),
        without_free_motion(&with, &free),
    );
    // An integrator's motion about a mean of its input is a straight line, which is not the output's variation.
    let known = product(&structure.known_denominator, &[1.0, -1.0]);
    let total = match structure.start {
        InitialState::Rest => alone,
        InitialState::Estimated => without_free_motion(&centred, &known),
    };
    let share = (alone - with) / total;
    let f = slow_variance(found, number, run).map_or(f64::INFINITY, |noise| {
        (alone - with) / structure.numerator as f64 / noise
    });
    (total > 0.0 && share.is_finite()).then_some(InputPart { share, f })
}

/// The variance of an estimate's errors of simulation, and of slow changes in them where those are larger:
/// `V / D(1)^2` of an autoregression `D e` white with variance V.
fn slow_variance(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
    let simulated = found.simulate(number, run);
    let pairs = run.outputs.iter().zip(&simulated);
    let errors: Vec<f64> = pairs.map(|(y, x)| y - x).skip(found.unknown(run)).collect();
    let d = whitening([errors.as_slice()].into_iter());
    let white = filter(&d, &[1.0], &errors).split_off((d.len() - 1).min(errors.len()));
    let mean = |of: &[f64]| of.iter().map(|e| e * e).sum::<f64>() / of.len().max(1) as f64;
    let slow = mean(&white) / d.iter().sum::<f64>().powi(2);
    Some(slow.max(mean(&errors))).filter(|it| *it > 0.0)
}

/// The input before a step in the first samples of a record, where it does nothing else, and the output stands still
/// until the step: a motion at the beginning would be the step's own.
pub(super) fn level_before_step(record: &Record) -> Option<f64> {
    let [number] = record.used()[..] else {
        return None;
    };
    let run = record.segments[number].run()?;
    let (first, last) = (run.inputs.first()?, run.inputs.last()?);
    let step = run.inputs.iter().position(|u| u != first)?;
    let range = |values: &[f64]| {
        let ends = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
                (low.min(*y), high.max(*y))
            });
        ends.1 - ends.0
    };
    let is_a_step = step <= FIRST_SAMPLES && run.inputs[step..].iter().all(|u| u == last);
    let stands = range(&run.outputs[..=step]) <= STANDS_STILL * range(run.outputs);
    (is_a_step && stands).then_some(*first)
}

/// The fit that the noise leaves to the best of models over the held-out data, %: the noise is what an equation of high
/// order leaves of all of the record. `None` where that is not known.
pub(super) fn attainable_fit(problem: &Problem<'_>, held_out: &[f64]) -> Option<f64> {
    let noise = innovation_variance(problem)? * held_out.len() as f64;
    fit(noise, variance(held_out) * held_out.len() as f64).or(Some(f64::NEG_INFINITY))
}
