//! Poles from states: a subspace method.
//!
//! ```text
//! y_f - (what inputs and outputs between add, by an equation of high order) = O x + noise
//! x = the n directions of the past that are most correlated with it
//! x_(k+1) = A x_k + B u_k + constant + K e_k,   e_k what [x_k, u_k, 1] leave of y_k      by least squares
//! ```
//! The future outputs, after subtracting the effect of inputs and outputs in between, are regressed on the past; the n most correlated
//! directions (canonical variates, Larimore, *American Control Conf.*, 1983) are the state (Jansson, "Subspace identification and ARX
//! modeling", *IFAC SYSID*, 2003). Regressing states on states is step two of N4SID (Van Overschee and De Moor, *Automatica* 30, 1994). Step one of
//! that method is an oblique projection instead of the high-order equation; it is biased in a closed loop.

use nalgebra::{Cholesky, DMatrix, DVector};
use planesman_linear::poles::eigenvalues;
use planesman_linear::polynomial;

/// Orders of the high-order equation that are tried.
pub(crate) const HIGH: [usize; 4] = [5, 10, 20, 40];
/// Maximum number of past and future samples.
const HORIZON: usize = 25;

/// `a1 ... an` of the orders from 1 to `most`, or as many as the samples determine. The arguments are the coefficients `a1, a2, ...` and
/// `b0, b1, ...` of a high-order equation, and the input and output of each record.
pub(crate) fn poles_of_states(
    (a, b): (&[f64], &[f64]),
    runs: &[(&[f64], &[f64])],
    most: usize,
) -> Vec<Vec<f64>> {
    let samples: usize = runs.iter().map(|(_, outputs)| outputs.len()).sum();
    let mut horizon = a.len().clamp(10, HORIZON);
    if samples < 18 * horizon {
        horizon = (samples / 18).max(3);
    }
    let (f, p) = (horizon, horizon);
    if samples < f + p + 4 * (f + 2 * p) {
        return Vec::new();
    }
    // Rows of each record, and all of a signal's, `at` samples further on.
    let runs: Vec<_> = (runs.iter())
        .filter(|(_, outputs)| outputs.len() > f + p + 1)
        .collect();
    let counts: Vec<usize> = runs.iter().map(|(_, y)| y.len() - f - p).collect();
    let count: usize = counts.iter().sum();
    let shifted = |outputs: bool, at: usize| -> DVector<f64> {
        let parts = runs.iter().zip(&counts).flat_map(|((u, y), count)| {
            let signal = if outputs { y } else { u };
            &signal[at..at + count]
        });
        DVector::from_iterator(count, parts.copied())
    };
    // Every record has a constant of its own.
    let centred = |mut column: DVector<f64>| -> DVector<f64> {
        let mut first = 0;
        for count in &counts {
            let mut own = column.rows_mut(first, *count);
            let mean = own.mean();
            own.add_scalar_mut(-mean);
            first += count;
        }
        column
    };
    let coefficient = |of: &[f64], i: usize| of.get(i).copied().unwrap_or_default();
    let mut future = DMatrix::zeros(count, f);
    for i in 0..f {
        let mut column = shifted(true, p + i);
        for j in 0..i {
            column.axpy(coefficient(a, i - j - 1), &shifted(true, p + j), 1.0);
        }
        for j in 0..=i {
            column.axpy(-coefficient(b, i - j), &shifted(false, p + j), 1.0);
        }
        future.set_column(i, &centred(column));
    }
    let mut past = DMatrix::zeros(count, 2 * p);
    for i in 0..p {
        for (at, outputs) in [(i, true), (p + i, false)] {
            past.set_column(at, &centred(shifted(outputs, p - 1 - i)));
        }
    }
    let Some((of_past, directions)) = directions(&future, &past) else {
        return Vec::new();
    };
    // Of two neighbouring rows of a record the earlier, and its record.
    let mut first = 0;
    let mut pairs = Vec::with_capacity(count);
    for (run, count) in counts.iter().enumerate() {
        pairs.extend((first..first + count - 1).map(|row| (row, run)));
        first += count;
    }
    let earlier: Vec<usize> = pairs.iter().map(|(row, _)| *row).collect();
    let later: Vec<usize> = earlier.iter().map(|row| row + 1).collect();
    let (inputs, outputs) = (shifted(false, p), shifted(true, p));
    (1..=most.min(f - 1))
        .map_while(|n| {
            let back = of_past.tr_solve_lower_triangular(&directions.rows(0, n).transpose())?;
            let states = &past * back;
            let rows = earlier.len();
            let mut regressors = DMatrix::zeros(rows, n + 1 + counts.len());
            let now = states.select_rows(&earlier);
            regressors.columns_mut(0, n).copy_from(&now);
            regressors.set_column(n, &inputs.select_rows(&earlier));
            for (row, (_, run)) in pairs.iter().enumerate() {
                regressors[(row, n + 1 + run)] = 1.0;
            }
            let measured =
                DMatrix::from_column_slice(rows, 1, outputs.select_rows(&earlier).as_slice());
            let explained = &regressors * solved(&regressors, &measured)?;
            let last = regressors.ncols();
            let mut regressors = regressors.insert_column(last, 0.0);
            regressors.set_column(last, &(measured - explained).column(0));
            let next = states.select_rows(&later);
            let step = solved(&regressors, &next)?;
            characteristic(&step.rows(0, n).transpose())
        })
        .collect()
}

/// A square root of the past's products, and the directions of the past, divided by that root, sorted by their correlation with the future.
fn directions(future: &DMatrix<f64>, past: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let root = |of: &DMatrix<f64>| {
        let products = of.tr_mul(of);
        let ridge = 1e-9 * products.trace() / products.nrows() as f64;
        let size = products.nrows();
        Cholesky::new(products + DMatrix::identity(size, size) * ridge).map(|it| it.l())
    };
    let (of_future, of_past) = (root(future)?, root(past)?);
    let half = of_future.solve_lower_triangular(&future.tr_mul(past))?;
    let whole = of_past.solve_lower_triangular(&half.transpose())?;
    let svd = whole.transpose().svd(false, true);
    Some((of_past, svd.v_t?))
}

/// Least squares by normal equations.
pub(crate) fn solved(regressors: &DMatrix<f64>, values: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let products = regressors.tr_mul(regressors);
    let ridge = 1e-13 * products.trace() / products.nrows() as f64;
    let size = products.nrows();
    let found = Cholesky::new(products + DMatrix::identity(size, size) * ridge)?;
    Some(found.solve(&regressors.tr_mul(values)))
}

/// `a1 ... an` of the characteristic polynomial of a matrix from its eigenvalues.
pub(crate) fn characteristic(matrix: &DMatrix<f64>) -> Option<Vec<f64>> {
    let roots = eigenvalues(matrix).ok()?;
    let mut polynomial = polynomial::from_roots(&roots).ok()?;
    polynomial.remove(0);
    Some(polynomial)
}
