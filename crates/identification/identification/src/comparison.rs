//! Models from any source on one record: fits of simulation and prediction, and residuals.
//!
//! A model is used unchanged. Only the initial state of each segment is fitted; the offset is the model's own.

use nalgebra::{DMatrix, DVector};
use planesman_linear::{polynomial::product, rows};

use crate::error::{IdentificationError, Result};
use crate::estimators::{Error, Estimate};
use crate::free_motion::free_motion;
use crate::prediction::{self, Missed};
use crate::static_curve::{FittedCurve, Side, StaticCurve};
use crate::structure::{InitialState, Layout, Structure, monic};
use crate::validation::residuals::ResidualTests;
use planesman_record::Record;
use planesman_record::Run;

/// Sampling intervals that differ by less than this share count as equal.
const SAME_TIME: f64 = 1e-4;

/// A transfer function with its noise, from any source.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenModel {
    /// The interval between samples, s.
    pub sample_time: f64,
    /// `b1 ... bn`, or `b0 ... bn` with direct feedthrough; output unit per input unit.
    pub num: Vec<f64>,
    /// `1, a1 ... an`.
    pub den: Vec<f64>,
    /// The covariance of `a1 ... an` and of `num`.
    pub covariance: Vec<Vec<f64>>,
    /// The output's offset, output unit.
    pub offset: f64,
    /// The input at which the output of an integrating model is constant, input unit.
    pub input_level: f64,
    /// Whether the noise enters the equation or the output.
    pub error: Error,
    /// The variance of the noise `e`, output unit squared.
    pub noise_variance: f64,
    /// `c1, c2, ...` of the noise `C e` in the equation; empty for white noise.
    pub noise_model: Vec<f64>,
    /// `d1, d2, ...` of the noise `e/D` on the output; empty for white noise.
    pub noise_denominator: Vec<f64>,
    /// A static curve before or after the transfer function.
    pub curve: Option<(Side, StaticCurve)>,
}

/// The performance of a model on a record.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The model, its offset and the initial motion of each segment used; its residuals are the one-step prediction errors.
    pub estimate: Estimate,
    /// Numbers of the segments used.
    pub segments: Vec<usize>,
    /// The longest segment, as an index into `segments`.
    pub longest: usize,
    /// The simulated output of each used segment, output unit.
    pub simulated: Vec<Vec<f64>>,
    /// The fit of the simulations, %; `None` if the output is constant, or a simulation diverges.
    pub fit: Option<f64>,
    /// Prediction horizons, samples, each with its fit, %.
    pub predicted: Vec<(usize, Option<f64>)>,
    /// Residual tests of the longest segment.
    pub residuals: Option<ResidualTests>,
    /// Number of samples in all segments used.
    pub samples: usize,
}

/// Refuses a record whose sampling interval differs from a model's.
pub(crate) fn check_sample_time(sample_time: f64, record: &Record) -> Result<()> {
    if (sample_time / record.sample_time - 1.0).abs() > SAME_TIME {
        return Err(IdentificationError::Model(format!(
            "the model has a sampling interval of {} s, but the data has {} s",
            sample_time, record.sample_time
        )));
    }
    Ok(())
}

impl GivenModel {
    /// The model of record `run` of an estimate.
    #[must_use]
    pub fn new(found: &Estimate, run: usize) -> Self {
        let model = found.model(run);
        let structure = &found.layout.structure;
        let known = &structure.known_denominator;
        let noise_model = match found.error {
            Error::Equation => product(&monic(&found.noise_model), known).split_off(1),
            Error::Output => Vec::new(),
        };
        Self {
            sample_time: found.sample_time,
            num: model.numerator(structure.delay == 0),
            den: monic(&model.a),
            covariance: rows(&found.coefficient_covariance(run)),
            offset: found.offset(run),
            input_level: found.level_of_integrator(run),
            error: found.error,
            noise_variance: found.noise_variance,
            noise_model,
            noise_denominator: found.noise_denominator.clone(),
            curve: (found.output_curve.as_ref()).map(|it| (Side::Output, it.curve.clone())),
        }
    }

    /// The judgement on the first input and output of a record: the fit of the simulation, and of predictions at these horizons.
    ///
    /// # Errors
    /// [`IdentificationError`]: a model without coefficients, a record with another sampling interval, or without input
    /// or output.
    pub fn on(&self, record: &Record, ahead: &[usize]) -> Result<Judgement> {
        check_sample_time(self.sample_time, record)?;
        let record = match &self.curve {
            Some((Side::Input, curve)) => &curve.of_input(record),
            _ => record,
        };
        let runs = record.runs().filter(|runs| !runs.is_empty());
        let runs = runs.ok_or_else(|| {
            IdentificationError::Record("a record with an input and an output is needed".to_owned())
        })?;
        let mut estimate = self.estimate(runs.len())?;
        let mut bounded = true;
        let simulated: Vec<Vec<f64>> = (runs.iter().enumerate())
            .map(|(number, run)| {
                bounded &= estimate.set_in_motion(number, *run);
                estimate.simulate(number, *run)
            })
            .collect();
        estimate.residuals = (0..runs.len())
            .map(|number| prediction::residuals(&estimate, number, runs[number]))
            .collect();
        let longest = (0..runs.len())
            .max_by_key(|number| runs[*number].outputs.len())
            .unwrap_or_default();
        let joined = |missed: &dyn Fn(usize) -> Missed| {
            let each = (0..runs.len()).map(missed);
            each.fold(Missed::default(), Missed::and).fit()
        };
        // Poles at z = 0 have no state of their own: what they remember is the input before.
        let poles = estimate.model(longest).a;
        let scored = Structure {
            poles: poles.iter().rposition(|a| *a != 0.0).map_or(0, |it| it + 1),
            ..estimate.layout.structure.clone()
        };
        let of_simulation = |number: usize| {
            let pairs = runs[number].outputs.iter().zip(&simulated[number]);
            let unknown = scored.unknown(runs[number].past.len());
            Missed::by(pairs.skip(unknown).map(|(y, x)| (*y, y - x)))
        };
        Ok(Judgement {
            segments: record.used(),
            longest,
            fit: joined(&of_simulation).filter(|_| bounded),
            predicted: (ahead.iter())
                .map(|ahead| {
                    let of = |number| prediction::missed(&estimate, number, runs[number], *ahead);
                    (*ahead, joined(&of))
                })
                .collect(),
            residuals: ResidualTests::new(&estimate.residuals[longest], runs[longest].inputs),
            samples: runs.iter().map(|run| run.outputs.len()).sum(),
            simulated,
            estimate,
        })
    }

    /// The model as an estimate for `runs` records, each with an initial motion of 0.
    ///
    /// # Errors
    /// [`IdentificationError`]: a model without coefficients.
    pub fn estimate(&self, runs: usize) -> Result<Estimate> {
        let (n, given) = (self.den.len().saturating_sub(1), self.num.len());
        let proper = self.den.first() == Some(&1.0) && (given == n || given == n + 1) && given > 0;
        let count = n + given;
        let square = self.covariance.iter().all(|row| row.len() == count);
        if !proper || self.covariance.len() != count || !square {
            return Err(IdentificationError::Model(
                "the model must have a denominator that begins with 1, as many numerator coefficients as poles or one more, and a covariance of all these coefficients"
                    .to_owned(),
            ));
        }
        // Zeros in front of the numerator are a delay, as many behind the denominator its poles at z = 0.
        let zeros = self.num.iter().take_while(|b| **b == 0.0).count();
        let zeros = if zeros == given { 0 } else { zeros };
        let behind = self.num.iter().rev().take_while(|b| **b == 0.0).count();
        let numerator = if zeros + behind >= given {
            given - zeros
        } else {
            given - zeros - behind
        };
        let idle = self.den.iter().rev().take_while(|a| **a == 0.0).count();
        // The motion at the beginning has room for the inputs before, however far the numerator looks back.
        let poles = (n - idle).max((numerator - 1).min(n));
        let layout = Layout {
            structure: Structure {
                poles,
                numerator,
                delay: zeros + usize::from(given == n),
                offset: true,
                known_numerator: vec![1.0],
                known_denominator: vec![1.0],
                start: InitialState::Estimated,
                own_numerators: false,
            },
            runs,
        };
        let places: Vec<usize> = (0..poles).chain(n + zeros..n + zeros + numerator).collect();
        let coefficients: Vec<f64> = [&self.den[1..], &self.num].concat();
        let steady = match self.error {
            Error::Equation => self.den.iter().sum(),
            Error::Output => 1.0,
        };
        let mut theta = DVector::zeros(layout.count());
        let mut covariance = DMatrix::zeros(theta.len(), theta.len());
        for (i, from) in places.iter().enumerate() {
            theta[i] = coefficients[*from];
            for (j, other) in places.iter().enumerate() {
                covariance[(i, j)] = self.covariance[*from][*other];
            }
        }
        for at in (0..runs).filter_map(|run| layout.offset(run)) {
            theta[at] = self.offset * steady;
        }
        Ok(Estimate {
            input_level: self.input_level,
            error: self.error,
            layout,
            sample_time: self.sample_time,
            theta,
            covariance,
            factor: None,
            noise_variance: self.noise_variance,
            noise_model: self.noise_model.clone(),
            noise_denominator: self.noise_denominator.clone(),
            residuals: Vec::new(),
            output_curve: match &self.curve {
                Some((Side::Output, curve)) => Some(FittedCurve::known(curve)),
                _ => None,
            },
            physical: None,
            process: None,
            frequency: None,
        })
    }
}

impl Estimate {
    /// Fits the initial motion of a record; returns whether a bounded one exists.
    fn set_in_motion(&mut self, number: usize, run: Run<'_>) -> bool {
        let unknown = self.layout.structure.unknown(run.past.len());
        let left = self.simulation_errors(number, run);
        let a = self.layout.denominator(self.theta.as_slice());
        let motion = free_motion(left.get(unknown..).unwrap_or_default(), &a);
        let found = motion.is_some();
        for (at, m) in self.layout.motion(number).zip(motion.unwrap_or_default()) {
            self.theta[at] = m;
        }
        found
    }
}
