//! The difference equation of records with any noise model: its one-step errors and their slopes.
//!
//! ```text
//! e_k = y_k + sum a_i y_(k-i) - sum b_j u_(k-j) - constant - sum c_i e_(k-i)
//! -de/dtheta = [-y_(k-i), u_(k-j), 1, e_(k-i)] / C
//! ```

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use super::levenberg_marquardt::Linearised;
use super::rows::{regression, rows_by_run};
use crate::batch::Triangle;
use crate::error::Result;
use crate::structure::Problem;
use planesman_record::filter;

/// Rounds of extended least squares before the search.
const ROUNDS: usize = 5;

/// The difference equation of records, prepared for evaluation with any noise model.
pub(super) struct Equation {
    /// The regressors without the noise model.
    phi: DMatrix<f64>,
    outputs: DVector<f64>,
    /// Rows of each record.
    counts: Vec<usize>,
    n: usize,
}

impl Equation {
    pub(super) fn of(problem: &Problem<'_>) -> Self {
        let (phi, outputs) = regression(problem);
        let counts = rows_by_run(problem, outputs.as_slice());
        Self {
            counts: counts.iter().map(Vec::len).collect(),
            n: problem.structure.poles,
            phi,
            outputs,
        }
    }

    /// `e` with the parameters of the equation and `c1 ... cn`.
    pub(super) fn errors(&self, theta: &DVector<f64>, noise: &[f64]) -> Vec<f64> {
        let mut c = vec![1.0];
        c.extend(noise);
        let equation = &self.outputs - &self.phi * theta;
        self.through(&c, equation.as_slice())
    }

    /// The parameters found on a part of the records, without its constant.
    pub(super) fn continued(&self, found: &Estimate) -> DVector<f64> {
        let plain = self.phi.ncols();
        let known = found.layout.b(0);
        DVector::from_fn(plain + self.n, |i, _| match i.checked_sub(plain) {
            Some(i) => found.noise_model[i],
            None if i < known.end => found.theta[i],
            None => 0.0,
        })
    }

    /// Starts of the search: least squares, and extended least squares.
    pub(super) fn starts(&self) -> Result<Vec<DVector<f64>>> {
        let plain = self.phi.ncols();
        let first = Triangle::new(&self.phi, &self.outputs)?.solution()?;
        let mut theta = first.clone().insert_rows(plain, self.n, 0.0);
        for _ in 0..ROUNDS {
            let errors = self.linearised(&theta).errors;
            if errors.iter().any(|e| !e.is_finite()) {
                break;
            }
            let mut phi = self.phi.clone().insert_columns(plain, self.n, 0.0);
            self.shifted(errors.as_slice(), |row, i, e| phi[(row, plain + i - 1)] = e);
            match Triangle::new(&phi, &self.outputs).and_then(|t| t.solution()) {
                Ok(found) if self.cost(&found).is_finite() => theta = found,
                _ => break,
            }
        }
        Ok(vec![first.insert_rows(plain, self.n, 0.0), theta])
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

    pub(super) fn linearised(&self, theta: &DVector<f64>) -> Linearised {
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

    /// Filters each record's rows by `1/C`, from zero.
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
