//! Quantities behind the verdict: the share of the output caused by the input, and a noise estimate that does not depend on the model.

use nalgebra::Complex;
use planesman_linear::ComplexFunctions as _;
use planesman_linear::polynomial::{self, product};

use crate::batch::squares_left;
use crate::estimators::{Estimate, through_poles, whitened, whitening};
use crate::fit::fit;
use crate::free_motion::without_free_motion;
use crate::selection::{innovation_variance, process};
use crate::structure::{InitialState, Problem, range, variance};
use crate::validation::nonlinearity::{Cause, Finding};
use planesman_record::{Record, Run, filter};

/// Number of samples before a step that are needed to detect a trend, and the number of standard deviations above which a slope counts as a trend.
const FEW_SAMPLES: usize = 8;
const TREND: f64 = 3.3;
/// Thresholds for a mode that existed before the record: its motion counts as visible in the second half above this share of the output's deviation;
/// it lasts if this share of its amplitude is left at the end; the input hardly moves it below this share of the motion.
const SEEN: f64 = 0.03;
const LASTS: f64 = 0.1;
const HARDLY: f64 = 0.3;
/// Samples by which the input may act later than in the model, in the test of the residual for a straight line.
const MORE_LAGS: usize = 4;
/// The output counts as constant while its changes stay below this share of its range.
const STANDS_STILL: f64 = 0.05;

/// The part of the output that the input explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputPart {
    /// The explained share of the output's squares beyond constant and free motion, 0 to 1; negative if the model makes the error larger.
    pub share: f64,
    /// The F statistic of the input's parameters, relative to the noise, or to its slow changes if these are larger.
    pub f: f64,
}

/// Computes the part of the output that the input explains. `None` if no degrees of freedom are left.
pub(super) fn part_of_input(found: &Estimate, number: usize, run: Run<'_>) -> Option<InputPart> {
    let structure = &found.layout.structure;
    if found.output_curve.is_some() {
        return part_behind_curve(found, number, run);
    }
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
    let parameters = match &found.process {
        Some(process) => process.values.len(),
        None => structure.poles + structure.numerator,
    };
    let f = slow_variance(found, number, run).map_or(f64::INFINITY, |noise| {
        (alone - with) / parameters as f64 / noise
    });
    (total > 0.0 && share.is_finite()).then_some(InputPart { share, f })
}

/// The part that the input explains with a curve after the dynamics, relative to the output's squares about their mean.
fn part_behind_curve(found: &Estimate, number: usize, run: Run<'_>) -> Option<InputPart> {
    let structure = &found.layout.structure;
    let unknown = found.unknown(run).min(run.outputs.len());
    let errors = found.simulation_errors(number, run);
    let left: f64 = errors[unknown..].iter().map(|e| e * e).sum();
    let outputs = &run.outputs[unknown..];
    let total = variance(outputs) * outputs.len() as f64;
    let share = (total - left) / total;
    let parameters = (structure.poles + structure.numerator) as f64;
    let f = slow_variance(found, number, run)
        .map_or(f64::INFINITY, |noise| (total - left) / parameters / noise);
    (total > 0.0 && share.is_finite()).then_some(InputPart { share, f })
}

/// Variance of the simulation error, or of its slow changes if these are larger: `V / D(1)^2`, where the autoregression `D e` is white with variance
/// V. `None` without errors.
fn slow_variance(found: &Estimate, number: usize, run: Run<'_>) -> Option<f64> {
    let errors = found.simulation_errors(number, run);
    let errors = errors.get(found.unknown(run)..).unwrap_or_default();
    Some(slow_variance_of(errors, found.theta.len())).filter(|it| *it > 0.0)
}

/// The variance of [`slow_variance`], corrected for this number of parameters.
fn slow_variance_of(left: &[f64], parameters: usize) -> f64 {
    let d = whitening([left].into_iter());
    let white = whitened(&d, left);
    let variance = |of: &[f64]| {
        let freedom = of.len().saturating_sub(parameters).max(1);
        of.iter().map(|e| e * e).sum::<f64>() / freedom as f64
    };
    (variance(&white) / d.iter().sum::<f64>().powi(2)).max(variance(left))
}

/// Share (0 to 1) of the output's variation that a straight line explains, beyond the response of the model's poles to the input.
pub(super) fn drift(found: &Estimate, run: Run<'_>) -> f64 {
    let structure = &found.layout.structure;
    let unknown = found.unknown(run).min(run.outputs.len());
    let a = found.layout.denominator(found.theta.as_slice());
    let caused = through_poles(&a, &found.driving(run));
    let outputs = &run.outputs[unknown..];
    let later = |by: usize| -> Vec<f64> {
        let at = |row: usize| (row + unknown).checked_sub(by).map_or(0.0, |k| caused[k]);
        (0..outputs.len()).map(at).collect()
    };
    let mut columns = vec![vec![1.0; outputs.len()]];
    columns.extend((0..structure.numerator + MORE_LAGS).map(later));
    let without = squares_left(&columns, outputs);
    columns.push((0..outputs.len()).map(|row| row as f64).collect());
    let explained = without
        .zip(squares_left(&columns, outputs))
        .map(|(p, q)| p - q);
    let share = explained.unwrap_or_default() / (variance(outputs) * outputs.len() as f64);
    if share.is_finite() { share } else { 0.0 }
}

/// A lightly damped mode, rad per sample, that moved before the record, lasts through it, and is hardly moved by the input: it does not belong to the
/// plant.
pub(super) fn oscillation(found: &Estimate, number: usize, run: Run<'_>) -> Option<Finding> {
    let unknown = found.unknown(run).min(run.outputs.len());
    let a = found.layout.denominator(found.theta.as_slice());
    let b = &found.theta.as_slice()[found.layout.b(number)];
    let driving = &found.driving(run)[unknown..];
    let poles = polynomial::roots(&a).ok()?;
    let count = (run.outputs.len() - unknown) as f64;
    let lasts = |it: &Complex<f64>| it.im > 0.0 && libm::pow(it.modulus(), count) > LASTS;
    if !poles.iter().any(lasts) {
        return None;
    }
    let simulated = found.simulate(number, run).split_off(unknown);
    let caused = filter(b, &a, driving);
    let half = simulated.len() / 2;
    let free: Vec<f64> = (simulated[half..].iter().zip(&caused[half..]))
        .map(|(y, caused)| y - caused)
        .collect();
    // Its part of the free motion, beside those of the other modes.
    let motion = |pole: &Complex<f64>| -> Vec<Vec<f64>> {
        let powers: Vec<_> = (0..free.len()).map(|k| pole.powu(k as u32)).collect();
        vec![
            powers.iter().map(|it| it.re).collect(),
            powers.iter().map(|it| it.im).collect(),
        ]
    };
    let part = |pole: &Complex<f64>| {
        let others = (poles.iter()).filter(|it| it.im >= 0.0 && *it != pole);
        let mut columns = vec![vec![1.0; free.len()]];
        columns.extend(others.flat_map(motion));
        let without = squares_left(&columns, &free)?;
        columns.extend(motion(pole));
        let with = squares_left(&columns, &free)?;
        Some(((without - with).max(0.0) / free.len() as f64).sqrt())
    };
    let seen = SEEN * variance(&run.outputs[unknown..]).sqrt();
    // The mode's part of the response, 2 Re(r x) with x_k = p x_(k-1) + u_(k-1).
    let moved = |pole: &Complex<f64>| {
        let above: Complex<f64> = (b.iter().enumerate())
            .map(|(k, b)| pole.powi(poles.len() as i32 - k as i32) * *b)
            .sum();
        let beside = poles.iter().filter(|it| *it != pole);
        let residue = above / beside.map(|it| pole - it).product::<Complex<f64>>();
        let mut state = Complex::new(0.0, 0.0);
        let mut squares = 0.0;
        for u in driving {
            squares += 4.0 * (residue * state).re.powi(2);
            state = pole * state + *u;
        }
        (squares / driving.len().max(1) as f64).sqrt()
    };
    let lasting = poles.iter().filter(|it| lasts(it));
    lasting
        .filter(|it| part(it).is_some_and(|part| part > seen && moved(it) < HARDLY * part))
        .map(|it| Finding {
            cause: Cause::Oscillation(it.argument()),
            gain: None,
        })
        .next()
}

/// The input level before the step of a step test, if the output is constant until then: otherwise an initial motion could be mistaken for the step
/// response.
pub(super) fn level_before_step(record: &Record) -> Option<f64> {
    let [number] = record.used()[..] else {
        return None;
    };
    let run = record.segments[number].run()?;
    let step = process::first_step(run.inputs)?;
    let level = run.inputs[..step].iter().sum::<f64>() / step as f64;
    let after = &run.inputs[step..];
    let outputs = (run.outputs.first()?, run.outputs.last()?);
    let returns = (outputs.0 - outputs.1).abs() <= STANDS_STILL * range(run.outputs);
    let is_at_rest = after.iter().all(|u| *u == 0.0);
    if step == 1 && run.past.is_empty() && is_at_rest && returns {
        // An impulse in the first row: before it the input was 0 too. A step in the second row is none.
        return Some(0.0);
    }
    let stood = run.past.iter().all(|u| u == run.past.last().unwrap_or(u));
    let before = &run.outputs[..=step];
    let stands = range(before) <= STANDS_STILL * range(run.outputs);
    let is_noise = before.len() >= FEW_SAMPLES && !has_trend(before);
    (stood && (stands || is_noise)).then_some(level)
}

/// Whether values have a trend beyond their noise and its slow changes.
fn has_trend(values: &[f64]) -> bool {
    let count = values.len() as f64;
    let times = (0..values.len()).map(|k| k as f64 - (count - 1.0) / 2.0);
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = times.clone().map(|t| t * t).sum();
    let slope = times.clone().zip(values).map(|(t, y)| t * y).sum::<f64>() / squares;
    let left: Vec<f64> = times
        .zip(values)
        .map(|(t, y)| y - mean - slope * t)
        .collect();
    let slow = slow_variance_of(&left, 2);
    slope.powi(2) * squares > TREND.powi(2) * slow
}

/// The largest fit, %, that noise allows any model on the held-out data; the noise is estimated by a high-order equation of the whole record. The
/// result is 0, the fit of a constant, if the outputs move less than the noise; `None` if the noise is not known.
pub(super) fn attainable_fit(problem: &Problem<'_>, held_out: &[f64]) -> Option<f64> {
    let noise = innovation_variance(problem)? * held_out.len() as f64;
    let fit = fit(noise, variance(held_out) * held_out.len() as f64);
    Some(fit.unwrap_or_default().max(0.0))
}
