//! An estimate: the parameters, their covariance, and the model.

use nalgebra::{DMatrix, DVector};
use planesman_linear::polynomial::product;

use super::frequency_fit::FrequencyFit;
use super::physical::Physical;
use super::process_model::ProcessModel;
use super::rows::impulse;
use crate::fit::{FitRange, fit};
use crate::free_motion::{STATE_SAMPLES, STATE_SHARE, carried_on, without_free_motion};
use crate::model::Model;
use crate::static_curve::FittedCurve;
use crate::structure::{InitialState, Layout, Problem, Structure};
use planesman_record::{Run, filter};

/// If `A(1)` is below this share of its terms' size, there is a pole at z = 1.
const AT_ONE: f64 = 1e-9;

/// The result of an estimator.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The input level to which the offset in theta and the simulation refer; 0 if no level was subtracted.
    pub input_level: f64,
    /// The kind of residual, which determines the place of a constant.
    pub error: Error,
    /// The place of each unknown in theta.
    pub layout: Layout,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The unknowns of the layout, without the initial motion if the method does not need it.
    pub theta: DVector<f64>,
    /// Covariance of theta, as computed by the method.
    pub covariance: DMatrix<f64>,
    /// A factor F of the covariance, `F F'`, if the method computes one: differences that nearly cancel in a product with the covariance are more
    /// accurate with the factor.
    pub factor: Option<DMatrix<f64>>,
    /// The variance of the noise `e`, output unit squared.
    pub noise_variance: f64,
    /// `c1 ... cn` of the noise model `C`; empty for a method without a noise model.
    pub noise_model: Vec<f64>,
    /// `d1 ... dk` of the noise `e/D` on the output; empty for a method without it.
    pub noise_denominator: Vec<f64>,
    /// The residuals of each record, output unit.
    pub residuals: Vec<Vec<f64>>,
    /// The curve after the dynamics, if one was fitted.
    pub output_curve: Option<FittedCurve>,
    /// The vehicle's own coefficients, if they were estimated.
    pub physical: Option<Physical>,
    /// The process model, if one was estimated.
    pub process: Option<ProcessModel>,
    /// The frequency response and its transfer function, if they were estimated.
    pub frequency: Option<FrequencyFit>,
}

impl Estimate {
    /// The estimate of a problem, with a factor of its covariance, for white noise.
    pub(super) fn of(
        problem: &Problem<'_>,
        error: Error,
        theta: DVector<f64>,
        factor: DMatrix<f64>,
        noise_variance: f64,
        residuals: Vec<Vec<f64>>,
    ) -> Self {
        Self {
            input_level: 0.0,
            error,
            layout: problem.layout(),
            sample_time: problem.sample_time,
            theta,
            covariance: &factor * factor.transpose(),
            factor: Some(factor),
            noise_variance,
            noise_model: Vec::new(),
            noise_denominator: Vec::new(),
            residuals,
            output_curve: None,
            physical: None,
            process: None,
            frequency: None,
        }
    }

    /// The model of a record.
    #[must_use]
    pub fn model(&self, run: usize) -> Model {
        self.layout
            .model(self.theta.as_slice(), run, self.sample_time)
    }

    /// The model of a record for the mean of the input over each interval, as needed for conversion to continuous time. This model equals
    /// [`Self::model`] unless the input is linear between its samples.
    #[must_use]
    pub fn model_of_means(&self, run: usize) -> Model {
        let layout = Layout {
            structure: self.layout.structure.of_means(),
            runs: self.layout.runs,
        };
        layout.model(self.theta.as_slice(), run, self.sample_time)
    }

    /// The covariance of `a1 ... an` and the numerator's coefficients ([`Model::numerator`]) of a record's model; zero for known values.
    #[must_use]
    pub fn coefficient_covariance(&self, run: usize) -> DMatrix<f64> {
        let coefficients = |theta: &DVector<f64>| {
            let model = self.layout.model(theta.as_slice(), run, self.sample_time);
            let numerator = model.numerator(self.layout.structure.delay == 0);
            DVector::from_vec([model.a, numerator].concat())
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

    /// The offset of a record's output, output unit; 0 if no offset was estimated.
    #[must_use]
    pub fn offset(&self, run: usize) -> f64 {
        let Some(at) = self.layout.offset(run) else {
            return 0.0;
        };
        let by_level = match self.input_level {
            0.0 => 0.0,
            level => level * self.model(run).steady_state_gain().unwrap_or(0.0),
        };
        self.offset_at_level(at) - by_level
    }

    /// The input at which the output of an integrating model is constant; 0 for others, whose offset includes it.
    #[must_use]
    pub fn level_of_integrator(&self, run: usize) -> f64 {
        match self.input_level {
            0.0 => 0.0,
            level => (self.model(run).steady_state_gain()).map_or(level, |_| 0.0),
        }
    }

    /// `A(1)`; `None` with a pole at z = 1.
    fn steady(&self) -> Option<f64> {
        let a = self.layout.denominator(self.theta.as_slice());
        let size: f64 = a.iter().map(|a| a.abs()).sum();
        Some(a.iter().sum()).filter(|steady: &f64| steady.abs() > AT_ONE * size)
    }

    /// The output's offset when the input is at its level.
    fn offset_at_level(&self, at: usize) -> f64 {
        if self.error == Error::Equation {
            // offset = constant / A(1); with a pole at 1 there is none.
            self.steady().map_or(0.0, |steady| self.theta[at] / steady)
        } else {
            self.theta[at]
        }
    }

    /// The input minus the level to which the offset refers.
    pub(crate) fn about_level(&self, inputs: &[f64]) -> Vec<f64> {
        inputs.iter().map(|u| u - self.input_level).collect()
    }

    /// A record's input minus its level, after known factors and delay, see [`Structure::driving`]; for a process model it is constant before the
    /// record.
    pub(crate) fn driving(&self, record: Run<'_>) -> Vec<f64> {
        let structure = &self.layout.structure;
        let [past, inputs] = [record.past, record.inputs].map(|it| self.about_level(it));
        match self.process {
            Some(_) => structure.driving_from_standing(&past, &inputs),
            None => structure.driving(&past, &inputs),
        }
    }

    /// Number of initial outputs of a record to ignore, see [`Structure::unknown`]; 0 for a process model.
    #[must_use]
    pub fn unknown(&self, record: Run<'_>) -> usize {
        match self.process {
            Some(_) => 0,
            None => self.layout.structure.unknown(record.past.len()),
        }
    }

    /// The output of record `run` simulated from its input alone, with offset and initial motion.
    #[must_use]
    pub fn simulate(&self, run: usize, record: Run<'_>) -> Vec<f64> {
        let structure = &self.layout.structure;
        let a = self.layout.denominator(self.theta.as_slice());
        let b = &self.theta.as_slice()[self.layout.b(run)];
        let (driving, begins) = match self.physical {
            // The vehicle's motion is its state, which no input before the record has led to.
            Some(_) => {
                let rest = Structure {
                    start: InitialState::Rest,
                    ..structure.clone()
                };
                (rest.driving(&[], &self.about_level(record.inputs)), 0)
            }
            None => (self.driving(record), self.unknown(record)),
        };
        let mut output = filter(b, &a, &driving);
        let offset = self
            .layout
            .offset(run)
            .map_or(0.0, |at| self.offset_at_level(at));
        let motion: Vec<f64> = self
            .layout
            .motion(run)
            .filter_map(|at| self.theta.get(at).copied())
            .collect();
        let transient = filter(&motion, &a, &impulse(begins, record.inputs.len()));
        for (y, t) in output.iter_mut().zip(transient) {
            *y += offset + t;
        }
        match &self.output_curve {
            Some(fitted) => fitted.curve.of(&output),
            None => output,
        }
    }

    /// Measured minus simulated outputs of record `run`.
    #[must_use]
    pub fn simulation_errors(&self, run: usize, record: Run<'_>) -> Vec<f64> {
        let simulated = self.simulate(run, record);
        let pairs = record.outputs.iter().zip(&simulated);
        pairs.map(|(y, x)| y - x).collect()
    }

    /// The fit of the simulated output, `100 (1 - |y - yhat| / |y - mean y|)` %, over the samples `from..` of record `run`, with the state fitted at
    /// their beginning; `None` if the output is constant or the simulation overflows.
    #[must_use]
    pub fn simulated_fit(&self, run: usize, record: Run<'_>, from: usize) -> Option<f64> {
        if self.output_curve.is_some() {
            return self.fit_behind_curve(run, record, from);
        }
        let (left, spread) = self.left_from_rest(run, record, from);
        let free = match self.layout.structure.start {
            InitialState::Rest if from.max(self.unknown(record)) == 0 => vec![1.0],
            _ => self.free_motion(),
        };
        fit(without_free_motion(&left, &free), spread)
    }

    /// The simulated fit with the state fitted only to the samples just before: at least a twentieth of the record for a high order. This is the fit
    /// of a simulation without output data. `None` if there are fewer.
    #[must_use]
    pub fn fit_from_carried_state(&self, run: usize, record: Run<'_>, from: usize) -> Option<f64> {
        if self.output_curve.is_some() {
            return self.fit_behind_curve(run, record, from);
        }
        let free = self.free_motion();
        let before = (record.outputs.len() / STATE_SHARE).max(STATE_SAMPLES * (free.len() - 1));
        let begin = from.checked_sub(before)?;
        if begin < self.unknown(record) {
            return None;
        }
        let (left, _) = self.left_from_rest(run, record, begin);
        let mut spread = FitRange::default();
        record.outputs[from..]
            .iter()
            .for_each(|y| spread.update(*y, 1.0));
        fit(carried_on(&left, before, &free)?, spread.sum_of_squares())
    }

    /// The fit with a curve after the dynamics. The curve hides the state, so the simulation starts at the beginning of the record.
    fn fit_behind_curve(&self, run: usize, record: Run<'_>, from: usize) -> Option<f64> {
        let errors = self.simulation_errors(run, record);
        let from = from.max(self.unknown(record));
        let mut spread = FitRange::default();
        let outputs = record.outputs.iter().skip(from);
        outputs.for_each(|y| spread.update(*y, 1.0));
        let squares = errors.iter().skip(from).map(|e| e * e).sum();
        fit(squares, spread.sum_of_squares())
    }

    /// The denominator of the free motion.
    fn free_motion(&self) -> Vec<f64> {
        let a = self.layout.denominator(self.theta.as_slice());
        product(&a, &self.layout.structure.known_denominator)
    }

    /// The outputs of record `run` minus a simulation from rest at sample `from`, and the outputs' sum of squares about their mean.
    fn left_from_rest(&self, run: usize, record: Run<'_>, from: usize) -> (Vec<f64>, f64) {
        let a = self.layout.denominator(self.theta.as_slice());
        let b = &self.theta.as_slice()[self.layout.b(run)];
        let from = from.max(self.unknown(record));
        let mut driving = self.driving(record);
        let (mut b, first) = (b, from.min(driving.len()));
        if b.len() > a.len() {
            // The numerator looks back farther than a state of the poles: through it first, where inputs are known.
            driving = filter(b, &[1.0], &driving);
            b = &[1.0];
        }
        let driving = driving.split_off(first);
        let outputs = record.outputs.get(from..).unwrap_or_default();
        let constant = match (self.layout.offset(run), self.error, self.steady()) {
            (None, ..) => vec![0.0; outputs.len()],
            // With a pole at 1 the constant of the equation makes a ramp.
            (Some(at), Error::Equation, None) => {
                filter(&[1.0], &a, &vec![self.theta[at]; outputs.len()])
            }
            (Some(at), ..) => vec![self.offset_at_level(at); outputs.len()],
        };
        let mut spread = FitRange::default();
        let pairs = outputs.iter().zip(filter(b, &a, &driving)).zip(constant);
        let left: Vec<f64> = pairs
            .map(|((y, x), constant)| {
                spread.update(*y, 1.0);
                y - x - constant
            })
            .collect();
        (left, spread.sum_of_squares())
    }
}

/// The error that an estimator minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// `A y - B u - constant`, white or with a noise model: the constant is in the equation.
    Equation,
    /// `y - (B/A) u - offset`: the constant is added to the output.
    Output,
}
