//! The output error over parts of records, by its normal equations.
//!
//! ```text
//! e = D (y - (B/A) u - (M/A) impulse - offset),   psi = -de/dtheta
//! (psi'psi + mu diag(psi'psi)) step = psi'e       summed over the parts that count
//! ```
//! The columns of `psi` are shifts of four signals, so `psi'psi` needs only their correlations: entries along a diagonal differ only by
//! terms at the ends. Nothing as large as the record is stored. `D = 1 + d1 q^-1 + ...` whitens the residual: with noise `v = e/D`, the minimum is
//! the minimum of a Box-Jenkins model with autoregressive noise (Ljung 1999, sec. 4.2 and 10.2).

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::coloured::whitening;
use super::levenberg_marquardt::{Trial, descend};
use super::rows::impulse;
use super::stability::held_within;
use super::sums::dot;
use crate::structure::{Layout, Problem};
use planesman_record::filter;

/// Maximum number of dampings tried within one step.
const TRIALS: usize = 12;

/// A part of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// The record's number.
    pub(crate) run: usize,
    /// Its samples.
    pub(crate) samples: Range<usize>,
}

/// Settings of a search for the smallest error.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Maximum number of steps.
    pub steps: usize,
    /// The search ends when a step lowers the cost by less than this share.
    pub enough: f64,
    /// The largest magnitude of a pole; infinite for models without poles.
    pub radius: f64,
}

/// The signals of a record, whitened.
pub(super) struct Signals {
    pub(super) driving: Vec<f64>,
    pub(super) outputs: Vec<f64>,
    pub(super) constant: Vec<f64>,
    pub(super) impulse: Vec<f64>,
    /// Number of first samples to ignore: their input is not known, or their whitened residual needs earlier values.
    pub(super) lead: usize,
}

impl Signals {
    /// The signals of each record of a problem, filtered by `1, d1, ..., dk`.
    pub(super) fn of(problem: &Problem<'_>, whitening: &[f64]) -> Vec<Self> {
        let through = |values: &[f64]| filter(whitening, &[1.0], values);
        let pairs = problem.runs.iter().zip(problem.driving());
        pairs
            .map(|(run, driving)| {
                let (count, unknown) =
                    (run.outputs.len(), problem.structure.unknown(run.past.len()));
                Self {
                    driving: through(&driving),
                    outputs: through(run.outputs),
                    constant: through(&vec![1.0; count]),
                    impulse: through(&impulse(unknown, count)),
                    lead: (unknown + whitening.len() - 1).min(count),
                }
            })
            .collect()
    }
}

/// The records, prepared for evaluation with any parameters.
pub(crate) struct NormalEquations {
    layout: Layout,
    signals: Vec<Signals>,
}

/// The normal equations of one part: `psi'psi`, `psi'e` and `e'e`, in the order a, b, offset, free motion of its record.
#[derive(Clone)]
struct Normal {
    run: usize,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    cost: f64,
}

/// The normal equations of several parts, in the order of theta.
#[derive(Debug)]
pub struct Total {
    /// `psi'psi`.
    pub information: DMatrix<f64>,
    /// `psi'e`.
    pub gradient: DVector<f64>,
    /// `e'e`.
    pub cost: f64,
}

impl NormalEquations {
    /// The records of a problem, with the residual whitened by `1, d1, ..., dk`; `[1]` for no whitening.
    pub(crate) fn new(problem: &Problem<'_>, whitening: &[f64]) -> Self {
        Self {
            layout: problem.layout(),
            signals: Signals::of(problem, whitening),
        }
    }

    /// Treats every record as one part.
    pub(crate) fn whole(&self) -> Vec<Part> {
        let parts = self.signals.iter().enumerate();
        parts
            .map(|(run, of)| Part {
                run,
                samples: 0..of.outputs.len(),
            })
            .collect()
    }

    /// The places of a record's parameters in theta, in the order a, b, offset, motion.
    fn places(&self, run: usize) -> Vec<usize> {
        let layout = &self.layout;
        (layout.a().chain(layout.b(run)))
            .chain(layout.offset(run))
            .chain(layout.motion(run))
            .collect()
    }

    /// `e` of a record.
    pub(crate) fn errors(&self, theta: &DVector<f64>, run: usize) -> Vec<f64> {
        let [.., errors] =
            self.gone_through(theta, run, &self.layout.denominator(theta.as_slice()));
        errors
    }

    /// `1, d1, ..., dk` that whiten the errors of all records.
    pub(crate) fn whitening(&self, theta: &DVector<f64>) -> Vec<f64> {
        let errors = |run: usize| self.errors(theta, run).split_off(self.signals[run].lead);
        let errors: Vec<Vec<f64>> = (0..self.signals.len()).map(errors).collect();
        whitening(errors.iter().map(Vec::as_slice))
    }

    /// The signals of a record at `theta`: `u/A`, `impulse/A`, `(B/A) u + (M/A) impulse`, and `e`.
    fn gone_through(&self, theta: &DVector<f64>, run: usize, a: &[f64]) -> [Vec<f64>; 4] {
        let of = &self.signals[run];
        let count = of.outputs.len();
        let by_input = through_poles(a, &of.driving);
        let motion = &theta.as_slice()[self.layout.motion(run)];
        let by_impulse = match motion {
            [] => Vec::new(),
            _ => through_poles(a, &of.impulse),
        };
        let b = &theta.as_slice()[self.layout.b(run)];
        let x = shifted_sum(count, [(b, &by_input), (motion, &by_impulse)]);
        let offset = self.layout.offset(run).map_or(0.0, |at| theta[at]);
        let pairs = x.iter().zip(&of.outputs).zip(&of.constant);
        let errors = pairs.map(|((x, y), one)| y - x - offset * one).collect();
        [by_input, by_impulse, x, errors]
    }

    fn normals(&self, theta: &DVector<f64>, parts: &[Part]) -> Vec<Normal> {
        let a = self.layout.denominator(theta.as_slice());
        let mut normals = Vec::with_capacity(parts.len());
        for (run, of) in self.signals.iter().enumerate() {
            if parts.iter().all(|part| part.run != run) {
                continue;
            }
            let [by_input, by_impulse, x, errors] = self.gone_through(theta, run, &a);
            let layout = &self.layout;
            let mut by_pole = through_poles(&a, &x);
            by_pole.iter_mut().for_each(|value| *value = -*value);
            let mut families = vec![
                (by_pole.as_slice(), 1..layout.structure.poles + 1),
                (&by_input, 0..layout.structure.numerator),
                (&of.constant, 0..usize::from(layout.offset(run).is_some())),
                (&by_impulse, 0..layout.motion(run).len()),
            ];
            families.retain(|(_, shifts)| !shifts.is_empty());
            for part in parts.iter().filter(|part| part.run == run) {
                let samples =
                    part.samples.start.max(of.lead).min(part.samples.end)..part.samples.end;
                let count: usize = families.iter().map(|(_, shifts)| shifts.len()).sum();
                let mut gradient = DVector::zeros(count);
                let mut at = 0;
                for (signal, shifts) in &families {
                    for shift in shifts.clone() {
                        gradient[at] = correlation(signal, shift, &errors, 0, &samples);
                        at += 1;
                    }
                }
                normals.push(Normal {
                    run,
                    information: information(&families, count, &samples),
                    gradient,
                    cost: correlation(&errors, 0, &errors, 0, &samples),
                });
            }
        }
        normals
    }

    /// The normal equations over parts at `theta`; `None` if a number is not finite.
    pub(crate) fn total(&self, theta: &DVector<f64>, parts: &[Part]) -> Option<Total> {
        let normals = self.normals(theta, parts);
        let mut total = Total {
            information: DMatrix::zeros(theta.len(), theta.len()),
            gradient: DVector::zeros(theta.len()),
            cost: 0.0,
        };
        for normal in &normals {
            let places = self.places(normal.run);
            for (i, row) in places.iter().enumerate() {
                total.gradient[*row] += normal.gradient[i];
                for (j, column) in places.iter().enumerate() {
                    total.information[(*row, *column)] += normal.information[(i, j)];
                }
            }
            total.cost += normal.cost;
        }
        let finite = total.cost.is_finite() && total.information.iter().all(|v| v.is_finite());
        finite.then_some(total)
    }

    /// With given poles, computes all other parameters, which enter linearly, by least squares over the parts.
    pub(crate) fn completed(&self, a: &[f64], parts: &[Part]) -> Option<DVector<f64>> {
        let (n, count) = (a.len(), self.layout.count());
        let mut theta = DVector::zeros(count);
        theta.rows_mut(0, n).copy_from_slice(a);
        // The second time mends what the first rounded.
        for _ in 0..2 {
            let at = self.total(&theta, parts)?;
            let linear = at.information.view((n, n), (count - n, count - n));
            let step = damped(
                &linear.into_owned(),
                &at.gradient.rows(n, count - n).into_owned(),
                1e-13,
            )?;
            let mut rest = theta.rows_mut(n, count - n);
            rest += step;
        }
        Some(theta)
    }

    /// Minimises the error over the parts, from `start`; returns the parameters and the sum of squares.
    pub(crate) fn minimised(
        &self,
        start: DVector<f64>,
        parts: &[Part],
        search: Search,
    ) -> Option<(DVector<f64>, f64)> {
        let n = self.layout.structure.poles;
        let within = |there: DVector<f64>| match held_within(&there.as_slice()[..n], search.radius)?
        {
            None => Some(there),
            Some(a) => self.completed(&a, parts),
        };
        least(start, search, &|theta| self.total(theta, parts), &within)
    }
}

/// Minimises the error by its normal equations, from `start`, with each step limited by `within`; returns the parameters and the sum of
/// squares. `None` if the error at `start` is not defined.
pub fn least(
    start: DVector<f64>,
    search: Search,
    total: &dyn Fn(&DVector<f64>) -> Option<Total>,
    within: &dyn Fn(DVector<f64>) -> Option<DVector<f64>>,
) -> Option<(DVector<f64>, f64)> {
    let here = total(&start)?;
    let trial = |theta: &DVector<f64>, here: &Total, damping| {
        let lower = || {
            let there = within(theta + damped(&here.information, &here.gradient, damping)?)?;
            let found = total(&there)?;
            (found.cost < here.cost).then_some(Trial::Lower(there, found))
        };
        Ok(lower().unwrap_or(Trial::NotLower))
    };
    let settled = |here: &Total, next: &Total| here.cost - next.cost <= search.enough * here.cost;
    let (theta, here) = descend((start, here), (search.steps, TRIALS), trial, settled).ok()?;
    Some((theta, here.cost))
}

/// The first `count` samples of the sum of signals filtered by numerators: each signal is shifted by one sample per coefficient.
pub(crate) fn shifted_sum(count: usize, of: [(&[f64], &Vec<f64>); 2]) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    for (numerator, signal) in of {
        for (shift, coefficient) in numerator.iter().enumerate() {
            let delayed = sum.get_mut(shift..).unwrap_or_default();
            for (sum, value) in delayed.iter_mut().zip(signal) {
                *sum += coefficient * value;
            }
        }
    }
    sum
}

/// `signal / A` from rest, in the transposed form, in which the sums of one sample are independent of each other.
pub(crate) fn through_poles(a: &[f64], signal: &[f64]) -> Vec<f64> {
    let mut state = vec![0.0; a.len()];
    let order = a.len() - 1;
    signal
        .iter()
        .map(|value| {
            let y = value + state[0];
            for i in 0..order {
                state[i] = state[i + 1] - a[i + 1] * y;
            }
            y
        })
        .collect()
}

/// `psi'psi` of signals and their shifts.
pub(crate) fn information(
    families: &[(&[f64], Range<usize>)],
    count: usize,
    samples: &Range<usize>,
) -> DMatrix<f64> {
    let mut information = DMatrix::zeros(count, count);
    let value =
        |signal: &[f64], at: usize, shift: usize| at.checked_sub(shift).map_or(0.0, |k| signal[k]);
    let mut row = 0;
    for (i, (f, rows)) in families.iter().enumerate() {
        let mut column = row;
        for (g, columns) in &families[i..] {
            for (r, s) in rows.clone().enumerate() {
                for (c, t) in columns.clone().enumerate() {
                    let entry = if r == 0 || c == 0 {
                        correlation(f, s, g, t, samples)
                    } else {
                        // sum f(k-s) g(k-t) is the one before, a sample earlier.
                        let before: f64 = information[(row + r - 1, column + c - 1)];
                        let (first, end) = (samples.start, samples.end);
                        let gained = match first.checked_sub(1) {
                            Some(k) => value(f, k, s - 1) * value(g, k, t - 1),
                            None => 0.0,
                        };
                        let lost = match end.checked_sub(1) {
                            Some(k) => value(f, k, s - 1) * value(g, k, t - 1),
                            None => 0.0,
                        };
                        before + gained - lost
                    };
                    information[(row + r, column + c)] = entry;
                }
            }
            column += columns.len();
        }
        row += rows.len();
    }
    information.fill_lower_triangle_with_upper_triangle();
    information
}

/// `sum f(k-s) g(k-t)` over samples k, with zeros before the first.
pub(crate) fn correlation(f: &[f64], s: usize, g: &[f64], t: usize, samples: &Range<usize>) -> f64 {
    let first = samples.start.max(s).max(t);
    if first >= samples.end {
        return 0.0;
    }
    dot(
        &f[first - s..samples.end - s],
        &g[first - t..samples.end - t],
    )
}

/// The step `(H + mu diag H)^-1 g`; `None` if that matrix is not positive definite.
pub(crate) fn damped(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let scales: Vec<f64> = (0..gradient.len())
        .map(|i| information[(i, i)].max(0.0).sqrt())
        .map(|scale| if scale > 0.0 { scale } else { 1.0 })
        .collect();
    let scaled = DMatrix::from_fn(scales.len(), scales.len(), |i, j| {
        let more = if i == j { damping.max(1e-14) } else { 0.0 };
        information[(i, j)] / (scales[i] * scales[j]) + more
    });
    let right = DVector::from_fn(scales.len(), |i, _| gradient[i] / scales[i]);
    let step = Cholesky::new(scaled)?.solve(&right);
    let step = DVector::from_fn(scales.len(), |i, _| step[i] / scales[i]);
    step.iter().all(|v| v.is_finite()).then_some(step)
}
