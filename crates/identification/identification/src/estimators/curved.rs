//! Static curves before or after linear dynamics.
//!
//! Curve before the dynamics (Hammerstein): for each curve the output-error dynamics are computed again, so that only the curve's few parameters are
//! searched (variable projection; Golub and Pereyra, *SIAM J. Numer. Anal.* 10, 1973). Curve after the dynamics (Wiener): all parameters at once,
//! `dyhat/dtheta = f'(x) dx/dtheta`.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};

use super::coloured::{independent_share, whitening};
use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::{Linearised, lowered, minimise};
use super::recursive::{self, Kind};
use super::refined::WarmStarted;
use super::rows::samples_by_run;
use super::simulator::{Simulator, coloured_factor};
use super::sums::dot;
use crate::error::{IdentificationError, Result};
use crate::static_curve::{FittedCurve, StaticCurve};
use crate::structure::{Problem, Structure, range};
use planesman_record::Run;

/// Step of the difference quotients, as a share of the signal's range.
const DIFFERENCE: f64 = 1e-3;
/// Maximum number of steps in the search for a curve, and the share of the cost that a step must remove for another to follow.
const STEPS: usize = 20;
const SHARE: f64 = 1e-4;
/// Squares of errors below this share of the largest candidate's are rounding.
const ROUNDING: f64 = 1e-16;
/// Number of iterations that convert measured outputs to outputs before the curve.
const PASSES: usize = 8;

/// Replaces the inputs of a problem's runs.
fn with_inputs<'a>(problem: &Problem<'a>, inputs: &'a [(Vec<f64>, Vec<f64>)]) -> Problem<'a> {
    let pairs = problem.runs.iter().zip(inputs);
    Problem {
        runs: pairs
            .map(|(run, (past, inputs))| Run {
                past,
                inputs,
                outputs: run.outputs,
            })
            .collect(),
        ..problem.clone()
    }
}

/// The input curve of the kind of `start` with the least output error near `start`, in front of linear dynamics of the problem's structure;
/// also returns the errors.
///
/// # Errors
/// [`IdentificationError`], if the data does not determine dynamics or curve.
pub(crate) fn in_front(
    problem: &Problem<'_>,
    start: &StaticCurve,
) -> Result<(FittedCurve, Vec<f64>)> {
    let values: Vec<f64> = start.parameters().iter().map(|it| it.1).collect();
    let (theta, at) = minimise_over(problem, start, &values)?;
    let none = IdentificationError::Search("the search for the curve found no minimum");
    let curve = start.with(theta.as_slice()).ok_or(none)?;
    let covariance = match theta.len() {
        0 => DMatrix::zeros(0, 0),
        count => {
            let residuals = samples_by_run(problem, at.errors.as_slice());
            let parameters = problem.layout().count() + count;
            let freedom = at.errors.len().saturating_sub(parameters).max(1);
            let variance = at.errors.norm_squared() / freedom as f64;
            let factor = coloured_factor(&at, &residuals, variance)?;
            &factor * factor.transpose()
        }
    };
    Ok((
        FittedCurve { curve, covariance },
        at.errors.as_slice().to_vec(),
    ))
}

/// The model with the lowest Bayesian criterion, `N ln V + k ln N`, from the number of parameters k and the errors of each. All are for the
/// same samples; N is the effective number of samples, given the colour of the smallest errors.
pub(crate) fn of_least_criterion<T>(models: Vec<(usize, Vec<f64>, T)>) -> Option<T> {
    let squares = |errors: &[f64]| dot(errors, errors);
    let least = (models.iter()).min_by(|p, q| squares(&p.1).total_cmp(&squares(&q.1)))?;
    let share = independent_share(&whitening([least.1.as_slice()].into_iter()));
    let n = (share * least.1.len() as f64).max(2.0);
    // Errors that are rounding are alike.
    let largest = (models.iter()).map(|it| squares(&it.1)).fold(0.0, f64::max);
    let rounding = (ROUNDING * largest).max(f64::MIN_POSITIVE);
    let criterion = |(parameters, errors, _): &(usize, Vec<f64>, T)| {
        n * libm::log(squares(errors).max(rounding)) + *parameters as f64 * libm::log(n)
    };
    let best = (models.into_iter()).min_by(|p, q| criterion(p).total_cmp(&criterion(q)));
    best.map(|it| it.2)
}

/// Output error of the linear dynamics after a curve; infinite if the data determines no dynamics.
pub(crate) fn cost_in_front(problem: &Problem<'_>, curve: &StaticCurve) -> f64 {
    let poles = RefCell::default();
    errors_behind(problem, curve, &poles).map_or(f64::INFINITY, |it| it.norm_squared())
}

fn minimise_over(
    problem: &Problem<'_>,
    start: &StaticCurve,
    values: &[f64],
) -> Result<(DVector<f64>, Linearised)> {
    let poles = RefCell::default();
    let rows = problem.runs.iter().map(|run| run.outputs.len()).sum();
    let inputs = || problem.runs.iter().flat_map(|run| run.inputs);
    let least = inputs().copied().fold(f64::INFINITY, f64::min);
    let size = inputs().copied().fold(f64::NEG_INFINITY, f64::max) - least;
    let errors = |values: &[f64]| {
        let curve = start.with(values);
        let within = curve.filter(|it| it.bends_within(least, least + size));
        within.and_then(|curve| errors_behind(problem, &curve, &poles))
    };
    let linearise = |theta: &DVector<f64>| {
        let Some(at) = errors(theta.as_slice()) else {
            return Linearised {
                errors: DVector::repeat(rows, f64::INFINITY),
                slopes: DMatrix::zeros(rows, theta.len()),
            };
        };
        let mut slopes = DMatrix::zeros(rows, theta.len());
        for j in 0..theta.len() {
            // Away from where levels would cross.
            let moved = [1.0, -1.0].into_iter().find_map(|sign| {
                let step = sign * DIFFERENCE * size;
                let mut there = theta.clone();
                there[j] += step;
                Some((errors(there.as_slice())?, step))
            });
            if let Some((there, step)) = moved {
                slopes.set_column(j, &((&at - there) / step));
            }
        }
        Linearised { errors: at, slopes }
    };
    lowered(
        DVector::from_column_slice(values),
        (STEPS, SHARE),
        linearise,
    )
}

/// Errors of the best linear dynamics after a curve; errors before the first known output are 0. The next search begins at the poles found.
fn errors_behind(
    problem: &Problem<'_>,
    curve: &StaticCurve,
    poles: &RefCell<Vec<f64>>,
) -> Option<DVector<f64>> {
    let inputs: Vec<_> = problem.runs.iter().map(|run| curve.of_run(run)).collect();
    let behind = with_inputs(problem, &inputs);
    let estimator = WarmStarted {
        poles: poles.borrow().clone(),
        noise: false,
    };
    let own = &problem.structure;
    // Without noise the right curve leaves nothing for more poles than the plant's.
    let lower = (1..own.poles).rev().map(|order| Problem {
        structure: Structure {
            poles: order,
            numerator: own.numerator.min(order),
            ..own.clone()
        },
        ..behind.clone()
    });
    let found = std::iter::once(behind.clone())
        .chain(lower)
        .find_map(|it| estimator.fit(&it).ok())?;
    poles.replace(found.theta.as_slice()[found.layout.a()].to_vec());
    let errors = found.residuals.concat();
    Some(DVector::from_vec(errors))
}

/// Output error with a static curve after the dynamics.
#[derive(Clone, Debug)]
pub struct Wiener {
    /// The initial curve of the search.
    pub start: StaticCurve,
    /// The initial `a1 ... an` of the search for the dynamics; if their number is not n, initial values are searched.
    pub poles: Vec<f64>,
}

impl Wiener {
    /// Runs whose outputs are estimates of the signal before the curve: from the measured output where the curve has a slope; from the simulation
    /// elsewhere, because the output carries no information there.
    pub(crate) fn in_front_of(
        curve: &StaticCurve,
        runs: &[Run<'_>],
        simulated: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let of_run = |(run, simulated): (&Run<'_>, &Vec<f64>)| {
            let pairs = run.outputs.iter().zip(simulated);
            pairs
                .map(|(y, x)| match curve.slope(*x) {
                    0.0 => *x,
                    slope => x + (y - curve.of(&[*x])[0]) / slope,
                })
                .collect()
        };
        runs.iter().zip(simulated).map(of_run).collect()
    }

    /// Initial parameters of the dynamics, after some passes from measured outputs to those before the curve.
    fn dynamics(&self, problem: &Problem<'_>, passes: usize) -> Result<DVector<f64>> {
        let mut poles = self.poles.clone();
        let mut outputs: Vec<Vec<f64>> =
            problem.runs.iter().map(|it| it.outputs.to_vec()).collect();
        let mut theta = DVector::zeros(0);
        for _ in 0..passes {
            let runs = problem.runs.iter().zip(&outputs);
            let in_front = Problem {
                runs: runs.map(|(run, outputs)| Run { outputs, ..*run }).collect(),
                ..problem.clone()
            };
            let found = WarmStarted {
                poles,
                noise: false,
            }
            .fit(&in_front)?;
            poles = found.theta.as_slice()[found.layout.a()].to_vec();
            let numbered = problem.runs.iter().enumerate();
            let simulated: Vec<_> = numbered
                .map(|(number, run)| found.simulate(number, *run))
                .collect();
            outputs = Self::in_front_of(&self.start, &problem.runs, &simulated);
            theta = found.theta;
        }
        Ok(theta)
    }

    /// The errors after the curve, and their slopes by the dynamics' parameters, then by the curve's.
    fn linearised(
        &self,
        problem: &Problem<'_>,
        simulator: &Simulator<'_>,
        theta: &DVector<f64>,
    ) -> Linearised {
        let count = problem.layout().count();
        let values = &theta.as_slice()[count..];
        let of_dynamics = simulator.linearised(&theta.rows(0, count).into_owned());
        let rows = of_dynamics.errors.len();
        let measured: Vec<f64> = problem
            .runs
            .iter()
            .flat_map(|it| it.outputs)
            .copied()
            .collect();
        let size = problem.runs.iter().map(|run| range(run.outputs));
        let step = DIFFERENCE * size.fold(0.0, f64::max);
        let mut slopes = of_dynamics.slopes.insert_columns(count, values.len(), 0.0);
        let mut errors = of_dynamics.errors;
        let Some(curve) = self.start.with(values) else {
            errors.fill(f64::INFINITY);
            return Linearised { errors, slopes };
        };
        let moved: Vec<Option<(StaticCurve, f64)>> = (0..values.len())
            .map(|j| {
                let moved = |sign: f64| {
                    let mut there = values.to_vec();
                    there[j] += sign * step;
                    Some((self.start.with(&there)?, sign * step))
                };
                moved(1.0).or_else(|| moved(-1.0))
            })
            .collect();
        let unknown = unknown_rows(problem);
        for k in 0..rows {
            if unknown[k] {
                continue; // Their errors and slopes are 0.
            }
            let x = measured[k] - errors[k];
            let y = curve.of(&[x])[0];
            errors[k] = measured[k] - y;
            slopes.row_mut(k).scale_mut(curve.slope(x));
            for (j, moved) in moved.iter().enumerate() {
                if let Some((there, step)) = moved {
                    slopes[(k, count + j)] = (there.of(&[x])[0] - y) / step;
                }
            }
        }
        Linearised { errors, slopes }
    }
}

/// Which samples come before the first output with known inputs.
fn unknown_rows(problem: &Problem<'_>) -> Vec<bool> {
    let unknown = problem.unknown();
    let runs = problem.runs.iter().zip(unknown);
    runs.flat_map(|(run, unknown)| (0..run.outputs.len()).map(move |k| k < unknown))
        .collect()
}

impl Estimator for Wiener {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let simulator = Simulator::new(problem);
        let count = problem.layout().count();
        let values: Vec<f64> = self.start.parameters().iter().map(|it| it.1).collect();
        let after = |passes: usize| {
            let dynamics = self.dynamics(problem, passes)?;
            let start = dynamics.iter().chain(&values).copied();
            let start = DVector::from_iterator(count + values.len(), start);
            minimise(start, |theta| self.linearised(problem, &simulator, theta))
        };
        // The passes may lead to dynamics that grow.
        let (theta, at) = after(PASSES).or_else(|_| after(1))?;
        let none = IdentificationError::Search("the search for the curve found no minimum");
        let curve = (self.start.with(&theta.as_slice()[count..])).ok_or(none)?;
        // The covariance of a part of the parameters is that of its slopes without what the others' make up.
        let own = at.slopes.columns(0, count).into_owned();
        let others = at.slopes.columns(count, theta.len() - count).into_owned();
        let of_dynamics = Linearised {
            slopes: beside(&own, &others)?,
            errors: at.errors.clone(),
        };
        let estimate = simulator.estimate(theta.rows(0, count).into_owned(), &of_dynamics)?;
        let of_curve = Linearised {
            slopes: beside(&others, &own)?,
            errors: at.errors,
        };
        let factor = coloured_factor(&of_curve, &estimate.residuals, estimate.noise_variance)?;
        Ok(Estimate {
            output_curve: Some(FittedCurve {
                curve,
                covariance: &factor * factor.transpose(),
            }),
            ..estimate
        })
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}

/// Removes from columns their projection on other columns.
fn beside(columns: &DMatrix<f64>, others: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    if others.ncols() == 0 || columns.ncols() == 0 {
        return Ok(columns.clone());
    }
    let basis = others.clone().qr().q();
    Ok(columns - &basis * (basis.transpose() * columns))
}

/// The change of the dynamics' parameters with each of the curve's, one column each.
///
/// # Errors
/// Errors of the estimator.
pub(crate) fn moved_by(
    estimator: &dyn Estimator,
    problem: &Problem<'_>,
    fitted: &FittedCurve,
) -> Result<DMatrix<f64>> {
    let parameters = fitted.curve.parameters();
    let find = |curve: &StaticCurve| -> Result<DVector<f64>> {
        let inputs: Vec<_> = problem.runs.iter().map(|run| curve.of_run(run)).collect();
        Ok(estimator.fit(&with_inputs(problem, &inputs))?.theta)
    };
    let here = find(&fitted.curve)?;
    let mut slopes = DMatrix::zeros(here.len(), parameters.len());
    for j in 0..parameters.len() {
        let step = fitted.covariance[(j, j)].max(0.0).sqrt();
        let moved = [1.0, -1.0].into_iter().find_map(|sign| {
            let mut values: Vec<f64> = parameters.iter().map(|it| it.1).collect();
            values[j] += sign * step;
            let there = find(&fitted.curve.with(&values)?).ok()?;
            (there.len() == here.len()).then_some((there, sign * step))
        });
        if let Some((there, step)) = moved.filter(|it| it.1 != 0.0) {
            slopes.set_column(j, &((there - &here) / step));
        }
    }
    Ok(slopes)
}
