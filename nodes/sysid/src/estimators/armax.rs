//! ARMAX: the difference equation with a model of its noise.
//!
//! ```text
//! A y = B u + constant + C e,   C = 1 + c1 q^-1 + ... + cn q^-n
//! e_k = y_k + sum a_i y_(k-i) - sum b_j u_(k-j) - constant - sum c_i e_(k-i)
//! -de/dtheta = [-y_(k-i), u_(k-j), 1, e_(k-i)] / C
//! ```
//! Noise on the gyro alone is `C = A`, which this contains. The start is extended least squares,
//! iterated: least squares gives residuals, which are regressed on next; from there the
//! one-step prediction error is minimised (Ljung 1999, sec. 7.2 and 10.2).

use nalgebra::{DMatrix, DVector};

use super::least_squares::{by_run, freedom, regression};
use super::levenberg_marquardt::{Linearised, minimise, unit_covariance};
use super::recursive::{Kind, Recursive};
use super::{Error, Estimate, Estimator, OutputError, recursion};
use crate::batch::Triangle;
use crate::structure::{Problem, filter};

/// Rounds of extended least squares before the search.
const ROUNDS: usize = 5;
/// What the roots of C begin with, of those of A.
const NEAR: f64 = 0.98;

/// ARMAX: the equation error with a model of the noise.
#[derive(Clone, Copy, Debug)]
pub struct Armax;

impl Estimator for Armax {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate, String> {
        let model = Equation::of(problem);
        let starts = match problem.part() {
            Some(part) => vec![model.continued(&self.fit(&part)?)],
            None => {
                let mut starts = model.starts()?;
                starts.extend(model.of_simulation(problem));
                starts
            }
        };
        let (theta, at) = starts
            .into_iter()
            .filter_map(|start| minimise(start, |theta| model.linearised(theta)).ok())
            .min_by(|p, q| {
                p.1.errors
                    .norm_squared()
                    .total_cmp(&q.1.errors.norm_squared())
            })
            .ok_or("the search for the least prediction error found no minimum")?;
        let noise_variance = at.errors.norm_squared() / freedom(at.errors.len(), theta.len())?;
        let covariance = unit_covariance(&at)? * noise_variance;
        let plain = model.phi.ncols();
        Ok(Estimate {
            error: Error::Equation,
            layout: problem.layout(),
            sample_time: problem.sample_time,
            covariance: covariance.view((0, 0), (plain, plain)).into_owned(),
            noise_variance,
            noise_model: theta.rows(plain, model.n).iter().copied().collect(),
            residuals: by_run(problem, at.errors.as_slice()),
            theta: theta.rows(0, plain).into_owned(),
            physical: None,
        })
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>, String> {
        recursion(Kind::PredictionError, problem)
    }
}

/// The difference equation of records, ready to be gone through with any noise model.
pub(crate) struct Equation {
    /// The regression without noise.
    phi: DMatrix<f64>,
    outputs: DVector<f64>,
    /// Rows of each record.
    counts: Vec<usize>,
    n: usize,
}

impl Equation {
    pub(crate) fn of(problem: &Problem<'_>) -> Self {
        let (phi, outputs) = regression(problem);
        let counts = by_run(problem, outputs.as_slice());
        Self {
            counts: counts.iter().map(Vec::len).collect(),
            n: problem.structure.poles,
            phi,
            outputs,
        }
    }

    /// `e` with the parameters of the equation and `c1 ... cn`.
    pub(crate) fn errors(&self, theta: &DVector<f64>, noise: &[f64]) -> Vec<f64> {
        let mut c = vec![1.0];
        c.extend(noise);
        let equation = &self.outputs - &self.phi * theta;
        self.through(&c, equation.as_slice())
    }

    /// What was found in a part, without its constant.
    fn continued(&self, found: &Estimate) -> DVector<f64> {
        let plain = self.phi.ncols();
        let known = found.layout.b(0);
        DVector::from_fn(plain + self.n, |i, _| match i.checked_sub(plain) {
            Some(i) => found.noise_model[i],
            None if i < known.end => found.theta[i],
            None => 0.0,
        })
    }

    /// Where searches begin: least squares, and extended least squares.
    fn starts(&self) -> Result<Vec<DVector<f64>>, String> {
        let plain = self.phi.ncols();
        let first = Triangle::of(&self.phi, &self.outputs)?.solution()?;
        let mut theta = first.clone().insert_rows(plain, self.n, 0.0);
        for _ in 0..ROUNDS {
            let errors = self.linearised(&theta).errors;
            if errors.iter().any(|e| !e.is_finite()) {
                break;
            }
            let mut phi = self.phi.clone().insert_columns(plain, self.n, 0.0);
            self.shifted(errors.as_slice(), |row, i, e| phi[(row, plain + i - 1)] = e);
            match Triangle::of(&phi, &self.outputs).and_then(|t| t.solution()) {
                Ok(found) if self.cost(&found).is_finite() => theta = found,
                _ => break,
            }
        }
        Ok(vec![first.insert_rows(plain, self.n, 0.0), theta])
    }

    /// Where noise on the gyro alone would lead: the best simulation, with `C` near `A`.
    fn of_simulation(&self, problem: &Problem<'_>) -> Option<DVector<f64>> {
        let plain = self.phi.ncols();
        let simulation = OutputError.fit(problem).ok()?;
        let mut theta = simulation.theta.rows(0, plain).into_owned();
        let a: Vec<f64> = theta.rows(0, self.n).iter().copied().collect();
        let steady = 1.0 + a.iter().sum::<f64>();
        for run in 0..problem.runs.len() {
            if let Some(at) = simulation.layout.offset(run) {
                theta[at] *= steady;
            }
        }
        let theta = theta.insert_rows(plain, self.n, 0.0);
        // Roots of C a little inside those of A: c_i = rho^i a_i.
        Some(DVector::from_fn(plain + self.n, |i, _| {
            match i.checked_sub(plain) {
                Some(i) => NEAR.powi(i as i32 + 1) * a[i],
                None => theta[i],
            }
        }))
    }

    fn cost(&self, theta: &DVector<f64>) -> f64 {
        self.linearised(theta).errors.norm_squared()
    }

    /// Calls `put(row, i, value of row - i)` for the n values before each row of its record.
    fn shifted(&self, values: &[f64], mut put: impl FnMut(usize, usize, f64)) {
        let mut first = 0;
        for count in &self.counts {
            for k in 0..*count {
                for i in 1..=self.n.min(k) {
                    put(first + k, i, values[first + k - i]);
                }
            }
            first += count;
        }
    }

    fn linearised(&self, theta: &DVector<f64>) -> Linearised {
        let plain = self.phi.ncols();
        let mut c = vec![1.0];
        c.extend(theta.rows(plain, self.n).iter());
        let errors = self.errors(&theta.rows(0, plain).into_owned(), &c[1..]);
        let errors = DVector::from_vec(errors);
        let mut slopes = self.phi.clone().insert_columns(plain, self.n, 0.0);
        self.shifted(errors.as_slice(), |row, i, e| {
            slopes[(row, plain + i - 1)] = e
        });
        for mut column in slopes.column_iter_mut() {
            let values: Vec<f64> = column.iter().copied().collect();
            for (slot, value) in column.iter_mut().zip(self.through(&c, &values)) {
                *slot = value;
            }
        }
        Linearised { errors, slopes }
    }

    /// Each record's rows through `1/C`, from zero.
    fn through(&self, c: &[f64], values: &[f64]) -> Vec<f64> {
        let mut filtered = Vec::with_capacity(values.len());
        let mut rest = values;
        for count in &self.counts {
            let (own, others) = rest.split_at(*count);
            filtered.extend(filter(&[1.0], c, own));
            rest = others;
        }
        filtered
    }
}
