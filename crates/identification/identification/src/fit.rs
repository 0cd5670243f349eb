//! The fit of a model to a record: `100 (1 - |y - yhat| / |y - mean y|)` %.
//!
//! 100 % is a perfect match, 0 % is no better than the output's mean, and negative values are worse. *One step ahead* predicts each output from the
//! measured outputs before it. This is optimistic: a model that repeats the last output does well. *Simulated* runs the model on the input alone,
//! from rest, the way the thesis compares its models (Brunner, NPS thesis, 1988, ch. V).

use crate::model::Model;
use planesman_record::Input;

/// The sum of squares of the outputs about their mean, with forgetting: `sum_i lambda^(k-i) (y_i - mean)^2`, updated in West's stable form
/// (*Comm. ACM* 22, 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitRange {
    weight: f64,
    mean: f64,
    sum_of_squares: f64,
}

impl FitRange {
    /// Takes one value; earlier values are weighted by a further factor `forgetting`.
    pub fn update(&mut self, value: f64, forgetting: f64) {
        let before = self.weight * forgetting;
        self.weight = before + 1.0;
        let deviation = value - self.mean;
        self.mean += deviation / self.weight;
        self.sum_of_squares =
            self.sum_of_squares * forgetting + deviation * deviation * before / self.weight;
    }

    /// `sum_i lambda^(k-i) (y_i - mean)^2`, the unit squared.
    #[must_use]
    pub fn sum_of_squares(&self) -> f64 {
        self.sum_of_squares
    }
}

/// The fit, %, for a sum of squared errors and the output's own sum of squares about its mean; `None` if the output is constant.
#[must_use]
pub fn fit(squared_errors: f64, spread: f64) -> Option<f64> {
    (spread > 0.0)
        .then(|| 100.0 * (1.0 - (squared_errors / spread).sqrt()))
        .filter(|fit| fit.is_finite())
}

/// The fit, %, of `model` simulated from rest on the inputs alone; `inputs[k]` acts over the interval that begins with `outputs[k]`. `None`
/// if the output is constant or the simulation overflows.
#[must_use]
pub fn simulated(model: &Model, inputs: &[Input], outputs: &[f64]) -> Option<f64> {
    let simulated = model.simulate(inputs, outputs.len());
    let mut spread = FitRange::default();
    let mut squared_errors = 0.0;
    for (y, y_hat) in outputs.iter().zip(&simulated) {
        spread.update(*y, 1.0);
        squared_errors += (y - y_hat) * (y - y_hat);
    }
    fit(squared_errors, spread.sum_of_squares())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_match_is_a_hundred_and_the_mean_is_zero() {
        assert_eq!(fit(0.0, 2.0), Some(100.0));
        assert_eq!(fit(2.0, 2.0), Some(0.0));
        assert!(fit(8.0, 2.0).unwrap() < 0.0);
        assert_eq!(fit(1.0, 0.0), None);
    }

    #[test]
    fn the_spread_is_the_weighted_sum_about_the_weighted_mean() {
        let values: [f64; 5] = [1e6 + 1.0, 1e6 - 2.0, 1e6 + 0.5, 1e6, 1e6 + 3.0];
        for lambda in [1.0_f64, 0.9] {
            let mut spread = FitRange::default();
            for value in values {
                spread.update(value, lambda);
            }
            let weights: Vec<f64> = (0..5).map(|i| lambda.powi(4 - i)).collect();
            let total: f64 = weights.iter().sum();
            let mean = values.iter().zip(&weights).map(|(y, w)| y * w).sum::<f64>() / total;
            let sum: f64 = values
                .iter()
                .zip(&weights)
                .map(|(y, w)| w * (y - mean) * (y - mean))
                .sum();
            assert!((spread.sum_of_squares() - sum).abs() < 1e-7);
        }
    }
}
