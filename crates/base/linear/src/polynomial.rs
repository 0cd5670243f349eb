//! Polynomials with real coefficients, highest power first: `[1, a1, a2]` is `x^2 + a1 x + a2`.
//!
//! Roots are the eigenvalues of the companion matrix (Golub and Van Loan, *Matrix Computations*, 7.4.6), each refined by Newton's method on the
//! polynomial itself.

use crate::ComplexFunctions as _;
use nalgebra::{Complex, DMatrix};

use crate::{
    Error,
    error::finite,
    poles::{eigenvalues, sort_slowest_first},
};

/// Maximum number of Newton steps per root. Convergence is quadratic from eigenvalues with half of the digits correct; a multiple root stops
/// earlier because no step improves it.
const POLISHING_STEPS: usize = 8;

/// The polynomial's value at `x`, by Horner's rule; 0 for no coefficients.
#[must_use]
pub fn evaluate(coefficients: &[f64], x: Complex<f64>) -> Complex<f64> {
    coefficients
        .iter()
        .fold(Complex::new(0.0, 0.0), |sum, &c| sum * x + c)
}

/// The derivative's coefficients.
#[must_use]
pub fn derivative(coefficients: &[f64]) -> Vec<f64> {
    let degree = coefficients.len().saturating_sub(1);
    coefficients[..degree]
        .iter()
        .enumerate()
        .map(|(i, c)| c * (degree - i) as f64)
        .collect()
}

/// Coefficients of the product; empty if either list is empty.
#[must_use]
pub fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    if a.is_empty() || b.is_empty() {
        return Vec::new();
    }
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    product
}

/// Coefficients of the sum of two polynomials, as many as in the longer list.
#[must_use]
pub fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    let (longer, shorter) = if a.len() >= b.len() { (a, b) } else { (b, a) };
    let mut sum = longer.to_vec();
    let offset = longer.len() - shorter.len();
    for (total, term) in sum[offset..].iter_mut().zip(shorter) {
        *total += term;
    }
    sum
}

/// Roots of the polynomial, sorted by decreasing real part; within a complex pair the root with positive imaginary part comes first. A constant has
/// no roots.
///
/// ```
/// use planesman_linear::{Complex, polynomial::roots};
///
/// assert_eq!(roots(&[1.0, 0.0, 4.0])?, [Complex::new(0.0, 2.0), Complex::new(0.0, -2.0)]); // s^2 + 4
/// # Ok::<(), planesman_linear::Error>(())
/// ```
///
/// A root of multiplicity `m` is returned as `m` roots spread by about the `m`-th root of the rounding error, which is unavoidable in the same
/// arithmetic. If coefficients span dozens of decades, the smallest roots may have no correct digit.
///
/// # Errors
/// [`Error::Empty`], [`Error::NotFinite`] or [`Error::LeadingZero`] for invalid coefficients; [`Error::NotFinite`] also if their ratios
/// overflow; [`Error::NoConvergence`].
pub fn roots(coefficients: &[f64]) -> Result<Vec<Complex<f64>>, Error> {
    check("the polynomial", coefficients)?;
    // Trailing zeros are exact roots at zero; dividing them out leaves the rest better posed.
    let at_zero = coefficients.iter().rev().take_while(|&&c| c == 0.0).count();
    let monic: Vec<f64> = coefficients[..coefficients.len() - at_zero]
        .iter()
        .map(|c| c / coefficients[0])
        .collect();
    finite("the monic polynomial", &monic)?;
    let degree = monic.len() - 1;

    // x^n = -a1 x^(n-1) - ... - an, on the vector (x^(n-1), ..., x, 1).
    let companion = DMatrix::from_fn(degree, degree, |row, column| {
        if row == 0 {
            -monic[column + 1]
        } else {
            f64::from(u8::from(row == column + 1))
        }
    });
    let slope = derivative(&monic);
    let mut roots: Vec<Complex<f64>> = eigenvalues(&companion)?
        .into_iter()
        .map(|root| polish(&monic, &slope, root))
        .chain(std::iter::repeat_n(Complex::new(0.0, 0.0), at_zero))
        .collect();
    sort_slowest_first(&mut roots);
    Ok(roots)
}

/// The real monic polynomial with these roots. Complex roots must be conjugate pairs; imaginary rounding errors of the product are dropped.
///
/// # Errors
/// [`Error::NotFinite`] if a root or the product is not finite.
pub fn from_roots(roots: &[Complex<f64>]) -> Result<Vec<f64>, Error> {
    let mut product = vec![Complex::new(1.0, 0.0)];
    for &root in roots {
        product.push(Complex::new(0.0, 0.0));
        for i in (1..product.len()).rev() {
            let carried = product[i - 1] * root;
            product[i] -= carried;
        }
    }
    let coefficients: Vec<f64> = product.into_iter().map(|c| c.re).collect();
    finite("the polynomial of these roots", &coefficients)?;
    Ok(coefficients)
}

/// Whether all roots of `z^n + a1 z^(n-1) + ... + an` have a magnitude below `radius` (Schur-Cohn recursion).
#[must_use]
pub fn lies_within(a: &[f64], radius: f64) -> bool {
    let mut scale = 1.0;
    let mut p: Vec<f64> = std::iter::once(1.0)
        .chain(a.iter().map(|a| {
            scale /= radius;
            a * scale
        }))
        .collect();
    while let (Some(last), true) = (p.last().copied(), p.len() > 1) {
        if last.is_nan() || last.abs() >= 1.0 {
            return false;
        }
        let n = p.len() - 1;
        p = (0..n)
            .map(|i| (p[i] - last * p[n - i]) / (1.0 - last * last))
            .collect();
    }
    true
}

/// Checks that a coefficient list is not empty, is finite, and does not begin with zero.
pub(crate) fn check(what: &'static str, coefficients: &[f64]) -> Result<(), Error> {
    finite(what, coefficients)?;
    match coefficients.first() {
        None => Err(Error::Empty { what }),
        Some(0.0) => Err(Error::LeadingZero { what }),
        Some(_) => Ok(()),
    }
}

/// Newton steps as long as each reduces the polynomial's magnitude.
fn polish(monic: &[f64], slope: &[f64], mut root: Complex<f64>) -> Complex<f64> {
    let mut residual = evaluate(monic, root);
    for _ in 0..POLISHING_STEPS {
        let next = root - residual / evaluate(slope, root);
        let next_residual = evaluate(monic, next);
        // False also for NaN, after a division by a zero slope.
        let improves = next_residual.modulus() < residual.modulus();
        if !improves {
            break;
        }
        (root, residual) = (next, next_residual);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Complex<f64>, re: f64, im: f64, tolerance: f64) {
        assert!(
            (found - Complex::new(re, im)).modulus() < tolerance,
            "{found}"
        );
    }

    #[test]
    fn the_printed_third_order_denominator_has_the_printed_roots() {
        // Brunner 1988, Table 8, q/delta third order.
        let roots = roots(&[1.0, -2.807382, 2.625671, -0.818083]).unwrap();
        close(roots[0], 0.95930, 0.01405, 1e-4);
        close(roots[1], 0.95930, -0.01405, 1e-4);
        close(roots[2], 0.88879, 0.0, 1e-4);
    }

    #[test]
    fn the_identified_models_of_table_9_have_the_poles_that_were_recomputed() {
        // Brunner 1988, Table 9: run 9/2 second order, run 8/1 third order.
        let run_9_2 = roots(&[1.0, -0.7812, -0.099]).unwrap();
        close(run_9_2[0], 0.89217, 0.0, 1e-5);
        close(run_9_2[1], -0.11097, 0.0, 1e-5);
        let run_8_1 = roots(&[1.0, -0.343, -0.2446, -0.2211]).unwrap();
        close(run_8_1[0], 0.89361, 0.0, 1e-5);
        close(run_8_1[1], -0.27530, 0.41429, 1e-5);
    }

    #[test]
    fn roots_and_their_product_are_inverse() {
        let coefficients = [1.0, -2.899220036, 2.801129200, -0.9018887212];
        let back = from_roots(&roots(&coefficients).unwrap()).unwrap();
        for (a, b) in coefficients.iter().zip(back) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn roots_of_unity_are_found_though_plain_qr_steps_stall_on_them() {
        for degree in 1..12 {
            let mut coefficients = vec![0.0; degree + 1];
            coefficients[0] = 1.0;
            coefficients[degree] = -1.0;
            let roots = roots(&coefficients).unwrap();
            assert_eq!(roots.len(), degree);
            for root in &roots {
                close(root.powu(degree as u32), 1.0, 0.0, 1e-12);
            }
        }
    }

    #[test]
    fn roots_at_zero_and_double_roots_are_found() {
        let zero = Complex::new(0.0, 0.0);
        assert_eq!(roots(&[3.0, 0.0, 0.0, 0.0]).unwrap(), vec![zero; 3]);
        for root in roots(&[1.0, -2.0, 1.0]).unwrap() {
            close(root, 1.0, 0.0, 1e-7);
        }
    }

    #[test]
    fn a_constant_has_no_root() {
        assert_eq!(roots(&[2.0]).unwrap(), vec![]);
    }

    #[test]
    fn what_is_no_polynomial_is_refused() {
        let what = "the polynomial";
        assert_eq!(roots(&[]), Err(Error::Empty { what }));
        assert_eq!(roots(&[0.0, 1.0]), Err(Error::LeadingZero { what }));
        assert_eq!(roots(&[1.0, f64::NAN]), Err(Error::NotFinite { what }));
        assert!(roots(&[1e-300, 1e300]).is_err());
        assert!(from_roots(&[Complex::new(f64::INFINITY, 0.0)]).is_err());
    }

    #[test]
    fn the_recursion_agrees_with_the_roots() {
        for (a, radius, within) in [
            (vec![-0.9], 0.95, true),
            (vec![-0.9], 0.85, false),
            (vec![-1.6, 0.8], 0.9, true),
            (vec![-1.6, 0.8], 0.89, false),
            (vec![0.0, 0.0, -0.5], 0.8, true),
            (vec![0.0, 0.0, -0.5], 0.79, false),
        ] {
            assert_eq!(lies_within(&a, radius), within, "{a:?} {radius}");
        }
    }
}
