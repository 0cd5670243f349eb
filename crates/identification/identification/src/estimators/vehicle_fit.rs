//! The vehicle's equations fitted to whole records: by minimising the simulated error, and by the extended Kalman filter in several passes.

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::kalman::{Filter, Settings};
use super::levenberg_marquardt::{Linearised, minimise, unit_covariance};
use super::physical::UNKNOWNS;
use super::rows::{freedom, samples_by_run};
use super::vehicle::{Solution, Vehicle};
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::structure::{InitialState, Problem, variance};
use planesman_parallel::stop_point;

/// The records do not determine a vehicle.
const UNDETERMINED: IdentificationError =
    IdentificationError::Undetermined("the records do not determine the vehicle");

/// Number of decay rates for initial guesses, from the record's length to one sample.
const GUESSES: usize = 6;

/// Rounds of search and noise estimate; the noise weighs the prior knowledge against the records.
const ROUNDS: usize = 3;

/// The vehicle with the smallest simulated error; each record has its own bias and, unless it begins at rest, initial motion. Of the problem's structure
/// only bias and initial motion are used.
#[derive(Clone, Copy, Debug, Default)]
pub struct VehicleSearch {
    /// The known part of the equations.
    pub vehicle: Vehicle,
}

impl Estimator for VehicleSearch {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let vehicle = self.vehicle;
        let prior = vehicle.prior();
        let mut noise = 0.0;
        let mut start = self.starts(problem)?;
        let mut last = None;
        for _ in 0..if prior.is_empty() { 1 } else { ROUNDS } {
            let (theta, at) = start
                .iter()
                .filter_map(|start| {
                    minimise(start.clone(), |theta| {
                        self.linearised(problem, theta, noise)
                    })
                    .ok()
                })
                .min_by(|p, q| {
                    let cost = |it: &(DVector<f64>, Linearised)| it.1.errors.norm_squared();
                    cost(p).total_cmp(&cost(q))
                })
                .ok_or(UNDETERMINED)?;
            let rows = at.errors.len() - prior.len();
            let freedom = freedom(rows, theta.len() - prior.len())?;
            let variance = at.errors.rows(0, rows).norm_squared() / freedom;
            noise = variance.sqrt();
            start = vec![theta.clone()];
            last = Some((theta, variance));
        }
        let (theta, noise_variance) = last.ok_or(UNDETERMINED)?;
        let at = self.linearised(problem, &theta, noise);
        let rows = at.errors.len() - prior.len();
        let (coefficients, biases, motions) = self.parts(problem, &theta);
        let solution = Solution {
            coefficients,
            biases,
            motions,
            covariance: unit_covariance(&at)? * noise_variance,
            noise_variance,
            residuals: samples_by_run(problem, &at.errors.as_slice()[..rows]),
        };
        Ok(vehicle.estimate(problem, solution))
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        VehicleFilter::new(self.vehicle).learner(problem)
    }
}

impl VehicleSearch {
    /// Starts: the best of a grid of decay rates, with all other parameters by least squares and heave at its prior.
    fn starts(&self, problem: &Problem<'_>) -> Result<Vec<DVector<f64>>> {
        let vehicle = self.vehicle;
        let unknowns = vehicle.unknowns();
        let count = vehicle.count(&problem.structure, problem.runs.len());
        let dt = problem.sample_time;
        // The unknowns that enter linearly: kappa, and all that belongs to a record.
        let columns: Vec<usize> = std::iter::once(0).chain(unknowns..count).collect();
        let completed = |guess: &DVector<f64>| {
            let mut theta = guess.clone();
            for column in &columns {
                theta[*column] = 0.0;
            }
            let at = self.linearised(problem, &theta, 0.0);
            let rows = problem.runs.iter().map(|run| run.outputs.len()).sum();
            let slopes = at.slopes.rows(0, rows).select_columns(&columns);
            let errors = at.errors.rows(0, rows).into_owned();
            let rest = Triangle::new(&slopes, &errors).ok()?.solution().ok()?;
            for (column, value) in columns.iter().zip(rest.iter()) {
                theta[*column] = *value;
            }
            Some(theta)
        };
        if let Some(part) = problem.part() {
            let found = self.fit(&part)?;
            let mut guess = DVector::zeros(count);
            let values = found.physical.ok_or(UNDETERMINED)?.values;
            guess.rows_mut(0, unknowns).copy_from(&values);
            return Ok(vec![completed(&guess).ok_or(UNDETERMINED)?]);
        }
        let longest = problem.runs.iter().map(|run| run.outputs.len()).max();
        let longest = longest.unwrap_or(0).max(2) as f64;
        let rate = |i: usize| libm::pow(longest, i as f64 / (GUESSES - 1) as f64 - 1.0) / dt;
        let mut starts: Vec<(f64, DVector<f64>)> = (0..GUESSES)
            .flat_map(|i| (0..=i).map(move |j| (rate(i), rate(j))))
            .filter_map(|(fast, slow)| {
                let mut guess = DVector::zeros(count);
                (guess[1], guess[2]) = (fast + slow, fast * slow);
                for (i, (known, _)) in vehicle.prior().iter().enumerate() {
                    guess[UNKNOWNS + i] = *known;
                }
                let theta = completed(&guess)?;
                let cost = self.linearised(problem, &theta, 0.0).errors.norm_squared();
                cost.is_finite().then_some((cost, theta))
            })
            .collect();
        starts.sort_by(|p, q| p.0.total_cmp(&q.0));
        starts.truncate(2);
        match starts.is_empty() {
            true => Err(UNDETERMINED),
            false => Ok(starts.into_iter().map(|(_, theta)| theta).collect()),
        }
    }

    /// All coefficients, and bias and initial state of each record.
    fn parts(
        &self,
        problem: &Problem<'_>,
        theta: &DVector<f64>,
    ) -> (DVector<f64>, Vec<f64>, Vec<DVector<f64>>) {
        let vehicle = self.vehicle;
        let mut coefficients = vehicle.coefficients([0.0; UNKNOWNS]);
        let unknowns = vehicle.unknowns();
        coefficients
            .rows_mut(0, unknowns)
            .copy_from(&theta.rows(0, unknowns));
        let (biases, motions) = (0..problem.runs.len())
            .map(|run| {
                let (bias, motion) = vehicle.columns(&problem.structure, run);
                let mut x = DVector::zeros(vehicle.states());
                x.rows_mut(0, motion.len())
                    .copy_from(&theta.rows(motion.start, motion.len()));
                (bias.map_or(0.0, |at| theta[at]), x)
            })
            .unzip();
        (coefficients, biases, motions)
    }

    /// `y - yhat` and its slopes, all records one below the other, followed by rows for the prior knowledge, scaled by its deviation and
    /// the noise's.
    fn linearised(&self, problem: &Problem<'_>, theta: &DVector<f64>, noise: f64) -> Linearised {
        let vehicle = self.vehicle;
        let (prior, unknowns) = (vehicle.prior(), vehicle.unknowns());
        let rows: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
        let mut errors = DVector::zeros(rows + prior.len());
        let mut slopes = DMatrix::zeros(rows + prior.len(), theta.len());
        let (coefficients, biases, motions) = self.parts(problem, theta);
        let mut first = 0;
        for (r, run) in problem.runs.iter().enumerate() {
            let count = run.outputs.len();
            let x = motions[r].clone();
            let (rate, by) = vehicle.simulate(&coefficients, x, problem.sample_time, run.inputs);
            for k in 0..count {
                errors[first + k] = run.outputs[k] - rate[k] - biases[r];
            }
            slopes
                .view_mut((first, 0), (count, unknowns))
                .copy_from(&by.columns(0, unknowns));
            let (bias, motion) = vehicle.columns(&problem.structure, r);
            if let Some(at) = bias {
                slopes.view_mut((first, at), (count, 1)).fill(1.0);
            }
            slopes
                .view_mut((first, motion.start), (count, motion.len()))
                .copy_from(&by.columns(unknowns, motion.len()));
            first += count;
        }
        for (i, (known, deviation)) in prior.iter().enumerate() {
            // Without a noise to weigh it by, what is known is held as it is.
            let weight = if noise > 0.0 { noise / deviation } else { HELD };
            errors[rows + i] = weight * (known - theta[UNKNOWNS + i]);
            slopes[(rows + i, UNKNOWNS + i)] = weight;
        }
        Linearised { errors, slopes }
    }
}

/// The weight of prior knowledge before a noise estimate exists.
const HELD: f64 = 1e6;

/// A filter's prior for the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// `kappa`, `beta`, `mu`.
    pub parameters: [f64; UNKNOWNS],
    /// Their standard deviations.
    pub deviations: [f64; UNKNOWNS],
    /// The bias' standard deviation about 0, output unit.
    pub bias_deviation: f64,
}

/// Passes over a record.
const PASSES: usize = 4;

/// The filter over records, one after the other, repeatedly. Of the problem's structure only the offset and the initial state are used.
#[derive(Clone, Copy, Debug)]
pub struct VehicleFilter {
    /// The known part of the equations.
    pub vehicle: Vehicle,
    /// The start; `None` for a guess from the records with an uncertainty as large as its values.
    pub guess: Option<Guess>,
    /// The noise's standard deviation, output unit; `None` to estimate it from the records' second differences, which white noise makes
    /// `sqrt(6)` times as large and a slow vehicle hardly affects.
    pub noise: Option<f64>,
    /// Standard deviation of the bias drift in one second, output unit.
    pub bias_drift: f64,
    /// Standard deviation of the rate's change by disturbances in one second, output unit.
    pub disturbance: f64,
    /// Passes over the records.
    pub passes: usize,
}

impl VehicleFilter {
    /// Four passes from a guess, with a constant bias and no disturbance.
    #[must_use]
    pub fn new(vehicle: Vehicle) -> Self {
        Self {
            vehicle,
            guess: None,
            noise: None,
            bias_drift: 0.0,
            disturbance: 0.0,
            passes: PASSES,
        }
    }

    fn settings(&self, problem: &Problem<'_>) -> Result<Settings> {
        let all: Vec<f64> = problem
            .runs
            .iter()
            .flat_map(|run| run.outputs.iter().copied())
            .collect();
        let size = (all.iter().map(|y| y * y).sum::<f64>() / all.len().max(1) as f64).sqrt();
        let guess = match self.guess {
            Some(guess) => guess,
            None => self.guessed(problem, size)?,
        };
        let noise = self
            .noise
            .unwrap_or_else(|| second_differences(problem).max(1e-6 * size));
        Ok(Settings {
            parameters: guess.parameters,
            deviations: guess.deviations,
            bias_deviation: if problem.structure.offset {
                guess.bias_deviation
            } else {
                0.0
            },
            noise,
            bias_drift: self.bias_drift,
            drift: [0.0; UNKNOWNS],
            disturbance: self.disturbance,
            motion: match problem.structure.start {
                InitialState::Rest => 0.0,
                InitialState::Estimated => size,
            },
        })
    }

    /// The best of a coarse grid.
    fn guessed(&self, problem: &Problem<'_>, size: f64) -> Result<Guess> {
        let search = VehicleSearch {
            vehicle: self.vehicle,
        };
        let starts = search.starts(problem)?;
        let parameters = [0, 1, 2].map(|i| starts[0][i]);
        Ok(Guess {
            parameters,
            deviations: parameters.map(f64::abs),
            bias_deviation: size,
        })
    }

    /// The initial state of a record with the smallest simulation error.
    fn beginning(
        &self,
        problem: &Problem<'_>,
        run: usize,
        coefficients: &DVector<f64>,
        bias: f64,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (n, unknowns) = (self.vehicle.states(), self.vehicle.unknowns());
        let rest = (DVector::zeros(n), DMatrix::zeros(n, n));
        if problem.structure.start == InitialState::Rest {
            return rest;
        }
        let run = problem.runs[run];
        let dt = problem.sample_time;
        let (rate, by) = self
            .vehicle
            .simulate(coefficients, rest.0.clone(), dt, run.inputs);
        let pairs = run.outputs.iter().zip(&rate);
        let errors = DVector::from_iterator(rate.len(), pairs.map(|(y, q)| y - q - bias));
        let found = Triangle::new(&by.columns(unknowns, n).into_owned(), &errors)
            .and_then(|triangle| Ok((triangle.solution()?, triangle.unit_covariance()?)));
        found.unwrap_or(rest)
    }
}

/// The standard deviation of the noise that would cause the outputs' second differences.
fn second_differences(problem: &Problem<'_>) -> f64 {
    let differences: Vec<f64> = problem
        .runs
        .iter()
        .flat_map(|run| run.outputs.windows(3).map(|y| y[0] - 2.0 * y[1] + y[2]))
        .collect();
    (variance(&differences) / 6.0).sqrt()
}

impl Estimator for VehicleFilter {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let mut settings = self.settings(problem)?;
        let mut filter = Filter::new(self.vehicle, problem.sample_time, settings)?;
        let (mut biases, mut residuals) = (Vec::new(), Vec::new());
        for _ in 0..self.passes.max(1) {
            stop_point();
            filter = Filter::new(self.vehicle, problem.sample_time, settings)?;
            (biases, residuals) = (Vec::new(), Vec::new());
            for run in &problem.runs {
                let mut innovations = Vec::with_capacity(run.outputs.len());
                for (k, output) in run.outputs.iter().enumerate() {
                    match k {
                        0 => filter.begin(*output),
                        k => filter.push(run.inputs[k - 1], *output),
                    }
                    innovations.extend(filter.error());
                }
                biases.push(filter.bias());
                residuals.push(innovations);
            }
            let found = filter.physical().values;
            if found.iter().any(|v| !v.is_finite()) {
                return Err(IdentificationError::Search("the Kalman filter diverged"));
            }
            settings.parameters = [found[0], found[1], found[2]];
        }
        let coefficients = filter.coefficients();
        let noise_variance = settings.noise.powi(2);
        let unknowns = self.vehicle.unknowns();
        let count = self.vehicle.count(&problem.structure, problem.runs.len());
        let mut motions = Vec::new();
        // The filter has one bias for all records.
        let (_, known) = filter.learnt();
        let of_filter = |i: usize| i.min(unknowns);
        let mut covariance =
            DMatrix::from_fn(count, count, |i, j| known[(of_filter(i), of_filter(j))]);
        for (run, bias) in biases.iter().enumerate() {
            let (x, unit) = self.beginning(problem, run, &coefficients, *bias);
            let (_, at) = self.vehicle.columns(&problem.structure, run);
            for i in at.clone() {
                covariance.row_mut(i).fill(0.0);
                covariance.column_mut(i).fill(0.0);
            }
            covariance
                .view_mut((at.start, at.start), (at.len(), at.len()))
                .copy_from(&(unit.view((0, 0), (at.len(), at.len())) * noise_variance));
            motions.push(x);
        }
        let solution = Solution {
            coefficients,
            biases,
            motions,
            covariance,
            noise_variance,
            residuals,
        };
        Ok(self.vehicle.estimate(problem, solution))
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        let settings = self.settings(problem)?;
        let filter = Filter::new(self.vehicle, problem.sample_time, settings)?;
        Ok(Box::new(filter))
    }
}
