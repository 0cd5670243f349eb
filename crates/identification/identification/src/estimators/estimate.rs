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

/// `A(1)` below this share of its terms' size is that of a pole at z = 1.
const AT_ONE: f64 = 1e-9;

/// The result of an estimator.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The level of the input that the offset in theta and the simulation are about; 0 where none was taken off.
    pub input_level: f64,
    /// The kind of residual, which says where a constant stands.
    pub error: Error,
    /// Where each unknown stands in theta.
    pub layout: Layout,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The unknowns of the layout, without the motion at the beginning where the method needs none.
    pub theta: DVector<f64>,
    /// Their covariance, as the method computes it.
    pub covariance: DMatrix<f64>,
    /// A factor F of it, `F F'`, where the method has one: what nearly cancels in a product of the covariance is
    /// not lost to rounding in one of the factor.
    pub factor: Option<DMatrix<f64>>,
    /// The variance of the noise `e`, output unit squared.
    pub noise_variance: f64,
    /// `c1 ... cn` of the noise model `C`; empty for a method without one.
    pub noise_model: Vec<f64>,
    /// `d1 ... dk` of the noise `e/D` on the output; empty for a method without it.
    pub noise_denominator: Vec<f64>,
    /// The residuals of each record, output unit.
    pub residuals: Vec<Vec<f64>>,
    /// The curve behind the dynamics, where one was fitted.
    pub output_curve: Option<FittedCurve>,
    /// The vehicle's own coefficients, where those were sought.
    pub physical: Option<Physical>,
    /// The process model, where one was sought.
    pub process: Option<ProcessModel>,
    /// The frequency response and the transfer function of it, where those were sought.
    pub frequency: Option<FrequencyFit>,
}

impl Estimate {
    /// The estimate of a problem, with a factor of its covariance, where the noise is white.
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

    /// The model of a record from the mean of the input over each interval, which a continuous model is of: that of
    /// [`Self::model`] but for an input that moves on straight lines between its samples.
    #[must_use]
    pub fn model_of_means(&self, run: usize) -> Model {
        let layout = Layout {
            structure: self.layout.structure.of_means(),
            runs: self.layout.runs,
        };
        layout.model(self.theta.as_slice(), run, self.sample_time)
    }

    /// The covariance of `a1 ... an` and the numerator's coefficients ([`Model::numerator`]) of a record's model; what
    /// is known beforehand has none.
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

    /// The offset of a record's output, output unit; 0 when none was sought.
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

    /// The level of the input at which the output of a model that integrates stands; 0 of others, whose offset holds it.
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

    /// The output's offset where the input is at its level.
    fn offset_at_level(&self, at: usize) -> f64 {
        if self.error == Error::Equation {
            // offset = constant / A(1); with a pole at 1 there is none.
            self.steady().map_or(0.0, |steady| self.theta[at] / steady)
        } else {
            self.theta[at]
        }
    }

    /// The input about the level that the offset is about.
    pub(crate) fn about_level(&self, inputs: &[f64]) -> Vec<f64> {
        inputs.iter().map(|u| u - self.input_level).collect()
    }

    /// A record's input about the level that the offset is about, as [`Structure::driving`] has it; that of a process model
    /// stood before the record.
    pub(crate) fn driving(&self, record: Run<'_>) -> Vec<f64> {
        let structure = &self.layout.structure;
        let [past, inputs] = [record.past, record.inputs].map(|it| self.about_level(it));
        match self.process {
            Some(_) => structure.driving_from_standing(&past, &inputs),
            None => structure.driving(&past, &inputs),
        }
    }

    /// The first outputs of a record that count for nothing, as [`Structure::unknown`] has it; none of a process model.
    #[must_use]
    pub fn unknown(&self, record: Run<'_>) -> usize {
        match self.process {
            Some(_) => 0,
            None => self.layout.structure.unknown(record.past.len()),
        }
    }

    /// The output of record `run` from its input alone, with offset and the motion it began with.
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

    /// The outputs of record `run` less the simulated ones.
    #[must_use]
    pub fn simulation_errors(&self, run: usize, record: Run<'_>) -> Vec<f64> {
        let simulated = self.simulate(run, record);
        let pairs = record.outputs.iter().zip(&simulated);
        pairs.map(|(y, x)| y - x).collect()
    }

    /// The fit of the simulated output, `100 (1 - |y - yhat| / |y - mean y|)` %, over samples
    /// `from..` of record `run`, the state at the first of them fitted; `None` when the output did not move or the
    /// simulation overflows.
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

    /// The same with the state fitted to the samples right before alone, a twentieth of the record or more of a high order: what a
    /// simulation does that is given no output. `None` where there are fewer.
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

    /// The same behind a curve, which hides the state: simulated from the beginning of the record.
    fn fit_behind_curve(&self, run: usize, record: Run<'_>, from: usize) -> Option<f64> {
        let errors = self.simulation_errors(run, record);
        let from = from.max(self.unknown(record));
        let mut spread = FitRange::default();
        let outputs = record.outputs.iter().skip(from);
        outputs.for_each(|y| spread.update(*y, 1.0));
        let squares = errors.iter().skip(from).map(|e| e * e).sum();
        fit(squares, spread.sum_of_squares())
    }

    /// The denominator of a free motion.
    fn free_motion(&self) -> Vec<f64> {
        let a = self.layout.denominator(self.theta.as_slice());
        product(&a, &self.layout.structure.known_denominator)
    }

    /// What a simulation from rest at sample `from` leaves of the outputs of record `run`, and their sum of squares about their
    /// mean.
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
    /// `A y - B u - constant`, white or through a noise model: the constant stands in the equation.
    Equation,
    /// `y - (B/A) u - offset`: the constant stands on the output.
    Output,
}
