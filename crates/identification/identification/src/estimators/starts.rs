//! Initial guesses of the output-error search, whose cost has local minima.

use nalgebra::DVector;
use planesman_linear::ComplexFunctions as _;
use planesman_linear::polynomial::{self, product};

use super::estimator::Estimator;
use super::least_squares::LeastSquares;
use super::rows::regression;
use super::simulator::Simulator;
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;
use planesman_record::filter;

/// The first filters, `(1 - rho q^-1)^-n`: from no filter to the slowest one, for records at 20 Hz. The first filters; the less noise they pass, the
/// nearer to the vehicle's poles the rounds begin.
const FIRST_FILTERS: [f64; 4] = [0.0, 0.7, 0.9, 0.97];

/// Number of decay rates per sample for initial guesses of real poles: from the record's length to one sample.
const RATES: usize = 7;

/// Number of starts from which the search continues.
const STARTS: usize = 3;

/// Starts of a search, smallest output error first: least squares with each of the first filters, and real poles on a grid; all other
/// parameters are computed for these poles. For long records, also the poles that `estimator` finds in a part.
///
/// # Errors
/// [`IdentificationError`], if the records do not determine every parameter even then.
pub(super) fn starts(
    estimator: &dyn Estimator,
    problem: &Problem<'_>,
    simulator: &Simulator<'_>,
) -> Result<Vec<DVector<f64>>> {
    let n = problem.structure.poles;
    if let Some(part) = problem.part() {
        let found = estimator.fit(&part)?;
        let start = completed(problem, simulator, &found.theta.as_slice()[..n]);
        return Ok(vec![start.ok_or_else(|| why_not(problem))?]);
    }
    let filtered = FIRST_FILTERS.iter().filter_map(|rho| {
        let den = (0..n).fold(vec![1.0], |den, _| product(&den, &[1.0, -rho]));
        let theta = filtered_least_squares(problem, &den)?;
        stable(&theta.as_slice()[..n])
    });
    let mut found: Vec<(f64, DVector<f64>)> = filtered
        .chain(real_poles(problem))
        .filter_map(|a| completed(problem, simulator, &a))
        .map(|theta| (simulator.linearised(&theta).cost(), theta))
        .filter(|(cost, _)| cost.is_finite())
        .collect();
    found.sort_by(|p, q| p.0.total_cmp(&q.0));
    found.truncate(STARTS);
    match found.is_empty() {
        true => Err(why_not(problem)),
        false => Ok(found.into_iter().map(|(_, theta)| theta).collect()),
    }
}

/// `a1 ... an` for every choice of n real poles from the grid.
fn real_poles(problem: &Problem<'_>) -> Vec<Vec<f64>> {
    let longest = problem
        .runs
        .iter()
        .map(|run| run.outputs.len())
        .max()
        .unwrap_or(1);
    let slowest = 1.0 / longest.max(2) as f64;
    let poles: Vec<f64> = (0..RATES)
        .map(|i| libm::exp(-libm::pow(slowest, i as f64 / (RATES - 1) as f64)))
        .collect();
    // Choices with repetition, each with its polynomial; all of them up to third order, fewer beyond.
    let mut choices = vec![(0, vec![1.0])];
    for order in 1..=problem.structure.poles {
        let stride = if order > 3 { 3 } else { 1 };
        choices = choices
            .iter()
            .flat_map(|(first, polynomial)| {
                (*first..RATES)
                    .step_by(stride)
                    .map(|i| (i, product(polynomial, &[1.0, -poles[i]])))
                    .collect::<Vec<_>>()
            })
            .collect();
    }
    choices
        .into_iter()
        .map(|(_, mut polynomial)| {
            polynomial.remove(0);
            polynomial
        })
        .collect()
}

/// The reason why no start was found, from least squares on the record.
fn why_not(problem: &Problem<'_>) -> IdentificationError {
    LeastSquares
        .fit(problem)
        .err()
        .unwrap_or(IdentificationError::Undetermined(
            "the record determines no stable model",
        ))
}

/// Least squares on filtered rows, each a sum over earlier rows and so equally valid.
fn filtered_least_squares(problem: &Problem<'_>, den: &[f64]) -> Option<DVector<f64>> {
    let (mut phi, mut outputs) = regression(problem);
    let first = problem.structure.history();
    let mut row = 0;
    for run in &problem.runs {
        let count = run.outputs.len().saturating_sub(first);
        for j in 0..phi.ncols() {
            let column: Vec<f64> = (row..row + count).map(|i| phi[(i, j)]).collect();
            for (i, value) in filter(&[1.0], den, &column).into_iter().enumerate() {
                phi[(row + i, j)] = value;
            }
        }
        let filtered = filter(&[1.0], den, &outputs.as_slice()[row..row + count]);
        for (i, value) in filtered.into_iter().enumerate() {
            outputs[row + i] = value;
        }
        row += count;
    }
    Triangle::new(&phi, &outputs).ok()?.solution().ok()
}

/// With given poles, computes all other parameters, which enter linearly, by least squares.
fn completed(problem: &Problem<'_>, simulator: &Simulator<'_>, a: &[f64]) -> Option<DVector<f64>> {
    let count = problem.layout().count();
    let mut theta = DVector::zeros(count);
    theta.rows_mut(0, a.len()).copy_from_slice(a);
    let at = simulator.linearised(&theta);
    let slopes = at.slopes.columns(a.len(), count - a.len()).into_owned();
    let rest = Triangle::new(&slopes, &at.errors).ok()?.solution().ok()?;
    theta.rows_mut(a.len(), rest.len()).copy_from(&rest);
    Some(theta)
}

/// The coefficients with every pole outside the unit circle reflected into it.
fn stable(a: &[f64]) -> Option<Vec<f64>> {
    let mut polynomial = vec![1.0];
    polynomial.extend(a);
    let mut roots = polynomial::roots(&polynomial).ok()?;
    if roots.iter().all(|z| z.modulus() <= 1.0) {
        return Some(a.to_vec());
    }
    for z in &mut roots {
        if z.modulus() > 1.0 {
            *z = z.conj().inv();
        }
    }
    let mut mirrored = polynomial::from_roots(&roots).ok()?;
    mirrored.remove(0);
    Some(mirrored)
}
