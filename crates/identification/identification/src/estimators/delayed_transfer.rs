//! A transfer function with a dead time in continuous time, and its sampled model for an input with zero-order hold.
//!
//! ```text
//!        s^z (b_m s^m + ... + b_0)
//! G(s) = ----------------------------------- e^(-theta s)       strictly proper: z + m < i + n
//!        s^i (s^n + a_(n-1) s^(n-1) + ... + a_0)
//! ```
//! With zero-order hold the sampled model is exact: it needs no factor for the hold and has no aliasing error. The search uses frequency in
//! units of the middle of the band, so that its parameters are near one.

use nalgebra::{DMatrix, DVector};
use planesman_linear::polynomial::{self, evaluate};
use planesman_linear::{Complex, DelayedLoop, StateSpace, TransferFunction, polar};

use crate::error::Result;

/// The relative step of a parameter in difference quotients, and the smallest step.
const BY: f64 = 1e-5;
const LEAST: f64 = 1e-2;

/// The orders of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// n, poles.
    pub poles: usize,
    /// m, zeros.
    pub zeros: usize,
    /// i, poles known to be at s = 0.
    pub integrators: usize,
    /// z, zeros known to be at s = 0.
    pub differentiators: usize,
    /// The dead time, s, if known; otherwise it is estimated.
    pub delay: Option<f64>,
}

impl Orders {
    /// The number of unknowns.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.poles + self.zeros + 1 + usize::from(self.delay.is_none())
    }

    /// Whether the transfer function is strictly proper.
    #[must_use]
    pub fn is_strictly_proper(&self) -> bool {
        self.differentiators + self.zeros < self.integrators + self.poles
    }

    /// The unknowns' names, in their order: `b_m ... b_0`, `a_(n-1) ... a_0`, `theta`.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let of = |letter: char, count: usize| {
            let powers = (0..count).rev();
            powers.map(move |power| format!("{letter}{power}"))
        };
        let delay = self.delay.is_none().then(|| "theta".to_owned());
        of('b', self.zeros + 1)
            .chain(of('a', self.poles))
            .chain(delay)
            .collect()
    }

    /// Factors from the unknowns of the search, in units of `middle` rad/s, to the coefficients of G.
    pub(super) fn scales(&self, middle: f64) -> DVector<f64> {
        let n = self.poles as i32;
        let power = |power: usize| middle.powi(n - power as i32);
        let numerator = (0..=self.zeros).rev().map(power);
        let denominator = (0..self.poles).rev().map(power);
        let delay = self.delay.is_none().then_some(1.0 / middle);
        let all = numerator.chain(denominator).chain(delay);
        DVector::from_vec(all.collect())
    }

    /// G with these unknowns.
    ///
    /// # Errors
    /// If numbers are not finite.
    pub(super) fn transfer(&self, values: &DVector<f64>) -> Result<DelayedLoop> {
        let (num, rest) = values.as_slice().split_at(self.zeros + 1);
        let (den, rest) = rest.split_at(self.poles);
        let num = [num, &vec![0.0; self.differentiators]].concat();
        let den = [&[1.0], den, &vec![0.0; self.integrators]].concat();
        Ok(DelayedLoop {
            transfer_function: TransferFunction::new(num, den)?,
            delay: self.delay.or(rest.first().copied()).unwrap_or_default(),
        })
    }
}

/// G sampled under zero-order hold, with the fraction f of the dead time beyond whole samples.
///
/// ```text
/// x_(k+1) = A x_k + B_0 u_k + B_1 u_(k-1),   B_0 the hold over (1 - f) T, B_0 + B_1 that over T
/// G = C (z - A)^-1 (B_0 + B_1/z) = (N_0(d) + N_1(d)/z) / D(d),   d = z - 1
/// ```
/// Polynomials in d = z - 1 stay accurate for poles near z = 1, where polynomials in z lose digits (Middleton and Goodwin, *Digital Control and
/// Estimation*, 1990).
pub(super) struct HeldInputTransfer {
    /// `D`, `N_0`, `N_1`, the highest power first.
    den: Vec<f64>,
    now: Vec<f64>,
    before: Vec<f64>,
    sample_time: f64,
    /// The dead time in whole samples.
    whole: usize,
}

impl HeldInputTransfer {
    /// # Errors
    /// If the transfer function is not strictly proper, the dead time is below 0, or numbers overflow.
    pub(super) fn new(of: &DelayedLoop, sample_time: f64) -> Result<Self> {
        let g = &of.transfer_function;
        // In a unit of time in which no coefficient of the denominator is above 1.
        let sizes = g.den.iter().enumerate().skip(1);
        let unit = sizes
            .map(|(power, a)| libm::pow((a / g.den[0]).abs(), 1.0 / power as f64))
            .fold(0.0, f64::max);
        let unit = if unit > 0.0 { unit } else { 1.0 / sample_time };
        let scaled = |of: &[f64]| {
            let last = of.len() as i32 - 1;
            let each = of.iter().enumerate();
            each.map(|(i, c)| c * unit.powi(last - i as i32)).collect()
        };
        let system = TransferFunction::new(scaled(&g.num), scaled(&g.den))?.companion()?;
        let tick = sample_time * unit;
        let whole = (of.delay / sample_time).floor().max(0.0);
        let left = tick * (1.0 - (of.delay / sample_time - whole));
        let all = system.zero_order_hold(tick)?;
        let now = match left < tick {
            true => system.zero_order_hold(left)?.b,
            false => all.b.clone(),
        };
        let states = all.a.nrows();
        let a = &all.a - DMatrix::identity(states, states);
        let behind = |b: DMatrix<f64>| {
            let of = StateSpace::new(a.clone(), b, system.c.clone(), system.d.clone())?;
            of.transfer_function(0, 0)
        };
        let of_now = behind(now.clone())?;
        Ok(Self {
            now: of_now.num,
            den: of_now.den,
            before: behind(all.b - now)?.num,
            sample_time,
            whole: whole as usize,
        })
    }

    /// The response at a frequency, rad/s; `None` at a pole.
    pub(super) fn at(&self, omega: f64) -> Option<Complex<f64>> {
        let (sin, cos) = libm::sincos(omega * self.sample_time);
        // cos - 1 without its rounding.
        let half = libm::sin(0.5 * omega * self.sample_time);
        let (z, d) = (
            Complex::new(cos, sin),
            Complex::new(-2.0 * half * half, sin),
        );
        let late = omega * self.sample_time * self.whole as f64;
        let num = evaluate(&self.now, d) + evaluate(&self.before, d) / z;
        let value = num / evaluate(&self.den, d) * polar(1.0, -late);
        (value.re.is_finite() && value.im.is_finite()).then_some(value)
    }

    /// `a1 ...` and `b1 ...`, one more, with a delay of [`HeldInputTransfer::delay`] samples.
    pub(super) fn difference_equation(&self) -> (Vec<f64>, Vec<f64>) {
        let in_z = |of: &[f64]| {
            let each = of.iter();
            each.fold(Vec::new(), |sum, c| {
                polynomial::sum(&polynomial::product(&sum, &[1.0, -1.0]), &[*c])
            })
        };
        let of = |list: &[f64]| {
            let mut list = in_z(list);
            let missing = self.den.len() - list.len();
            list.splice(0..0, vec![0.0; missing]);
            list
        };
        let (den, now, before) = (of(&self.den), of(&self.now), of(&self.before));
        let late = |i: usize| if i == 0 { 0.0 } else { before[i - 1] };
        let b = (1..=den.len()).map(|i| now.get(i).copied().unwrap_or_default() + late(i));
        (den[1..].to_vec(), b.collect())
    }

    /// Samples from the input to its first effect.
    pub(super) fn delay(&self) -> usize {
        self.whole + 1
    }
}

/// Derivatives of the values that `of` computes at `theta` (`here`), with respect to each parameter: central differences, or one-sided differences if
/// the other side has no value.
pub(super) fn slopes(
    theta: &DVector<f64>,
    here: &DVector<f64>,
    of: impl Fn(&DVector<f64>) -> Option<DVector<f64>>,
) -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(here.len(), theta.len());
    for i in 0..theta.len() {
        let by = BY * theta[i].abs().max(LEAST);
        let moved = |by: f64| {
            let mut theta = theta.clone();
            theta[i] += by;
            of(&theta)
        };
        let slope = match (moved(by), moved(-by)) {
            (Some(above), Some(below)) => (above - below) / (2.0 * by),
            (Some(above), None) => (above - here) / by,
            (None, Some(below)) => (here - below) / by,
            (None, None) => continue,
        };
        slopes.set_column(i, &slope);
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;

    /// Two poles, a zero and a dead time of 3.4 samples: the difference equation, the response, and the step in closed form.
    #[test]
    fn a_held_transfer_function_is_the_sampled_step_response() {
        let orders = Orders {
            poles: 2,
            zeros: 1,
            integrators: 0,
            differentiators: 0,
            delay: None,
        };
        // (s + 3) / ((s + 1)(s + 2)), steps to 1.5 - 2 e^-t + 0.5 e^-2t.
        let values = DVector::from_vec(vec![1.0, 3.0, 3.0, 2.0, 0.34]);
        let held = HeldInputTransfer::new(&orders.transfer(&values).unwrap(), 0.1).unwrap();
        assert_eq!(held.delay(), 4);
        let (a, b) = held.difference_equation();
        let through = planesman_record::filter(
            &[&[0.0; 4][..], &b].concat(),
            &[&[1.0][..], &a].concat(),
            &[1.0; 40],
        );
        for (k, y) in through.iter().enumerate() {
            let t = (k as f64 * 0.1 - 0.34).max(0.0);
            let expected = 1.5 - 2.0 * libm::exp(-t) + 0.5 * libm::exp(-2.0 * t);
            assert!((y - expected).abs() < 1e-9, "{k}: {y} {expected}");
        }
        // The transform of the differences of that step response.
        for omega in [0.3, 5.0, 25.0] {
            let late = |k: f64| polar(1.0, -omega * 0.1 * k);
            let response = |k: usize| {
                let t = (k as f64 * 0.1 - 0.34).max(0.0);
                1.5 - 2.0 * libm::exp(-t) + 0.5 * libm::exp(-2.0 * t)
            };
            let sum: Complex<f64> = (1..600)
                .map(|k| late(k as f64) * (response(k) - response(k - 1)))
                .sum();
            assert!((held.at(omega).unwrap() - sum).modulus() < 1e-9, "{omega}");
        }
    }
}
