//! Transfer functions `G = num / den`, highest power first, in `s` or in `z`.

use nalgebra::Complex;

use crate::{
    Domain, Error,
    error::finite,
    polynomial::{self, evaluate},
};

/// A ratio of polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Numerator; leading zeros are allowed and kept.
    pub num: Vec<f64>,
    /// Denominator; its leading coefficient is not zero.
    pub den: Vec<f64>,
}

impl TransferFunction {
    /// The transfer function `num / den`.
    ///
    /// # Errors
    /// [`Error::Empty`], [`Error::NotFinite`], or [`Error::LeadingZero`] for the denominator.
    pub fn new(num: Vec<f64>, den: Vec<f64>) -> Result<Self, Error> {
        polynomial::check("the denominator", &den)?;
        finite("the numerator", &num)?;
        if num.is_empty() {
            return Err(Error::Empty {
                what: "the numerator",
            });
        }
        Ok(Self { num, den })
    }

    /// The poles, in the order of [`polynomial::roots`].
    ///
    /// # Errors
    /// Those of [`polynomial::roots`].
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, Error> {
        polynomial::roots(&self.den)
    }

    /// The zeros, in the order of [`polynomial::roots`]; empty for a zero numerator.
    ///
    /// # Errors
    /// Those of [`polynomial::roots`].
    pub fn zeros(&self) -> Result<Vec<Complex<f64>>, Error> {
        match self.trimmed_num() {
            [] => Ok(Vec::new()),
            num => polynomial::roots(num),
        }
    }

    /// Series connection of `self` and `other`. Common factors are not cancelled.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient overflows.
    pub fn series(&self, other: &Self) -> Result<Self, Error> {
        Self::new(
            polynomial::product(&self.num, &other.num),
            polynomial::product(&self.den, &other.den),
        )
    }

    /// `G / (1 + G)`: closed loop with unity negative feedback.
    ///
    /// # Errors
    /// [`Error::LeadingZero`] if a loop with direct feedthrough has no solution, [`Error::NotFinite`].
    pub fn closed_loop(&self) -> Result<Self, Error> {
        Self::new(self.num.clone(), polynomial::sum(&self.num, &self.den))
    }

    /// `G` at a point of the complex plane; not finite at a pole.
    #[must_use]
    pub fn value_at(&self, point: Complex<f64>) -> Complex<f64> {
        evaluate(&self.num, point) / evaluate(&self.den, point)
    }

    /// Steady-state gain.
    ///
    /// # Errors
    /// [`Error::NoSteadyGain`] if a pole is at the steady point.
    pub fn steady_state_gain(&self, domain: Domain) -> Result<f64, Error> {
        let gain = self.value_at(Complex::new(domain.steady_point(), 0.0)).re;
        if gain.is_finite() {
            Ok(gain)
        } else {
            Err(Error::NoSteadyGain)
        }
    }

    /// Response of this discrete system, initially at rest:
    ///
    /// ```text
    /// a_0 y_k = b_0 u_k + ... + b_n u_(k-n) - a_1 y_(k-1) - ... - a_n y_(k-n)
    /// ```
    /// with the numerator padded with leading zeros to the denominator's length. One output per input. The response of an unstable system may
    /// overflow; the caller must check for this.
    ///
    /// ```
    /// # use planesman_linear::TransferFunction;
    /// let lag = TransferFunction::new(vec![0.5], vec![1.0, -0.5])?; // 0.5 / (z - 0.5)
    /// assert_eq!(lag.simulate(&[1.0; 4])?, [0.0, 0.5, 0.75, 0.875]);
    /// # Ok::<(), planesman_linear::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Improper`] if the numerator's degree is above the denominator's.
    pub fn simulate(&self, input: &[f64]) -> Result<Vec<f64>, Error> {
        let num = self.trimmed_num();
        let order = self.den.len() - 1;
        if num.len() > order + 1 {
            return Err(Error::Improper {
                numerator: num.len() - 1,
                denominator: order,
            });
        }
        let delay = order + 1 - num.len();
        let mut output: Vec<f64> = Vec::with_capacity(input.len());
        for k in 0..input.len() {
            let driven: f64 = num
                .iter()
                .enumerate()
                .filter_map(|(i, b)| Some(b * input[k.checked_sub(delay + i)?]))
                .sum();
            let remembered: f64 = self.den[1..]
                .iter()
                .enumerate()
                .filter_map(|(i, a)| Some(a * output[k.checked_sub(i + 1)?]))
                .sum();
            output.push((driven - remembered) / self.den[0]);
        }
        Ok(output)
    }

    /// The transfer function with 1 as the denominator's first coefficient, and without the numerator's leading zeros.
    #[must_use]
    pub fn monic(&self) -> Self {
        let lead = self.den[0];
        let divided = |c: &[f64]| c.iter().map(|c| c / lead).collect();
        Self {
            num: divided(self.trimmed_num()),
            den: divided(&self.den),
        }
        .or_zero()
    }

    /// The transfer function with coefficients that are only rounding errors set to 0, and without the numerator's leading zeros.
    #[must_use]
    pub fn without_rounding(mut self) -> Self {
        for polynomial in [&mut self.num, &mut self.den] {
            let largest = polynomial.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            for c in polynomial.iter_mut() {
                if c.abs() < 1e-14 * largest {
                    *c = 0.0;
                }
            }
        }
        self.num = self.trimmed_num().to_vec();
        self.or_zero()
    }

    /// Sets an empty numerator to 0.
    fn or_zero(mut self) -> Self {
        if self.num.is_empty() {
            self.num.push(0.0);
        }
        self
    }

    /// The numerator without its leading zeros.
    pub(crate) fn trimmed_num(&self) -> &[f64] {
        let zeros = self.num.iter().take_while(|&&b| b == 0.0).count();
        &self.num[zeros..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run_9_2() -> TransferFunction {
        // Brunner 1988, Table 9, run 9/2, q/delta second order.
        TransferFunction::new(vec![0.033, 0.0758], vec![1.0, -0.7812, -0.099]).unwrap()
    }

    #[test]
    fn the_printed_model_of_run_9_2_has_the_printed_gain_and_zero() {
        assert!((run_9_2().steady_state_gain(Domain::Discrete).unwrap() - 0.908).abs() < 5e-4);
        assert!((run_9_2().zeros().unwrap()[0].re + 2.30).abs() < 5e-3);
    }

    #[test]
    fn the_response_to_a_held_input_ends_at_the_steady_state_gain() {
        let output = run_9_2().simulate(&[1.0; 300]).unwrap();
        let gain = run_9_2().steady_state_gain(Domain::Discrete).unwrap();
        assert!((output[299] - gain).abs() < 1e-12);
    }

    #[test]
    fn the_first_samples_follow_the_difference_equation() {
        let output = run_9_2().simulate(&[1.0, 0.0, 0.0]).unwrap();
        assert_eq!(output[0], 0.0);
        assert_eq!(output[1], 0.033);
        assert!((output[2] - (0.0758 + 0.7812 * 0.033)).abs() < 1e-16);
    }

    #[test]
    fn the_companion_form_has_the_same_transfer_function() {
        let g = TransferFunction::new(vec![0.0, 4.0, 3.0, 2.0], vec![2.0, 1.0, -0.5]).unwrap();
        assert_eq!(
            g.companion().unwrap().transfer_function(0, 0).unwrap(),
            TransferFunction::new(vec![2.0, 1.5, 1.0], vec![1.0, 0.5, -0.25]).unwrap()
        );
        let improper = TransferFunction::new(vec![1.0, 0.0], vec![1.0]).unwrap();
        assert!(matches!(improper.companion(), Err(Error::Improper { .. })));
    }

    #[test]
    fn a_common_factor_of_numerator_and_denominator_changes_no_response() {
        let g = TransferFunction::new(vec![1.0], vec![1.0, -0.5]).unwrap();
        let scaled = TransferFunction::new(vec![4.0], vec![4.0, -2.0]).unwrap();
        let input = [1.0, -2.0, 0.5];
        assert_eq!(
            g.simulate(&input).unwrap(),
            scaled.simulate(&input).unwrap()
        );
    }

    #[test]
    fn leading_zeros_of_the_numerator_are_delays_not_degree() {
        let g = TransferFunction::new(vec![0.0, 0.0, 0.0, 1.0], vec![1.0, 0.0]).unwrap();
        assert_eq!(g.simulate(&[3.0, 5.0]).unwrap(), vec![0.0, 3.0]);
        assert_eq!(g.zeros().unwrap(), vec![]);
    }

    #[test]
    fn what_cannot_run_is_refused() {
        assert!(TransferFunction::new(vec![], vec![1.0]).is_err());
        assert!(TransferFunction::new(vec![1.0], vec![]).is_err());
        assert!(TransferFunction::new(vec![1.0], vec![0.0, 1.0]).is_err());
        assert!(TransferFunction::new(vec![f64::NAN], vec![1.0]).is_err());
        let improper = TransferFunction::new(vec![1.0, 0.0], vec![2.0]).unwrap();
        assert_eq!(
            improper.simulate(&[1.0]),
            Err(Error::Improper {
                numerator: 1,
                denominator: 0
            })
        );
        let integrator = TransferFunction::new(vec![1.0], vec![1.0, -1.0]).unwrap();
        assert_eq!(
            integrator.steady_state_gain(Domain::Discrete),
            Err(Error::NoSteadyGain)
        );
    }
}
