//! Eigenvalues, and the mapping between the `z` plane of a sampled system and the `s` plane.
//!
//! A mode `exp(s t)` sampled every `dt` is `z^k` with `z = exp(s dt)`.

use std::cmp::Ordering;

use crate::ComplexFunctions as _;
use nalgebra::{Complex, DMatrix, Schur, linalg::balancing::balance_parlett_reinsch};

use crate::{Error, error::finite};

/// Largest number of QR steps per row before giving up; two or three are usual.
const STEPS_PER_ROW: usize = 100;

/// The continuous pole `s = ln(z) / dt` \[rad/s\] of a discrete pole sampled every `dt` \[s\],
/// on the principal branch: `|Im s| <= pi / dt`.
///
/// A negative real `z` gives `Im s = pi / dt`, which no real continuous first-order system has. `None` for `z = 0` (a pure delay), for numbers
/// that are not finite, and for a `dt` that is not positive.
#[must_use]
pub fn discrete_to_continuous(z: Complex<f64>, dt: f64) -> Option<Complex<f64>> {
    let s = z.ln() / dt;
    (dt > 0.0 && s.re.is_finite() && s.im.is_finite()).then_some(s)
}

/// Whether a pole in `z` is an artefact of sampling: its mode decays or oscillates at least as fast as the Nyquist frequency, `|ln z| >= pi`, which
/// samples cannot resolve. This includes poles at and near `z = 0`, and all on the negative real axis.
#[must_use]
pub fn is_sampling_artefact(z: Complex<f64>) -> bool {
    // ln 0 has an infinite norm.
    z.ln().modulus() >= (1.0 - 1e-9) * std::f64::consts::PI
}

/// Order of poles in s, slowest first: by decreasing real part; within a complex pair the pole with positive imaginary part comes first. The first
/// one is the dominant pole.
#[must_use]
pub fn by_decay(a: &Complex<f64>, b: &Complex<f64>) -> Ordering {
    b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im))
}

/// A pole as text with this many decimals: `-0.3550 + 0.1260i`.
#[must_use]
pub fn pole_text(pole: Complex<f64>, decimals: usize) -> String {
    let sign = if pole.im < 0.0 { '-' } else { '+' };
    signed_text(pole, sign, decimals)
}

/// A conjugate pair as text, from either of its poles: `-0.3550 ± 0.1260i`. A real pole is printed alone.
#[must_use]
pub fn pair_text(pole: Complex<f64>, decimals: usize) -> String {
    signed_text(pole, '±', decimals)
}

/// Description of a continuous pole: natural frequency and damping ratio of a pair, time constant of a real pole.
#[must_use]
pub fn mode_text(pole: Complex<f64>) -> String {
    let size = pole.modulus();
    let unstable = if pole.re > 0.0 { "unstable, " } else { "" };
    if size == 0.0 {
        "integrator".to_owned()
    } else if pole.im == 0.0 {
        format!("{unstable}time constant {:.3} s", 1.0 / size)
    } else {
        format!(
            "{unstable}natural frequency {size:.4} rad/s, damping ratio {:.3}",
            -pole.re / size
        )
    }
}

fn signed_text(pole: Complex<f64>, sign: char, decimals: usize) -> String {
    if pole.im == 0.0 {
        format!("{:.decimals$}", pole.re)
    } else {
        format!(
            "{:.decimals$} {sign} {:.decimals$}i",
            pole.re,
            pole.im.abs()
        )
    }
}

/// Eigenvalues of a square matrix, in the order of [`polynomial::roots`](crate::polynomial::roots).
///
/// # Errors
/// [`Error::Shape`] if it is not square, [`Error::NotFinite`], [`Error::NoConvergence`].
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, Error> {
    let size = matrix.nrows();
    if matrix.ncols() != size {
        return Err(Error::Shape {
            what: "the matrix",
            found: format!("{size} x {}", matrix.ncols()),
            expected: "a square one".to_owned(),
        });
    }
    finite("the matrix", matrix)?;
    if size == 0 {
        return Ok(Vec::new());
    }
    // Balancing makes rows and columns alike in size, so that small eigenvalues survive large ones.
    let mut balanced = matrix.clone();
    balance_parlett_reinsch(&mut balanced);
    finite("the balanced matrix", &balanced)?;
    let schur = |m: DMatrix<f64>| Schur::try_new(m, f64::EPSILON, STEPS_PER_ROW * size);
    // The shifted QR steps leave a cyclic permutation (the companion of x^n - 1) as it is;
    // mirroring it first, which keeps the eigenvalues, takes away that symmetry.
    let schur = schur(balanced.clone())
        .or_else(|| schur(mirrored(&balanced)))
        .ok_or(Error::NoConvergence { size })?;
    let mut values: Vec<Complex<f64>> = schur.complex_eigenvalues().iter().copied().collect();
    if values
        .iter()
        .any(|v| !v.re.is_finite() || !v.im.is_finite())
    {
        return Err(Error::NotFinite {
            what: "an eigenvalue",
        });
    }
    sort_slowest_first(&mut values);
    Ok(values)
}

/// Sorts by largest real part, then largest imaginary part: the slowest continuous mode, or the discrete mode nearest to +1, comes first.
pub(crate) fn sort_slowest_first(roots: &mut [Complex<f64>]) {
    roots.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
}

/// `H M H` with the Householder reflection `H = 1 - 2 v v' / v'v`, `v = (1, 2, ..., n)`.
fn mirrored(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let size = matrix.nrows();
    let normal = DMatrix::from_fn(size, 1, |i, _| (i + 1) as f64);
    let mirror = DMatrix::identity(size, size)
        - &normal * normal.transpose() * (2.0 / normal.norm_squared());
    &mirror * matrix * &mirror
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_told_in_the_words_of_the_field() {
        let text = |re, im| mode_text(Complex::new(re, im));
        assert_eq!(
            text(-3.0, 4.0),
            "natural frequency 5.0000 rad/s, damping ratio 0.600"
        );
        assert_eq!(text(-0.5, 0.0), "time constant 2.000 s");
        assert_eq!(text(2.0, 0.0), "unstable, time constant 0.500 s");
        assert_eq!(text(0.0, 0.0), "integrator");
    }

    #[test]
    fn the_dominant_pole_of_run_9_2_is_at_2_28_radians_per_second() {
        // Brunner 1988, Table 9: z = .89217 at T = 0.05 s.
        let s = discrete_to_continuous(Complex::new(0.89217, 0.0), 0.05).unwrap();
        assert!((s.re + 2.282).abs() < 1e-3 && s.im == 0.0, "{s}");
    }

    #[test]
    fn a_negative_pole_lies_at_the_nyquist_frequency() {
        let s = discrete_to_continuous(Complex::new(-0.11097, 0.0), 0.05).unwrap();
        assert!((s.im - 62.83).abs() < 0.01, "{s}");
    }

    #[test]
    fn what_is_faster_than_the_nyquist_frequency_is_an_artefact() {
        let is_one = |re, im| is_sampling_artefact(Complex::new(re, im));
        assert!(is_one(0.0, 0.0) && is_one(-0.9, 0.0) && is_one(-1e-9, 0.0));
        // exp(-pi) = 0.0432: a decay by pi in one sample.
        assert!(is_one(0.043, 0.0) && !is_one(0.044, 0.0));
        assert!(!is_one(0.0, 0.9) && is_one(-0.5, 0.01));
        assert!(!is_one(1.0, 0.0) && !is_one(1.2, 0.0));
    }

    #[test]
    fn the_planes_map_back_and_forth() {
        let s = Complex::new(-0.3553, 0.1256);
        let back = discrete_to_continuous((s * 0.05).exp(), 0.05).unwrap();
        assert!((back - s).modulus() < 1e-12);
    }

    #[test]
    fn a_delay_has_no_continuous_pole() {
        assert_eq!(discrete_to_continuous(Complex::new(0.0, 0.0), 0.05), None);
        assert_eq!(discrete_to_continuous(Complex::new(0.5, 0.0), 0.0), None);
        assert_eq!(
            discrete_to_continuous(Complex::new(f64::NAN, 0.0), 0.05),
            None
        );
    }

    #[test]
    fn eigenvalues_of_a_rotation_are_a_conjugate_pair() {
        let rotation = DMatrix::from_row_slice(2, 2, &[0.0, -2.0, 2.0, 0.0]);
        let values = eigenvalues(&rotation).unwrap();
        assert!((values[0] - Complex::new(0.0, 2.0)).modulus() < 1e-14);
        assert!((values[1] - Complex::new(0.0, -2.0)).modulus() < 1e-14);
    }

    #[test]
    fn matrices_without_eigenvalues_are_refused() {
        assert!(eigenvalues(&DMatrix::zeros(2, 3)).is_err());
        assert!(eigenvalues(&DMatrix::from_element(2, 2, f64::NAN)).is_err());
        assert_eq!(eigenvalues(&DMatrix::zeros(0, 0)).unwrap(), vec![]);
    }
}
