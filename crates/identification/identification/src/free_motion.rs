//! The effect of an initial state.

use nalgebra::{DMatrix, DVector};

use crate::estimators::impulse;
use planesman_record::filter;

/// Singular values below this share of the largest count as zero.
const NEGLIGIBLE: f64 = 1e-9;
/// Minimum number of samples to which a state is fitted: for each pole, and as a fraction 1/n of a record.
pub(crate) const STATE_SAMPLES: usize = 4;
pub(crate) const STATE_SHARE: usize = 20;
/// Beyond this growth of a free motion, differences are rounding error.
const LARGEST: f64 = 1e7;

/// The sum of squares of `left` after subtracting the best free motion of the denominator; infinite if a free motion diverges.
pub(crate) fn without_free_motion(left: &[f64], denominator: &[f64]) -> f64 {
    let (n, count) = (denominator.len() - 1, left.len());
    let all: f64 = left.iter().map(|v| v * v).sum();
    if n == 0 || count <= n || !all.is_finite() {
        return all;
    }
    let Some((columns, _)) = motions(count, denominator) else {
        return f64::INFINITY;
    };
    let qr = columns.qr();
    let mut rotated = DVector::from_column_slice(left);
    qr.q_tr_mul(&mut rotated);
    let svd = qr.r().svd(true, false);
    let Some(u) = svd.u else {
        return f64::INFINITY;
    };
    let largest = svd.singular_values.max();
    let head = rotated.rows(0, n);
    let ignored = (0..n).filter(|i| svd.singular_values[*i] <= NEGLIGIBLE * largest);
    let rest: f64 = ignored.map(|i| u.column(i).dot(&head).powi(2)).sum();
    rotated.rows(n, count - n).norm_squared() + rest
}

/// Fits a free response of `1/A` to `left` by least squares; returns the coefficients `m0 ... m(n-1)` of `(m0 + m1 q^-1 + ...) / A`, driven by
/// an impulse. `None` if a free response diverges, or `left` is too short.
pub(crate) fn free_motion(left: &[f64], denominator: &[f64]) -> Option<Vec<f64>> {
    let (n, count) = (denominator.len() - 1, left.len());
    if n == 0 {
        return Some(Vec::new());
    }
    if count <= n || !left.iter().all(|v| v.is_finite()) {
        return None;
    }
    let (columns, sizes) = motions(count, denominator)?;
    let qr = columns.qr();
    let mut rotated = DVector::from_column_slice(left);
    qr.q_tr_mul(&mut rotated);
    let svd = qr.r().svd(true, true);
    let least = NEGLIGIBLE * svd.singular_values.max();
    let found = svd.solve(&rotated.rows(0, n), least).ok()?;
    Some(found.iter().zip(sizes).map(|(m, size)| m / size).collect())
}

/// The sum of squares of `left` after its first `before` samples, minus the free motion fitted to these samples; `None` if the motion diverges.
pub(crate) fn carried_on(left: &[f64], before: usize, denominator: &[f64]) -> Option<f64> {
    let mut impulse = free_motion(left.get(..before)?, denominator)?;
    impulse.resize(left.len(), 0.0);
    let moving = filter(&[1.0], denominator, &impulse);
    let pairs = left.iter().zip(&moving).skip(before);
    Some(pairs.map(|(e, motion)| (e - motion).powi(2)).sum())
}

/// The free motions of the denominator as columns of length 1 (the impulse response and its shifts), and their original lengths; `None` if
/// they diverge.
fn motions(count: usize, denominator: &[f64]) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let n = denominator.len() - 1;
    let motion = filter(&[1.0], denominator, &impulse(0, count));
    if !motion.iter().all(|v| v.abs() < LARGEST) {
        return None;
    }
    let mut columns = DMatrix::zeros(count, n);
    let mut sizes = Vec::with_capacity(n);
    for i in 0..n {
        let size = motion[..count - i]
            .iter()
            .map(|v| v * v)
            .sum::<f64>()
            .sqrt();
        for k in i..count {
            columns[(k, i)] = motion[k - i] / size;
        }
        sizes.push(size);
    }
    Some((columns, sizes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_motion_is_taken_away_and_nothing_else() {
        let denominator = [1.0, -1.5, 0.7];
        let free = filter(&[2.0, -3.0], &denominator, &impulse(0, 50));
        assert!(without_free_motion(&free, &denominator) < 1e-20);
        let found = free_motion(&free, &denominator).unwrap();
        assert!((found[0] - 2.0).abs() < 1e-9 && (found[1] + 3.0).abs() < 1e-9);
        let mut disturbed = free;
        disturbed[49] += 1.0;
        let left = without_free_motion(&disturbed, &denominator);
        assert!(left > 0.99 && left <= 1.0, "{left}");
        assert_eq!(without_free_motion(&[1.0; 50], &[1.0, -2.0]), f64::INFINITY);
    }
}
