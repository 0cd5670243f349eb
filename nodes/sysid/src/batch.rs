//! Least squares over a whole record, by Householder QR.
//!
//! `theta = argmin |Phi theta - y|`. The recursive form ([`crate::rls`]) with lambda = 1 and
//! p0 without bound gives the same; this is its independent check and the tool for
//! records at hand.

use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-13;

/// The parameters that fit rows and outputs best.
///
/// # Errors
/// A sentence, when there are fewer rows than parameters, rows differ in length, or the rows do not
/// determine every parameter.
pub fn least_squares(rows: &[(Vec<f64>, f64)]) -> Result<DVector<f64>, String> {
    let parameters = rows.first().map_or(0, |(row, _)| row.len());
    if parameters == 0 || rows.len() < parameters {
        return Err(format!(
            "{} rows cannot determine {parameters} parameters",
            rows.len()
        ));
    }
    if rows.iter().any(|(row, _)| row.len() != parameters) {
        return Err("the rows differ in length".to_owned());
    }
    let phi = DMatrix::from_fn(rows.len(), parameters, |i, j| rows[i].0[j]);
    let outputs = DVector::from_fn(rows.len(), |i, _| rows[i].1);
    let qr = phi.qr();
    let r = qr.r();
    let singular = r.singular_values();
    let rank = singular
        .iter()
        .filter(|s| **s > RANK_TOLERANCE * singular.max())
        .count();
    if rank < parameters {
        return Err(format!(
            "the record determines {rank} of {parameters} parameters"
        ));
    }
    r.solve_upper_triangular(&(qr.q().transpose() * outputs))
        .ok_or_else(|| "the record determines no parameters".to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_line_through_points_on_it_is_found() {
        let rows: Vec<_> = (0..5)
            .map(|k| (vec![f64::from(k), 1.0], 3.0 * f64::from(k) - 2.0))
            .collect();
        let theta = least_squares(&rows).unwrap();
        assert!((theta[0] - 3.0).abs() < 1e-14 && (theta[1] + 2.0).abs() < 1e-14);
    }

    #[test]
    fn records_that_determine_nothing_are_refused_with_the_reason() {
        assert!(least_squares(&[]).is_err());
        let refusal = least_squares(&[(vec![1.0, 0.0], 1.0)]).unwrap_err();
        assert!(refusal.contains("1 rows cannot determine 2"), "{refusal}");
        let rows: Vec<_> = (0..5)
            .map(|k| (vec![f64::from(k), 2.0 * f64::from(k)], f64::from(k)))
            .collect();
        let refusal = least_squares(&rows).unwrap_err();
        assert!(refusal.contains("1 of 2"), "{refusal}");
        assert!(least_squares(&[(vec![1.0], 1.0), (vec![], 1.0)]).is_err());
    }
}
