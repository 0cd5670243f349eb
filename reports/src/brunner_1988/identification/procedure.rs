//! The thesis's identification procedure, step by step, as printed (Brunner 1988, p. 94 f.).
//!
//! > 1) Load the data file for the particular run of interest. 2) Detrend data as necessary. 3) Enter the
//! > order of the transfer function numerator and denominator. 4) Perform recursive-least-squares (RLS) fit
//! > of the data. 5) With the computer generated transfer function, simulate the model's response to the
//! > input data. 6) Compare actual response to simulated response.
//!
//! The thesis detrends the gyro, whose mean should be zero (p. 95), the plane command of run 7/3, and the offset of run 9/1's plane command (p. 99
//! f.). Run 7/5 was "adjusted to begin at zero" instead (p. 100). Depth is never detrended. The records are lost; here the procedure uses synthetic
//! records ([`super::synthetic`]).

use planesman_identification::{
    IdentificationError, Input, Model, RecursiveLeastSquares, Shape, filter, rows, simulated,
    with_noise,
};

use super::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME};

/// Initial covariance of the recursive least squares: large, as usual.
const INITIAL_COVARIANCE: f64 = 1e6;

/// Step 2: the trend to subtract from a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// No trend.
    Nothing,
    /// The mean.
    Mean,
    /// The first value.
    Beginning,
}

impl Detrend {
    /// The thesis's detrending of a run's gyro.
    #[must_use]
    pub fn of_gyro(run: Run) -> Self {
        match run {
            Run::SevenFive => Self::Beginning,
            _ => Self::Mean,
        }
    }

    /// The thesis's detrending of a run's plane command.
    #[must_use]
    pub fn of_planes(run: Run) -> Self {
        match run {
            Run::SevenThree => Self::Mean,
            Run::SevenFive | Run::NineOne => Self::Beginning,
            Run::EightOne | Run::NineTwo => Self::Nothing,
        }
    }

    /// Subtracts the trend from a signal.
    #[must_use]
    pub fn apply(self, mut values: Vec<f64>) -> Prepared {
        let level = match self {
            Self::Nothing => 0.0,
            Self::Mean => values.iter().sum::<f64>() / values.len().max(1) as f64,
            Self::Beginning => values.first().copied().unwrap_or(0.0),
        };
        for value in &mut values {
            *value -= level;
        }
        Prepared {
            detrend: self,
            subtracted: level,
            values,
        }
    }
}

/// A signal after step 2.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Kind of the subtracted trend.
    pub detrend: Detrend,
    /// Subtracted value, V.
    pub subtracted: f64,
    /// Signal after subtraction, V.
    pub values: Vec<f64>,
}

/// Step 3: orders of numerator and denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orders {
    /// Degree of the numerator, which is lower than that of the denominator.
    pub numerator: usize,
    /// Degree of the denominator: the model order.
    pub denominator: usize,
}

impl Orders {
    /// The largest numerator for a denominator, as in Table 9, except for depth over planes.
    #[must_use]
    pub fn of(denominator: usize) -> Self {
        Self {
            numerator: denominator.saturating_sub(1),
            denominator,
        }
    }

    /// Step 4: fits the data.
    fn fit(self, inputs: &[Input], outputs: &[f64]) -> Result<Model, IdentificationError> {
        let order = self.denominator;
        let shape = Shape {
            order,
            moment: false,
            bias: false,
        };
        // b1 .. of a model whose numerator is shorter are zero: their columns are left out.
        let absent = order..(2 * order).saturating_sub(self.numerator + 1);
        let unknowns = shape.parameters() - absent.len();
        let mut rls = RecursiveLeastSquares::new(unknowns, 1.0, INITIAL_COVARIANCE)?;
        for (mut row, output) in rows(shape, inputs, outputs) {
            row.drain(absent.clone());
            rls.update(&row, output);
        }
        let mut theta = rls.parameters().as_slice().to_vec();
        theta.splice(order..order, absent.map(|_| 0.0));
        Ok(Model::from_parameters(shape, &theta, SAMPLE_TIME))
    }
}

/// Result of steps 5 and 6 for a model.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The model.
    pub model: Model,
    /// Response to the input from rest, V.
    pub simulated: Vec<f64>,
    /// Fit, `100 (1 - |y - yhat| / |y - mean y|)` %; `None` if it overflows.
    pub fit: Option<f64>,
    /// Root mean square of the error, V.
    pub rms: f64,
}

/// Two detrended signals of a run, and the models fitted to them.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The input.
    pub input: Prepared,
    /// The output.
    pub output: Prepared,
    /// Fitted models, in the requested order.
    pub models: Vec<(Orders, Comparison)>,
}

impl Identification {
    /// Performs steps 3 to 6.
    ///
    /// # Errors
    /// Like [`RecursiveLeastSquares::new`]: a model of order zero has no parameters.
    pub fn of(
        input: Prepared,
        output: Prepared,
        orders: &[Orders],
    ) -> Result<Self, IdentificationError> {
        let mut identification = Self {
            input,
            output,
            models: Vec::new(),
        };
        let inputs = identification.inputs();
        for order in orders {
            let model = order.fit(&inputs, &identification.output.values)?;
            let comparison = identification.compare(model);
            identification.models.push((*order, comparison));
        }
        Ok(identification)
    }

    /// Performs steps 1 to 6 for plane command to pitch rate, second and third order.
    ///
    /// # Errors
    /// Same as [`Identification::of`].
    pub fn pitch_rate(run: Run) -> Result<Self, IdentificationError> {
        Self::of(
            Detrend::of_planes(run).apply(run.planes()),
            Detrend::of_gyro(run).apply(pitch_rate(run)),
            &[Orders::of(2), Orders::of(3)],
        )
    }

    /// Performs steps 1 to 6 for pitch rate to depth.
    ///
    /// # Errors
    /// Same as [`Identification::of`].
    pub fn depth(run: Run, orders: &[Orders]) -> Result<Self, IdentificationError> {
        Self::of(
            Detrend::of_gyro(run).apply(pitch_rate(run)),
            Detrend::Nothing.apply(depth(run)),
            orders,
        )
    }

    /// Performs steps 1 to 6 for plane command to depth, with the orders of Table 9: first over fourth.
    ///
    /// # Errors
    /// Same as [`Identification::of`].
    pub fn depth_of_planes(run: Run) -> Result<Self, IdentificationError> {
        Self::of(
            Detrend::of_planes(run).apply(run.planes()),
            Detrend::Nothing.apply(depth(run)),
            &[Orders {
                numerator: 1,
                denominator: 4,
            }],
        )
    }

    /// Performs steps 5 and 6 for any model, for example a predicted one.
    #[must_use]
    pub fn compare(&self, model: Model) -> Comparison {
        let (inputs, outputs) = (self.inputs(), &self.output.values);
        let response = model.simulate(&inputs, outputs.len());
        let squares = outputs.iter().zip(&response).map(|(y, m)| (y - m).powi(2));
        Comparison {
            rms: (squares.sum::<f64>() / outputs.len().max(1) as f64).sqrt(),
            fit: simulated(&model, &inputs, outputs),
            simulated: response,
            model,
        }
    }

    fn inputs(&self) -> Vec<Input> {
        self.input.values.iter().map(|u| Input::held(*u)).collect()
    }
}

/// Step 1, replacing the lost file: the run's gyro signal, V.
#[must_use]
pub fn pitch_rate(run: Run) -> Vec<f64> {
    run.measured(GYRO_SEED, NOISE, BIAS)
}

/// The run's depth signal, V above its initial value: the pitch rate integrated twice at the run's speed (Table 8, second order), with noise of the
/// same level as the gyro's.
#[must_use]
pub fn depth(run: Run) -> Vec<f64> {
    let gain = 0.005_382_5 * run.speed();
    let integrated = filter(&[0.0, gain, gain], &[1.0, -2.0, 1.0], &run.clean());
    with_noise(&integrated, DEPTH_SEED, NOISE)
}

/// Seeds of the noise.
const GYRO_SEED: u32 = 12345;
const DEPTH_SEED: u32 = 54321;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_and_third_order_fit_alike_and_their_further_poles_are_a_smoothers() {
        // Brunner 1988, p. 95: "very little difference between second order and third order".
        for run in [Run::EightOne, Run::NineTwo, Run::SevenFive] {
            let found = Identification::pitch_rate(run).unwrap().models;
            let fits: Vec<f64> = found.iter().map(|(_, it)| it.fit.unwrap()).collect();
            assert!((fits[0] - fits[1]).abs() < 10.0, "{}: {fits:?}", run.name());
            let poles = found[0].1.model.poles().unwrap();
            assert!(poles[1].re < 0.0, "{}: {poles:?}", run.name());
        }
    }

    #[test]
    fn what_is_detrended_begins_or_averages_at_zero() {
        let values = vec![3.0, 4.0, 8.0];
        let from_zero = Detrend::Beginning.apply(values.clone());
        assert_eq!((from_zero.subtracted, from_zero.values[0]), (3.0, 0.0));
        let about_zero = Detrend::Mean.apply(values.clone());
        assert_eq!(about_zero.subtracted, 5.0);
        assert_eq!(about_zero.values.iter().sum::<f64>(), 0.0);
        assert_eq!(Detrend::Nothing.apply(values.clone()).values, values);
    }

    #[test]
    fn second_order_cannot_predict_depth() {
        // p. 100: "it lacks the two required integrations".
        let of_second_order = [Orders::of(2)];
        let found = Identification::depth(Run::EightOne, &of_second_order).unwrap();
        let poles = found.models[0].1.model.poles().unwrap();
        assert!(
            (poles[0].re - 1.0).abs() > 1e-3 || (poles[1].re - 1.0).abs() > 1e-3,
            "{poles:?}"
        );
    }

    #[test]
    fn a_short_numerator_is_fitted_as_that_and_found_again() {
        // y_k = 1.2 y_(k-1) - 0.5 y_(k-2) + 0.3 u_(k-2)
        let model = Model {
            sample_time: SAMPLE_TIME,
            a: vec![-1.2, 0.5],
            feedthrough: 0.0,
            b: vec![0.0, 0.3],
            c: Vec::new(),
            bias: 0.0,
        };
        let input = Run::EightOne.planes();
        let held: Vec<Input> = input.iter().map(|u| Input::held(*u)).collect();
        let output = model.simulate(&held, input.len());
        let orders = Orders {
            numerator: 0,
            denominator: 2,
        };
        let found = Identification::of(
            Detrend::Nothing.apply(input),
            Detrend::Nothing.apply(output),
            &[orders],
        )
        .unwrap();
        let found = &found.models[0].1;
        assert_eq!(found.model.b[0], 0.0);
        for (it, is) in [
            (found.model.a[0], -1.2),
            (found.model.a[1], 0.5),
            (found.model.b[1], 0.3),
        ] {
            assert!((it - is).abs() < 1e-3, "{it} is not {is}");
        }
        assert!(found.fit.unwrap() > 99.9 && found.rms < 1e-4);
    }
}
