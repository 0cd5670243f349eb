//! Residual tests (Ljung, *System Identification*, 2nd ed., 1999, sec. 16.6).
//!
//! ```text
//! R_e(l)  = 1/N sum e_k e_(k-l) / R_e(0)               white: |R_e(l)|  < 2.58 / sqrt(N)
//! R_eu(l) = 1/N sum e_k u_(k-l)                         independent of the input:
//!           |R_eu(l)| < 2.58 sqrt(P / N),  P = sum_l R_e(l) R_u(l)
//! ```
//! the bounds of 99 %, the second of both signals through the filter that whitens the residual. Correlation with the input means that the model lacks
//! dynamics. Colour alone means only that the noise model is wrong; the standard errors are then wrong for methods that assume white noise.

use serde::Serialize;

use crate::estimators::whitening;
use crate::uncertainty::SIGMAS_99;
use planesman_record::filter;

/// Lags looked at.
const LAGS: usize = 20;

/// Number of standard deviations that one value in 16 000 exceeds by chance.
const HARDLY_EVER: f64 = 4.0;

/// One correlation function with its bound.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Lag in samples and correlation, each between -1 and 1.
    pub values: Vec<(i64, f64)>,
    /// If the signals are unrelated, each value stays within this bound with 99 % probability.
    pub bound: f64,
}

impl Correlation {
    /// Number of lags outside the bound.
    #[must_use]
    pub fn outside(&self) -> usize {
        self.values
            .iter()
            .filter(|(_, r)| r.abs() > self.bound)
            .count()
    }

    /// The largest magnitude.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.values.iter().fold(0.0_f64, |m, (_, r)| m.max(r.abs()))
    }

    /// Whether no more lags are outside than chance causes in 99 of 100 tests (binomial distribution with 1 % for each lag), and none is so far
    /// outside that chance hardly ever causes it.
    #[must_use]
    pub fn passes(&self) -> bool {
        if self.largest() > self.bound * HARDLY_EVER / SIGMAS_99 {
            return false;
        }
        let n = self.values.len();
        let mut probability = 0.99_f64.powi(n as i32);
        let mut below = 0.0;
        let mut allowed = 0;
        for k in 0..n {
            below += probability;
            allowed = k;
            if below >= 0.99 {
                break;
            }
            probability *= (n - k) as f64 / (k + 1) as f64 * (0.01 / 0.99);
        }
        self.outside() <= allowed
    }
}

/// The residual tests of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTests {
    /// Correlation of the residual with itself, lags 1 to 20.
    pub whiteness: Correlation,
    /// Correlation of the residual with earlier (and, at negative lags, later) inputs, lags -20 to 20.
    pub input: Correlation,
}

impl ResidualTests {
    /// Tests residuals and the inputs at the same samples; `None` if there are too few samples for 3 lags, or no residual.
    #[must_use]
    pub fn new(residuals: &[f64], inputs: &[f64]) -> Option<Self> {
        let n = residuals.len().min(inputs.len());
        let lags = LAGS.min(n / 4);
        if lags < 3 {
            return None;
        }
        // A residual may end later than its inputs begin: they end together.
        let e = centred(&residuals[residuals.len() - n..]);
        let u = centred(&inputs[inputs.len() - n..]);
        // Both through the filter that whitens the residual: else its colour hides a relation, or makes one up.
        let whitening = whitening([e.as_slice()].into_iter());
        let [white, through] = [&e, &u].map(|signal| {
            let mut signal = filter(&whitening, &[1.0], signal);
            signal.drain(..(whitening.len() - 1).min(n / 2));
            signal
        });
        let covariance = |x: &[f64], y: &[f64], lag: usize| -> f64 {
            (lag..n).map(|k| x[k] * y[k - lag]).sum::<f64>() / n as f64
        };
        let e0 = covariance(&e, &e, 0);
        if !(e0 > 0.0 && e0.is_finite()) {
            return None;
        }
        let of_e: Vec<f64> = (0..=lags).map(|l| covariance(&e, &e, l) / e0).collect();
        let whiteness = Correlation {
            values: (1..=lags).map(|l| (l as i64, of_e[l])).collect(),
            bound: SIGMAS_99 / (n as f64).sqrt(),
        };
        let (e, u, n) = (white, through, n - (whitening.len() - 1).min(n / 2));
        let covariance = |x: &[f64], y: &[f64], lag: usize| -> f64 {
            (lag..n).map(|k| x[k] * y[k - lag]).sum::<f64>() / n as f64
        };
        let (e0, u0) = (covariance(&e, &e, 0), covariance(&u, &u, 0));
        let scale = (e0 * u0).sqrt();
        let power: f64 = (0..=lags)
            .map(|l| {
                let sides = if l == 0 { 1.0 } else { 2.0 };
                let of_e = covariance(&e, &e, l) / e0.max(f64::MIN_POSITIVE);
                sides * of_e * covariance(&u, &u, l) / u0.max(f64::MIN_POSITIVE)
            })
            .sum();
        let cross = |lag: i64| {
            let size = lag.unsigned_abs() as usize;
            let sum = if lag >= 0 {
                covariance(&e, &u, size)
            } else {
                covariance(&u, &e, size)
            };
            if scale > 0.0 { sum / scale } else { 0.0 }
        };
        let most = lags as i64;
        let input = Correlation {
            values: (-most..=most).map(|l| (l, cross(l))).collect(),
            bound: SIGMAS_99 * (power.max(1.0) / n as f64).sqrt(),
        };
        Some(Self { whiteness, input })
    }

    /// Each required property of the residual, with the correlations that test it.
    #[must_use]
    pub fn each(&self) -> [(&'static str, Correlation); 3] {
        [
            ("white", self.whiteness.clone()),
            ("uncorrelated with earlier inputs", self.of_earlier_inputs()),
            ("uncorrelated with later inputs", self.of_later_inputs()),
        ]
    }

    /// The lags at which the residual correlates with an earlier input.
    #[must_use]
    pub fn of_earlier_inputs(&self) -> Correlation {
        self.of_inputs_at(|lag| lag >= 0)
    }

    /// The lags at which the residual correlates with a later input, which means feedback.
    #[must_use]
    pub fn of_later_inputs(&self) -> Correlation {
        self.of_inputs_at(|lag| lag < 0)
    }

    /// The lags at which the residual correlates with an earlier input or the input of the same instant.
    pub(crate) fn of_inputs_from_now(&self) -> Correlation {
        self.of_inputs_at(|lag| lag <= 0)
    }

    /// The lags at which the residual correlates with an input before this instant.
    pub(crate) fn of_inputs_before(&self) -> Correlation {
        self.of_inputs_at(|lag| lag > 0)
    }

    fn of_inputs_at(&self, wanted: impl Fn(i64) -> bool) -> Correlation {
        let values = self.input.values.iter().copied();
        Correlation {
            values: values.filter(|(lag, _)| wanted(*lag)).collect(),
            bound: self.input.bound,
        }
    }
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| v - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_record::noise;

    #[test]
    fn white_noise_passes_nearly_always_and_coloured_noise_never() {
        let mut passed = 0;
        for seed in 0..100 {
            let (e, u) = (noise(seed, 400), noise(seed + 1000, 400));
            let tests = ResidualTests::new(&e, &u).unwrap();
            passed += usize::from(tests.whiteness.passes() && tests.input.passes());
            let coloured = filter(&[1.0], &[1.0, -0.6], &e);
            assert!(
                !ResidualTests::new(&coloured, &u)
                    .unwrap()
                    .whiteness
                    .passes()
            );
        }
        assert!(passed >= 90, "{passed}");
    }

    #[test]
    fn an_input_that_is_left_over_is_found_and_where_it_came_from() {
        let (e, u) = (noise(1, 400), noise(2, 400));
        let mut left: Vec<f64> = e.clone();
        for k in 3..400 {
            left[k] += 0.4 * u[k - 3];
        }
        let tests = ResidualTests::new(&left, &u).unwrap();
        assert!(!tests.of_earlier_inputs().passes());
        assert!(tests.of_later_inputs().passes());
        let mut fed = u;
        for k in 1..400 {
            fed[k] += 0.5 * e[k - 1];
        }
        let tests = ResidualTests::new(&e, &fed).unwrap();
        assert!(tests.of_earlier_inputs().passes());
        assert!(!tests.of_later_inputs().passes());
    }

    #[test]
    fn too_short_a_residual_is_not_judged() {
        assert_eq!(ResidualTests::new(&[1.0; 8], &[1.0; 8]), None);
        assert_eq!(ResidualTests::new(&[0.0; 80], &[1.0; 80]), None);
    }
}
