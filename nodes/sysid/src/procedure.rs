//! The thesis' procedure, step by step, as printed (Brunner 1988, p. 94 f.).
//!
//! > 1) Load the data file for the particular run of interest. 2) Detrend data as necessary. 3) Enter the
//! > order of the transfer function numerator and denominator. 4) Perform recursive-least-squares (RLS) fit
//! > of the data. 5) With the computer generated transfer function, simulate the model's response to the
//! > input data. 6) Compare actual response to simulated response.
//!
//! Detrended was the gyro alone, whose mean should be zero (p. 95); run 7/5 was "adjusted to begin at zero"
//! instead (p. 100). The records are lost: it is run here on [`crate::synthetic`] ones.

use crate::fit::simulated;
use crate::model::Model;
use crate::regression::{Input, Shape, rows};
use crate::rls::RecursiveLeastSquares;
use crate::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME, with_noise};

/// Covariance before the first row: large, as such programs begin with.
const INITIAL_COVARIANCE: f64 = 1e6;

/// Step 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// Nothing is taken away.
    Nothing,
    /// The mean is.
    Mean,
    /// The first value is.
    Beginning,
}

impl Detrend {
    /// What the thesis did to a run's gyro.
    #[must_use]
    pub fn of(run: Run) -> Self {
        match run {
            Run::SevenFive => Self::Beginning,
            _ => Self::Mean,
        }
    }

    fn apply(self, values: &[f64]) -> Vec<f64> {
        let trend = match self {
            Self::Nothing => 0.0,
            Self::Mean => values.iter().sum::<f64>() / values.len().max(1) as f64,
            Self::Beginning => values.first().copied().unwrap_or(0.0),
        };
        values.iter().map(|value| value - trend).collect()
    }
}

/// Steps 3 to 6 for one order.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The model that was fitted.
    pub model: Model,
    /// Its response to the input from rest.
    pub simulated: Vec<f64>,
    /// How near it comes, `100 (1 - |y - yhat| / |y - mean y|)` %; `None` when it overflows.
    pub fit: Option<f64>,
}

/// Steps 2 to 6: the detrended output, and a comparison for each order.
///
/// # Errors
/// As [`RecursiveLeastSquares::new`].
pub fn identify(
    inputs: &[f64],
    outputs: &[f64],
    detrend: Detrend,
    orders: &[usize],
) -> Result<(Vec<f64>, Vec<Comparison>), String> {
    let outputs = detrend.apply(outputs);
    let inputs: Vec<Input> = inputs.iter().map(|u| Input::held(*u)).collect();
    let comparisons = orders
        .iter()
        .map(|order| {
            let shape = Shape {
                order: *order,
                moment: false,
                bias: false,
            };
            let mut rls = RecursiveLeastSquares::new(shape.parameters(), 1.0, INITIAL_COVARIANCE)?;
            for (row, output) in rows(shape, &inputs, &outputs) {
                rls.update(&row, output);
            }
            let model = Model::from_parameters(shape, rls.parameters().as_slice(), SAMPLE_TIME);
            Ok(Comparison {
                simulated: model.simulate(&inputs, outputs.len()),
                fit: simulated(&model, &inputs, &outputs),
                model,
            })
        })
        .collect::<Result<_, String>>()?;
    Ok((outputs, comparisons))
}

/// Step 1, in place of the lost file: the run's gyro, V.
#[must_use]
pub fn pitch_rate(run: Run) -> Vec<f64> {
    run.measured(GYRO_SEED, NOISE, BIAS)
}

/// The run's depth cell, V: the pitch rate integrated twice at the run's speed (Table 8, second order),
/// 1.627 V at the surface (p. 73), with the gyro's level of noise.
#[must_use]
pub fn depth(run: Run) -> Vec<f64> {
    let gain = 0.005_382_5 * run.speed();
    let integrated = crate::structure::filter(&[0.0, gain, gain], &[1.0, -2.0, 1.0], &run.clean());
    with_noise(&integrated, DEPTH_SEED, NOISE)
}

/// The noises drawn.
const GYRO_SEED: u32 = 12345;
const DEPTH_SEED: u32 = 54321;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn second_and_third_order_fit_alike_and_their_further_poles_are_a_smoothers() {
        // Brunner 1988, p. 95: "very little difference between second order and third order".
        for run in [Run::EightOne, Run::NineTwo, Run::SevenFive] {
            let (_, found) =
                identify(&run.planes(), &pitch_rate(run), Detrend::of(run), &[2, 3]).unwrap();
            let fits: Vec<f64> = found.iter().map(|it| it.fit.unwrap()).collect();
            assert!((fits[0] - fits[1]).abs() < 10.0, "{}: {fits:?}", run.name());
            let poles = found[0].model.poles().unwrap();
            assert!(poles[1].re < 0.0, "{}: {poles:?}", run.name());
        }
    }

    #[test]
    fn what_is_detrended_begins_or_averages_at_zero() {
        let values = [3.0, 4.0, 8.0];
        assert_eq!(Detrend::Beginning.apply(&values)[0], 0.0);
        assert_eq!(Detrend::Mean.apply(&values).iter().sum::<f64>(), 0.0);
        assert_eq!(Detrend::Nothing.apply(&values), values);
    }

    #[test]
    fn second_order_cannot_predict_depth() {
        // p. 100: "it lacks the two required integrations".
        let run = Run::EightOne;
        let (_, found) = identify(&run.clean(), &depth(run), Detrend::Nothing, &[2]).unwrap();
        let poles = found[0].model.poles().unwrap();
        assert!(
            (poles[0].re - 1.0).abs() > 1e-3 || (poles[1].re - 1.0).abs() > 1e-3,
            "{poles:?}"
        );
    }
}
