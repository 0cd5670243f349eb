//! What an estimator has learnt, as [`crate::model::Model`] has it: the whole transfer function, with what
//! was known of it beforehand, and its covariance.
//!
//! A recursion's unknowns enter linearly:
//! ```text
//! a = D (1, a~),  b = q^-delay N b~,  c = q^-delay N c~,  bias = D(1) constant
//! ```
//! but for a constant that stands on the output, `bias = A(1) offset`. The vehicle's equations are sampled with
//! the input held; their slopes are central differences.

use nalgebra::{DMatrix, DVector};
use planesman_linear::StateSpace;

use crate::estimators::kalman::Filter;
use crate::estimators::recursive::{Kind, Recursion};
use crate::estimators::vehicle::{UNKNOWNS, Vehicle};
use crate::model::Model;

/// The step of central differences, as a share of a value.
const NUDGE: f64 = 1e-5;

/// What the unknowns of the vehicle's equations are called; the gyro's bias last.
pub const PHYSICAL: [&str; UNKNOWNS + 1] = ["K/J", "B/J", "M_theta/J", "bias"];

/// A model, and how sure it is.
#[derive(Clone, Debug)]
pub struct Readout {
    /// The model.
    pub model: Model,
    /// The covariance of `[a b c bias]`; `None` while it cannot be told.
    pub covariance: Option<DMatrix<f64>>,
}

impl Readout {
    /// Of a recursion: with its first moments, if `moments`, and its constant, if it has one.
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

    /// Of the vehicle's equations, with the gyro's bias as constant.
    ///
    /// # Errors
    /// A sentence, when the equations cannot be sampled.
    pub fn of_vehicle(filter: &Filter, sample_time: f64) -> Result<Self, String> {
        let vehicle = filter.vehicle();
        let (found, known) = filter.learnt();
        let at = |unknowns: &DVector<f64>| sampled(vehicle, unknowns, sample_time);
        let all = at(&found)?;
        let mut slopes = DMatrix::zeros(all.len(), found.len());
        for column in 0..found.len() {
            let by = NUDGE * found[column].abs().max(1e-2);
            let moved = |by: f64| {
                let mut unknowns = found.clone();
                unknowns[column] += by;
                at(&unknowns)
            };
            let slope = (moved(by)? - moved(-by)?) / (2.0 * by);
            slopes.set_column(column, &slope);
        }
        let order = (all.len() - 1) / 2;
        Ok(Self {
            model: model(all.as_slice(), order, false, true, sample_time),
            covariance: Some(&slopes * known * slopes.transpose()),
        })
    }
}

/// `[a b c bias]` by their names.
fn model(all: &[f64], order: usize, moments: bool, bias: bool, sample_time: f64) -> Model {
    let block = |i: usize| all[i * order..(i + 1) * order].to_vec();
    Model {
        sample_time,
        a: block(0),
        b: block(1),
        c: if moments { block(2) } else { Vec::new() },
        bias: all.last().copied().filter(|_| bias).unwrap_or(0.0),
    }
}

/// `[a b bias]` of the vehicle with `kappa, beta, mu, bias`.
fn sampled(
    vehicle: Vehicle,
    unknowns: &DVector<f64>,
    sample_time: f64,
) -> Result<DVector<f64>, String> {
    let (a, b) = vehicle.equations([unknowns[0], unknowns[1], unknowns[2]]);
    let n = vehicle.states();
    let mut rate = DMatrix::zeros(1, n);
    rate[(0, 0)] = 1.0;
    let b = DMatrix::from_column_slice(n, 1, b.as_slice());
    let transfer = StateSpace::new(a, b, rate, DMatrix::zeros(1, 1))
        .and_then(|continuous| continuous.zero_order_hold(sample_time))
        .and_then(|held| held.transfer_function(0, 0))
        .map_err(|reason| format!("the vehicle's equations cannot be sampled: {reason}"))?;
    let lead = transfer.den[0];
    let mut all = DVector::zeros(2 * n + 1);
    for (i, coefficient) in transfer.den.iter().skip(1).enumerate() {
        all[i] = coefficient / lead;
    }
    // The last powers belong together; nothing comes through at once.
    for (i, coefficient) in transfer.num.iter().rev().take(n).enumerate() {
        all[2 * n - 1 - i] = coefficient / lead;
    }
    all[2 * n] = (1.0 + all.rows(0, n).sum()) * unknowns[UNKNOWNS];
    Ok(all)
}
