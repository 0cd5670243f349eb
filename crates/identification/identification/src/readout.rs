//! The current estimate of a recursion as a [`Model`]: the whole transfer function, including known factors, and its covariance.
//!
//! A recursion's unknowns enter linearly:
//! ```text
//! a = D (1, a~),  b = q^-delay N b~,  c = q^-delay N c~,  bias = D(1) constant
//! ```
//! except for a constant on the output, for which `bias = A(1) offset`. The vehicle's equations are sampled under zero-order hold
//! ([`Filter::sampled`]).

use nalgebra::{DMatrix, DVector};

use crate::estimators::UNKNOWNS;
use crate::estimators::kalman::Filter;
use crate::estimators::recursive::{Kind, Recursion};
use crate::model::Model;

/// The names of the unknowns of the vehicle's equations; the gyro's bias last.
pub const PHYSICAL: [&str; UNKNOWNS + 1] = ["K/J", "B/J", "M_theta/J", "bias"];

/// A model and its covariance.
#[derive(Clone, Debug)]
pub struct Readout {
    /// The model.
    pub model: Model,
    /// The covariance of `[a b c bias]`; `None` if unknown.
    pub covariance: Option<DMatrix<f64>>,
}

impl Readout {
    /// The readout of a recursion: with first moments if `moments`, and with its constant if it has one.
    #[must_use]
    pub fn of_recursion(recursion: &Recursion, moments: bool, sample_time: f64) -> Self {
        let rows = recursion.rows();
        let theta = rows.parameters();
        let layout = recursion.layout();
        let structure = &layout.structure;
        let (known_zeros, known_poles) = (&structure.known_numerator, &structure.known_denominator);
        let lead = structure.delay - 1;
        let order = (structure.poles + known_poles.len() - 1)
            .max(lead + structure.numerator + known_zeros.len() - 1);
        let blocks = if moments { 3 } else { 2 };
        let count = blocks * order + usize::from(structure.offset);
        // [a b c bias] = start + slopes theta
        let mut start = DVector::zeros(count);
        for (i, known) in known_poles.iter().skip(1).enumerate() {
            start[i] = *known;
        }
        let mut slopes = DMatrix::zeros(count, theta.len());
        for column in layout.a() {
            for (i, known) in known_poles.iter().enumerate() {
                slopes[(column + i, column)] = *known;
            }
        }
        let first_moment = layout.without_motion();
        for (j, column) in layout.b(0).enumerate() {
            for (i, known) in known_zeros.iter().enumerate() {
                slopes[(order + lead + j + i, column)] = *known;
                if moments {
                    slopes[(2 * order + lead + j + i, first_moment + j)] = *known;
                }
            }
        }
        if let Some(column) = layout.offset(0) {
            slopes[(count - 1, column)] = known_poles.iter().sum();
        }
        let mut all = &start + &slopes * &theta;
        if let (Kind::OutputError, Some(column)) = (recursion.kind(), layout.offset(0)) {
            let by_a = slopes.rows(0, order).row_sum();
            let steady = 1.0 + all.rows(0, order).sum();
            all[count - 1] = steady * theta[column];
            slopes.row_mut(count - 1).copy_from(&(by_a * theta[column]));
            slopes[(count - 1, column)] = steady;
        }
        let covariance = rows
            .noise_variance()
            .map(|variance| &slopes * rows.unit_covariance() * slopes.transpose() * variance);
        let model = model(
            all.as_slice(),
            order,
            moments,
            structure.offset,
            sample_time,
        );
        Self { model, covariance }
    }

    /// The readout of the vehicle's equations, with the gyro's bias as constant.
    #[must_use]
    pub fn of_vehicle(filter: &Filter, sample_time: f64) -> Self {
        let (found, known) = filter.learnt();
        let (coefficients, by) = filter.sampled();
        let (order, last) = (coefficients.len() / 2, found.len() - 1);
        // [a b bias], bias = A(1) times the gyro's.
        let steady = 1.0 + coefficients.rows(0, order).sum();
        let all = coefficients.push(steady * found[last]);
        let mut slopes = DMatrix::zeros(all.len(), found.len());
        slopes.view_mut((0, 0), by.shape()).copy_from(&by);
        let by_a = by.rows(0, order).row_sum() * found[last];
        slopes
            .view_mut((2 * order, 0), by_a.shape())
            .copy_from(&by_a);
        slopes[(2 * order, last)] = steady;
        Self {
            model: model(all.as_slice(), order, false, true, sample_time),
            covariance: Some(&slopes * known * slopes.transpose()),
        }
    }
}

/// `[a b c bias]` by their names.
fn model(all: &[f64], order: usize, moments: bool, bias: bool, sample_time: f64) -> Model {
    let block = |i: usize| all[i * order..(i + 1) * order].to_vec();
    Model {
        sample_time,
        a: block(0),
        feedthrough: 0.0,
        b: block(1),
        c: if moments { block(2) } else { Vec::new() },
        bias: all.last().copied().filter(|_| bias).unwrap_or(0.0),
    }
}
