//! Identifiability: whether the record determines all parameters.
//!
//! Three reasons why it may not, each reported with its numbers: an input that excites too few directions
//! (one sinusoid excites two, Ljung 1999, sec. 13.2); an input that is feedback and nothing
//! else (`u = -K y` makes rows of the regression depend on each other); rows that depend on each
//! other for whatever reason, as those of too high an order on a clean record.

use nalgebra::{DMatrix, DVector};

use crate::batch::Triangle;
use crate::estimators::regression;
use crate::structure::{InitialState, Problem};
use planesman_record::Run;

/// An input counts as exciting a direction when its singular value is above this share of the
/// largest; noise of a thousandth of the input's size excites nothing.
const EXCITED: f64 = 1e-3;
/// The share of the input that feedback leaves unexplained when it is feedback alone.
const UNEXPLAINED: f64 = 1e-6;
/// A regression whose singular values, columns scaled alike, spread wider than this leaves directions
/// to rounding and the smallest noise.
const SPREAD: f64 = 1e-8;

/// A reason to distrust any model from the records.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// The input's order of persistent excitation, and the parameters sought.
    Excitation(usize, usize),
    /// A record whose input is feedback, counted from 1, where there are several; the share of the input's power that is not.
    FeedbackAlone(Option<usize>, f64),
    /// Parameters determined, of so many, and the ratio of the singular values.
    Rank(usize, usize, f64),
}

/// Reasons to distrust any model from these records.
#[must_use]
pub fn doubts(problem: &Problem<'_>) -> Vec<Doubt> {
    let structure = &problem.structure;
    let needed = structure.poles + structure.numerator;
    let of = |problem: &Problem<'_>| {
        let mut doubts = of_inputs(problem, needed);
        doubts.extend(of_rows(problem));
        doubts
    };
    let doubts = of(problem);
    let is_feedback = |doubt: &Doubt| matches!(doubt, Doubt::FeedbackAlone(..));
    let is_moving = structure.start == InitialState::Estimated;
    if is_moving || doubts.is_empty() || doubts.iter().any(is_feedback) {
        return doubts;
    }
    // Of a record from rest the samples before it are known.
    let before = structure.history().max(needed);
    let longer = |values: &[f64], rest: f64| [vec![rest; before], values.to_vec()].concat();
    let longer: Vec<_> = (problem.runs.iter())
        .map(|run| {
            let rest = run.outputs.first().copied().unwrap_or_default();
            (longer(run.inputs, 0.0), longer(run.outputs, rest))
        })
        .collect();
    let runs = longer.iter().zip(&problem.runs);
    of(&Problem {
        runs: runs
            .map(|((inputs, outputs), run)| Run {
                inputs,
                outputs,
                ..*run
            })
            .collect(),
        ..problem.clone()
    })
}

/// Those that the inputs give, when so many parameters are sought.
#[must_use]
pub fn of_inputs(problem: &Problem<'_>, needed: usize) -> Vec<Doubt> {
    let history = problem.structure.history();
    let is_one = problem.runs.len() == 1;
    let mut doubts = Vec::new();
    for (r, run) in problem.runs.iter().enumerate() {
        let order = excitation_order(run.inputs, needed);
        if order < needed && is_one {
            doubts.push(Doubt::Excitation(order, needed));
        }
        let unexplained = feedback_leaves(run.inputs, run.outputs, history);
        if let Some(unexplained) = unexplained.filter(|share| *share < UNEXPLAINED) {
            let record = (!is_one).then_some(r + 1);
            doubts.push(Doubt::FeedbackAlone(record, unexplained));
        }
    }
    doubts
}

/// That the rows of the regression depend on each other.
fn of_rows(problem: &Problem<'_>) -> Option<Doubt> {
    let (mut phi, _) = regression(problem);
    for mut column in phi.column_iter_mut() {
        let size = column.norm();
        if size > 0.0 {
            column /= size;
        }
    }
    if phi.nrows() < phi.ncols() {
        return None;
    }
    let singular = singular_values(&phi);
    let (least, largest) = (singular.min(), singular.max());
    let known = singular.iter().filter(|s| **s > SPREAD * largest).count();
    (least <= SPREAD * largest).then(|| Doubt::Rank(known, phi.ncols(), least / largest))
}

/// Those of the triangle, for the matrix may be long; none of one with numbers that are not finite.
fn singular_values(matrix: &DMatrix<f64>) -> DVector<f64> {
    let nothing = DVector::zeros(matrix.nrows());
    let triangle = Triangle::new(matrix, &nothing);
    triangle.map_or_else(
        |_| DVector::zeros(matrix.ncols()),
        |it| it.singular_values(),
    )
}

/// Of how many samples' past the input is independent: its order of excitation, up to `most`.
#[must_use]
pub fn excitation_order(inputs: &[f64], most: usize) -> usize {
    if inputs.len() < 2 * most || most == 0 {
        return 0;
    }
    let rows = inputs.len() - most + 1;
    let past = DMatrix::from_fn(rows, most, |i, j| inputs[i + j]);
    let singular = singular_values(&past);
    let largest = singular.max();
    if largest == 0.0 {
        return 0;
    }
    singular.iter().filter(|s| **s > EXCITED * largest).count()
}

/// The share of the input's sum of squares that a linear feedback from `history` past outputs, itself
/// and inputs leaves unexplained; `None` when the record is too short or the input stands still.
fn feedback_leaves(inputs: &[f64], outputs: &[f64], history: usize) -> Option<f64> {
    // An input between two levels changes to the other one: a clean output knows which it was.
    let (least, largest) = (inputs.iter()).fold((f64::MAX, f64::MIN), |(least, largest), u| {
        (u.min(least), u.max(largest))
    });
    if inputs.iter().all(|u| *u == least || *u == largest) {
        return None;
    }
    let n = history.max(1);
    let rows = inputs.len().checked_sub(n)?;
    if rows < 4 * (2 * n + 1) {
        return None;
    }
    // u_k from y_k ... y_(k-n) and u_(k-1) ... u_(k-n): a controller's difference equation. Only
    // samples at which the input changes count; a held one is explained by itself.
    let kept: Vec<usize> = (n..inputs.len())
        .filter(|k| inputs[*k] != inputs[k - 1])
        .collect();
    if kept.len() < 2 * n + 4 {
        return None;
    }
    let phi = DMatrix::from_fn(kept.len(), n + 1, |i, j| outputs[kept[i] - j]);
    let u = DVector::from_fn(kept.len(), |i, _| inputs[kept[i]]);
    let total = u.norm_squared();
    let left = Triangle::new(&phi, &u).ok()?.cost;
    (total > 0.0).then_some(left / total)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::common::{clean, measured, next, pulses};
    use crate::structure::Structure;
    use planesman_record::with_noise;

    fn doubts_of(structure: Structure, inputs: &[f64], outputs: &[f64]) -> Vec<Doubt> {
        doubts(
            &Problem::new(
                structure,
                0.05,
                vec![Run {
                    inputs,
                    outputs,
                    ..Run::default()
                }],
            )
            .unwrap(),
        )
    }

    #[test]
    fn pulses_excite_enough_and_a_sinusoid_two_directions() {
        assert!(doubts_of(Structure::of_order(3), &pulses(), &measured(1, 0.005, 0.0)).is_empty());
        let sine: Vec<f64> = (0..220)
            .map(|k| libm::sin(f64::from(k) * PI / 8.0))
            .collect();
        assert_eq!(excitation_order(&sine, 6), 2);
        assert_eq!(excitation_order(&[0.0; 50], 6), 0);
        assert_eq!(excitation_order(&[0.2; 50], 6), 1);
    }

    #[test]
    fn feedback_without_a_reference_is_named() {
        let mut outputs = vec![0.05, 0.04, 0.02];
        let mut inputs: Vec<f64> = outputs.iter().map(|y| -y).collect();
        while outputs.len() < 200 {
            outputs.push(next(&inputs, &outputs));
            inputs.push(-outputs[outputs.len() - 1]);
        }
        let found = doubts_of(Structure::of_order(3).without_offset(), &inputs, &outputs);
        let is_feedback = |doubt: &Doubt| matches!(doubt, Doubt::FeedbackAlone(None, _));
        assert!(found.iter().any(is_feedback), "{found:?}");
        let lacks = |doubt: &Doubt| matches!(doubt, Doubt::Rank(_, 6, _));
        assert!(found.iter().any(lacks), "{found:?}");
    }

    #[test]
    fn feedback_with_a_reference_is_not() {
        let (mut inputs, mut outputs): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
        for r in pulses() {
            outputs.push(next(&inputs, &outputs));
            inputs.push(r - outputs[outputs.len() - 1]);
        }
        let outputs = with_noise(&outputs, 3, 0.005);
        let found = doubts_of(Structure::of_order(2), &inputs, &outputs);
        assert!(found.is_empty(), "{found:?}");
    }

    #[test]
    fn too_high_an_order_on_a_clean_record_is_found_out() {
        let found = doubts_of(Structure::of_order(4).without_offset(), &pulses(), &clean());
        let lacks_one = |doubt: &Doubt| matches!(doubt, Doubt::Rank(7, 8, _));
        assert!(found.iter().any(lacks_one), "{found:?}");
    }
}
