//! The equations on the runs of data: the unknowns, the errors with their slopes, and searches for the minimum.

use nalgebra::{DMatrix, DVector};
use planesman_identification::estimators::{Search, Total, least};
use planesman_identification::on_all_cores;

use crate::model::{Equations, Unknown};
use crate::simulation::{Run, Simulated, Unfinished, simulate};

/// Settings of a search.
const SEARCH: Search = Search {
    steps: 100,
    enough: 1e-10,
    radius: f64::INFINITY,
};
/// Number of points between the bounds; the best of them are used as start values.
const POINTS: usize = 64;
const STARTS: usize = 4;
/// A search uses these growing parts of the runs, one after the other.
const GROWTH: [f64; 3] = [0.04, 0.12, 0.35];

/// A parameter counts as at its bound if its distance, relative to the range, is below this value.
const AT_BOUND: f64 = 1e-9;

/// An output's errors by run, in the output's unit, and their derivatives, with the runs stacked.
pub(crate) type OutputErrors = (Vec<Vec<f64>>, DMatrix<f64>);

/// The equations on the runs.
pub(crate) struct Problem<'a> {
    pub(crate) equations: &'a Equations,
    pub(crate) runs: &'a [Run],
    /// The inverse noise of each output.
    pub(crate) weights: Vec<f64>,
    /// All unknowns: parameters, then the initial states of each run.
    pub(crate) sought: Vec<Unknown>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(equations: &'a Equations, runs: &'a [Run], weights: Vec<f64>) -> Self {
        let states: Vec<Unknown> = equations.sought_states().map(|it| it.1.clone()).collect();
        let mut sought = equations.unknowns.clone();
        for _ in runs {
            sought.extend(states.iter().cloned());
        }
        Self {
            equations,
            runs,
            weights,
            sought,
        }
    }

    /// The places of the parameters and of the initial states of a run.
    pub(crate) fn places(&self, run: usize) -> Vec<usize> {
        let parameters = self.equations.unknowns.len();
        let states = self.equations.sought_states().count();
        let first = parameters + run * states;
        (0..parameters).chain(first..first + states).collect()
    }

    pub(crate) fn simulated(
        &self,
        theta: &DVector<f64>,
        with_slopes: bool,
    ) -> Result<Vec<Vec<Simulated>>, Unfinished> {
        let parameters = self.equations.unknowns.len();
        let numbers: Vec<usize> = (0..self.runs.len()).collect();
        let of = |run: &usize| {
            let at = |places: &[usize]| places.iter().map(|it| theta[*it]).collect::<Vec<f64>>();
            let places = self.places(*run);
            let (of_model, of_run) = places.split_at(parameters);
            simulate(
                self.equations,
                &at(of_model),
                &at(of_run),
                &self.runs[*run],
                with_slopes,
            )
        };
        on_all_cores(&numbers, of).into_iter().collect()
    }

    /// The weighted errors of every run and output, one below the other.
    pub(crate) fn errors(&self, theta: &DVector<f64>) -> Option<DVector<f64>> {
        let simulated = self.simulated(theta, false).ok()?;
        let mut errors = Vec::new();
        for (run, simulated) in self.runs.iter().zip(&simulated) {
            for (output, of) in simulated.iter().enumerate() {
                let pairs = run.outputs[output].values.iter().zip(&of.values);
                errors.extend(pairs.map(|(y, x)| (y - x) * self.weights[output]));
            }
        }
        Some(DVector::from_vec(errors))
    }

    fn total(&self, theta: &DVector<f64>) -> Option<Total> {
        let simulated = self.simulated(theta, true).ok()?;
        let count = theta.len();
        let mut total = Total {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            cost: 0.0,
        };
        for (run, simulated) in simulated.iter().enumerate() {
            let places = self.places(run);
            let p = places.len();
            let mut information = vec![0.0; p * p];
            for (output, of) in simulated.iter().enumerate() {
                let weight = self.weights[output];
                let measured = &self.runs[run].outputs[output].values;
                for (k, (y, x)) in measured.iter().zip(&of.values).enumerate() {
                    let error = (y - x) * weight;
                    total.cost += error * error;
                    let row = &of.slopes[k * p..(k + 1) * p];
                    for (i, slope) in row.iter().enumerate() {
                        total.gradient[places[i]] += weight * slope * error;
                        let scaled = weight * weight * slope;
                        for (to, other) in information[i * p..].iter_mut().zip(&row[..=i]) {
                            *to += scaled * other;
                        }
                    }
                }
            }
            for i in 0..p {
                for j in 0..=i {
                    total.information[(places[i], places[j])] += information[i * p + j];
                    if i != j {
                        total.information[(places[j], places[i])] += information[i * p + j];
                    }
                }
            }
        }
        // At a bound that the next step would leave, a parameter stays.
        for (i, of) in self.sought.iter().enumerate() {
            let leaves = theta[i] <= of.bounds.0 && total.gradient[i] < 0.0
                || theta[i] >= of.bounds.1 && total.gradient[i] > 0.0;
            if leaves {
                total.information.row_mut(i).fill(0.0);
                total.information.column_mut(i).fill(0.0);
                total.gradient[i] = 0.0;
            }
        }
        let is_finite = total.cost.is_finite() && total.information.iter().all(|it| it.is_finite());
        is_finite.then_some(total)
    }

    fn within(&self, theta: DVector<f64>) -> DVector<f64> {
        let bounded = theta.iter().zip(&self.sought);
        let bounded = bounded.map(|(value, of)| value.clamp(of.bounds.0, of.bounds.1));
        DVector::from_iterator(self.sought.len(), bounded)
    }

    pub(crate) fn minimised(&self, start: DVector<f64>) -> Option<(DVector<f64>, f64)> {
        let within = |theta| Some(self.within(theta));
        least(start, SEARCH, &|theta| self.total(theta), &within)
    }

    /// Improves a start on growing parts of each run. Over a short time, a search from a simulation within half a period of the output converges; over a
    /// long time convergence is not certain.
    pub(crate) fn grown(&self, start: &DVector<f64>) -> Option<DVector<f64>> {
        let mut theta = start.clone();
        for share in GROWTH {
            let parts: Vec<Run> = self
                .runs
                .iter()
                .map(|it| it.until(share * it.end()))
                .collect();
            let of = Problem::new(self.equations, &parts, self.weights.clone());
            if parts.iter().map(Run::samples).sum::<usize>() > 2 * theta.len() {
                theta = of.minimised(theta)?.0;
            }
        }
        (theta != *start).then_some(theta)
    }

    /// Starts of searches: the given start values, and the best of several points between the bounds.
    pub(crate) fn starts(&self) -> Vec<DVector<f64>> {
        let start =
            DVector::from_iterator(self.sought.len(), self.sought.iter().map(|it| it.start));
        let ranged = self.sought.iter().take(self.equations.unknowns.len());
        let ranged: Vec<usize> = ranged
            .enumerate()
            .filter(|(_, it)| it.bounds.0.is_finite() && it.bounds.1.is_finite())
            .map(|it| it.0)
            .collect();
        let mut points: Vec<(f64, DVector<f64>)> = Vec::new();
        for point in 1..=POINTS {
            if ranged.is_empty() {
                break;
            }
            let mut theta = start.clone();
            for (dimension, at) in ranged.iter().enumerate() {
                let (low, high) = self.sought[*at].bounds;
                let share = halton(point, PRIMES[dimension % PRIMES.len()]);
                theta[*at] = match low > 0.0 {
                    true => low * libm::pow(high / low, share),
                    false => low + share * (high - low),
                };
            }
            let cost = self.errors(&theta).map(|it| it.norm_squared());
            points.extend(cost.filter(|it| it.is_finite()).map(|cost| (cost, theta)));
        }
        points.sort_by(|p, q| p.0.total_cmp(&q.0));
        let best = points.into_iter().take(STARTS).map(|it| it.1);
        std::iter::once(start).chain(best).collect()
    }

    /// Whether a parameter is at one of its bounds.
    pub(crate) fn is_at_bound(&self, theta: &DVector<f64>, parameter: usize) -> bool {
        let (low, high) = self.sought[parameter].bounds;
        let value = theta[parameter];
        let near = AT_BOUND * value.abs().max(1e-300);
        value - low <= near || high - value <= near
    }

    /// The residuals of each output.
    pub(crate) fn by_output(&self, theta: &DVector<f64>) -> Option<Vec<OutputErrors>> {
        let simulated = self.simulated(theta, true).ok()?;
        let outputs = (0..self.equations.outputs.len()).map(|output| {
            let mut errors = Vec::new();
            let rows: usize = self
                .runs
                .iter()
                .map(|it| it.outputs[output].times.len())
                .sum();
            let mut slopes = DMatrix::zeros(rows, theta.len());
            let mut first = 0;
            for (run, simulated) in simulated.iter().enumerate() {
                let places = self.places(run);
                let of = &simulated[output];
                let measured = &self.runs[run].outputs[output].values;
                for (k, row) in of.slopes.chunks(places.len()).enumerate() {
                    for (place, slope) in places.iter().zip(row) {
                        slopes[(first + k, *place)] = *slope;
                    }
                }
                first += measured.len();
                errors.push(
                    measured
                        .iter()
                        .zip(&of.values)
                        .map(|(y, x)| y - x)
                        .collect(),
                );
            }
            (errors, slopes)
        });
        Some(outputs.collect())
    }
}

const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

/// An element of the Halton sequence (1960), which fills 0 to 1 evenly.
fn halton(mut number: usize, base: usize) -> f64 {
    let (mut share, mut value) = (1.0, 0.0);
    while number > 0 {
        share /= base as f64;
        value += share * (number % base) as f64;
        number /= base;
    }
    value
}
