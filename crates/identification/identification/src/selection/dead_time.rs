//! Finds a dead time beyond the delays that are searched one by one.
//!
//! For each delay an equation of second order, `y(k) = -a1 y(k-1) - a2 y(k-2) + b1 u(k-d) + b2 u(k-d-1)` about the means, is fitted by
//! least squares, all on the same rows.

use std::ops::RangeInclusive;

use nalgebra::{Cholesky, Matrix4, Vector4};

use crate::estimators::dot;
use crate::structure::{Problem, Structure};

/// The longest delay, samples, and its maximum share of the longest record.
pub(crate) const LONGEST: usize = 1000;
const SHARE: usize = 4;
/// Number of samples on both sides of the delay found that are searched.
const ABOUT: usize = 10;
/// Required increase of twice the log-likelihood, compared with a shorter delay.
const BEYOND_DOUBT: f64 = 30.0;
/// Relative ridge on the regressors.
const RIDGE: f64 = 1e-12;

/// The longest delay searched in a record of this many samples.
pub(crate) fn longest(samples: usize) -> usize {
    LONGEST.min(samples / SHARE)
}

/// The delays to search, if one longer than `shorter` fits clearly better.
pub(super) fn beyond(
    problem: &Problem<'_>,
    shorter: &RangeInclusive<usize>,
) -> Option<RangeInclusive<usize>> {
    let samples = problem.runs.iter().map(|run| run.outputs.len()).max()?;
    let most = longest(samples);
    if most <= *shorter.end() {
        return None;
    }
    let plain = Structure {
        delay: 0,
        ..problem.structure.clone()
    };
    let mut outputs = [[0.0; 3]; 3];
    // Of u(k-d): its products with y(k), y(k-1), y(k-2), with itself, and with u(k-d-1).
    let mut inputs = vec![[0.0; 5]; most + 2];
    let mut rows = 0;
    for run in &problem.runs {
        let y = about_mean(run.outputs);
        let driving = plain.driving(&[], &[run.past, run.inputs].concat());
        // The rows are the same for all delays: before what is known the input is taken to have stood.
        let before = driving.first().copied().unwrap_or_default();
        let past = run.past.len().max(most + 1);
        let mut held = vec![before; past - run.past.len()];
        held.extend(driving);
        let u = about_mean(&held);
        let (first, end) = (2, y.len());
        if first >= end {
            continue;
        }
        rows += end - first;
        let output = |lag: usize| &y[first - lag..end - lag];
        let input = |lag: usize| &u[past + first - lag..past + end - lag];
        for (i, row) in outputs.iter_mut().enumerate() {
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += dot(output(i), output(j));
            }
        }
        for (delay, sums) in inputs.iter_mut().enumerate() {
            for (i, sum) in sums[..3].iter_mut().enumerate() {
                *sum += dot(output(i), input(delay));
            }
            sums[3] += dot(input(delay), input(delay));
            if delay <= most {
                sums[4] += dot(input(delay), input(delay + 1));
            }
        }
    }
    let left = |delay: usize| {
        let (one, two) = (&inputs[delay], &inputs[delay + 1]);
        let [[yy, y1, y2], [_, y11, y12], [.., y22]] = outputs;
        let products = Matrix4::new(
            y11, y12, one[1], two[1], y12, y22, one[2], two[2], one[1], one[2], one[3], one[4],
            two[1], two[2], one[4], two[3],
        );
        let right = Vector4::new(y1, y2, one[0], two[0]);
        let scales = products
            .diagonal()
            .map(|it| it.max(f64::MIN_POSITIVE).sqrt());
        let scaled = Matrix4::from_fn(|i, j| {
            let ridge = if i == j { RIDGE } else { 0.0 };
            products[(i, j)] / (scales[i] * scales[j]) + ridge
        });
        let right = right.component_div(&scales);
        let found = Cholesky::new(scaled)?.solve(&right);
        Some((yy - found.dot(&right)).max(f64::MIN_POSITIVE)).filter(|it| it.is_finite())
    };
    let least = |delays: RangeInclusive<usize>| {
        let found = delays.filter_map(|delay| Some((left(delay)?, delay)));
        found.min_by(|p, q| p.0.total_cmp(&q.0))
    };
    let (near, far) = (least(shorter.clone())?, least(shorter.end() + 1..=most)?);
    let is_farther = rows as f64 * libm::log(near.0 / far.0) > BEYOND_DOUBT;
    is_farther
        .then(|| far.1.saturating_sub(ABOUT).max(shorter.end() + 1)..=(far.1 + ABOUT).min(most))
}

fn about_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}
