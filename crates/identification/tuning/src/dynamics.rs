//! A continuous model in gain, time constants and dead time, the form that tuning rules use.

use nalgebra::Complex;
use planesman_linear::{ComplexFunctions as _, TransferFunction, polynomial};

use crate::error::Result;

/// A pole nearer to s = 0 than this share of the fastest counts as an integrator.
const AT_ZERO: f64 = 1e-7;

/// `gain prod(s/-z + 1) / (s^n prod(s/-p + 1)) e^(-delay s)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Dynamics {
    /// The gain, output unit per input unit (and s^n).
    pub gain: f64,
    /// `n`.
    pub integrators: usize,
    /// The other poles, 1/s, slowest first.
    pub poles: Vec<Complex<f64>>,
    /// 1/s
    pub zeros: Vec<Complex<f64>>,
    /// s
    pub delay: f64,
}

impl Dynamics {
    /// Converts a transfer function in s with a dead time, s.
    ///
    /// # Errors
    /// If roots cannot be found.
    pub fn new(transfer: &TransferFunction, delay: f64) -> Result<Self> {
        let mut poles = transfer.poles()?;
        let fastest = poles.iter().map(|p| p.modulus()).fold(0.0, f64::max);
        let all = poles.len();
        // A model of one integrator alone has no faster pole to compare with.
        let near = match fastest > 0.0 && all > 1 {
            true => AT_ZERO * fastest,
            false => f64::MIN_POSITIVE,
        };
        poles.retain(|p| p.modulus() > near);
        poles.sort_by(|p, q| p.modulus().total_cmp(&q.modulus()));
        let integrators = all - poles.len();
        let zeros = transfer.zeros()?;
        let lead = transfer.monic();
        let product =
            |roots: &[Complex<f64>]| roots.iter().map(|r| -r).product::<Complex<f64>>().re;
        // With a zero at s = 0 the gain that counts is that of s K.
        let others: Vec<_> = zeros
            .iter()
            .copied()
            .filter(|z| z.modulus() > 0.0)
            .collect();
        let gain = lead.num[0] * product(&others) / product(&poles);
        Ok(Self {
            gain,
            integrators,
            poles,
            zeros,
            delay,
        })
    }

    /// Converts short zeros to dead time, each by its time constant, a pair by the sum: for a short `T`, `T s + 1 = e^(T s)`. A zero is short if its
    /// time constant is below `sample` seconds (such zeros are caused by sampling and moved by noise), or if it is in the left half plane and
    /// compensates the dead time, for example in a model with a delay that is one sample too long. The dead time does not fall below 0.
    #[must_use]
    pub fn with_short_zeros_as_delay(mut self, sample: f64) -> Self {
        let lead = |zero: &Complex<f64>| {
            let count = if zero.im == 0.0 { 1.0 } else { 2.0 };
            -count * zero.re / zero.norm_sqr()
        };
        let mut zeros = std::mem::take(&mut self.zeros);
        zeros.retain(|zero| zero.im >= 0.0);
        zeros.sort_by(|a, b| lead(a).total_cmp(&lead(b)));
        for zero in zeros {
            let lead = lead(&zero);
            if zero.modulus() * sample > 1.0 || (lead > 0.0 && lead <= self.delay) {
                self.delay = (self.delay - lead).max(0.0);
                continue;
            }
            self.zeros.push(zero);
            if zero.im > 0.0 {
                self.zeros.push(zero.conj());
            }
        }
        self
    }

    /// The number of poles, including integrators.
    #[must_use]
    pub fn order(&self) -> usize {
        self.integrators + self.poles.len()
    }

    /// The most unstable pole, 1/s; `None` for a model without unstable poles.
    #[must_use]
    pub fn unstable(&self) -> Option<f64> {
        let growing = self.poles.iter().map(|p| p.re).filter(|re| *re > 0.0);
        growing.max_by(f64::total_cmp)
    }

    /// The denominator polynomial in s, without dead time and zeros, highest power first.
    ///
    /// # Errors
    /// If numbers overflow.
    pub fn denominator(&self) -> Result<Vec<f64>> {
        let monic = polynomial::from_roots(&self.poles)?;
        let end = monic.last().copied().unwrap_or(1.0);
        let mut den: Vec<f64> = monic.iter().map(|c| c / end).collect();
        den.extend(std::iter::repeat_n(0.0, self.integrators));
        Ok(den)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_and_integrators_are_those_of_the_standard_form() {
        // 3 (2 s + 1) / (s (4 s + 1)) e^(-0.5 s)
        let transfer = TransferFunction::new(vec![6.0, 3.0], vec![4.0, 1.0, 0.0]).unwrap();
        let found = Dynamics::new(&transfer, 0.5).unwrap();
        assert!((found.gain - 3.0).abs() < 1e-12);
        assert_eq!(
            (found.integrators, found.poles.len(), found.zeros.len()),
            (1, 1, 1)
        );
        let den = found.denominator().unwrap();
        assert!((den[0] - 4.0).abs() < 1e-12 && den[2] == 0.0);
        let integrator = TransferFunction::new(vec![0.2], vec![1.0, 0.0]).unwrap();
        let found = Dynamics::new(&integrator, 0.0).unwrap();
        assert_eq!((found.integrators, found.gain), (1, 0.2));
    }

    #[test]
    fn zeros_within_the_dead_time_are_part_of_it_and_longer_ones_stay() {
        let of = |zeros: &[Complex<f64>], delay: f64| {
            let zeros = zeros.to_vec();
            let dynamics = Dynamics {
                gain: 1.0,
                integrators: 0,
                poles: vec![Complex::from(-0.2), Complex::from(-1.0)],
                zeros,
                delay,
            };
            let found = dynamics.with_short_zeros_as_delay(0.05);
            (found.zeros.len(), found.delay)
        };
        let real = |lead: f64| Complex::from(-1.0 / lead);
        let pair = [5_f64.sqrt(), -5_f64.sqrt()].map(|im| Complex::new(-1.0, im));
        let close = |found: (usize, f64), zeros: usize, delay: f64| {
            assert_eq!(found.0, zeros);
            assert!((found.1 - delay).abs() < 1e-12, "{found:?}");
        };
        close(of(&[real(0.051)], 0.1), 0, 0.049);
        close(of(&[real(0.06), real(0.051)], 0.1), 1, 0.049);
        close(of(&[real(0.051)], 0.05), 1, 0.05);
        close(of(&[real(0.03)], 0.02), 0, 0.0);
        close(of(&[real(-0.03), real(0.06)], 0.04), 0, 0.01);
        close(of(&[real(-0.3)], 0.4), 1, 0.4);
        // s^2 + 2 s + 6: time constants of 1/3 s in sum.
        close(of(&pair, 0.5), 0, 0.5 - 1.0 / 3.0);
        close(of(&pair, 0.3), 2, 0.3);
    }

    #[test]
    fn an_unstable_lag_has_a_negative_standard_gain() {
        // 1 / (s - 0.5) = -2 / (-2 s + 1)
        let transfer = TransferFunction::new(vec![1.0], vec![1.0, -0.5]).unwrap();
        let found = Dynamics::new(&transfer, 0.0).unwrap();
        assert!((found.gain + 2.0).abs() < 1e-12);
        assert_eq!(found.unstable(), Some(0.5));
    }
}
