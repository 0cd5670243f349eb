//! Converts a transfer function in s to a difference equation on the records.

use nalgebra::{DMatrix, DVector};
use planesman_linear::DelayedLoop;
use planesman_record::filter;

use super::super::delayed_transfer::{HeldInputTransfer, Orders, slopes};
use super::super::estimate::{Error, Estimate};
use super::super::frequency_fit::FrequencyFit;
use super::super::rows::{self, impulse};
use crate::batch::Triangle;
use crate::error::Result;
use crate::structure::{Problem, Structure, monic};

/// A simulation beyond this value has no meaning.
const HUGE: f64 = 1e30;

/// A transfer function as a difference equation on records, with the best offset and initial motion.
pub(super) struct Simulated {
    structure: Structure,
    a: Vec<f64>,
    b: Vec<f64>,
    /// Offsets, then motions, in the order of the layout.
    rest: DVector<f64>,
    /// A factor of their covariance for noise of variance 1; empty if nothing is estimated.
    factor: DMatrix<f64>,
    pub(super) left: Vec<Vec<f64>>,
}

impl Simulated {
    pub(super) fn new(
        problem: &Problem<'_>,
        orders: &Orders,
        transfer: &DelayedLoop,
    ) -> Result<Self> {
        let held = HeldInputTransfer::new(transfer, problem.sample_time)?;
        let all = orders.poles + orders.integrators;
        let (structure, a, b) = difference_equation(&problem.structure, orders, &held);
        let of = Problem {
            structure: structure.clone(),
            ..problem.clone()
        };
        let layout = of.layout();
        let first = layout.a().len() + structure.numerator;
        let count = layout.count() - first;
        let den = monic(&a);
        let rows: usize = of.runs.iter().map(|run| run.outputs.len()).sum();
        let mut columns = DMatrix::zeros(rows, count);
        let mut right = DVector::zeros(rows);
        let mut row = 0;
        for (run, (record, driving)) in of.runs.iter().zip(of.driving()).enumerate() {
            let (samples, begins) = (record.outputs.len(), structure.unknown(record.past.len()));
            let caused = filter(&b, &den, &driving);
            for (k, (y, x)) in record.outputs.iter().zip(&caused).enumerate() {
                right[row + k] = if k < begins { 0.0 } else { y - x };
            }
            let mut column = |place: usize, values: &[f64]| {
                for (k, value) in values.iter().enumerate().skip(begins) {
                    columns[(row + k, place - first)] = *value;
                }
            };
            if let Some(place) = layout.offset(run) {
                column(place, &vec![1.0; samples]);
            }
            for (i, place) in layout.motion(run).enumerate() {
                column(place, &filter(&[1.0], &den, &impulse(begins + i, samples)));
            }
            row += samples;
        }
        let (mut rest, mut factor) = (DVector::zeros(count), DMatrix::zeros(count, 0));
        // The simulation of an unstable model says nothing.
        let is_finite = columns.iter().chain(right.iter()).all(|it| it.abs() < HUGE);
        if !is_finite {
            right.fill(0.0);
            columns.fill(0.0);
        } else if count > 0 {
            let sizes: Vec<f64> = (columns.column_iter())
                .map(|it| it.norm().max(f64::MIN_POSITIVE))
                .collect();
            let triangle = Triangle::new(&columns, &right)?.scaled(&sizes).damped(1e-9);
            rest = triangle.solution()?;
            factor = triangle.unit_factor()?;
            for (i, size) in sizes.iter().enumerate() {
                rest[i] /= size;
                factor.row_mut(i).unscale_mut(*size);
            }
        }
        let left = right - &columns * &rest;
        let lengths = of.runs.iter().map(|run| run.outputs.len());
        let left = rows::parts(left.as_slice(), lengths);
        debug_assert_eq!(b.len(), all + 1);
        Ok(Self {
            structure,
            a,
            b,
            rest,
            factor,
            left,
        })
    }
}

/// The difference equation's structure, `a1 ...` without known poles, and `b1 ...`.
fn difference_equation(
    of: &Structure,
    orders: &Orders,
    held: &HeldInputTransfer,
) -> (Structure, Vec<f64>, Vec<f64>) {
    let all = orders.poles + orders.integrators;
    let (mut a, b) = held.difference_equation();
    let mut structure = Structure {
        offset: of.offset,
        start: of.start,
        delay: held.delay(),
        numerator: all + 1,
        ..Structure::of_order(all)
    };
    for _ in 0..orders.integrators {
        structure = structure.with_integrator();
        // A / (1 - q^-1), whose remainder is rounding.
        let mut sum = 1.0;
        for it in &mut a {
            sum += *it;
            *it = sum;
        }
        a.pop();
    }
    structure.poles = orders.poles;
    structure.numerator = all + 1;
    (structure, a, b)
}

/// The estimate with the difference equation; the parameters are scaled by the middle of the band, rad/s.
pub(super) fn sampled(
    problem: &Problem<'_>,
    middle: f64,
    theta: &DVector<f64>,
    covariance: &DMatrix<f64>,
    fit: FrequencyFit,
) -> Result<Estimate> {
    let orders = fit.orders;
    let simulated = Simulated::new(problem, &orders, &fit.transfer)?;
    let coefficients = |theta: &DVector<f64>| {
        let values = theta.component_mul(&orders.scales(middle));
        let mut transfer = orders.transfer(&values).ok()?;
        // The whole samples of the dead time stay: slopes are of the fraction.
        let whole = (simulated.structure.delay - 1) as f64 * problem.sample_time;
        transfer.delay -= whole;
        let held = HeldInputTransfer::new(&transfer, problem.sample_time).ok()?;
        if held.delay() > 1 || transfer.delay < 0.0 {
            return None;
        }
        let (_, a, b) = difference_equation(&problem.structure, &orders, &held);
        Some(DVector::from_vec([a, b].concat()))
    };
    let here = DVector::from_vec([&simulated.a[..], &simulated.b].concat());
    let count = here.len();
    let by = slopes(theta, &here, coefficients);
    let root = root_of(covariance);
    let samples: usize = simulated.left.iter().map(Vec::len).sum();
    let sought = orders.parameters() + simulated.rest.len();
    let freedom = rows::freedom(samples, sought)?;
    let squares: f64 = simulated.left.iter().flatten().map(|e| e * e).sum();
    let variance = squares / freedom;
    let (own, rest) = (by * root, simulated.factor * variance.sqrt());
    let mut factor = DMatrix::zeros(count + rest.nrows(), own.ncols() + rest.ncols());
    factor.view_mut((0, 0), own.shape()).copy_from(&own);
    factor
        .view_mut((count, own.ncols()), rest.shape())
        .copy_from(&rest);
    let all = [&simulated.a[..], &simulated.b, simulated.rest.as_slice()].concat();
    let of = Problem {
        structure: simulated.structure,
        ..problem.clone()
    };
    let (all, left) = (DVector::from_vec(all), simulated.left);
    Ok(Estimate {
        frequency: Some(fit),
        ..Estimate::of(&of, Error::Output, all, factor, variance, left)
    })
}

/// A factor of a covariance whose smallest eigenvalues may be rounding error.
fn root_of(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let sizes = DVector::from_fn(covariance.nrows(), |i, _| {
        covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt()
    });
    let scaled = DMatrix::from_fn(sizes.len(), sizes.len(), |i, j| {
        covariance[(i, j)] / (sizes[i] * sizes[j])
    });
    let eigen = scaled.symmetric_eigen();
    let roots = eigen.eigenvalues.map(|it| it.max(0.0).sqrt());
    DMatrix::from_diagonal(&sizes) * eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}
