//! Linear systems in state space.
//!
//! ```text
//! continuous  x'      = A x   + B u      y = C x + D u
//! discrete    x_(k+1) = A x_k + B u_k    y = C x + D u
//! ```
//!
//! The matrices do not show whether a system is continuous or discrete; functions that depend on this take a [`Domain`] or document what they expect.

use crate::ComplexFunctions as _;
use nalgebra::{Complex, DMatrix};

use crate::{Domain, Error, TransferFunction, error::finite, exponential, poles::eigenvalues};

/// A linear system with `n` states, `m` inputs and `p` outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// `n x n`: system matrix.
    pub a: DMatrix<f64>,
    /// `n x m`: input matrix.
    pub b: DMatrix<f64>,
    /// `p x n`: output matrix.
    pub c: DMatrix<f64>,
    /// `p x m`: feedthrough matrix.
    pub d: DMatrix<f64>,
}

impl StateSpace {
    /// A system of matrices with compatible sizes.
    ///
    /// # Errors
    /// [`Error::Shape`] for incompatible sizes, [`Error::NotFinite`].
    pub fn new(
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
    ) -> Result<Self, Error> {
        let system = Self { a, b, c, d };
        system.check()?;
        Ok(system)
    }

    /// Zero-order-hold discretisation of this continuous system: its input is constant over each `dt` \[s\], its state and outputs are sampled at
    /// the ends.
    ///
    /// ```text
    /// exp( [A B] dt ) = [Ad Bd]
    ///      [0 0]        [0   1]
    /// ```
    /// (Van Loan, *IEEE Trans. Automatic Control* 23, 1978), which is also valid for a singular `A`.
    ///
    /// ```
    /// # use planesman_linear::{DMatrix, StateSpace};
    /// let matrix = |rows, columns, numbers: &[f64]| DMatrix::from_row_slice(rows, columns, numbers);
    /// let position = StateSpace::new(
    ///     matrix(2, 2, &[0.0, 1.0, 0.0, 0.0]), // x1' = x2, x2' = u
    ///     matrix(2, 1, &[0.0, 1.0]),
    ///     matrix(1, 2, &[1.0, 0.0]),
    ///     matrix(1, 1, &[0.0]),
    /// )?;
    /// let sampled = position.zero_order_hold(0.1)?;
    /// assert!((sampled.b[(0, 0)] - 0.005).abs() < 1e-15);
    /// # Ok::<(), planesman_linear::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NotPositive`] for `dt`, [`Error::NotFinite`] if the exponential overflows, [`Error::Shape`].
    pub fn zero_order_hold(&self, dt: f64) -> Result<Self, Error> {
        self.check()?;
        if !dt.is_finite() {
            return Err(Error::NotFinite { what: "dt" });
        }
        if dt <= 0.0 {
            return Err(Error::NotPositive {
                what: "dt",
                value: dt,
            });
        }
        let (states, inputs) = self.b.shape();
        let mut augmented = DMatrix::zeros(states + inputs, states + inputs);
        augmented
            .view_mut((0, 0), (states, states))
            .copy_from(&(&self.a * dt));
        augmented
            .view_mut((0, states), (states, inputs))
            .copy_from(&(&self.b * dt));
        finite("A dt or B dt", &augmented)?;
        let exponential = exponential(&augmented);
        finite("the matrix exponential", &exponential)?;
        Ok(Self {
            a: exponential.view((0, 0), (states, states)).into_owned(),
            b: exponential.view((0, states), (states, inputs)).into_owned(),
            c: self.c.clone(),
            d: self.d.clone(),
        })
    }

    /// The poles: eigenvalues of `A`, in the order of [`polynomial::roots`](crate::polynomial::roots), including poles that cancel with zeros.
    ///
    /// # Errors
    /// Those of [`eigenvalues`].
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, Error> {
        eigenvalues(&self.a)
    }

    /// Finite zeros of a system with one input, one output and no direct feedthrough, in the order of
    /// [`polynomial::roots`](crate::polynomial::roots): the remaining poles when the output is held at 0. Let `c A^r b` be the first of `c b`,
    /// `c A b`, ... that is not 0; then
    ///
    /// ```text
    /// u = -(c A^(r+1) / (c A^r b)) x,    the eigenvalues of A - b c A^(r+1) / (c A^r b)
    /// ```
    /// Of these eigenvalues `r + 1` are 0 and not zeros. For a discrete system, zeros at 0 are left out together with these poles.
    ///
    /// # Errors
    /// [`Error::Shape`] for other systems, the errors of [`eigenvalues`].
    pub fn zeros(&self) -> Result<Vec<Complex<f64>>, Error> {
        self.check()?;
        let n = self.a.nrows();
        if self.d.shape() != (1, 1) || self.d[(0, 0)] != 0.0 {
            return Err(Error::Shape {
                what: "D",
                found: format!("{} x {}", self.d.nrows(), self.d.ncols()),
                expected: "one input, one output and no direct feedthrough".to_owned(),
            });
        }
        let mut seen = self.c.clone();
        for _ in 0..n {
            let reached = (&seen * &self.b)[(0, 0)];
            if reached.abs() > 1e-12 * seen.norm() * self.b.norm() {
                let held = &self.a - &self.b * (&seen * &self.a) / reached;
                let mut zeros = eigenvalues(&held)?;
                let largest = zeros.iter().map(|it| it.modulus()).fold(0.0, f64::max);
                zeros.retain(|it| it.modulus() > 1e-6 * largest);
                return Ok(zeros);
            }
            seen = &seen * &self.a;
        }
        Ok(Vec::new())
    }

    /// Transfer function from one input to one output (indices from 0), of degree `n` without cancellation, by the Leverrier-Faddeev recursion:
    ///
    /// ```text
    /// (s 1 - A)^-1 = (M_1 s^(n-1) + ... + M_n) / (s^n + a_1 s^(n-1) + ... + a_n)
    /// M_1 = 1,  a_k = -tr(A M_k) / k,  M_(k+1) = A M_k + a_k 1
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] if the index is out of range, [`Error::NotFinite`].
    pub fn transfer_function(
        &self,
        output: usize,
        input: usize,
    ) -> Result<TransferFunction, Error> {
        self.check()?;
        let (outputs, inputs) = self.d.shape();
        if output >= outputs || input >= inputs {
            return Err(Error::Shape {
                what: "the transfer matrix",
                found: format!("{outputs} x {inputs}"),
                expected: format!("an entry ({output}, {input})"),
            });
        }
        let states = self.a.nrows();
        let seen = self.c.row(output);
        let driven = self.b.column(input);
        let direct = self.d[(output, input)];

        let mut adjugate = DMatrix::<f64>::identity(states, states);
        let mut den = vec![1.0];
        let mut num = vec![direct];
        for k in 1..=states {
            let strictly_proper = (seen * &adjugate * driven)[(0, 0)];
            let next = &self.a * &adjugate;
            let coefficient = -next.trace() / k as f64;
            den.push(coefficient);
            num.push(strictly_proper + direct * coefficient);
            adjugate = next + DMatrix::identity(states, states) * coefficient;
        }
        TransferFunction::new(num, den)
    }

    /// Steady-state gain matrix, `p x m`.
    ///
    /// # Errors
    /// [`Error::NoSteadyGain`] if a pole is at the steady point, as for an integrator; [`Error::Shape`], [`Error::NotFinite`].
    pub fn steady_state_gain(&self, domain: Domain) -> Result<DMatrix<f64>, Error> {
        self.check()?;
        let states = self.a.nrows();
        let from_state = DMatrix::identity(states, states) * domain.steady_point() - &self.a;
        let state = from_state.lu().solve(&self.b).ok_or(Error::NoSteadyGain)?;
        let gain = &self.c * state + &self.d;
        finite("the steady-state gain", &gain)?;
        Ok(gain)
    }

    fn check(&self) -> Result<(), Error> {
        let (states, inputs, outputs) = (self.a.nrows(), self.b.ncols(), self.c.nrows());
        for (what, matrix, expected) in [
            ("A", &self.a, (states, states)),
            ("B", &self.b, (states, inputs)),
            ("C", &self.c, (outputs, states)),
            ("D", &self.d, (outputs, inputs)),
        ] {
            if matrix.shape() != expected {
                return Err(Error::Shape {
                    what,
                    found: format!("{} x {}", matrix.nrows(), matrix.ncols()),
                    expected: format!("{} x {}", expected.0, expected.1),
                });
            }
            finite(what, matrix)?;
        }
        Ok(())
    }
}

/// Conversion from a transfer function.
impl TransferFunction {
    /// State space in controllable companion form: with the denominator scaled to `s^n + a_1 s^(n-1) + ... + a_n` and the numerator to
    /// `d (that) + b_1 s^(n-1) + ... + b_n`,
    ///
    /// ```text
    ///     [-a_1 ... -a_n]       [1]
    /// A = [  1         0]   B = [0]   C = [b_1 ... b_n]   D = d
    ///     [      1     0]       [0]
    /// ```
    ///
    /// # Errors
    /// [`Error::Improper`] if the numerator's degree is above the denominator's, [`Error::NotFinite`].
    pub fn companion(&self) -> Result<StateSpace, Error> {
        let num = self.trimmed_num();
        if num.len() > self.den.len() {
            return Err(Error::Improper {
                numerator: num.len() - 1,
                denominator: self.den.len() - 1,
            });
        }
        let n = self.den.len() - 1;
        let lead = self.den[0];
        let a: Vec<f64> = self.den.iter().map(|a| a / lead).collect();
        let mut b = vec![0.0; self.den.len() - num.len()];
        b.extend(num.iter().map(|b| b / lead));
        StateSpace::new(
            DMatrix::from_fn(n, n, |row, column| match row {
                0 => -a[column + 1],
                _ => f64::from(u8::from(row == column + 1)),
            }),
            DMatrix::from_fn(n, 1, |row, _| f64::from(u8::from(row == 0))),
            DMatrix::from_fn(1, n, |_, column| b[column + 1] - b[0] * a[column + 1]),
            DMatrix::from_element(1, 1, b[0]),
        )
    }

    /// Zero-order-hold discretisation of this continuous system with a sampling interval of `dt` \[s\], in `z`.
    ///
    /// # Errors
    /// Those of [`companion`](Self::companion) and [`StateSpace::zero_order_hold`].
    pub fn zero_order_hold(&self, dt: f64) -> Result<Self, Error> {
        self.companion()?
            .zero_order_hold(dt)?
            .transfer_function(0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass on a spring with a damper: `x'' = -w^2 x - 2 z w x' + u`.
    fn oscillator(w: f64, z: f64) -> StateSpace {
        StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -w * w, -2.0 * z * w]),
            DMatrix::from_row_slice(2, 1, &[0.0, 1.0]),
            DMatrix::from_row_slice(1, 2, &[1.0, 0.0]),
            DMatrix::zeros(1, 1),
        )
        .unwrap()
    }

    #[test]
    fn a_held_double_integrator_is_the_textbook_one() {
        // Brunner 1988, Table 8, z/q second order: T^2/2 (z + 1) / (z - 1)^2.
        let held = oscillator(0.0, 0.0).zero_order_hold(0.05).unwrap();
        let g = held.transfer_function(0, 0).unwrap();
        for (found, expected) in g.num.iter().zip([0.0, 0.00125, 0.00125]) {
            assert!((found - expected).abs() < 1e-16);
        }
        for (found, expected) in g.den.iter().zip([1.0, -2.0, 1.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn the_printed_second_order_pitch_rate_model_comes_out() {
        // Brunner 1988, Table 8, q/delta second order: J .6, B .72, K .14, restoring .1633,
        // volts through 1.25.
        let pitch = StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -0.1633 / 0.6, -0.72 / 0.6]),
            DMatrix::from_row_slice(2, 1, &[0.0, 1.25 * 0.14 / 0.6]),
            DMatrix::from_row_slice(1, 2, &[0.0, 1.0]),
            DMatrix::zeros(1, 1),
        )
        .unwrap();
        let held = pitch.zero_order_hold(0.05).unwrap();
        let g = held.transfer_function(0, 0).unwrap();
        assert!((g.num[1] - 0.0141528).abs() < 1e-6, "{g:?}");
        assert!((g.den[1] + 1.941104).abs() < 1e-5, "{g:?}");
        assert!((g.den[2] - 0.9417645).abs() < 1e-6, "{g:?}");
        let poles = held.poles().unwrap();
        assert!((poles[0].re - 0.984928).abs() < 1e-5 && (poles[1].re - 0.956176).abs() < 1e-5);
    }

    #[test]
    fn sampling_moves_each_pole_to_its_exponential_and_keeps_the_steady_state_gain() {
        let system = oscillator(2.0, 0.3);
        let held = system.zero_order_hold(0.05).unwrap();
        for (s, z) in system.poles().unwrap().iter().zip(held.poles().unwrap()) {
            assert!(((s * 0.05).exp() - z).modulus() < 1e-14);
        }
        assert!(
            (system.steady_state_gain(Domain::Continuous).unwrap()[(0, 0)] - 0.25).abs() < 1e-15
        );
        assert!((held.steady_state_gain(Domain::Discrete).unwrap()[(0, 0)] - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_direct_path_reaches_the_numerator() {
        // 1 + 1/(s + 2) = (s + 3)/(s + 2)
        let one = |x| DMatrix::from_element(1, 1, x);
        let lag = StateSpace::new(one(-2.0), one(1.0), one(1.0), one(1.0)).unwrap();
        let g = lag.transfer_function(0, 0).unwrap();
        assert_eq!((g.num, g.den), (vec![1.0, 3.0], vec![1.0, 2.0]));
    }

    #[test]
    fn the_zeros_are_those_of_the_numerator() {
        // (s + 3) (s + 5) / (s + 1) (s + 2) (s + 4) (s + 6)
        let numerator = vec![1.0, 8.0, 15.0];
        let denominator = vec![1.0, 13.0, 56.0, 92.0, 48.0];
        let g = TransferFunction::new(numerator, denominator).unwrap();
        let zeros = g.companion().unwrap().zeros().unwrap();
        assert_eq!(zeros.len(), 2, "{zeros:?}");
        assert!((zeros[0].re + 3.0).abs() < 1e-9 && (zeros[1].re + 5.0).abs() < 1e-9);
        assert!(oscillator(1.0, 0.2).zeros().unwrap().is_empty());
    }

    #[test]
    fn an_integrator_has_no_steady_state_gain() {
        assert_eq!(
            oscillator(0.0, 0.0).steady_state_gain(Domain::Continuous),
            Err(Error::NoSteadyGain)
        );
    }

    #[test]
    fn matrices_that_do_not_fit_are_refused_by_name() {
        let wide = DMatrix::zeros(2, 3);
        let refusal = StateSpace::new(
            wide,
            DMatrix::zeros(2, 1),
            DMatrix::zeros(1, 2),
            DMatrix::zeros(1, 1),
        )
        .unwrap_err()
        .to_string();
        assert_eq!(refusal, "A is 2 x 3, 2 x 2 is needed");
        let system = oscillator(1.0, 1.0);
        assert!(system.zero_order_hold(0.0).is_err());
        assert!(system.zero_order_hold(f64::NAN).is_err());
        assert!(oscillator(1e3, -1.0).zero_order_hold(1e3).is_err());
        assert!(system.transfer_function(1, 0).is_err());
    }
}
