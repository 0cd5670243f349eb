//! Nonlinear least squares by Gauss-Newton steps, damped where the model is strongly nonlinear.
//!
//! ```text
//! minimise V = |e(theta)|^2,   psi = -de/dtheta
//! (psi'psi + mu diag(psi'psi)) step = psi'e
//! ```
//! (Levenberg 1944; Marquardt 1963, whose diagonal makes the step independent of the parameters' units.) Each step is a separate
//! least-squares problem, solved by QR, so that no condition number is squared; [`super::normal_equations`] solves the normal equations
//! without the rows of psi. Both use [`descend`].

use nalgebra::{DMatrix, DVector};

use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use planesman_parallel::stop_point;

/// Maximum number of steps; ten are usual.
const STEPS: usize = 200;
/// Maximum number of dampings tried within one step.
const TRIALS: usize = 25;
/// The search ends when a step would lower the cost by less than this share.
const MIN_COST_DECREASE: f64 = 1e-12;

/// Result of a step with one damping.
pub enum Trial<P> {
    /// A lower cost at these parameters.
    Lower(DVector<f64>, P),
    /// No lower cost: more damping is needed.
    NotLower,
    /// The search has converged.
    Done,
}

/// Takes at most `steps` damped steps from the given parameters, each with at most `trials` dampings, until no step lowers the cost or `is_last`
/// accepts a step.
///
/// # Errors
/// Errors of a trial.
pub fn descend<P>(
    (mut theta, mut here): (DVector<f64>, P),
    (steps, trials): (usize, usize),
    trial: impl Fn(&DVector<f64>, &P, f64) -> Result<Trial<P>>,
    is_last: impl Fn(&P, &P) -> bool,
) -> Result<(DVector<f64>, P)> {
    let mut damping = 1e-3;
    for _ in 0..steps {
        stop_point();
        let mut lower = None;
        for _ in 0..trials {
            match trial(&theta, &here, damping)? {
                Trial::Lower(theta, there) => lower = Some((theta, there)),
                Trial::NotLower => {
                    damping = (damping * 4.0).max(1e-9);
                    continue;
                }
                Trial::Done => {}
            }
            break;
        }
        let Some((next, there)) = lower else {
            break;
        };
        let is_last = is_last(&here, &there);
        (theta, here) = (next, there);
        damping *= 0.1;
        if is_last {
            break;
        }
    }
    Ok((theta, here))
}

/// Errors and their slopes at a point.
#[derive(Clone, Debug)]
pub(crate) struct Linearised {
    /// `e`, output unit.
    pub(crate) errors: DVector<f64>,
    /// `psi = -de/dtheta`, one column per parameter.
    pub(crate) slopes: DMatrix<f64>,
}

impl Linearised {
    /// `V`; infinite if the model overflows.
    pub(super) fn cost(&self) -> f64 {
        let cost = self.errors.norm_squared();
        if cost.is_finite() {
            cost
        } else {
            f64::INFINITY
        }
    }
}

/// The minimum of the cost near `start`, with the errors and slopes there.
///
/// # Errors
/// [`IdentificationError`], if the errors at `start` or the slopes at the minimum are not finite or do not determine every parameter.
pub(super) fn minimise(
    start: DVector<f64>,
    linearise: impl Fn(&DVector<f64>) -> Linearised,
) -> Result<(DVector<f64>, Linearised)> {
    lowered(start, (STEPS, 0.0), linearise)
}

/// Minimises with a limit on the number of steps, and on the relative decrease of the cost in the last step.
///
/// # Errors
/// Same as [`minimise`].
pub(super) fn lowered(
    start: DVector<f64>,
    (steps, share): (usize, f64),
    linearise: impl Fn(&DVector<f64>) -> Linearised,
) -> Result<(DVector<f64>, Linearised)> {
    let here = linearise(&start);
    if here.cost().is_infinite() {
        return Err(IdentificationError::Search(
            "the model's output overflows at the start of the search",
        ));
    }
    let valley = Valley::of(&here)?;
    let trial = |theta: &DVector<f64>, (here, valley): &(Linearised, Option<Valley>), damping| {
        let step = valley.as_ref().and_then(|it| it.step(damping));
        let Some((step, _)) = step.filter(|it| it.1 > MIN_COST_DECREASE * here.cost()) else {
            return Ok(Trial::Done);
        };
        let there = theta + &step;
        let found = linearise(&there);
        Ok(match found.cost() < here.cost() {
            true => {
                let valley = Valley::of(&found)?;
                Trial::Lower(there, (found, valley))
            }
            false => Trial::NotLower,
        })
    };
    let is_last = |here: &(Linearised, _), there: &(Linearised, _)| {
        there.0.cost() > (1.0 - share) * here.0.cost()
    };
    let found = descend((start, (here, valley)), (steps, TRIALS), trial, is_last)?;
    Ok((found.0, found.1.0))
}

/// The linear problem at a point, with columns of equal length.
struct Valley {
    triangle: Triangle,
    scales: Vec<f64>,
    cost: f64,
}

impl Valley {
    /// `None` if all slopes are zero.
    fn of(at: &Linearised) -> Result<Option<Self>> {
        let mut scales = lengths(&at.slopes);
        if scales.iter().any(|scale| !scale.is_finite()) {
            return Err(IdentificationError::Search(
                "the search left the range of floating-point numbers",
            ));
        }
        let largest = scales.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(None);
        }
        for scale in scales.iter_mut().filter(|scale| **scale == 0.0) {
            *scale = largest;
        }
        Ok(Some(Self {
            triangle: Triangle::new(&at.slopes, &at.errors)?.scaled(&scales),
            cost: at.cost(),
            scales,
        }))
    }

    /// The damped step, and the decrease of the cost predicted by the linear model.
    fn step(&self, damping: f64) -> Option<(DVector<f64>, f64)> {
        let damped = self.triangle.clone().damped(damping.max(1e-20).sqrt());
        let scaled = damped.solution().ok()?;
        let step = DVector::from_fn(scaled.len(), |j, _| scaled[j] / self.scales[j]);
        Some((step, self.cost - damped.cost))
    }
}

/// The columns' lengths.
fn lengths(slopes: &DMatrix<f64>) -> Vec<f64> {
    slopes.column_iter().map(|column| column.norm()).collect()
}

/// `(psi'psi)^-1`, computed with columns of equal length.
///
/// # Errors
/// [`IdentificationError`], if the slopes do not determine every parameter.
pub(super) fn unit_covariance(at: &Linearised) -> Result<DMatrix<f64>> {
    let factor = unit_factor(at)?;
    Ok(&factor * factor.transpose())
}

/// A factor F of the unit covariance, which is `F F'`.
pub(crate) fn unit_factor(at: &Linearised) -> Result<DMatrix<f64>> {
    let mut scales = lengths(&at.slopes);
    for scale in scales.iter_mut().filter(|scale| **scale == 0.0) {
        *scale = 1.0;
    }
    let triangle = Triangle::new(&at.slopes, &at.errors)?.scaled(&scales);
    let mut factor = triangle.unit_factor()?;
    for (mut row, scale) in factor.row_iter_mut().zip(scales) {
        row /= scale;
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// e = (1 - x, 10 (y - x^2)): the curved valley of Rosenbrock (1960).
    fn valley(theta: &DVector<f64>) -> Linearised {
        let (x, y) = (theta[0], theta[1]);
        Linearised {
            errors: DVector::from_vec(vec![1.0 - x, 10.0 * (x * x - y)]),
            slopes: DMatrix::from_row_slice(2, 2, &[1.0, 0.0, -20.0 * x, 10.0]),
        }
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let (theta, _) = minimise(DVector::from_vec(vec![-1.2, 1.0]), valley).unwrap();
        assert!(
            (theta[0] - 1.0).abs() < 1e-6 && (theta[1] - 1.0).abs() < 1e-6,
            "{theta}"
        );
    }

    #[test]
    fn a_search_that_begins_beyond_the_numbers_is_refused() {
        let start = DVector::from_vec(vec![f64::MAX, 1.0]);
        assert!(minimise(start, valley).is_err());
    }
}
