//! Predictions some samples ahead, from the measured output before and the input in between.
//!
//! ```text
//! A y = B u + constant + C e      y(k) by the equation, from outputs and errors up to k - ahead, later errors 0
//! y = (B/A) u + offset + e/D      the simulation, and D's continuation of its error up to k - ahead
//! ```
//! For one sample ahead, the prediction error is the model's residual `e`. A model without a noise model predicts the same as it simulates.

use std::ops::RangeInclusive;

use planesman_linear::polynomial::product;

use crate::estimators::{Error, Estimate};
use crate::fit::{FitRange, fit};
use crate::structure::monic;
use planesman_record::{Run, filter};

/// The default prediction horizon, samples.
pub const AHEAD: usize = 10;

/// Maximum number of predictions from a measured past in a record.
const PREDICTIONS: usize = 20_000;

/// The sum of squared prediction errors, and the output's sum of squares at the same samples.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Missed {
    squares: f64,
    spread: f64,
}

impl Missed {
    /// Adds the sums of another record.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            spread: self.spread + other.spread,
        }
    }

    /// The fit, %; `None` if the output is constant, or the predictions diverge.
    pub(crate) fn fit(self) -> Option<f64> {
        fit(self.squares, self.spread)
    }

    /// Computes the sums from pairs of outputs and errors.
    pub(crate) fn by(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut spread = FitRange::default();
        let mut squares = 0.0;
        for (y, error) in pairs {
            spread.update(y, 1.0);
            squares += error.powi(2);
        }
        Self {
            squares,
            spread: spread.sum_of_squares(),
        }
    }
}

/// The errors of predictions at this horizon for record `number`, to which the model is fitted.
pub(crate) fn missed(found: &Estimate, number: usize, run: Run<'_>, ahead: usize) -> Missed {
    if found.error == Error::Output {
        return by_noise_model(found, number, run, ahead);
    }
    let model = found.model(number);
    let mut num = model.numerator(true);
    let order = model.a.len();
    num.resize(order + 1, 0.0);
    // What is known of the denominator multiplies constant and noise as well.
    let known = &found.layout.structure.known_denominator;
    let constant = constant(found, number) * known.iter().sum::<f64>();
    let noise = product(&monic(&found.noise_model), known);
    let errors = match noise.len() {
        1 => Vec::new(),
        _ => errors_of_equation(found, number, run),
    };
    let (u, y) = (found.about_level(run.inputs), run.outputs);
    let first = order + ahead - 1;
    let stride = (y.len() / PREDICTIONS).max(1);
    Missed::by((first..y.len()).step_by(stride).map(|end| {
        // From measured outputs up to end - ahead.
        let start = end + 1 - ahead;
        let forced = |k: usize| -> f64 {
            let terms = (0..=order).map(|j| num[j] * u[k - j]);
            let noise = noise.iter().enumerate().filter_map(|(i, c)| {
                let past = k.checked_sub(i).filter(|past| *past < start)?;
                Some(c * errors.get(past)?)
            });
            terms.sum::<f64>() + noise.sum::<f64>() + constant
        };
        (
            y[end],
            y[end] - extrapolated(y, &model.a, start..=end, forced),
        )
    }))
}

/// The prediction errors of a simulation that is corrected by the noise model, which predicts the simulation's error from earlier errors.
fn by_noise_model(found: &Estimate, number: usize, run: Run<'_>, ahead: usize) -> Missed {
    let errors = found.simulation_errors(number, run);
    let d = &found.noise_denominator;
    let unknown = found.unknown(run);
    Missed::by((unknown + d.len() + ahead - 1..errors.len()).map(|end| {
        let start = end + 1 - ahead;
        let predicted = match d.is_empty() {
            true => 0.0,
            false => extrapolated(&errors, d, start..=end, |_| 0.0),
        };
        (run.outputs[end], errors[end] - predicted)
    }))
}

/// The one-step prediction errors, from the first sample with a known past: the model's residuals of record `number`.
pub(crate) fn residuals(found: &Estimate, number: usize, run: Run<'_>) -> Vec<f64> {
    let (mut errors, past) = match found.error {
        Error::Equation => (
            errors_of_equation(found, number, run),
            found.layout.structure.history(),
        ),
        Error::Output => {
            let d = monic(&found.noise_denominator);
            let errors = found.simulation_errors(number, run);
            let unknown = found.unknown(run);
            (filter(&d, &[1.0], &errors), unknown + d.len() - 1)
        }
    };
    errors.drain(..past.min(errors.len()));
    errors
}

/// `e` of the difference equation at each sample, 0 before the first row.
fn errors_of_equation(found: &Estimate, number: usize, run: Run<'_>) -> Vec<f64> {
    let structure = &found.layout.structure;
    let mut errors = filter(
        &found.layout.denominator(found.theta.as_slice()),
        &[1.0],
        run.outputs,
    );
    let forced = forced(found, number, run);
    for (k, (error, forced)) in errors.iter_mut().zip(forced).enumerate() {
        *error = match k < structure.history() {
            true => 0.0,
            false => *error - forced,
        };
    }
    filter(&[1.0], &monic(&found.noise_model), &errors)
}

/// The output of the difference equation without noise, from the first measured outputs.
pub(crate) fn from_first_outputs(found: &Estimate, number: usize, run: Run<'_>) -> Vec<f64> {
    let a = found.layout.denominator(found.theta.as_slice());
    let first = found.layout.structure.history().min(run.outputs.len());
    let mut driving = filter(&a, &[1.0], &run.outputs[..first]);
    driving.extend(&forced(found, number, run)[first..]);
    filter(&[1.0], &a, &driving)
}

/// `B u + constant` of a record's difference equation.
fn forced(found: &Estimate, number: usize, run: Run<'_>) -> Vec<f64> {
    let driving = found.driving(run);
    let b = &found.theta.as_slice()[found.layout.b(number)];
    let constant = constant(found, number);
    let caused = filter(b, &[1.0], &driving);
    caused.into_iter().map(|it| it + constant).collect()
}

/// The constant of a record's difference equation.
fn constant(found: &Estimate, number: usize) -> f64 {
    let at = found.layout.offset(number);
    at.map_or(0.0, |at| found.theta[at])
}

/// Computes the last samples by `y_k = forced(k) - a1 y_(k-1) - ... - an y_(k-n)`, from the values before them.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::{Armax, Estimator, LeastSquares, WarmStarted};
    use crate::structure::{InitialState, Problem, Structure};
    use planesman_record::noise;

    #[test]
    fn one_sample_ahead_the_residual_is_missed_and_far_ahead_the_simulations_error() {
        let inputs = noise(4, 800);
        let noises = filter(&[1.0, 0.5], &[1.0, -1.5, 0.7], &noise(9, 800));
        let caused = filter(&[0.0, 1.0, 0.5], &[1.0, -1.5, 0.7], &inputs);
        let outputs: Vec<f64> = (caused.iter().zip(&noises))
            .map(|(x, v)| x + 0.3 * v + 2.0)
            .collect();
        let run = Run {
            inputs: &inputs,
            outputs: &outputs,
            ..Run::default()
        };
        let structure = Structure {
            start: InitialState::Estimated,
            ..Structure::of_order(2)
        };
        let problem = Problem::new(structure, 0.1, vec![run]).unwrap();
        let near = WarmStarted {
            poles: Vec::new(),
            noise: true,
        };
        let estimators: [&dyn Estimator; 3] = [&LeastSquares, &Armax, &near];
        for estimator in estimators {
            let found = estimator.fit(&problem).unwrap();
            let left = residuals(&found, 0, run);
            let squares: f64 = left.iter().map(|e| e * e).sum();
            let one = missed(&found, 0, run, 1);
            assert!((one.squares / squares - 1.0).abs() < 1e-9, "{estimator:?}");
            let own: f64 = found.residuals[0].iter().map(|e| e * e).sum();
            assert!((own / squares - 1.0).abs() < 1e-6, "{estimator:?}");
            let far = missed(&found, 0, run, 200).fit().unwrap();
            let simulated = found.simulated_fit(0, run, 0).unwrap();
            assert!(
                (far - simulated).abs() < 2.0,
                "{estimator:?}: {far} {simulated}"
            );
        }
    }
}
