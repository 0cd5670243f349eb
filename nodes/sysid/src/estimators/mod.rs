//! Every way to find a transfer function's unknowns, behind one call.
//!
//! | method | minimises, or solves | consistent when the noise is |
//! |---|---|---|
//! | [`least_squares`] | the equation error `A y - B u`, by QR | white in the equation (rarely so) |
//! | [`armax`] | the one-step error of `A y = B u + C e` | a moving average through the plant's poles |
//! | [`output_error`] | the simulated error `y - (B/A) u` | anything the input does not cause |
//! | [`instruments`] | `A y = B u` with simulated outputs as instruments | anything the input does not cause |
//!
//! Beside them: [`recursive`], the first three a sample at a time; [`vehicle`] and [`kalman`], which
//! seek the vehicle's own coefficients, as a whole and a sample at a time.
//!
//! Source: Ljung, *System Identification*, 2nd ed., 1999, ch. 7, 10, 11;
//! what the thesis used is the first (Brunner, NPS thesis, 1988, ch. V).

pub mod armax;
pub mod instruments;
pub mod kalman;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod output_error;
pub mod recursive;
pub mod vehicle;

use std::fmt;
use std::str::FromStr;

use nalgebra::{DMatrix, DVector};

use crate::model::Model;
use crate::structure::{Layout, Problem, Run, filter};

/// What an estimator found.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// How it was found.
    pub method: Method,
    /// Where each unknown stands in theta.
    pub layout: Layout,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The unknowns of the layout, without the motion at the beginning where the method needs none.
    pub theta: DVector<f64>,
    /// Their covariance, by the method's own reckoning.
    pub covariance: DMatrix<f64>,
    /// The variance of the noise `e`, output unit squared.
    pub noise_variance: f64,
    /// `c1 ... cn` of the noise model `C`; empty for a method without one.
    pub noise_model: Vec<f64>,
    /// What the method took for noise in each record, output unit.
    pub residuals: Vec<Vec<f64>>,
}

impl Estimate {
    /// The model of a record.
    #[must_use]
    pub fn model(&self, run: usize) -> Model {
        self.layout
            .model(self.theta.as_slice(), run, self.sample_time)
    }

    /// The covariance of `a1 ... an, b1 ... bn` of a record's model; what is known beforehand has none.
    #[must_use]
    pub fn coefficient_covariance(&self, run: usize) -> DMatrix<f64> {
        let coefficients = |theta: &DVector<f64>| {
            let model = self.layout.model(theta.as_slice(), run, self.sample_time);
            DVector::from_vec([model.a, model.b].concat())
        };
        // The coefficients are linear in theta, and a constant: their slopes are whole differences.
        let none = DVector::zeros(self.theta.len());
        let constant = coefficients(&none);
        let mut slopes = DMatrix::zeros(constant.len(), self.theta.len());
        for i in 0..self.theta.len() {
            let mut one = none.clone();
            one[i] = 1.0;
            slopes.set_column(i, &(coefficients(&one) - &constant));
        }
        &slopes * &self.covariance * slopes.transpose()
    }

    /// The offset of a record's output, output unit; 0 when none was sought.
    #[must_use]
    pub fn offset(&self, run: usize) -> f64 {
        let Some(at) = self.layout.offset(run) else {
            return 0.0;
        };
        if self.method.offset_is_in_the_equation() {
            // offset = constant / A(1); with a pole at 1 there is none.
            let steady = 1.0 + self.theta.rows(0, self.layout.structure.poles).sum();
            let offset = self.theta[at] / steady;
            if offset.is_finite() { offset } else { 0.0 }
        } else {
            self.theta[at]
        }
    }

    /// The output of record `run` from its input alone, with offset and the motion it began with.
    #[must_use]
    pub fn simulate(&self, run: usize, inputs: &[f64]) -> Vec<f64> {
        let model = self.model(run);
        let mut den = vec![1.0];
        den.extend(&model.a);
        let mut num = vec![0.0];
        num.extend(&model.b);
        let mut output = filter(&num, &den, inputs);
        let offset = self.offset(run);
        let mut a = vec![1.0];
        a.extend(self.theta.rows(0, self.layout.structure.poles).iter());
        let motion: Vec<f64> = self
            .layout
            .motion(run)
            .filter_map(|at| self.theta.get(at).copied())
            .collect();
        let transient = filter(&motion, &a, &output_error::impulse(inputs.len()));
        for (y, t) in output.iter_mut().zip(transient) {
            *y += offset + t;
        }
        output
    }

    /// The fit of the simulated output, `100 (1 - |y - yhat| / |y - mean y|)` %, over samples
    /// `from..` of record `run`; `None` when the output did not move or the simulation overflows.
    #[must_use]
    pub fn simulated_fit(&self, run: usize, record: Run<'_>, from: usize) -> Option<f64> {
        let simulated = self.simulate(run, record.inputs);
        let pairs = record.outputs.iter().zip(&simulated).skip(from);
        let mut spread = crate::fit::Spread::default();
        let mut squared_errors = 0.0;
        for (y, y_hat) in pairs {
            spread.update(*y, 1.0);
            squared_errors += (y - y_hat) * (y - y_hat);
        }
        crate::fit::fit(squared_errors, spread.sum_of_squares())
    }
}

/// The ways there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Least squares on the equation error, as the thesis.
    LeastSquares,
    /// ARMAX: the equation error with a model of the noise.
    Armax,
    /// Output error.
    OutputError,
    /// Refined instrumental variables (SRIV).
    Instruments,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::LeastSquares,
        Self::Armax,
        Self::OutputError,
        Self::Instruments,
    ];

    /// The name it is asked for by.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LeastSquares => "least_squares",
            Self::Armax => "armax",
            Self::OutputError => "output_error",
            Self::Instruments => "instruments",
        }
    }

    /// Whether the constant stands in the difference equation, `A y = B u + constant`, and not on
    /// the output.
    fn offset_is_in_the_equation(self) -> bool {
        matches!(self, Self::LeastSquares | Self::Armax)
    }

    /// Finds the unknowns from whole records.
    ///
    /// # Errors
    /// A sentence: records that do not determine the unknowns, a search that finds no minimum, a
    /// structure the method is not for.
    pub fn fit(self, problem: &Problem<'_>) -> Result<Estimate, String> {
        match self {
            Self::LeastSquares => least_squares::fit(problem),
            Self::Armax => armax::fit(problem),
            Self::OutputError => output_error::fit(problem),
            Self::Instruments => instruments::fit(problem),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|method| method.name() == text)
            .ok_or_else(|| {
                let names: Vec<&str> = Self::ALL.iter().map(|method| method.name()).collect();
                format!("no estimator '{text}'; there are {}", names.join(", "))
            })
    }
}
