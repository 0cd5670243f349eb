//! Intervals of poles and steady-state gain by a bootstrap of the residuals.
//!
//! Records are simulated with the estimate as the true system. The noise is drawn with replacement from the whitened residuals, and then coloured
//! again. The estimator fits each simulated record, with the same order and delay. The interval contains the middle 95 % of the results (Efron and
//! Tibshirani, *An Introduction to the Bootstrap*, 1993, ch. 13). In contrast to the interval from the covariance, it need not be symmetric.

use planesman_linear::polynomial::product;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::error::{IdentificationError, Result};
use crate::estimators::{Error, Estimate, Estimator, whitening};
use crate::prediction;
use crate::structure::{Problem, monic};
use crate::uncertainty::Reading;
use planesman_parallel::on_all_cores;
use planesman_record::{Run, filter};

/// Number of samples by which the simulated noise starts before the record.
const LEAD: usize = 500;
/// Minimum share of the simulated records whose fit must succeed.
const SUCCEED: f64 = 0.9;

/// A 95 % interval.
pub type Interval = (f64, f64);

/// Intervals by a bootstrap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bootstrap {
    /// Number of records that were simulated and fitted.
    pub refits: usize,
    /// Intervals of real and imaginary part of each pole in s, 1/s, in the order of [`Reading::continuous_poles`].
    pub poles: Vec<(Interval, Interval)>,
    /// The steady-state gain, output unit per input unit; `None` for a pole at z = 1.
    pub gain: Option<Interval>,
}

/// Poles in s as real and imaginary part, and the steady-state gain.
struct Values {
    poles: Vec<(f64, f64)>,
    gain: Option<f64>,
}

impl Values {
    fn of(estimate: &Estimate, run: usize) -> Option<Self> {
        let reading = Reading::new(estimate, run);
        let poles = reading.continuous_poles().ok()?;
        Some(Self {
            poles: poles.iter().map(|it| (it.value.re, it.value.im)).collect(),
            gain: reading.steady_state_gain().map(|gain| gain.value.re),
        })
    }
}

/// The intervals for run `run` of an estimate, from this many simulated records.
///
/// # Errors
/// [`IdentificationError`]: an estimate whose simulation has no bound, or an estimator that fails on one simulated record
/// in ten.
pub(super) fn bootstrap(
    estimator: &dyn Estimator,
    found: &Estimate,
    problem: &Problem<'_>,
    run: usize,
    refits: usize,
) -> Result<Bootstrap> {
    let simulated = Simulated::new(found, problem)?;
    let own = Values::of(found, run).ok_or(IdentificationError::Undetermined(
        "the model's poles cannot be found",
    ))?;
    let refit = |seed: &u64| -> Option<Values> {
        let outputs = simulated.outputs(*seed);
        let runs = problem.runs.iter().zip(&outputs);
        let again = Problem {
            runs: runs.map(|(run, outputs)| Run { outputs, ..*run }).collect(),
            ..problem.clone()
        };
        Values::of(&estimator.fit(&again).ok()?, run)
    };
    let seeds: Vec<u64> = (0..refits as u64).collect();
    let values: Vec<Values> = on_all_cores(&seeds, refit).into_iter().flatten().collect();
    if (values.len() as f64) < SUCCEED * refits as f64 {
        return Err(IdentificationError::Option(format!(
            "the bootstrap failed, because {} of {refits} simulated records do not determine a model of this order",
            refits - values.len()
        )));
    }
    let nearest: Vec<Vec<(f64, f64)>> = values
        .iter()
        .map(|it| paired(&own.poles, &it.poles))
        .collect();
    let poles = (0..own.poles.len()).map(|at| {
        let of = |part: fn(&(f64, f64)) -> f64| {
            let values = nearest.iter().filter_map(|poles| poles.get(at).map(part));
            middle(values.collect())
        };
        (of(|pole| pole.0), of(|pole| pole.1))
    });
    Ok(Bootstrap {
        refits: values.len(),
        poles: poles.collect(),
        gain: (own.gain).map(|_| middle(values.iter().filter_map(|it| it.gain).collect())),
    })
}

/// The model's output and its noise, for simulated records.
struct Simulated {
    /// The noise-free output of each record.
    outputs: Vec<Vec<f64>>,
    /// Numerator and denominator of the filter that produces the output noise from white noise.
    noise: (Vec<f64>, Vec<f64>),
    /// The whitened residuals to draw from.
    drawn: Vec<f64>,
}

impl Simulated {
    fn new(found: &Estimate, problem: &Problem<'_>) -> Result<Self> {
        let runs = || problem.runs.iter().enumerate();
        let mut residuals: Vec<Vec<f64>> = runs()
            .map(|(number, run)| prediction::residuals(found, number, *run))
            .collect();
        let colour = whitening(residuals.iter().map(Vec::as_slice));
        for values in &mut residuals {
            let lead = (colour.len() - 1).min(values.len());
            *values = filter(&colour, &[1.0], values).split_off(lead);
        }
        let mut drawn: Vec<f64> = residuals.concat();
        let mean = drawn.iter().sum::<f64>() / drawn.len().max(1) as f64;
        // What the parameters have taken from the residual.
        let free = drawn.len().saturating_sub(found.theta.len()).max(1);
        let size = (drawn.len() as f64 / free as f64).sqrt();
        drawn.iter_mut().for_each(|e| *e = (*e - mean) * size);
        let outputs: Vec<Vec<f64>> = runs()
            .map(|(number, run)| match found.error {
                Error::Output => found.simulate(number, *run),
                Error::Equation => prediction::from_first_outputs(found, number, *run),
            })
            .collect();
        let a = found.layout.denominator(found.theta.as_slice());
        let noise = match found.error {
            Error::Output => (
                vec![1.0],
                product(&monic(&found.noise_denominator), &colour),
            ),
            Error::Equation => (monic(&found.noise_model), product(&colour, &a)),
        };
        let simulated = Self {
            outputs,
            noise,
            drawn,
        };
        let bounded = |outputs: Vec<Vec<f64>>| {
            let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let mut pairs = outputs.iter().zip(&problem.runs);
            pairs.all(|(values, run)| largest(values) <= 1e3 * largest(run.outputs))
        };
        match simulated.drawn.is_empty() || !bounded(simulated.outputs(0)) {
            true => Err(IdentificationError::Option(
                "the bootstrap failed, because the simulation of the model grows without bound"
                    .to_owned(),
            )),
            false => Ok(simulated),
        }
    }

    /// The output of each record with newly drawn noise.
    fn outputs(&self, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (num, den) = &self.noise;
        let noisy = |output: &Vec<f64>| -> Vec<f64> {
            let white: Vec<f64> = (0..LEAD + output.len())
                .map(|_| self.drawn[random.random_range(0..self.drawn.len())])
                .collect();
            let noise = filter(num, den, &white).split_off(LEAD);
            output.iter().zip(noise).map(|(y, v)| y + v).collect()
        };
        self.outputs.iter().map(noisy).collect()
    }
}

/// Pairs each pole with the nearest pole of the other model; each pole is used once.
fn paired(own: &[(f64, f64)], others: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut left = others.to_vec();
    own.iter()
        .map_while(|pole| {
            let distance = |other: &(f64, f64)| libm::hypot(other.0 - pole.0, other.1 - pole.1);
            let at = (0..left.len())
                .min_by(|p, q| distance(&left[*p]).total_cmp(&distance(&left[*q])))?;
            Some(left.swap_remove(at))
        })
        .collect()
}

/// The interval that contains the middle 95 % of the values.
fn middle(mut values: Vec<f64>) -> Interval {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let last = values.len().saturating_sub(1) as f64;
        values.get((last * share).round() as usize).copied()
    };
    (at(0.025).unwrap_or(f64::NAN), at(0.975).unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{Options, analyse};
    use crate::estimators::Method;
    use crate::uncertainty::SIGMAS_95;
    use planesman_record::Record;
    use planesman_record::{noise, with_noise};

    #[test]
    fn on_a_long_record_the_intervals_are_those_of_the_covariance() {
        let inputs = noise(5, 600);
        let a = [1.0, -1.6, 0.7];
        let clean = filter(&[0.0, 0.2, 0.1], &a, &inputs);
        let by_equation = filter(&[1.0], &a, &noise(7, 600));
        for (method, outputs) in [
            (Method::OutputError, with_noise(&clean, 6, 0.2)),
            (Method::BoxJenkins, with_noise(&clean, 6, 0.2)),
            (
                Method::LeastSquares,
                (clean.iter().zip(by_equation).map(|(x, v)| x + 0.1 * v)).collect(),
            ),
        ] {
            let options = Options {
                method,
                order: Some(2),
                delay: Some(1),
                bootstrap: Some(400),
                ..Options::default()
            };
            let (u, y) = (vec![("u", inputs.clone())], vec![("y", outputs)]);
            let found = analyse(&Record::of_run(0.1, u, y).unwrap(), &options).unwrap();
            let bootstrap = found.bootstrap.as_ref().unwrap();
            let reading = found.reading();
            let pole = reading.continuous_poles().unwrap()[0];
            let gain = reading.steady_state_gain().unwrap();
            let (re, im) = bootstrap.poles[0];
            for (interval, value, deviation) in [
                (re, pole.value.re, pole.real_deviation()),
                (im, pole.value.im, pole.imaginary_deviation()),
                (
                    bootstrap.gain.unwrap(),
                    gain.value.re,
                    gain.real_deviation(),
                ),
            ] {
                let ratio = (interval.1 - interval.0) / (2.0 * SIGMAS_95 * deviation);
                assert!((0.75..1.33).contains(&ratio), "{method:?}: {ratio}");
                assert!(interval.0 < value && value < interval.1, "{method:?}");
            }
        }
    }
}
