//! A model sampled at the controller's ticks.

use nalgebra::Complex;
use planesman_linear::polynomial::lies_within;
use planesman_linear::sampled::AT_ONCE;
use planesman_linear::{Error, Sampled, TransferFunction, polar};

/// A leading coefficient below this share of the largest is rounding error.
const ROUNDING: f64 = 1e-12;
/// A dead time closer to a whole number of ticks than this share of a tick is rounded to that number.
const WHOLE: f64 = 1e-9;
/// If `A(1)` is below this share of its terms' size, there is a pole at z = 1.
const AT_ONE: f64 = 1e-9;

/// `y_k = b_0 u_(k-d) + b_1 u_(k-d-1) + ... - a_1 y_(k-1) - ... - a_n y_(k-n)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// `a_1 ... a_n`.
    pub a: Vec<f64>,
    /// `b_0 ... b_m`, output unit per input unit.
    pub b: Vec<f64>,
    /// `d`, ticks from an input to its first effect.
    pub delay: usize,
    /// The interval between ticks, s.
    pub tick: f64,
}

impl Plant {
    /// Converts a transfer function in z, highest power first, with further ticks of delay.
    #[must_use]
    pub fn of_z(num: &[f64], den: &[f64], tick: f64, further: usize) -> Self {
        let lead = den.first().copied().unwrap_or(1.0);
        let largest = num.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
        let idle = num.iter().take_while(|b| b.abs() <= ROUNDING * largest);
        let idle = idle.count().min(num.len().saturating_sub(1));
        // Zeros at the end of both are factors z.
        let without_end = |c: &[f64]| {
            let end = c.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1);
            c[..end].iter().map(|c| c / lead).collect::<Vec<f64>>()
        };
        Self {
            a: without_end(den.get(1..).unwrap_or_default()),
            b: without_end(&num[idle..]),
            delay: den.len().saturating_sub(num.len()) + idle + further,
            tick,
        }
    }

    /// Samples a continuous model whose input is held over each tick and acts `delay` seconds later.
    ///
    /// # Errors
    /// [`Error`]: a model whose input acts on the output at once, a tick that is not above 0, numbers that overflow.
    pub fn held(transfer: &TransferFunction, delay: f64, tick: f64) -> Result<Self, Error> {
        let ticks = (delay / tick + WHOLE).floor().max(0.0);
        let rest = delay - ticks * tick;
        let motion = match rest > WHOLE * tick {
            true => [(rest, 0.0), (rest, 1.0)],
            false => AT_ONCE,
        };
        let system = Sampled::new(&transfer.companion()?, &motion, tick)?;
        let TransferFunction { num, den } = system.state_space().transfer_function(0, 0)?;
        Ok(Self::of_z(&num, &den, tick, ticks as usize))
    }

    /// `pi / T`, rad/s.
    #[must_use]
    pub fn nyquist(&self) -> f64 {
        std::f64::consts::PI / self.tick
    }

    /// The response at a frequency, rad/s.
    #[must_use]
    pub fn at(&self, frequency: f64) -> Complex<f64> {
        let q = polar(1.0, -frequency * self.tick);
        let a = backward(&self.a, q) * q + 1.0;
        let delay = polar(1.0, -frequency * self.tick * self.delay as f64);
        delay * backward(&self.b, q) / a
    }

    /// The initial direction in which a constant input moves the output: the sign of `B(1)`. This is the sign of the gain, except with an unstable
    /// pole.
    #[must_use]
    pub fn sign(&self) -> f64 {
        self.b.iter().sum::<f64>().signum()
    }

    /// Whether all poles are inside or on the unit circle.
    #[must_use]
    pub fn decays(&self) -> bool {
        lies_within(&self.a, 1.0 + AT_ONE.sqrt())
    }

    /// The number of poles at z = 1.
    #[must_use]
    pub fn integrators(&self) -> usize {
        let mut a: Vec<f64> = std::iter::once(1.0).chain(self.a.iter().copied()).collect();
        let mut count = 0;
        loop {
            let size: f64 = a.iter().map(|a| a.abs()).sum();
            if a.len() < 2 || a.iter().sum::<f64>().abs() > AT_ONE * size {
                return count;
            }
            a = without_one(&a);
            count += 1;
        }
    }

    /// The steady-state gain; for a plant that integrates n times the gain K of `K / s^n`, output unit per input unit and s^n.
    #[must_use]
    pub fn gain(&self) -> f64 {
        let mut a: Vec<f64> = std::iter::once(1.0).chain(self.a.iter().copied()).collect();
        let integrators = self.integrators();
        for _ in 0..integrators {
            a = without_one(&a);
        }
        self.b.iter().sum::<f64>()
            / a.iter().sum::<f64>()
            / self
                .tick
                .powi(i32::try_from(integrators).unwrap_or(i32::MAX))
    }
}

/// `c_0 + c_1 q + c_2 q^2 + ...`
pub(crate) fn backward(c: &[f64], q: Complex<f64>) -> Complex<f64> {
    let zero = Complex::new(0.0, 0.0);
    c.iter().rev().fold(zero, |sum, c| sum * q + *c)
}

/// A polynomial in `1/z` without its factor `1 - 1/z`.
fn without_one(a: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let quotient = a[..a.len() - 1].iter().map(|a| {
        sum += a;
        sum
    });
    quotient.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;

    fn lag(time_constant: f64) -> TransferFunction {
        TransferFunction::new(vec![2.0], vec![time_constant, 1.0]).unwrap()
    }

    #[test]
    fn a_held_lag_with_dead_time_is_the_textbook_one() {
        // Astrom and Wittenmark, Computer-Controlled Systems, 3rd ed., ex. 2.8, with a dead time of d T + tau:
        // y_k+1 = a y_k + b0 u_k-d + b1 u_k-d-1, b0 = K (1 - exp(-(T - tau)/T1)), b1 = K exp(-(T - tau)/T1) (1 - exp(-tau/T1)).
        let plant = Plant::held(&lag(3.0), 1.3, 0.5).unwrap();
        let (rest, left) = (0.3_f64, 0.2_f64);
        assert_eq!(plant.delay, 3);
        assert!((plant.a[0] + libm::exp(-0.5_f64 / 3.0)).abs() < 1e-14);
        let b0 = 2.0 * (1.0 - libm::exp(-left / 3.0));
        let b1 = 2.0 * libm::exp(-left / 3.0) * (1.0 - libm::exp(-rest / 3.0));
        assert!((plant.b[0] - b0).abs() < 1e-13 && (plant.b[1] - b1).abs() < 1e-13);
        assert_eq!(plant.b.len(), 2);
        assert!((plant.gain() - 2.0).abs() < 1e-12 && plant.integrators() == 0);
    }

    #[test]
    fn whole_ticks_of_dead_time_leave_one_coefficient() {
        let plant = Plant::held(&lag(3.0), 1.5, 0.5).unwrap();
        assert_eq!((plant.delay, plant.b.len()), (4, 1));
    }

    #[test]
    fn a_delay_written_as_zeros_is_a_delay() {
        // 0.2 / (z^3 - 0.9 z^2), and with the input of the same sample: 0.2 z / (z - 0.9).
        let plant = Plant::of_z(&[0.0, 0.0, 0.2], &[1.0, -0.9, 0.0, 0.0], 0.1, 0);
        assert_eq!(
            (plant.delay, &plant.a[..], &plant.b[..]),
            (3, &[-0.9][..], &[0.2][..])
        );
        let plant = Plant::of_z(&[0.2, 0.0], &[1.0, -0.9], 0.1, 0);
        assert_eq!((plant.delay, &plant.b[..]), (0, &[0.2][..]));
    }

    #[test]
    fn integrators_have_the_gain_of_their_continuous_counterpart() {
        for (den, count) in [(vec![4.0, 1.0, 0.0], 1), (vec![1.0, 0.0, 0.0], 2)] {
            let transfer = TransferFunction::new(vec![0.7], den).unwrap();
            let plant = Plant::held(&transfer, 0.25, 0.1).unwrap();
            assert_eq!(plant.integrators(), count);
            assert!((plant.gain() - 0.7).abs() < 1e-9, "{}", plant.gain());
        }
    }

    #[test]
    fn the_response_is_that_of_the_held_model() {
        // Slow against the tick: e^(-jw (theta + T/2)) K / (jw T1 + 1).
        let (plant, w) = (Plant::held(&lag(3.0), 0.7, 0.01).unwrap(), 0.5);
        let s = Complex::new(0.0, w);
        let expected = (-s * (0.7 + 0.005)).exp() * 2.0 / (s * 3.0 + 1.0);
        assert!((plant.at(w) - expected).modulus() < 1e-5);
    }
}
