//! Frequency response of open loops: crossovers, gain and phase margins.
//!
//! For an open loop `L(s) = G(s) e^(-tau s)` closed by unity negative feedback:
//!
//! - **gain crossover**: `|L(jw)| = 1`; the **phase margin** there is `pi + arg L(jw)`;
//! - **phase crossover**: `L(jw)` is real and negative; the **gain margin** there is `1 / |L(jw)|`, the
//!   factor on the gain that puts a pole of the closed loop at `jw`.
//!
//! A loop that is stable only between two gains has a gain margin below one too (Franklin, Powell and
//! Emami-Naeini, *Feedback Control of Dynamic Systems*, ch. 6).

use std::f64::consts::TAU;

use crate::ComplexFunctions as _;
use nalgebra::Complex;

use crate::{Error, TransferFunction, polar, polynomial};

/// Points per decade of the search for phase crossovers.
const POINTS_PER_DECADE: usize = 100;

/// A rational transfer function followed by a dead time.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayedLoop {
    /// `G(s)`.
    pub transfer_function: TransferFunction,
    /// `tau`, s.
    pub delay: f64,
}

/// A gain crossover: the open loop has magnitude one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseMargin {
    /// Frequency, rad/s.
    pub frequency: f64,
    /// Phase margin, rad, in `(-pi, pi]`; positive for a stable loop with one crossover.
    pub margin: f64,
}

/// A phase crossover: the open loop is real and negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainMargin {
    /// Frequency, rad/s.
    pub frequency: f64,
    /// Gain margin `1 / |L|`, a factor.
    pub factor: f64,
}

/// The maximum of a frequency response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Frequency, rad/s.
    pub frequency: f64,
    /// Magnitude.
    pub value: f64,
}

/// Phases of a frequency response, rad, unwrapped: each within half a turn of the previous one.
#[must_use]
pub fn unwrapped_phases(response: impl IntoIterator<Item = Complex<f64>>) -> Vec<f64> {
    let mut before: Option<f64> = None;
    let follow = |value: Complex<f64>| {
        let phase = value.argument();
        let turns = before.map_or(0.0, |before| ((before - phase) / TAU).round());
        let phase = phase + turns * TAU;
        before = Some(phase);
        phase
    };
    response.into_iter().map(follow).collect()
}

impl DelayedLoop {
    /// A loop without dead time.
    #[must_use]
    pub fn undelayed(transfer_function: TransferFunction) -> Self {
        Self {
            transfer_function,
            delay: 0.0,
        }
    }

    /// `L(s)` with the second-order Padé approximation of the dead time, for poles and step responses:
    ///
    /// ```text
    /// e^(-x) ~ (1 - x/2 + x^2/12) / (1 + x/2 + x^2/12)        x = tau s
    /// ```
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn rational(&self) -> Result<TransferFunction, Error> {
        if self.delay == 0.0 {
            return Ok(self.transfer_function.clone());
        }
        let (first, second) = (self.delay / 2.0, self.delay.powi(2) / 12.0);
        TransferFunction::new(vec![second, -first, 1.0], vec![second, first, 1.0])?
            .series(&self.transfer_function)
    }

    /// `L(jw)` at a frequency (rad/s).
    #[must_use]
    pub fn at(&self, frequency: f64) -> Complex<f64> {
        let delay = polar(1.0, -frequency * self.delay);
        self.transfer_function
            .value_at(Complex::new(0.0, frequency))
            * delay
    }

    /// All gain crossovers, lowest frequency first: the positive roots of `|N(jw)|^2 = |D(jw)|^2`, a polynomial in `w^2`.
    ///
    /// # Errors
    /// Those of [`polynomial::roots`].
    pub fn phase_margins(&self) -> Result<Vec<PhaseMargin>, Error> {
        let num = squared_magnitude(&self.transfer_function.num);
        let den = squared_magnitude(&self.transfer_function.den);
        let difference: Vec<f64> =
            polynomial::sum(&den, &num.iter().map(|c| -c).collect::<Vec<_>>())
                .into_iter()
                .skip_while(|c| *c == 0.0)
                .collect();
        if difference.len() < 2 {
            return Ok(Vec::new());
        }
        let mut crossovers: Vec<PhaseMargin> = polynomial::roots(&difference)?
            .into_iter()
            .filter(|x| x.re > 0.0 && x.im.abs() <= 1e-9 * x.modulus())
            .map(|x| {
                let frequency = x.re.sqrt();
                PhaseMargin {
                    frequency,
                    margin: margin_of(self.at(frequency)),
                }
            })
            .collect();
        crossovers.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Ok(crossovers)
    }

    /// All phase crossovers in `[lowest, highest]` (rad/s), lowest frequency first, found on a logarithmic grid and refined by bisection.
    #[must_use]
    pub fn gain_margins(&self, lowest: f64, highest: f64) -> Vec<GainMargin> {
        gain_margins(&response(lowest, highest, |w| self.at(w)), |w| self.at(w))
    }
}

/// A frequency response: frequencies (rad/s), ascending, and values.
pub type Response = Vec<(f64, Complex<f64>)>;

/// Logarithmically spaced frequencies from `lowest` to `highest` (rad/s), both included.
#[must_use]
pub fn grid(lowest: f64, highest: f64) -> Vec<f64> {
    let decades = libm::log10(highest / lowest);
    let points = (decades * POINTS_PER_DECADE as f64).ceil().max(1.0) as usize;
    (0..=points)
        .map(|i| lowest * libm::pow(highest / lowest, i as f64 / points as f64))
        .collect()
}

/// Values of `at` on the [`grid`].
fn response(lowest: f64, highest: f64, at: impl Fn(f64) -> Complex<f64>) -> Response {
    let grid = grid(lowest, highest).into_iter();
    grid.map(|w| (w, at(w))).collect()
}

/// All phase crossovers between the points of an open loop's response, refined by bisection of `at`, the same response at any frequency
/// (rad/s).
#[must_use]
pub fn gain_margins(
    response: &[(f64, Complex<f64>)],
    at: impl Fn(f64) -> Complex<f64>,
) -> Vec<GainMargin> {
    let crossovers = crossings(response, &at, |value| value.im);
    let values = crossovers.into_iter().map(|w| (w, at(w)));
    values
        // A pole on the axis changes the sign too, through infinity.
        .filter(|(_, value)| value.re < 0.0 && value.im.abs() <= 1e-6 * value.modulus())
        .map(|(frequency, value)| GainMargin {
            frequency,
            factor: 1.0 / value.modulus(),
        })
        .collect()
}

/// Like [`gain_margins`], for gain crossovers.
#[must_use]
pub fn phase_margins(
    response: &[(f64, Complex<f64>)],
    at: impl Fn(f64) -> Complex<f64>,
) -> Vec<PhaseMargin> {
    let crossovers = crossings(response, &at, |value| libm::log(value.modulus()));
    crossovers
        .into_iter()
        .map(|frequency| PhaseMargin {
            frequency,
            margin: margin_of(at(frequency)),
        })
        .collect()
}

/// The largest `|S| = |1 / (1 + L)|` between the points of an open loop's response, and its frequency (rad/s). The inverse of the peak is the
/// distance of the Nyquist plot from -1.
#[must_use]
pub fn sensitivity_peak(
    response: &[(f64, Complex<f64>)],
    at: impl Fn(f64) -> Complex<f64>,
) -> Option<Peak> {
    let size = |value: Complex<f64>| 1.0 / (value + 1.0).modulus();
    let highest =
        (0..response.len()).max_by(|a, b| size(response[*a].1).total_cmp(&size(response[*b].1)))?;
    let (mut low, mut high) = (
        response[highest.saturating_sub(1)].0,
        response[(highest + 1).min(response.len() - 1)].0,
    );
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if size(at(a)) > size(at(b)) {
            high = b;
        } else {
            low = a;
        }
    }
    let frequency = 0.5 * (low + high);
    Some(Peak {
        frequency,
        value: size(at(frequency)),
    })
}

/// Frequencies at which `of` the response changes sign, by bisection.
fn crossings(
    response: &[(f64, Complex<f64>)],
    at: &impl Fn(f64) -> Complex<f64>,
    of: impl Fn(Complex<f64>) -> f64,
) -> Vec<f64> {
    let mut found = Vec::new();
    for pair in response.windows(2) {
        let [(mut low, first), (mut high, last)] = [pair[0], pair[1]];
        let below = of(first);
        if !(below * of(last) < 0.0 || below == 0.0) {
            continue;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if of(at(middle)) * below > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        found.push(high);
    }
    found
}

/// Argument of -L, in `(-pi, pi]`: the argument of L plus pi.
fn margin_of(value: Complex<f64>) -> f64 {
    let (sin, cos) = libm::sincos(value.argument());
    libm::atan2(-sin, -cos)
}

/// `|p(jw)|^2` as a polynomial in `x = w^2`, highest power first: `E(x)^2 + x O(x)^2` with the even and odd parts of
/// `p(jw) = E(w^2) + j w O(w^2)`.
fn squared_magnitude(p: &[f64]) -> Vec<f64> {
    let degree = p.len() - 1;
    let part = |parity: usize| -> Vec<f64> {
        // Of s^k with k = parity + 2 i the share of (-x)^i.
        let mut lowest_first: Vec<f64> = (parity..=degree)
            .step_by(2)
            .enumerate()
            .map(|(i, k)| p[degree - k] * if i % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        lowest_first.reverse();
        lowest_first
    };
    let (even, odd) = (part(0), part(1));
    let mut odd_squared = polynomial::product(&odd, &odd);
    if !odd_squared.is_empty() {
        odd_squared.push(0.0);
    }
    polynomial::sum(&polynomial::product(&even, &even), &odd_squared)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tf(num: &[f64], den: &[f64]) -> TransferFunction {
        TransferFunction::new(num.to_vec(), den.to_vec()).unwrap()
    }

    #[test]
    fn a_double_lag_behind_an_integrator_has_the_textbook_margins() {
        // L = 2 / (s (s + 1)^2): phase -180 at w = 1, |L| = 1 there.
        let open = DelayedLoop::undelayed(tf(&[2.0], &[1.0, 2.0, 1.0, 0.0]));
        let gain = open.gain_margins(1e-2, 1e2);
        assert_eq!(gain.len(), 1);
        assert!((gain[0].frequency - 1.0).abs() < 1e-9);
        assert!((gain[0].factor - 1.0).abs() < 1e-9);
        let phase = open.phase_margins().unwrap();
        assert_eq!(phase.len(), 1);
        assert!((phase[0].frequency - 1.0).abs() < 1e-9 && phase[0].margin.abs() < 1e-9);
    }

    #[test]
    fn dead_time_takes_its_angle_from_the_phase_margin() {
        let integrator = tf(&[1.0], &[1.0, 0.0]);
        let open = DelayedLoop {
            transfer_function: integrator,
            delay: 0.5,
        };
        let margin = open.phase_margins().unwrap()[0];
        assert!((margin.frequency - 1.0).abs() < 1e-12);
        assert!((margin.margin - (std::f64::consts::FRAC_PI_2 - 0.5)).abs() < 1e-12);
        // Unstable from K w / w = 1 where w tau = pi / 2.
        let gain = open.gain_margins(1e-2, 5.0)[0];
        assert!((gain.factor - std::f64::consts::PI).abs() < 1e-6);
    }

    #[test]
    fn the_rational_loop_has_the_same_frequency_response_well_below_the_dead_time() {
        let open = DelayedLoop {
            transfer_function: tf(&[3.0], &[1.0, 1.0]),
            delay: 0.1,
        };
        let rational = open.rational().unwrap();
        for w in [0.1, 1.0, 5.0] {
            let off = rational.value_at(Complex::new(0.0, w)) - open.at(w);
            assert!(off.modulus() < 1e-4 * open.at(w).modulus(), "{w}");
        }
    }

    #[test]
    fn a_conditionally_stable_loop_has_a_gain_margin_on_either_side() {
        // An unstable pole, caught by rate: L = 4 (s + 1) / (s^2 - 1) . 1 / (0.05 s + 1)^2
        let open = DelayedLoop::undelayed(tf(
            &[4.0, 4.0],
            &polynomial::product(&[1.0, 0.0, -1.0], &[0.0025, 0.1, 1.0]),
        ));
        let margins = open.gain_margins(1e-3, 1e3);
        let upper = margins.iter().map(|m| m.factor).fold(0.0, f64::max);
        assert!(upper > 1.0);
        for margin in margins {
            let scaled = tf(
                &open
                    .transfer_function
                    .num
                    .iter()
                    .map(|b| b * margin.factor)
                    .collect::<Vec<_>>(),
                &open.transfer_function.den,
            );
            let closed = scaled.closed_loop().unwrap();
            let nearest = closed
                .poles()
                .unwrap()
                .iter()
                .map(|s| s.re.abs())
                .fold(f64::MAX, f64::min);
            assert!(nearest < 1e-6, "{nearest}");
        }
    }

    #[test]
    fn the_squared_magnitude_is_that_on_the_axis() {
        let p = [2.0, -1.0, 3.0, 0.5, 4.0];
        let in_square = squared_magnitude(&p);
        for w in [0.1_f64, 1.0, 3.7] {
            let direct = polynomial::evaluate(&p, Complex::new(0.0, w)).norm_sqr();
            let found = polynomial::evaluate(&in_square, Complex::new(w * w, 0.0)).re;
            assert!((found - direct).abs() < 1e-9 * direct);
        }
    }
}
