//! A finite impulse response: the output as a weighted sum of past inputs.
//!
//! ```text
//! y_k = b1 u_(k-d) + ... + bm u_(k-d-m+1) + constant + e_k
//! ```
//! The method is linear in its unknowns, and unbiased for noise of any colour that is independent of the input. A slow system needs many coefficients
//! (Ljung 1999, sec. 4.2). The Bayesian criterion chooses their number: the regressors of a shorter response are the first of a longer one, so one QR
//! gives the error of every length.

use nalgebra::DVector;

use super::estimate::{Error, Estimate};
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::Linearised;
use super::rows::{freedom, regression, rows_by_run};
use super::simulator::coloured_factor;
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::structure::{Problem, Structure};

/// Maximum number of coefficients: with a delay, the largest order of a model file.
const LONGEST: usize = 64;
/// Minimum number of rows for each coefficient, when the length is chosen.
const ROWS_PER_COEFFICIENT: usize = 5;

/// A finite impulse response by least squares.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fir {
    /// Number of coefficients; with `None` the Bayesian criterion chooses it.
    pub length: Option<usize>,
}

impl Fir {
    /// The problem without poles, with the requested or chosen number of coefficients.
    fn shaped<'a>(self, problem: &Problem<'a>) -> Result<Problem<'a>> {
        let of_length = |length: usize| Problem {
            structure: Structure {
                poles: 0,
                numerator: length,
                ..problem.structure.clone()
            },
            ..problem.clone()
        };
        if let Some(length) = self.length {
            return match length {
                0 => Err(IdentificationError::Option(
                    "a finite impulse response needs at least one coefficient".to_owned(),
                )),
                length => Ok(of_length(length)),
            };
        }
        let part = problem.part().unwrap_or_else(|| problem.clone());
        let samples: usize = part.runs.iter().map(|run| run.outputs.len()).sum();
        let most = LONGEST - problem.structure.delay.saturating_sub(1).min(LONGEST - 1);
        let most = most.min(samples / ROWS_PER_COEFFICIENT).max(1);
        let longest = Problem {
            structure: Structure {
                own_numerators: false,
                ..of_length(most).structure
            },
            ..part
        };
        Ok(of_length(best_length(&longest, most)))
    }
}

/// The number of coefficients, up to `most`, with the lowest Bayesian criterion, all on the same rows.
fn best_length(longest: &Problem<'_>, most: usize) -> usize {
    let (phi, outputs) = regression(longest);
    let (rows, constants) = (phi.nrows(), phi.ncols() - most);
    if rows <= phi.ncols() {
        return 1;
    }
    // Constants first, then the coefficients: what one adds takes a square off the error.
    let columns: Vec<usize> = (most..phi.ncols()).chain(0..most).collect();
    let mut rotated: DVector<f64> = outputs;
    phi.select_columns(&columns).qr().q_tr_mul(&mut rotated);
    let n = rows as f64;
    (1..=most)
        .map(|length| {
            let left = rotated.rows(constants + length, rows - constants - length);
            let variance = (left.norm_squared() / n).max(f64::MIN_POSITIVE);
            (
                n * libm::log(variance) + length as f64 * libm::log(n),
                length,
            )
        })
        .min_by(|p, q| p.0.total_cmp(&q.0))
        .map_or(1, |(_, length)| length)
}

impl Estimator for Fir {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let problem = self.shaped(problem)?;
        let (phi, outputs) = regression(&problem);
        let triangle = Triangle::new(&phi, &outputs)?;
        let theta = triangle.solution()?;
        let noise_variance = triangle.cost / freedom(triangle.rows, theta.len())?;
        let errors = outputs - &phi * &theta;
        let residuals = rows_by_run(&problem, errors.as_slice());
        let at = Linearised {
            errors,
            slopes: phi,
        };
        let factor = coloured_factor(&at, &residuals, noise_variance)?;
        Ok(Estimate::of(
            &problem,
            Error::Equation,
            theta,
            factor,
            noise_variance,
            residuals,
        ))
    }

    fn learner(&self, _: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        Err(IdentificationError::Option(
            "the length of a finite impulse response can be chosen only from a complete record"
                .to_owned(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::InitialState;
    use planesman_record::noise;
    use planesman_record::{Run, filter};

    /// `(q^-1 + 0.5 q^-2) / (1 - 1.5 q^-1 + 0.7 q^-2) u + 0.3 v + 2`, v slow.
    fn record(seed: u32) -> (Vec<f64>, Vec<f64>) {
        let u = noise(seed, 600);
        let clean = filter(&[0.0, 1.0, 0.5], &[1.0, -1.5, 0.7], &u);
        let v = filter(&[1.0], &[1.0, -0.8], &noise(seed + 5, 600));
        let y = clean.iter().zip(&v).map(|(x, v)| x + 0.3 * v + 2.0);
        (u, y.collect())
    }

    fn found(fir: Fir, seed: u32) -> Estimate {
        let (inputs, outputs) = record(seed);
        let structure = Structure {
            start: InitialState::Estimated,
            ..Structure::of_order(2)
        };
        let (inputs, outputs) = (&inputs[..], &outputs[..]);
        let problem = Problem::new(
            structure,
            0.1,
            vec![Run {
                inputs,
                outputs,
                ..Run::default()
            }],
        );
        fir.fit(&problem.unwrap()).unwrap()
    }

    /// numpy: lstsq for each length up to 64 on the same rows, then of the best on all its rows.
    #[test]
    fn length_and_coefficients_are_those_of_numpy() {
        let found = found(Fir::default(), 4);
        assert_eq!(found.layout.b(0).len(), 19);
        let expected = [
            0.998_258_04,
            1.985_622_92,
            2.303_854_31,
            2.070_880_04,
            1.469_749_75,
            0.769_937_41,
        ];
        for (it, expected) in found.theta.iter().zip(expected) {
            assert!((it - expected).abs() < 1e-7, "{}", found.theta);
        }
        assert!((found.offset(0) - 1.927_789_05).abs() < 1e-7);
        // In full: as many poles at z = 0 as coefficients.
        assert_eq!(found.model(0).a, vec![0.0; 19]);
    }

    #[test]
    fn the_length_may_be_given() {
        assert_eq!(found(Fir { length: Some(8) }, 4).layout.b(0).len(), 8);
    }

    #[test]
    fn the_intervals_hold_in_slow_noise() {
        // The response's coefficients are 1, 2, 2.3, 2.05; 95 % of 160 is 152, its standard deviation 2.8.
        let within: usize = (0..40)
            .map(|seed| {
                let found = found(Fir { length: Some(24) }, 100 + 37 * seed);
                let pairs = [1.0, 2.0, 2.3, 2.05].into_iter().enumerate();
                pairs
                    .filter(|(i, truth)| {
                        let deviation = found.covariance[(*i, *i)].sqrt();
                        (found.theta[*i] - truth).abs() < 1.96 * deviation
                    })
                    .count()
            })
            .sum();
        assert!((142..=160).contains(&within), "{within}");
    }
}
