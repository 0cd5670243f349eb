//! Regressions on past outputs and inputs, over whole records and parts, from one matrix of products.
//!
//! Columns: `y(k-1) ... y(k-L)`, `u(k) ... u(k-L)`, a constant, and `y(k)` itself. Every difference equation up to order and delay L is a
//! least-squares problem on some of these columns.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::estimators::Part;

/// Relative ridge on the regressors.
const RIDGE: f64 = 1e-12;

/// The products of the columns over the rows of each part.
pub(super) struct Lagged {
    /// L.
    pub(super) lags: usize,
    products: Vec<DMatrix<f64>>,
    rows: Vec<usize>,
}

/// A difference equation `y = -a1 y(k-1) - ... + b1 u(k-delay) + ... + constant`.
#[derive(Clone, Debug)]
pub(crate) struct Equation {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) constant: f64,
    /// The mean squared error.
    pub(crate) variance: f64,
    pub(crate) rows: usize,
}

impl Lagged {
    /// Computes the products. For records at rest the earlier samples are known: no input, and the first output.
    pub(super) fn of(
        inputs: &[Vec<f64>],
        outputs: &[Vec<f64>],
        lags: usize,
        parts: &[Part],
        unknown: &[usize],
        at_rest: bool,
    ) -> Self {
        let columns = 2 * lags + 3;
        let mut products = Vec::new();
        let mut rows = Vec::new();
        for part in parts {
            let (u, y) = (&inputs[part.run], &outputs[part.run]);
            let Range { start, end } = part.samples;
            let first = match at_rest {
                true => start,
                false => start.max(unknown[part.run] + lags),
            };
            let count = end.saturating_sub(first);
            let mut matrix = DMatrix::zeros(count, columns);
            let mut fill = |at: usize, signal: &[f64], shift: usize, rest: f64| {
                let value = |k: usize| k.checked_sub(shift).map_or(rest, |before| signal[before]);
                let mut column = matrix.column_mut(at);
                let values = column.iter_mut().zip(first..end);
                values.for_each(|(it, k)| *it = value(k));
            };
            let level = y.first().copied().unwrap_or_default();
            for shift in 1..=lags {
                fill(shift - 1, y, shift, level);
            }
            for shift in 0..=lags {
                fill(lags + shift, u, shift, 0.0);
            }
            fill(2 * lags + 2, y, 0, level);
            matrix.column_mut(2 * lags + 1).fill(1.0);
            products.push(matrix.tr_mul(&matrix));
            rows.push(count);
        }
        Self {
            lags,
            products,
            rows,
        }
    }

    /// The products over the selected parts, and their number of rows.
    pub(super) fn over(&self, counts: &dyn Fn(usize) -> bool) -> (DMatrix<f64>, usize) {
        let columns = 2 * self.lags + 3;
        let parts = self.products.iter().zip(&self.rows).enumerate();
        let none = (DMatrix::zeros(columns, columns), 0);
        parts
            .filter(|(i, _)| counts(*i))
            .fold(none, |(sum, rows), (_, (part, more))| {
                (sum + part, rows + more)
            })
    }

    /// The equation of `order` with `numerator` coefficients from `delay` on, with or without a constant; `None` if the rows do not
    /// determine it.
    pub(super) fn equation(
        &self,
        (products, rows): &(DMatrix<f64>, usize),
        order: usize,
        delay: usize,
        numerator: usize,
        constant: bool,
    ) -> Option<Equation> {
        let lags = self.lags;
        if delay + numerator > lags + 1 || order > lags {
            return None;
        }
        let mut columns: Vec<usize> = (0..order).collect();
        columns.extend((0..numerator).map(|j| lags + delay + j));
        columns.extend(constant.then_some(2 * lags + 1));
        if *rows <= columns.len() {
            return None;
        }
        let last = 2 * lags + 2;
        let count = columns.len();
        let scales: Vec<f64> = columns
            .iter()
            .map(|i| products[(*i, *i)].max(f64::MIN_POSITIVE).sqrt())
            .collect();
        let matrix = DMatrix::from_fn(count, count, |i, j| {
            let ridge = if i == j { RIDGE } else { 0.0 };
            products[(columns[i], columns[j])] / (scales[i] * scales[j]) + ridge
        });
        let right = DVector::from_fn(count, |i, _| products[(columns[i], last)] / scales[i]);
        let found = Cholesky::new(matrix)?.solve(&right);
        let left = (products[(last, last)] - found.dot(&right)).max(0.0);
        let theta: Vec<f64> = (0..count).map(|i| found[i] / scales[i]).collect();
        theta.iter().all(|v| v.is_finite()).then(|| Equation {
            a: theta[..order].iter().map(|v| -v).collect(),
            b: theta[order..order + numerator].to_vec(),
            constant: if constant { theta[count - 1] } else { 0.0 },
            variance: left / *rows as f64,
            rows: *rows,
        })
    }
}
