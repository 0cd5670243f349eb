//! Finds parameters that the data does not determine: directions in which no output changes, and combinations that are nevertheless known.
//!
//! A direction is a null vector of the slopes. If only `K/J` occurs in the equations, K and J may grow together: the direction is
//! `dK/K = dJ/J`, and `K/J` is constant along it. A trial step along the direction shows whether products or sums are constant.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use planesman_identification::SIGMAS_95;
use planesman_identification::estimators::coloured_covariance;
use planesman_linear::digits::with_interval;

use crate::error::EquationsError;
use crate::problem::{OutputErrors, Problem};

/// A direction is undetermined if its singular value is below this share of the largest.
const SINGULAR: f64 = 1e-7;
/// A parameter belongs to a direction if its component is at least this share of the largest.
const PART: f64 = 1e-3;
/// The length of the trial step along a direction, relative to the parameters.
const STEP: f64 = 0.05;
/// A combination counts as constant if its change is at most this share of the change that one parameter alone would cause.
const CONSTANT: f64 = 0.01;
/// Exponents this close to a whole number are rounded to it.
const WHOLE: f64 = 1e-3;

/// Parameters that the data does not determine.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// Their names.
    pub names: Vec<String>,
    /// Combinations that the data determines, each with value and standard deviation; empty if there are none.
    pub kept: Vec<(String, f64, f64)>,
}

impl fmt::Display for Undetermined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.names.join(", ");
        if let [name] = &self.names[..] {
            return write!(
                f,
                "{name} changes no output. Fix its value (fixed: VALUE), or record data in which it has an effect"
            );
        }
        let kept = self.kept.iter().map(|(name, value, deviation)| {
            format!("{name} = {}", with_interval(*value, SIGMAS_95 * deviation))
        });
        let kept = match &kept.collect::<Vec<_>>()[..] {
            [] => format!("{} combinations of them", self.names.len() - 1),
            kept => kept.join(", "),
        };
        write!(
            f,
            "the data does not determine {names} separately, only {kept}. Fix one of them (fixed: VALUE)"
        )
    }
}

/// A direction in parameter space: the parameters involved, each with its relative change.
type Direction = Vec<(usize, f64)>;

/// The information of the data about each parameter at the minimum.
pub(crate) struct Uncertainty {
    pub(crate) covariance: DMatrix<f64>,
    /// Parameters with an effect.
    active: Vec<usize>,
    /// Parameters without an effect that are not at a bound.
    idle: Vec<usize>,
    /// Combinations of the other parameters that have no effect.
    directions: Vec<Direction>,
}

impl Uncertainty {
    /// Computes the uncertainty from the errors of each output by run, and their slopes.
    pub(crate) fn of(
        problem: &Problem<'_>,
        theta: &DVector<f64>,
        by_output: &[OutputErrors],
    ) -> Result<Self, EquationsError> {
        let count = theta.len();
        let rows: usize = by_output.iter().map(|it| it.1.nrows()).sum();
        let mut all = DMatrix::zeros(rows, count);
        let mut first = 0;
        for ((_, slopes), weight) in by_output.iter().zip(&problem.weights) {
            all.rows_mut(first, slopes.nrows())
                .copy_from(&(slopes * *weight));
            first += slopes.nrows();
        }
        for i in (0..count).filter(|it| problem.is_at_bound(theta, *it)) {
            all.column_mut(i).fill(0.0);
        }
        let lengths: Vec<f64> = all.column_iter().map(|it| it.norm()).collect();
        // What moves no output by more than rounding does nothing.
        let moves = |i: usize| lengths[i] * theta[i].abs().max(1e-6) > 1e-9;
        let active: Vec<usize> = (0..count)
            .filter(|i| lengths[*i] > 0.0 && moves(*i))
            .collect();
        if active.is_empty() {
            return Err(EquationsError::NoEffect);
        }
        let scaled = DMatrix::from_fn(rows, active.len(), |k, j| {
            all[(k, active[j])] / lengths[active[j]]
        });
        let svd = scaled.qr().r().svd(false, true);
        let (Some(v), sigma) = (svd.v_t.map(|it| it.transpose()), svd.singular_values) else {
            return Err(EquationsError::NoEffect);
        };
        let is_kept = |j: &usize| sigma[*j] > SINGULAR * sigma.max();
        let kept: Vec<usize> = (0..sigma.len()).filter(is_kept).collect();
        let mut unit = DMatrix::zeros(count, kept.len());
        for (column, j) in kept.iter().enumerate() {
            for (row, i) in active.iter().enumerate() {
                unit[(*i, column)] = v[(row, *j)] / (sigma[*j] * lengths[*i]);
            }
        }
        let mut covariance = DMatrix::zeros(count, count);
        for ((errors, slopes), weight) in by_output.iter().zip(&problem.weights) {
            let weighted: Vec<Vec<f64>> = errors
                .iter()
                .map(|of| of.iter().map(|it| it * weight).collect())
                .collect();
            let n = slopes.nrows() as f64;
            // Each output pays for its share of the parameters.
            let freedom = n * (1.0 - kept.len() as f64 / rows as f64);
            let variance =
                weighted.concat().iter().map(|it| it * it).sum::<f64>() / freedom.max(1.0);
            covariance += coloured_covariance(&unit, slopes * *weight, &weighted, variance);
        }
        let directions = null_directions(&v, &sigma, &active, &lengths, theta);
        let idle: Vec<usize> = (0..count)
            .filter(|i| !active.contains(i) && !problem.is_at_bound(theta, *i))
            .collect();
        Ok(Self {
            covariance,
            active,
            idle,
            directions,
        })
    }

    /// Whether the data determines a parameter.
    pub(crate) fn determines(&self, parameter: usize) -> bool {
        let mut others = self.directions.iter().flatten();
        self.active.contains(&parameter) && others.all(|(at, _)| *at != parameter)
    }

    /// The undetermined parameters: one entry for each direction, and the parameters without an effect.
    pub(crate) fn undetermined(
        &self,
        problem: &Problem<'_>,
        theta: &DVector<f64>,
    ) -> Vec<Undetermined> {
        let name = |i: usize| problem.sought[i].name.clone();
        let of = |direction: &Direction| Undetermined {
            names: direction.iter().map(|it| name(it.0)).collect(),
            kept: kept(problem, theta, &self.covariance, direction),
        };
        let alone = self.idle.iter().map(|i| Undetermined {
            names: vec![name(*i)],
            kept: Vec::new(),
        });
        alone.chain(self.directions.iter().map(of)).collect()
    }
}

/// The directions with zero singular values, each with as few parameters as possible.
fn null_directions(
    v: &DMatrix<f64>,
    sigma: &DVector<f64>,
    active: &[usize],
    lengths: &[f64],
    theta: &DVector<f64>,
) -> Vec<Direction> {
    let scale = |i: usize| if theta[i] == 0.0 { 1.0 } else { theta[i].abs() };
    let null: Vec<usize> = (0..sigma.len())
        .filter(|j| sigma[*j] <= SINGULAR * sigma.max())
        .collect();
    // Rows of null vectors, relative to the parameters; reduced to as few entries as can be.
    let mut rows = DMatrix::from_fn(null.len(), active.len(), |r, c| {
        v[(c, null[r])] / (lengths[active[c]] * scale(active[c]))
    });
    for r in 0..rows.nrows() {
        let largest = rows.row(r).amax();
        rows.row_mut(r).scale_mut(1.0 / largest);
    }
    for r in 0..rows.nrows() {
        let of = rows.row(r).into_owned();
        let pivot = of.transpose().iamax();
        if of[pivot] == 0.0 {
            continue;
        }
        let of = &of / of[pivot];
        rows.row_mut(r).copy_from(&of);
        for other in (0..rows.nrows()).filter(|it| *it != r) {
            let by = rows[(other, pivot)];
            let mut row = rows.row_mut(other);
            row -= &of * by;
        }
    }
    let direction = |r: usize| {
        let row = rows.row(r);
        let largest = row.amax();
        let entries = active.iter().zip(row.iter());
        let entries = entries.filter(|(_, it)| it.abs() > PART * largest);
        entries
            .map(|(at, it)| (*at, it / largest))
            .collect::<Direction>()
    };
    (0..rows.nrows())
        .map(direction)
        .filter(|it| !it.is_empty())
        .collect()
}

/// The combinations that are constant along a direction; each contains the parameter that changes most and one other parameter.
fn kept(
    problem: &Problem<'_>,
    theta: &DVector<f64>,
    covariance: &DMatrix<f64>,
    direction: &Direction,
) -> Vec<(String, f64, f64)> {
    let Some((last, most)) = direction
        .iter()
        .rev()
        .find(|it| it.1.abs() > 1.0 - WHOLE)
        .copied()
    else {
        return Vec::new();
    };
    let scale = |i: usize| if theta[i] == 0.0 { 1.0 } else { theta[i].abs() };
    let errors = |change: &dyn Fn(usize, f64) -> f64, of: &[(usize, f64)]| {
        let mut moved = theta.clone();
        for (i, by) in of {
            moved[*i] = change(*i, *by);
        }
        Some(problem.errors(&moved)? - problem.errors(theta)?)
    };
    let product = |i: usize, by: f64| theta[i] * libm::exp(STEP * by * theta[i].signum());
    let sum = |i: usize, by: f64| theta[i] + STEP * by * scale(i);
    let is_constant = |change: &dyn Fn(usize, f64) -> f64| {
        let all = errors(change, direction);
        let alone = errors(change, &[(last, most)]);
        matches!((all, alone), (Some(all), Some(alone)) if all.norm() < CONSTANT * alone.norm())
    };
    let name = |i: usize| &problem.sought[i].name;
    let others = direction.iter().filter(|it| it.0 != last);
    let carried = |other: usize, by_other: f64, by_last: f64| {
        let both = [(other, by_other), (last, by_last)];
        let sum: f64 = both
            .iter()
            .flat_map(|(i, a)| both.iter().map(move |(j, b)| a * b * covariance[(*i, *j)]))
            .sum();
        sum.max(0.0).sqrt()
    };
    let none_is_zero = direction.iter().all(|it| theta[it.0] != 0.0);
    if none_is_zero && is_constant(&product) {
        return others
            .map(|(other, by)| {
                let exponent = -(by * theta[*other].signum()) / (most * theta[last].signum());
                let whole = exponent.round();
                let exponent = if (exponent - whole).abs() < WHOLE {
                    whole
                } else {
                    exponent
                };
                let (a, b) = (name(*other), name(last));
                let text = match exponent {
                    1.0 => format!("{a}*{b}"),
                    -1.0 => format!("{a}/{b}"),
                    e => format!("{a}*{b}^{e:.3}"),
                };
                // An exponent that is not whole is of the magnitude.
                let power = match exponent == whole {
                    true => theta[last].powi(whole as i32),
                    false => libm::pow(theta[last].abs(), exponent),
                };
                let value = theta[*other] * power;
                let by_last = exponent * value / theta[last];
                (text, value, carried(*other, power, by_last))
            })
            .collect();
    }
    if is_constant(&sum) {
        return others
            .map(|(other, by)| {
                let factor = -(by * scale(*other)) / (most * scale(last));
                let value = theta[*other] + factor * theta[last];
                let (a, b) = (name(*other), name(last));
                let sign = if factor < 0.0 { '-' } else { '+' };
                let text = match (factor.abs() - 1.0).abs() < WHOLE {
                    true => format!("{a} {sign} {b}"),
                    false => format!("{a} {sign} {:.4}*{b}", factor.abs()),
                };
                (text, value, carried(*other, 1.0, factor))
            })
            .collect();
    }
    Vec::new()
}
