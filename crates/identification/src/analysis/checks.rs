//! Figures that a verdict rests on: how much of the output the input causes, and the noise by a measure that does not
//! depend on the model.

use planesman_linear::polynomial::product;

use crate::estimators::Estimate;
use crate::fit::fit;
use crate::free_motion::without_free_motion;
use crate::selection::innovation_variance;
use crate::structure::{InitialState, Problem, variance};
use planesman_record::{Record, Run, filter};

/// A step is in the first samples of a record up to this one.
const FIRST_SAMPLES: usize = 20;
/// The share of the output's range within which it stands still.
const STANDS_STILL: f64 = 0.05;

/// The share of the output's squares that the input accounts for beyond constant and free motion, 0 to 1; negative
/// when the model makes it worse. `None` when nothing is left for the input.
pub(super) fn share_of_input(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
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
    let unknown = structure.unknown(run.past.len()).min(run.outputs.len());
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
    (total > 0.0 && share.is_finite()).then_some(share)
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
    // A step within an interval has a mean of both levels there.
    let is_a_step = step <= FIRST_SAMPLES && run.inputs[step + 1..].iter().all(|u| u == last);
    let stands = range(&run.outputs[..=step]) <= STANDS_STILL * range(run.outputs);
    (is_a_step && stands).then_some(*first)
}

/// The fit that the noise leaves to the best of models over the held-out data, %: the noise is what an equation of high
/// order leaves of all of the record. 0, which their mean has, where the outputs move less than that; `None` where the noise is not known.
pub(super) fn attainable_fit(problem: &Problem<'_>, held_out: &[f64]) -> Option<f64> {
    let noise = innovation_variance(problem)? * held_out.len() as f64;
    let fit = fit(noise, variance(held_out) * held_out.len() as f64);
    Some(fit.unwrap_or_default().max(0.0))
}
