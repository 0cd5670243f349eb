//! Difference equations with several inputs, from one matrix of products: likely delays, a high-order equation.
//!
//! ```text
//! A(q) y = sum Bi(q) u_i + constant + e
//! ```
//! Columns: `y(k-1) ... y(k-L)`, `u_i(k) ... u_i(k-L)` of each input, and `y(k)` itself; each record minus its means.

use nalgebra::{Cholesky, DMatrix, DVector};
use planesman_record::Segment;

use crate::states::HIGH;

/// Largest lag of inputs and outputs.
pub(super) const LAGS: usize = 40;
/// Maximum number of columns, over all inputs.
const COLUMNS: usize = 400;
/// Relative ridge on the regressors.
const RIDGE: f64 = 1e-12;
/// Orders of the equations for the search of delays, and rounds over the inputs.
const ORDERS: [usize; 5] = [1, 2, 3, 4, 6];
const ROUNDS: usize = 4;
/// Minimum number of rows for each parameter of a high-order equation.
const ROWS_PER_PARAMETER: usize = 4;

/// The products of the columns over all rows.
pub(super) struct Regressions {
    lags: usize,
    inputs: usize,
    products: DMatrix<f64>,
    rows: usize,
}

/// An equation `y = -a1 y(k-1) - ... + sum b_i,0 u_i(k-d_i) + ...`.
#[derive(Clone, Debug)]
pub(super) struct Equation {
    pub(super) a: Vec<f64>,
    pub(super) b: Vec<Vec<f64>>,
    pub(super) delays: Vec<usize>,
    /// The mean squared error.
    pub(super) variance: f64,
    pub(super) rows: usize,
}

impl Equation {
    fn parameters(&self) -> usize {
        self.a.len() + self.b.iter().map(Vec::len).sum::<usize>()
    }

    fn criterion(&self, for_each: f64) -> f64 {
        let likelihood = self.rows as f64 * libm::log(self.variance.max(f64::MIN_POSITIVE));
        likelihood + for_each * self.parameters() as f64
    }

    /// The variance of the noise per degree of freedom.
    pub(super) fn noise_variance(&self) -> f64 {
        let freedom = self.rows.saturating_sub(self.parameters() + 1).max(1);
        self.variance * self.rows as f64 / freedom as f64
    }
}

impl Regressions {
    /// Computes the products for records with one output.
    pub(super) fn of(segments: &[Segment], inputs: usize) -> Self {
        let samples: usize = segments.iter().map(Segment::len).sum();
        let lags = LAGS
            .min(samples / (8 * (inputs + 1)).max(16))
            .min(COLUMNS / (inputs + 1))
            .max(2);
        let columns = lags + inputs * (lags + 1) + 1;
        let mut products = DMatrix::zeros(columns, columns);
        let mut rows = 0;
        for segment in segments.iter().filter(|it| it.len() > lags) {
            let centred = |values: &[f64]| -> Vec<f64> {
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                values.iter().map(|v| v - mean).collect()
            };
            let count = segment.len() - lags;
            let mut matrix = DMatrix::zeros(count, columns);
            let mut fill = |at: usize, signal: &[f64], shift: usize| {
                let values = signal[lags - shift..].iter();
                let mut column = matrix.column_mut(at);
                column.iter_mut().zip(values).for_each(|(it, v)| *it = *v);
            };
            let y = centred(&segment.outputs[0]);
            for shift in 1..=lags {
                fill(shift - 1, &y, shift);
            }
            fill(columns - 1, &y, 0);
            for (input, values) in segment.inputs.iter().enumerate() {
                let u = centred(values);
                for shift in 0..=lags {
                    fill(lags + input * (lags + 1) + shift, &u, shift);
                }
            }
            products += matrix.tr_mul(&matrix);
            rows += count;
        }
        Self {
            lags,
            inputs,
            products,
            rows,
        }
    }

    /// The equation of an order, with this many coefficients of each input from its delay on; `None` if the rows do not determine it.
    fn equation(&self, order: usize, delays: &[usize], numerator: usize) -> Option<Equation> {
        let lags = self.lags;
        if order > lags || delays.iter().any(|it| it + numerator > lags + 1) {
            return None;
        }
        let mut columns: Vec<usize> = (0..order).collect();
        for (input, delay) in delays.iter().enumerate() {
            let first = lags + input * (lags + 1) + delay;
            columns.extend(first..first + numerator);
        }
        let (count, last) = (columns.len(), self.products.ncols() - 1);
        if self.rows <= count + 1 {
            return None;
        }
        let scale = |at: usize| self.products[(at, at)].max(f64::MIN_POSITIVE).sqrt();
        let scales: Vec<f64> = columns.iter().map(|at| scale(*at)).collect();
        let matrix = DMatrix::from_fn(count, count, |i, j| {
            let ridge = if i == j { RIDGE } else { 0.0 };
            self.products[(columns[i], columns[j])] / (scales[i] * scales[j]) + ridge
        });
        let right = DVector::from_fn(count, |i, _| self.products[(columns[i], last)] / scales[i]);
        let found = Cholesky::new(matrix)?.solve(&right);
        let left = (self.products[(last, last)] - found.dot(&right)).max(0.0);
        let theta: Vec<f64> = (0..count).map(|i| found[i] / scales[i]).collect();
        let (a, b) = theta.split_at(order);
        theta.iter().all(|v| v.is_finite()).then(|| Equation {
            a: a.iter().map(|v| -v).collect(),
            b: b.chunks(numerator).map(<[f64]>::to_vec).collect(),
            delays: delays.to_vec(),
            variance: left / self.rows as f64,
            rows: self.rows,
        })
    }

    /// The equation with the lowest Bayesian criterion, each input with its best delay; given delays are kept.
    pub(super) fn likely(&self, delay: Option<usize>) -> Option<Equation> {
        let penalty = libm::log(self.rows.max(2) as f64);
        let of_order = |order: usize| {
            let first = delay.unwrap_or(1).min(self.lags + 1 - order.min(self.lags));
            let mut best = self.equation(order, &vec![first; self.inputs], order)?;
            for _ in 0..if delay.is_some() { 0 } else { ROUNDS } {
                let before = best.delays.clone();
                for input in 0..self.inputs {
                    for other in 0..=(self.lags + 1).saturating_sub(order) {
                        let mut delays = best.delays.clone();
                        delays[input] = other;
                        let found = self.equation(order, &delays, order);
                        if let Some(found) = found.filter(|it| it.variance < best.variance) {
                            best = found;
                        }
                    }
                }
                if best.delays == before {
                    break;
                }
            }
            Some(best)
        };
        let found = ORDERS.into_iter().filter_map(of_order);
        found.min_by(|p, q| p.criterion(penalty).total_cmp(&q.criterion(penalty)))
    }

    /// The high-order equation chosen by Akaike's criterion.
    pub(super) fn high_order(&self) -> Option<Equation> {
        let none = vec![0; self.inputs];
        let orders = HIGH.into_iter().filter(|order| {
            let parameters = order + self.inputs * (order + 1) + 1;
            *order <= self.lags && self.rows > ROWS_PER_PARAMETER * parameters
        });
        let found = orders.filter_map(|order| self.equation(order, &none, order + 1));
        found.min_by(|p, q| p.criterion(2.0).total_cmp(&q.criterion(2.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_record::{filter, noise, with_noise};

    #[test]
    fn each_input_is_given_its_own_delay() {
        let (u, v) = (noise(1, 2000), noise(2, 2000));
        let one = filter(&[0.0, 0.0, 0.0, 0.5], &[1.0, -0.8], &u);
        let two = filter(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], &[1.0, -0.8], &v);
        let y: Vec<f64> = one.iter().zip(&two).map(|(x, y)| x + y).collect();
        let segment = Segment {
            inputs: vec![u, v],
            outputs: vec![with_noise(&y, 3, 0.05)],
            ..Segment::default()
        };
        let found = Regressions::of(&[segment], 2).likely(None).unwrap();
        assert_eq!(found.delays, [3, 7]);
    }
}
