//! Recursive least squares in square-root information form.
//!
//! The estimate minimises, over the rows so far,
//! ```text
//! J = sum_i lambda^(k-i) (y_i - phi_i . theta)^2 + lambda^k |theta|^2 / p0
//! ```
//! which for lambda = 1 is `(Phi'Phi + I/p0)^-1 Phi'y`, the textbook recursion started from theta = 0, P = p0 I. That recursion squares the
//! data's condition number, 1e5 for a third-order vehicle sampled at 20 Hz, and lets P lose its symmetry and sign. Instead, this module
//! stores the triangle R and the vector z of
//! ```text
//! J = |R theta - z|^2 + V
//! ```
//! and adds each row by Givens rotations (Bierman, *Factorization Methods for Discrete Sequential Estimation*, 1977, ch. V; Gentleman, *J.
//! Inst. Maths Applics* 12, 1973). R equals that of a QR factorisation of the whole record, so nothing is lost compared with the batch
//! solution; `P = R^-1 R^-T` is positive definite by construction; and p0 may be arbitrarily large.
//!
//! With lambda < 1 the prior is forgotten too, and P would grow without bound in directions that the rows never excite. So whenever the prior has
//! decayed to a millionth, it is restored at the current estimate. This changes neither theta nor V, and keeps P below a million times p0.

use nalgebra::{DMatrix, DVector};

use crate::error::{IdentificationError, Result};

/// The prior is restored when less than this share of its information is left.
const FADED: f64 = 1e-6;

/// A parameter direction counts as learnt if the rows contribute at least this many times more information about it than the prior
/// `|theta|^2 / p0`.
const LEARNT: f64 = 100.0;

/// The current least-squares problem.
#[derive(Clone, Debug)]
pub struct RecursiveLeastSquares {
    forgetting: f64,
    /// Upper triangular, non-negative diagonal.
    r: DMatrix<f64>,
    z: DVector<f64>,
    /// `V`, the smallest value of J, output unit squared.
    cost: f64,
    /// `1 / p0`.
    initial: f64,
    /// The prior's part of each diagonal element of R'R: `lambda^k / p0` until it is restored.
    prior: f64,
    /// `sum_i lambda^(k-i)`.
    weight: f64,
    rows: u64,
    /// The row being added.
    work: Vec<f64>,
}

impl RecursiveLeastSquares {
    /// A problem without rows: theta = 0, P = `initial_covariance` I. `forgetting` is lambda in (0, 1].
    ///
    /// # Errors
    /// [`IdentificationError`], if there are no parameters, lambda is outside (0, 1] or p0 is not positive and finite.
    pub fn new(parameters: usize, forgetting: f64, initial_covariance: f64) -> Result<Self> {
        if parameters == 0 {
            return Err(IdentificationError::Option(
                "nothing to estimate: the model has no parameters".to_owned(),
            ));
        }
        check_forgetting(forgetting)?;
        if !(initial_covariance > 0.0 && initial_covariance.is_finite()) {
            return Err(IdentificationError::Option(format!(
                "initial covariance {initial_covariance} refused: it must be positive"
            )));
        }
        Ok(Self {
            forgetting,
            r: DMatrix::from_diagonal_element(
                parameters,
                parameters,
                (1.0 / initial_covariance).sqrt(),
            ),
            z: DVector::zeros(parameters),
            cost: 0.0,
            initial: 1.0 / initial_covariance,
            prior: 1.0 / initial_covariance,
            weight: 0.0,
            rows: 0,
            work: vec![0.0; parameters],
        })
    }

    /// Forgets every row: theta = 0, P = p0 I.
    pub fn reset(&mut self) {
        self.r.fill(0.0);
        self.r.fill_diagonal(self.initial.sqrt());
        self.z.fill(0.0);
        self.cost = 0.0;
        self.prior = self.initial;
        self.weight = 0.0;
        self.rows = 0;
    }

    /// Uses another forgetting factor from the next row on.
    ///
    /// # Errors
    /// [`IdentificationError`], if lambda is outside (0, 1].
    pub fn set_forgetting(&mut self, forgetting: f64) -> Result<()> {
        check_forgetting(forgetting)?;
        self.forgetting = forgetting;
        Ok(())
    }

    /// Resets the covariance and keeps theta: P = p0 I.
    pub fn reset_covariance(&mut self) {
        let theta = self.parameters();
        self.restart_about(&theta);
    }

    /// Forgets every row and restarts at `theta`, P = p0 I.
    pub fn restart_about(&mut self, theta: &DVector<f64>) {
        self.reset();
        self.set_parameters(theta);
    }

    /// Copies the estimate of `other`, which has the same number of parameters. Earlier rows still count.
    pub fn take_over(&mut self, other: &Self) {
        let rows = self.rows;
        self.clone_from(other);
        self.rows = rows;
    }

    /// Moves the estimate to `theta`; its covariance is kept.
    pub fn set_parameters(&mut self, theta: &DVector<f64>) {
        self.z = &self.r * theta;
    }

    /// `phi' P phi`: the prediction's variance for a residual of unit variance.
    #[must_use]
    pub fn leverage(&self, row: &[f64]) -> f64 {
        self.r
            .tr_solve_upper_triangular(&DVector::from_row_slice(row))
            .map_or(f64::INFINITY, |w| w.norm_squared())
    }

    /// Forgets only the information of earlier rows about `row . theta`: with `w = R phi`,
    /// ```text
    /// R'R <- R' (1 - (1 - lambda) w w' / w'w) R
    /// ```
    /// (Cao and Schwartz, *Automatica* 36, 2000). Directions without new rows are kept unchanged, so P stays bounded without a limit.
    pub fn forget_along(&mut self, row: &[f64], lambda: f64) {
        let w = &self.r * DVector::from_row_slice(row);
        let size = w.norm_squared();
        if size == 0.0 {
            return;
        }
        let theta = self.parameters();
        let shrink = &w * w.transpose() * ((1.0 - lambda.sqrt()) / size);
        self.r = (&self.r - shrink * &self.r).qr().r();
        for i in 0..theta.len() {
            // A triangle with a non-negative diagonal.
            if self.r[(i, i)] < 0.0 {
                self.r.row_mut(i).neg_mut();
            }
        }
        self.set_parameters(&theta);
        self.cost *= lambda;
        self.weight *= lambda;
    }

    /// If the trace of P is above `limit`, reduces it: a prior of `limit` at the current estimate is added, which changes neither theta nor
    /// V.
    pub fn limit_covariance(&mut self, limit: f64) {
        if self.unit_covariance().trace() <= limit {
            return;
        }
        let theta = self.parameters();
        self.add_prior(1.0 / limit, &theta);
    }

    /// Adds one row, `output = row . theta + noise`. `row` has one number per parameter.
    pub fn update(&mut self, row: &[f64], output: f64) {
        debug_assert_eq!(row.len(), self.z.len());
        if self.forgetting < 1.0 {
            self.forget();
        }
        self.work.copy_from_slice(row);
        let remainder = self.fold_in(output);
        self.cost += remainder * remainder;
        self.weight += 1.0;
        self.rows += 1;
    }

    /// Multiplies the weight of all earlier rows by lambda.
    fn forget(&mut self) {
        let root = self.forgetting.sqrt();
        self.r *= root;
        self.z *= root;
        self.cost *= self.forgetting;
        self.prior *= self.forgetting;
        self.weight *= self.forgetting;
        if self.prior < FADED * self.initial {
            let theta = self.parameters();
            self.add_prior(self.initial - self.prior, &theta);
            self.prior = self.initial;
        }
    }

    /// Adds `information |theta - about|^2` to J.
    fn add_prior(&mut self, information: f64, about: &DVector<f64>) {
        let root = information.sqrt();
        for i in 0..about.len() {
            self.work.fill(0.0);
            self.work[i] = root;
            self.fold_in(root * about[i]);
        }
    }

    /// Rotates the row in `work` and its output into R and z. Returns the remainder of the output, the part of the row's residual that no
    /// theta can remove.
    fn fold_in(&mut self, output: f64) -> f64 {
        let p = self.z.len();
        let mut remainder = output;
        for i in 0..p {
            if self.work[i] == 0.0 {
                continue;
            }
            // Turn (R_ii, work_i) onto the first axis, and the rest of both rows with it.
            let radius = libm::hypot(self.r[(i, i)], self.work[i]);
            let (cosine, sine) = (self.r[(i, i)] / radius, self.work[i] / radius);
            self.r[(i, i)] = radius;
            for j in i + 1..p {
                let (kept, folded) = (self.r[(i, j)], self.work[j]);
                self.r[(i, j)] = cosine * kept + sine * folded;
                self.work[j] = cosine * folded - sine * kept;
            }
            let kept = self.z[i];
            self.z[i] = cosine * kept + sine * remainder;
            remainder = cosine * remainder - sine * kept;
        }
        remainder
    }

    /// The number of parameters.
    #[must_use]
    pub fn size(&self) -> usize {
        self.z.len()
    }

    /// `theta`, the minimum of J, in the order of the row.
    #[must_use]
    pub fn parameters(&self) -> DVector<f64> {
        let p = self.z.len();
        let mut theta = DVector::zeros(p);
        for i in (0..p).rev() {
            let known: f64 = (i + 1..p).map(|j| self.r[(i, j)] * theta[j]).sum();
            theta[i] = (self.z[i] - known) / self.r[(i, i)];
        }
        theta
    }

    /// `P = (R'R)^-1`, the covariance for a residual of unit variance. With forgetting it
    /// is the inverse of the weighted information, the usual P of recursive least squares.
    #[must_use]
    pub fn unit_covariance(&self) -> DMatrix<f64> {
        let inverse = self.inverse_root();
        &inverse * inverse.transpose()
    }

    /// `R^-1`, column by column, by back substitution.
    fn inverse_root(&self) -> DMatrix<f64> {
        let p = self.z.len();
        let mut inverse = DMatrix::<f64>::zeros(p, p);
        for column in 0..p {
            inverse[(column, column)] = 1.0 / self.r[(column, column)];
            for i in (0..column).rev() {
                let known: f64 = (i + 1..=column)
                    .map(|j| self.r[(i, j)] * inverse[(j, column)])
                    .sum();
                inverse[(i, column)] = -known / self.r[(i, i)];
            }
        }
        inverse
    }

    /// `V / (effective rows - parameters)`, the residual's variance, output unit squared; `None` if there are not more rows than
    /// parameters.
    #[must_use]
    pub fn noise_variance(&self) -> Option<f64> {
        let freedom = self.weight - self.z.len() as f64;
        (freedom > 0.0).then(|| self.cost / freedom)
    }

    /// `V`, the (weighted) sum of squared residuals of the current estimate, output unit squared.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// `sum_i lambda^(k-i)`, the effective number of rows.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Rows folded in.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// The number of parameter directions that the rows determine: singular values of R above the share `tolerance` of the largest.
    #[must_use]
    pub fn rank(&self, tolerance: f64) -> usize {
        let singular = self.r.singular_values();
        let least = tolerance * singular.max();
        singular.iter().filter(|s| **s > least).count()
    }

    /// The number of directions among the parameters in `columns` that the rows do not determine: there the estimate is still the prior. 0
    /// if all are determined.
    #[must_use]
    pub fn unlearnt(&self, columns: &[usize]) -> usize {
        let threshold = LEARNT * self.prior;
        // The sum of 1/s^2 over the singular values s of R, which are at most those of its columns.
        if self.inverse_root().norm_squared() * threshold < 1.0 {
            return 0;
        }
        let chosen = self.r.select_columns(columns);
        chosen
            .singular_values()
            .iter()
            .filter(|s| **s * **s <= threshold)
            .count()
    }
}

/// The range check of a forgetting factor.
///
/// # Errors
/// If lambda is outside (0, 1].
pub(crate) fn check_forgetting(forgetting: f64) -> Result<()> {
    if forgetting > 0.0 && forgetting <= 1.0 {
        Ok(())
    } else {
        Err(IdentificationError::Option(format!(
            "forgetting factor {forgetting} refused: it must lie in (0, 1]"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The textbook recursion, for comparison: g = P phi / (lambda + phi' P phi).
    fn textbook(rows: &[(Vec<f64>, f64)], lambda: f64, p0: f64) -> (DVector<f64>, DMatrix<f64>) {
        let n = rows[0].0.len();
        let mut theta = DVector::zeros(n);
        let mut p = DMatrix::from_diagonal_element(n, n, p0);
        for (row, output) in rows {
            let phi = DVector::from_row_slice(row);
            let p_phi = &p * &phi;
            let gain = &p_phi / (lambda + phi.dot(&p_phi));
            theta += &gain * (output - phi.dot(&theta));
            p = (&p - &gain * p_phi.transpose()) / lambda;
        }
        (theta, p)
    }

    fn well_posed_rows() -> Vec<(Vec<f64>, f64)> {
        (0..40)
            .map(|k| {
                let t = f64::from(k);
                let row = vec![libm::sin(0.3 * t), libm::cos(0.7 * t), 1.0];
                let noise = 0.01 * libm::sin(17.0 * t * t);
                let output = 2.0 * row[0] - 0.5 * row[1] + 0.25 + noise;
                (row, output)
            })
            .collect()
    }

    #[test]
    fn estimate_and_covariance_are_the_textbook_recursions() {
        for (lambda, p0) in [(1.0, 1e2), (1.0, 1e4), (0.98, 1e4), (0.9, 1e2)] {
            let rows = well_posed_rows();
            let mut rls = RecursiveLeastSquares::new(3, lambda, p0).unwrap();
            for (row, output) in &rows {
                rls.update(row, *output);
            }
            let (theta, p) = textbook(&rows, lambda, p0);
            assert!((rls.parameters() - theta).amax() < 1e-12);
            assert!((rls.unit_covariance() - p).amax() < 1e-12);
            assert_eq!(rls.rows(), 40);
        }
    }

    #[test]
    fn the_cost_is_the_sum_of_squared_residuals_of_the_present_estimate() {
        let rows = well_posed_rows();
        let mut rls = RecursiveLeastSquares::new(3, 1.0, 1e16).unwrap();
        for (row, output) in &rows {
            rls.update(row, *output);
        }
        let theta = rls.parameters();
        let sum: f64 = rows
            .iter()
            .map(|(row, y)| (y - DVector::from_row_slice(row).dot(&theta)).powi(2))
            .sum();
        assert!((rls.cost() - sum).abs() < 1e-12 * sum.max(1.0));
        assert!((rls.noise_variance().unwrap() - sum / 37.0).abs() < 1e-14);
    }

    #[test]
    fn a_direction_without_excitation_is_noticed() {
        let mut rls = RecursiveLeastSquares::new(3, 1.0, 1e16).unwrap();
        assert_eq!(rls.unlearnt(&[0, 1, 2]), 3);
        assert_eq!(rls.noise_variance(), None);
        for k in 0..100 {
            let x = libm::sin(f64::from(k));
            rls.update(&[x, 2.0 * x, 1.0], 3.0 * x + 1.0);
        }
        assert_eq!(rls.unlearnt(&[0, 1, 2]), 1);
        assert_eq!(rls.unlearnt(&[0, 2]), 0);
    }

    #[test]
    fn forgetting_without_excitation_keeps_the_estimate_and_a_bounded_covariance() {
        let mut rls = RecursiveLeastSquares::new(2, 0.9, 1e6).unwrap();
        for k in 0..50 {
            let x = libm::sin(f64::from(k));
            let y = libm::cos(f64::from(k));
            rls.update(&[x, y], 3.0 * x - y);
        }
        for _ in 0..100_000 {
            rls.update(&[0.0, 0.0], 0.0);
        }
        let theta = rls.parameters();
        assert!(
            (theta[0] - 3.0).abs() < 1e-4 && (theta[1] + 1.0).abs() < 1e-4,
            "{theta}"
        );
        assert!(rls.unit_covariance().amax() < 2.0 * 1e6 / FADED);
        assert_eq!(rls.unlearnt(&[0, 1]), 2);
    }

    #[test]
    fn numbers_that_define_no_recursion_are_refused() {
        assert!(RecursiveLeastSquares::new(0, 1.0, 1.0).is_err());
        for lambda in [0.0, -0.1, 1.1, f64::NAN] {
            assert!(RecursiveLeastSquares::new(2, lambda, 1.0).is_err());
        }
        for p0 in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(RecursiveLeastSquares::new(2, 1.0, p0).is_err());
        }
    }
}
