//! Poles for every order from one equation of high order.
//!
//! Two ways from a high-order equation to few poles. The Markov parameters `g1, g2, ...` of its transfer function
//! fill a Hankel matrix whose n largest singular directions are shift invariant up to the poles (Kung, *12th
//! Asilomar Conf.*, 1978). And the outputs to come, freed of what inputs and outputs between add to them, are
//! regressed on the past; the n directions most correlated are the state (Jansson, *IFAC SYSID*, 2003, after
//! Larimore's canonical variates). The second weights by the noise and holds in a closed loop too.

use nalgebra::{Cholesky, DMatrix, DVector};
use planesman_linear::poles::eigenvalues;
use planesman_linear::polynomial;

use super::lagged::{Equation, Lagged};
use crate::estimators::impulse;
use crate::structure::{filter, monic};

/// Orders of the high-order equation tried.
const HIGH: [usize; 4] = [5, 10, 20, 40];
/// Markov parameters in a row of the Hankel matrix.
const HANKEL: usize = 80;
/// Samples of past and future at most.
const HORIZON: usize = 25;

/// The equation of high order that Akaike's criterion takes.
pub(super) fn high_order(lagged: &Lagged, constant: bool) -> Option<Equation> {
    let all = lagged.over(&|_| true);
    let criterion = |of: &Equation| {
        let parameters = (of.a.len() + of.b.len()) as f64;
        of.rows as f64 * of.variance.max(f64::MIN_POSITIVE).ln() + 2.0 * parameters
    };
    HIGH.iter()
        .filter(|order| **order <= lagged.lags && all.1 > 4 * (2 * **order + 2))
        .filter_map(|order| lagged.equation(&all, *order, 0, order + 1, constant))
        .min_by(|p, q| criterion(p).total_cmp(&criterion(q)))
}

/// `a1 ... an` of the orders up to `most`, from the Markov parameters.
pub(super) fn from_markov_parameters(
    high: &Equation,
    samples: usize,
    most: usize,
) -> Vec<Vec<f64>> {
    let rows = HANKEL.min(samples / 4);
    if rows < 2 * most {
        return Vec::new();
    }
    let g = filter(&high.b, &monic(&high.a), &impulse(2 * rows));
    let early = g.iter().take(20).fold(0.0_f64, |m, v| m.max(v.abs()));
    if !g.iter().all(|v| v.is_finite() && v.abs() <= 1e6 * early) {
        return Vec::new();
    }
    let hankel = DMatrix::from_fn(rows, rows, |i, j| g[i + j + 1]);
    let symmetric = hankel.symmetric_eigen();
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|i, j| {
        let size = |i: &usize| symmetric.eigenvalues[*i].abs();
        size(j).total_cmp(&size(i))
    });
    (1..=most)
        .map_while(|n| {
            let observability = DMatrix::from_fn(rows, n, |i, j| {
                symmetric.eigenvectors[(i, order[j])] * symmetric.eigenvalues[order[j]].abs().sqrt()
            });
            let above = observability.rows(0, rows - 1).into_owned();
            let below = observability.rows(1, rows - 1).into_owned();
            characteristic(&solved(&above, &below)?)
        })
        .collect()
}

/// The same from the states of canonical variates.
pub(super) fn from_states(
    high: &Equation,
    inputs: &[f64],
    outputs: &[f64],
    most: usize,
) -> Vec<Vec<f64>> {
    let samples = outputs.len();
    let mut horizon = high.a.len().clamp(10, HORIZON);
    if samples < 18 * horizon {
        horizon = (samples / 18).max(3);
    }
    let (f, p) = (horizon, horizon);
    if samples < f + p + 4 * (f + 2 * p) {
        return Vec::new();
    }
    let count = samples - f - p;
    let shifted = |signal: &[f64], at: usize| signal[at..at + count].to_vec();
    let coefficient = |of: &[f64], i: usize| of.get(i).copied().unwrap_or_default();
    let mut future = DMatrix::zeros(count, f);
    for i in 0..f {
        let mut column = DVector::from_vec(shifted(outputs, p + i));
        for j in 0..i {
            let share = coefficient(&high.a, i - j - 1);
            column.axpy(
                share,
                &DVector::from_column_slice(&outputs[p + j..p + j + count]),
                1.0,
            );
        }
        for j in 0..=i {
            let share = coefficient(&high.b, i - j);
            column.axpy(
                -share,
                &DVector::from_column_slice(&inputs[p + j..p + j + count]),
                1.0,
            );
        }
        let mean = column.mean();
        future.set_column(i, &column.add_scalar(-mean));
    }
    let mut past = DMatrix::zeros(count, 2 * p);
    for i in 0..p {
        for (at, signal) in [(i, outputs), (p + i, inputs)] {
            let column = DVector::from_vec(shifted(signal, p - 1 - i));
            let mean = column.mean();
            past.set_column(at, &column.add_scalar(-mean));
        }
    }
    let root = |of: &DMatrix<f64>| {
        let products = of.tr_mul(of);
        let ridge = 1e-9 * products.trace() / products.nrows() as f64;
        let size = products.nrows();
        Cholesky::new(products + DMatrix::identity(size, size) * ridge).map(|it| it.l())
    };
    let (Some(of_future), Some(of_past)) = (root(&future), root(&past)) else {
        return Vec::new();
    };
    let joint = future.tr_mul(&past);
    let half = of_future.solve_lower_triangular(&joint);
    let whole = half.and_then(|half| of_past.solve_lower_triangular(&half.transpose()));
    let Some(svd) = whole.map(|it| it.transpose().svd(false, true)) else {
        return Vec::new();
    };
    let Some(directions) = svd.v_t else {
        return Vec::new();
    };
    (1..=most.min(f - 1))
        .map_while(|n| {
            let back = of_past.tr_solve_lower_triangular(&directions.rows(0, n).transpose())?;
            let states = &past * back;
            let rows = count - 1;
            let now = states.rows(0, rows);
            let mut regressors = DMatrix::zeros(rows, n + 2);
            regressors.columns_mut(0, n).copy_from(&now);
            regressors.set_column(n, &DVector::from_column_slice(&inputs[p..p + rows]));
            regressors.set_column(n + 1, &DVector::repeat(rows, 1.0));
            let measured = DMatrix::from_column_slice(rows, 1, &outputs[p..p + rows]);
            let explained = &regressors * solved(&regressors, &measured)?;
            let mut regressors = regressors.insert_column(n + 2, 0.0);
            regressors.set_column(n + 2, &(measured - explained).column(0));
            let next = states.rows(1, rows).into_owned();
            let step = solved(&regressors, &next)?;
            characteristic(&step.rows(0, n).transpose())
        })
        .collect()
}

/// Least squares by normal equations.
fn solved(regressors: &DMatrix<f64>, values: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let products = regressors.tr_mul(regressors);
    let ridge = 1e-13 * products.trace() / products.nrows() as f64;
    let size = products.nrows();
    let found = Cholesky::new(products + DMatrix::identity(size, size) * ridge)?;
    Some(found.solve(&regressors.tr_mul(values)))
}

/// `a1 ... an` of the characteristic polynomial of a matrix from its eigenvalues.
fn characteristic(matrix: &DMatrix<f64>) -> Option<Vec<f64>> {
    let roots = eigenvalues(matrix).ok()?;
    let mut polynomial = polynomial::from_roots(&roots).ok()?;
    polynomial.remove(0);
    Some(polynomial)
}
