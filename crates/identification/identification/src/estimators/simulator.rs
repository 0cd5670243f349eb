//! Simulates records with any parameters: the output error and its slopes.
//!
//! ```text
//! x = (B/A) u + (M/A) impulse,   yhat = x + offset,   e = y - yhat
//! dyhat/da_i = -q^-i x / A,   dyhat/db_j = q^-j u / A,   dyhat/dm_i = q^-i impulse / A
//! ```
//! `u` has been filtered by the known factors and delayed; `M` exists for a record that begins in motion. With a noise model `1/D`
//! everything is first filtered by `D`, and the first samples, whose past is missing, are ignored.

use nalgebra::{DMatrix, DVector};

use super::coloured::{whitened, whitening};
use super::estimate::{Error, Estimate};
use super::levenberg_marquardt::{Linearised, unit_factor};
use super::normal_equations::Signals;
use super::rows::{freedom, samples_by_run};
use crate::error::Result;
use crate::structure::{Layout, Problem};
use planesman_record::filter;

/// The records, prepared for simulation with any parameters.
pub(super) struct Simulator<'a> {
    problem: &'a Problem<'a>,
    layout: Layout,
    whitening: Vec<f64>,
    signals: Vec<Signals>,
    rows: usize,
}

impl<'a> Simulator<'a> {
    pub(super) fn new(problem: &'a Problem<'a>) -> Self {
        Self::whitened(problem, vec![1.0])
    }

    /// Prepares the records with the filter `1, d1, ..., dk`, which whitens the residual.
    pub(super) fn whitened(problem: &'a Problem<'a>, whitening: Vec<f64>) -> Self {
        Self {
            problem,
            layout: problem.layout(),
            signals: Signals::of(problem, &whitening),
            whitening,
            rows: problem.runs.iter().map(|run| run.outputs.len()).sum(),
        }
    }

    /// `B/A u` of a record, without offset and motion.
    pub(super) fn simulate_input_response(&self, theta: &DVector<f64>, run: usize) -> Vec<f64> {
        let b: Vec<f64> = theta.as_slice()[self.layout.b(run)].to_vec();
        filter(&b, &self.denominator(theta), &self.signals[run].driving)
    }

    /// `1, a1 ... an`.
    pub(super) fn denominator(&self, theta: &DVector<f64>) -> Vec<f64> {
        self.layout.denominator(theta.as_slice())
    }

    /// `y - yhat` and its slopes, all records one below the other.
    pub(super) fn linearised(&self, theta: &DVector<f64>) -> Linearised {
        let mut errors = DVector::zeros(self.rows);
        let mut slopes = DMatrix::zeros(self.rows, self.layout.count());
        let a = self.denominator(theta);
        let mut first = 0;
        for (r, run) in self.problem.runs.iter().enumerate() {
            let count = run.outputs.len();
            let motion: Vec<f64> = theta.as_slice()[self.layout.motion(r)].to_vec();
            let of = &self.signals[r];
            let mut x = self.simulate_input_response(theta, r);
            for (x, m) in x.iter_mut().zip(filter(&motion, &a, &of.impulse)) {
                *x += m;
            }
            let offset = self.layout.offset(r);
            for k in 0..count {
                let offset = offset.map_or(0.0, |at| theta[at] * of.constant[k]);
                errors[first + k] = of.outputs[k] - x[k] - offset;
            }
            let mut column = |at: usize, delay: usize, sign: f64, values: &[f64]| {
                for k in delay..count {
                    slopes[(first + k, at)] += sign * values[k - delay];
                }
            };
            let x = filter(&[1.0], &a, &x);
            for (i, at) in self.layout.a().enumerate() {
                column(at, i + 1, -1.0, &x);
            }
            let driving = filter(&[1.0], &a, &of.driving);
            for (j, at) in self.layout.b(r).enumerate() {
                column(at, j, 1.0, &driving);
            }
            if let Some(at) = offset {
                column(at, 0, 1.0, &of.constant);
            }
            let impulse = filter(&[1.0], &a, &of.impulse);
            for (i, at) in self.layout.motion(r).enumerate() {
                column(at, i, 1.0, &impulse);
            }
            let lead = of.lead;
            errors.rows_mut(first, lead).fill(0.0);
            slopes.rows_mut(first, lead).fill(0.0);
            first += count;
        }
        Linearised { errors, slopes }
    }

    /// The estimate at `theta`.
    pub(super) fn estimate(&self, theta: DVector<f64>, at: &Linearised) -> Result<Estimate> {
        let lead: usize = self.signals.iter().map(|of| of.lead).sum();
        let freedom = freedom(at.errors.len().saturating_sub(lead), theta.len())?;
        let noise_variance = at.errors.norm_squared() / freedom;
        let residuals = samples_by_run(self.problem, at.errors.as_slice());
        let mut factor = coloured_factor(at, &residuals, noise_variance)?;
        if self.whitening.len() > 1 {
            // The residual is nearly white, the noise on the output is not.
            let on_output = residuals
                .iter()
                .map(|of| filter(&[1.0], &self.whitening, of));
            let on_output: Vec<Vec<f64>> = on_output.collect();
            factor *= lost(&self.whitening, &on_output, theta.len());
        }
        let (problem, error) = (self.problem, Error::Output);
        Ok(Estimate {
            noise_denominator: self.whitening[1..].to_vec(),
            ..Estimate::of(problem, error, theta, factor, noise_variance, residuals)
        })
    }
}

/// A factor of the covariance of theta for a residual of any colour, `(psi'psi)^-1 psi' R psi (psi'psi)^-1`, with R from the autoregression
/// of the residual; for a white residual, of `variance (psi'psi)^-1`. The residuals are the errors of each record.
pub(super) fn coloured_factor(
    at: &Linearised,
    residuals: &[Vec<f64>],
    variance: f64,
) -> Result<DMatrix<f64>> {
    Ok(coloured(unit_factor(at)?, at, residuals, variance))
}

/// The covariance for a coloured residual, with a given factor of `(psi'psi)^-1`.
pub(crate) fn coloured(
    unit: DMatrix<f64>,
    at: &Linearised,
    residuals: &[Vec<f64>],
    variance: f64,
) -> DMatrix<f64> {
    let colour = whitening(residuals.iter().map(Vec::as_slice));
    if colour.len() == 1 {
        return unit * variance.sqrt();
    }
    // psi' R psi = variance of the white noise times |1/D, backwards in time, psi|^2.
    let mut backwards = at.slopes.clone();
    let (mut first, mut white) = (0, 0.0);
    for residual in residuals {
        white += filter(&colour, &[1.0], residual)
            .iter()
            .map(|e| e * e)
            .sum::<f64>();
        for mut column in backwards.column_iter_mut() {
            let mut values: Vec<f64> = column.rows(first, residual.len()).iter().copied().collect();
            values.reverse();
            let through = filter(&[1.0], &colour, &values);
            for (k, value) in through.into_iter().rev().enumerate() {
                column[first + k] = value;
            }
        }
        first += residual.len();
    }
    let white = white / at.errors.norm_squared() * variance;
    let triangle = (backwards * &unit).qr().r();
    let lost = lost(&colour, residuals, at.slopes.ncols());
    unit * triangle.transpose() * (white.sqrt() * lost)
}

/// Contribution of one output to the covariance of parameters that several outputs determine together, `U U' psi' R psi U U'`. `unit` is U, a factor
/// of the inverse information of all outputs; `slopes` are psi; R is the covariance of the output's errors, which have this variance and any colour.
/// `residuals` are its errors in each record, one below the other like the rows of psi.
#[must_use]
pub fn coloured_covariance(
    unit: &DMatrix<f64>,
    slopes: DMatrix<f64>,
    residuals: &[Vec<f64>],
    variance: f64,
) -> DMatrix<f64> {
    let is_white = whitening(residuals.iter().map(Vec::as_slice)).len() == 1;
    let factor = if is_white {
        unit * (slopes * unit).qr().r().transpose() * variance.sqrt()
    } else {
        let errors = DVector::from_vec(residuals.concat());
        coloured(
            unit.clone(),
            &Linearised { errors, slopes },
            residuals,
            variance,
        )
    };
    &factor * factor.transpose()
}

/// The factor on the standard deviations for the slow part of the noise that the fit has removed from coloured residuals (`D e` white). Of
/// the effective number of samples, `N D(1)^2 var e / V`, twice the number of parameters is lost. 1 for white residuals, whose degrees of
/// freedom are already taken into account.
pub(crate) fn lost(d: &[f64], residuals: &[Vec<f64>], parameters: usize) -> f64 {
    let squares = |of: &[f64]| of.iter().map(|e| e * e).sum::<f64>();
    let white: f64 = residuals.iter().map(|of| squares(&whitened(d, of))).sum();
    let share = residuals.iter().map(|of| squares(of)).sum::<f64>() / white;
    let count: usize = residuals.iter().map(Vec::len).sum();
    let worth = count as f64 * (share * d.iter().sum::<f64>().powi(2)).min(1.0);
    let lost = 2.0 * parameters as f64;
    (1.0 - lost / worth.max(2.0 * lost)).sqrt().recip()
}
