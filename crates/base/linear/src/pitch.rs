//! Linear equations of pitch, and optionally heave, each divided by its inertia.
//!
//! ```text
//! q'     = kappa delta - beta q - mu theta + nu w        kappa = M_delta/J, beta = -M_q/J, mu = W BG/J
//! theta' = q
//! w'     = epsilon delta + eta q - zeta w
//! ```
//! Plane angle and pitch rate determine only these ratios: identification estimates them, and an identified vehicle is built from them. Without
//! heave they are the pitch equation of Brunner 1988, p. 93, `J q' = K delta - B q - M_theta theta`.
//!
//! Coefficients are a list `kappa, beta, mu`, or with heave `kappa, beta, mu, nu, zeta, eta, epsilon`.

use crate::{DMatrix, Error, StateSpace};

/// Number of coefficients without heave: `kappa`, `beta`, `mu`.
pub const PITCH: usize = 3;

/// Number of coefficients with heave.
pub const PITCH_AND_HEAVE: usize = 7;

/// `[A B]` of `x' = A x + B delta`, with `x = (q, theta)` for three coefficients, `(q, theta, w)` for more. Missing coefficients are 0.
#[must_use]
#[rustfmt::skip]
pub fn equations(coefficients: &[f64]) -> DMatrix<f64> {
    let mut all = [0.0; PITCH_AND_HEAVE];
    all.iter_mut().zip(coefficients).for_each(|(all, given)| *all = *given);
    let [kappa, beta, mu, nu, zeta, eta, epsilon] = all;
    if coefficients.len() <= PITCH {
        return DMatrix::from_row_slice(2, 3, &[
            -beta, -mu, kappa,
              1.0, 0.0,   0.0,
        ]);
    }
    DMatrix::from_row_slice(3, 4, &[
        -beta, -mu,    nu,   kappa,
          1.0, 0.0,   0.0,     0.0,
          eta, 0.0, -zeta, epsilon,
    ])
}

/// Derivative of [`equations`] with respect to one of `coefficients` coefficients, in which they are linear.
#[must_use]
pub fn slope(coefficient: usize, coefficients: usize) -> DMatrix<f64> {
    let unit: Vec<f64> = (0..coefficients)
        .map(|i| f64::from(u8::from(i == coefficient)))
        .collect();
    equations(&unit) - equations(&vec![0.0; coefficients])
}

/// The linear system from the plane angle to the pitch rate.
///
/// # Errors
/// [`Error::NotFinite`].
pub fn state_space(coefficients: &[f64]) -> Result<StateSpace, Error> {
    let equations = equations(coefficients);
    let states = equations.nrows();
    StateSpace::new(
        equations.columns(0, states).into_owned(),
        equations.columns(states, 1).into_owned(),
        DMatrix::from_fn(1, states, |_, column| f64::from(u8::from(column == 0))),
        DMatrix::zeros(1, 1),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_heave_it_is_a_damped_inertia() {
        let system = state_space(&[-0.47, 1.2, 0.27]).and_then(|it| it.transfer_function(0, 0));
        let model = system.expect("a model");
        // q / delta = kappa s / (s^2 + beta s + mu)
        assert_eq!(model.den, [1.0, 1.2, 0.27]);
        assert!((model.num[1] + 0.47).abs() < 1e-15 && model.num[2].abs() < 1e-15);
    }
}
