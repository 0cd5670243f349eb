//! Matrix exponential. Nalgebra's version uses the C library's logarithm, which differs between machines.

use nalgebra::DMatrix;

/// Orders of the Padé approximant, with the largest 1-norm for which each is exact to the rounding of `f64`: Higham, "The scaling and squaring
/// method for the matrix exponential revisited", SIAM J. Matrix Anal. Appl. 26 (2005), table 2.3.
const ORDERS: [(u32, f64); 5] = [
    (3, 1.495585217958292e-2),
    (5, 2.53939833006323e-1),
    (7, 9.504178996162932e-1),
    (9, 2.097847961257068),
    (13, 5.371920351148152),
];

/// `e^A` of a square matrix (n x n): the diagonal Padé approximant whose order fits the norm. Larger matrices are first scaled to `A / 2^s`, and
/// the result is squared `s` times. Entries that are not finite give entries that are not finite.
#[must_use]
pub fn exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    let norm = a
        .column_iter()
        .map(|column| column.iter().map(|x| x.abs()).sum())
        .fold(0.0, f64::max);
    let (mut order, limit) = ORDERS[ORDERS.len() - 1];
    let mut squarings = 0;
    if let Some((lower, _)) = ORDERS.iter().find(|(_, limit)| norm <= *limit) {
        order = *lower;
    } else if norm.is_finite() {
        squarings = libm::ceil(libm::log2(norm / limit)) as i32;
    }
    let a = a * 0.5_f64.powi(squarings);
    let (even, odd) = halves(&a, order);
    let odd = &a * odd;
    let n = a.nrows();
    let mut exponential = (&even - &odd)
        .lu()
        .solve(&(even + odd))
        .unwrap_or_else(|| DMatrix::from_element(n, n, f64::NAN));
    for _ in 0..squarings {
        exponential = &exponential * &exponential;
    }
    exponential
}

/// The numerator's even powers of `a`, and its odd powers divided by `a`.
fn halves(a: &DMatrix<f64>, order: u32) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = a.nrows();
    let square = a * a;
    let mut power = DMatrix::identity(n, n);
    let mut sums = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
    let mut coefficient = 1.0;
    for k in 0..=order {
        if k > 0 {
            coefficient *= f64::from(order - k + 1) / f64::from((2 * order - k + 1) * k);
        }
        if k > 1 && k % 2 == 0 {
            power = &power * &square;
        }
        sums[(k % 2) as usize] += &power * coefficient;
    }
    let [even, odd] = sums;
    (even, odd)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest difference of an entry from the expected one, over the largest expected.
    fn error(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
        (found - expected).amax() / expected.amax()
    }

    #[test]
    fn each_order_and_the_squaring_give_the_closed_forms() {
        for scale in [1e-3, 0.1, 0.5, 1.5, 4.0, 30.0] {
            // A rotation, a decay and a chain of integrators: exponentials in closed form.
            let w = DMatrix::from_row_slice(2, 2, &[0.0, scale, -scale, 0.0]);
            let (sin, cos) = libm::sincos(scale);
            let turned = DMatrix::from_row_slice(2, 2, &[cos, sin, -sin, cos]);
            assert!(error(&exponential(&w), &turned) < 1e-13, "{scale}");
            let chain = DMatrix::from_fn(4, 4, |i, j| if j == i + 1 { scale } else { 0.0 });
            let power = |k: usize| scale.powi(k as i32) / [1.0, 1.0, 2.0, 6.0][k];
            let summed = DMatrix::from_fn(4, 4, |i, j| if j < i { 0.0 } else { power(j - i) });
            assert!(error(&exponential(&chain), &summed) < 1e-14, "{scale}");
            let decay = DMatrix::from_diagonal_element(1, 1, -scale);
            assert!((exponential(&decay)[(0, 0)] / libm::exp(-scale) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_matrix_of_nothing_and_one_that_is_not_finite_do_not_panic() {
        assert_eq!(exponential(&DMatrix::zeros(0, 0)).len(), 0);
        assert_eq!(exponential(&DMatrix::zeros(2, 2)), DMatrix::identity(2, 2));
        for bad in [f64::NAN, f64::INFINITY] {
            let of = exponential(&DMatrix::from_element(2, 2, bad));
            assert!(of.iter().all(|x| !x.is_finite()));
        }
        // Overflows: the caller's check of finite entries refuses it.
        let large = exponential(&DMatrix::from_diagonal_element(1, 1, 1e300));
        assert!(!large[(0, 0)].is_finite());
    }
}
