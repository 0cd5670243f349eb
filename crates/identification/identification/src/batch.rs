//! Least squares over a whole record, by Householder QR.
//!
//! `theta = argmin |Phi theta - y|`. The recursive form ([`crate::RecursiveLeastSquares`]) with lambda = 1 and a very large p0 gives the
//! same result; this is its independent check, and is used for complete records. Every batch estimator here uses it, including Gauss-Newton
//! steps.

use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

use crate::error::{IdentificationError, Result};

/// Singular values below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-13;

/// Number of rows factorised at a time; it limits the memory, which would otherwise grow with the record.
const BLOCK: usize = 4096;

/// `Phi = Q R`, with `z = Q'y`: the sufficient statistics of a least-squares problem.
#[derive(Clone, Debug)]
pub struct Triangle {
    r: DMatrix<f64>,
    z: DVector<f64>,
    /// `|y|^2 - |z|^2`, the residual sum of squares at the minimum, output unit squared.
    pub cost: f64,
    /// Rows in Phi.
    pub rows: usize,
}

/// Solves the regression of values on columns; `None` if there are too few rows or a number is not finite.
pub(crate) fn regressed(columns: &[Vec<f64>], values: &[f64]) -> Option<Triangle> {
    let phi = DMatrix::from_fn(values.len(), columns.len(), |row, column| {
        columns[column][row]
    });
    Triangle::new(&phi, &DVector::from_column_slice(values)).ok()
}

/// The residual sum of squares.
pub(crate) fn squares_left(columns: &[Vec<f64>], values: &[f64]) -> Option<f64> {
    Some(regressed(columns, values)?.cost.max(0.0))
}

impl Triangle {
    /// Factorises the regression of `outputs` on the rows of `phi`.
    ///
    /// # Errors
    /// [`IdentificationError`], if there are fewer rows than parameters, or a number is not finite.
    pub fn new(phi: &DMatrix<f64>, outputs: &DVector<f64>) -> Result<Self> {
        let (rows, parameters) = phi.shape();
        if parameters == 0 || rows < parameters {
            return Err(IdentificationError::TooFewRows { rows, parameters });
        }
        if phi.iter().chain(outputs.iter()).any(|v| !v.is_finite()) {
            return Err(IdentificationError::Record(
                "the regression contains numbers that are not finite".to_owned(),
            ));
        }
        let mut triangle = Self {
            r: DMatrix::zeros(0, parameters),
            z: DVector::zeros(0),
            cost: 0.0,
            rows: 0,
        };
        for first in (0..rows).step_by(BLOCK) {
            let count = BLOCK.min(rows - first);
            triangle.fold_in(phi.rows(first, count), outputs.rows(first, count));
        }
        Ok(triangle)
    }

    /// Adds further rows.
    fn fold_in(&mut self, phi: DMatrixView<'_, f64>, outputs: DVectorView<'_, f64>) {
        let (above, count) = (self.z.len(), outputs.len());
        let mut block = self.r.clone().resize_vertically(above + count, 0.0);
        block.rows_mut(above, count).copy_from(&phi);
        let mut values = self.z.clone().resize_vertically(above + count, 0.0);
        values.rows_mut(above, count).copy_from(&outputs);
        let qr = block.qr();
        qr.q_tr_mul(&mut values);
        self.r = qr.r();
        let kept = self.r.nrows();
        self.z = values.rows(0, kept).into_owned();
        self.cost += values.rows(kept, values.len() - kept).norm_squared();
        self.rows += count;
    }

    /// Scales the problem: each parameter j is divided by `scales[j]`.
    #[must_use]
    pub fn scaled(mut self, scales: &[f64]) -> Self {
        for (mut column, scale) in self.r.column_iter_mut().zip(scales) {
            column /= *scale;
        }
        self
    }

    /// Adds the regularisation `|root theta|^2` to the cost.
    #[must_use]
    pub fn damped(mut self, root: f64) -> Self {
        let p = self.z.len();
        let rows = DMatrix::from_diagonal_element(p, p, root);
        self.fold_in(rows.as_view(), DVector::zeros(p).as_view());
        self
    }

    /// The singular values of R, which are those of Phi.
    #[must_use]
    pub fn singular_values(&self) -> DVector<f64> {
        self.r.singular_values()
    }

    /// The number of parameter directions that the rows determine: singular values of R above 1e-13 of the largest.
    #[must_use]
    pub fn rank(&self) -> usize {
        let singular = self.singular_values();
        singular
            .iter()
            .filter(|s| **s > RANK_TOLERANCE * singular.max())
            .count()
    }

    /// theta.
    ///
    /// # Errors
    /// [`IdentificationError`], if the rows do not determine every parameter.
    pub fn solution(&self) -> Result<DVector<f64>> {
        self.determined()?;
        self.r
            .solve_upper_triangular(&self.z)
            .ok_or(IdentificationError::Undetermined(
                "the record determines no parameters",
            ))
    }

    /// `(Phi'Phi)^-1`: the covariance of theta for a white residual of unit variance.
    ///
    /// # Errors
    /// Like [`Triangle::solution`].
    pub fn unit_covariance(&self) -> Result<DMatrix<f64>> {
        let factor = self.unit_factor()?;
        Ok(&factor * factor.transpose())
    }

    /// `R^-1`: a factor F of the unit covariance, which is `F F'`.
    ///
    /// # Errors
    /// Like [`Triangle::solution`].
    pub fn unit_factor(&self) -> Result<DMatrix<f64>> {
        self.determined()?;
        let p = self.z.len();
        self.r
            .solve_upper_triangular(&DMatrix::identity(p, p))
            .ok_or(IdentificationError::Undetermined(
                "the record determines no parameters",
            ))
    }

    fn determined(&self) -> Result<()> {
        let (rank, parameters) = (self.rank(), self.z.len());
        if rank < parameters {
            return Err(IdentificationError::Rank { rank, parameters });
        }
        Ok(())
    }
}

/// The least-squares parameters for rows and outputs.
///
/// # Errors
/// [`IdentificationError`], if there are fewer rows than parameters, rows differ in length, or the rows do not determine every parameter.
pub fn least_squares(rows: &[(Vec<f64>, f64)]) -> Result<DVector<f64>> {
    let parameters = rows.first().map_or(0, |(row, _)| row.len());
    if rows.iter().any(|(row, _)| row.len() != parameters) {
        return Err(IdentificationError::Record(
            "the rows differ in length".to_owned(),
        ));
    }
    let phi = DMatrix::from_fn(rows.len(), parameters, |i, j| rows[i].0[j]);
    let outputs = DVector::from_fn(rows.len(), |i, _| rows[i].1);
    Triangle::new(&phi, &outputs)?.solution()
}

#[cfg(test)]
mod tests {
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
    fn cost_and_covariance_are_those_of_the_normal_equations() {
        let phi = DMatrix::from_fn(9, 2, |i, j| {
            ((i + 1) as f64).powi(j as i32) + 0.1 * j as f64
        });
        let y = DVector::from_fn(9, |i, _| libm::sin(i as f64));
        let found = Triangle::new(&phi, &y).unwrap();
        let theta = found.solution().unwrap();
        assert!(((&phi * theta - y).norm_squared() - found.cost).abs() < 1e-14);
        let inverse = (phi.transpose() * phi).try_inverse().unwrap();
        assert!((found.unit_covariance().unwrap() - inverse).amax() < 1e-13);
    }

    #[test]
    fn records_that_determine_nothing_are_refused_with_the_reason() {
        assert!(least_squares(&[]).is_err());
        let refusal = least_squares(&[(vec![1.0, 0.0], 1.0)])
            .unwrap_err()
            .to_string();
        assert!(
            refusal.contains("1 rows of the regression cannot determine 2"),
            "{refusal}"
        );
        let rows: Vec<_> = (0..5)
            .map(|k| (vec![f64::from(k), 2.0 * f64::from(k)], f64::from(k)))
            .collect();
        let refusal = least_squares(&rows).unwrap_err().to_string();
        assert!(refusal.contains("1 of 2"), "{refusal}");
        assert!(least_squares(&[(vec![1.0], 1.0), (vec![], 1.0)]).is_err());
        assert!(least_squares(&[(vec![f64::NAN], 1.0)]).is_err());
    }
}
