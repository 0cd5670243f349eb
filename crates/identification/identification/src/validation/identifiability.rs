//! Identifiability: whether the record determines all parameters.
//!
//! Three reasons are reported, each with its numbers. First, an input that excites too few directions (one sinusoid excites two, Ljung 1999, sec.
//! 13.2). Second, an input that is only feedback (`u = -K y` makes rows of the regression linearly dependent). Third, rows that are linearly
//! dependent for another reason, such as too high an order for a noise-free record.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::batch::{Triangle, regressed};
use crate::estimators::regression;
use crate::structure::{InitialState, Problem, extremes, variance};
use planesman_record::Run;

/// An input excites a direction if the singular value is above this share of the largest one; noise of a thousandth of the input's size excites
/// nothing.
const EXCITED: f64 = 1e-3;
/// Maximum share of the input's power that a controller leaves unexplained, if neither plant nor loop is disturbed.
const UNEXPLAINED: f64 = 1e-12;
/// Maximum share of the input's innovations that the output leaves unexplained if the input is only feedback: for quantised signals; and, for an
/// input that acts against the output, with sensor noise that is only in the log.
const FED: f64 = 0.05;
const FED_AGAINST: f64 = 0.15;
/// Disturbances count as moving the output if its past leaves at least this share of its power unexplained.
const RENEWED: f64 = 0.05;
/// An input whose past leaves at most this share of its power unexplained is a sum of sines or a smooth curve.
const DETERMINED: f64 = 1e-9;
/// F statistic above which the input counts as following the outputs; by chance it is exceeded once in 20 000 tests.
const FOLLOWS: f64 = 8.0;
const HALF: f64 = 0.5;
/// Above this unexplained share of its power, the output counts as noisy.
const DISTURBED: f64 = 1e-5;
/// Number of lags of both signals in the regressions that detect disturbances.
const LAGS: usize = 20;
/// Lags of a controller.
const CONTROLLER_LAGS: usize = 3;
/// Minimum number of samples for each lag, and maximum number of samples used.
const SAMPLES_PER_LAG: usize = 12;
const SAMPLES: usize = 4000;
/// If the singular values of a regression with equally scaled columns spread more than this, some directions contain only rounding error and the
/// smallest noise; if what the regression leaves of the output is smaller, by this factor, than the least singular value, that value is no noise.
const SPREAD: f64 = 1e-8;
const ABOVE_NOISE: f64 = 30.0;
const ROUNDING: f64 = 1e-12;

/// A reason to distrust any model from the records.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// The input's order of persistent excitation, and the number of estimated parameters.
    Excitation(usize, usize),
    /// Number (from 1) of the record whose input is feedback, if there are several; and the share of the input's power that is not feedback.
    FeedbackAlone(Option<usize>, f64),
    /// Number of determined parameters, number of all parameters, and the ratio of the singular values.
    Rank(usize, usize, f64),
}

/// Reasons to distrust any model from these records.
#[must_use]
pub fn doubts(problem: &Problem<'_>) -> Vec<Doubt> {
    let structure = &problem.structure;
    let needed = structure.poles + structure.numerator;
    let of = |problem: &Problem<'_>| {
        let deficient = of_rows(problem);
        let mut doubts = of_inputs(problem, needed, deficient.is_some());
        doubts.extend(deficient);
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

/// Doubts because of the inputs, for this many parameters and rows that may be rank-deficient.
#[must_use]
pub fn of_inputs(problem: &Problem<'_>, needed: usize, is_deficient: bool) -> Vec<Doubt> {
    let is_one = problem.runs.len() == 1;
    let mut doubts = Vec::new();
    for (r, run) in problem.runs.iter().enumerate() {
        let order = excitation_order(run.inputs, needed);
        if order < needed && is_one {
            doubts.push(Doubt::Excitation(order, needed));
        }
        let pasts = Pasts::new(run.inputs, run.outputs).filter(Pasts::may_be_fed);
        let feedback = pasts.and_then(|it| it.feedback());
        if let Some(feedback) = feedback.filter(|it| it.is_alone(is_deficient)) {
            let record = (!is_one).then_some(r + 1);
            doubts.push(Doubt::FeedbackAlone(record, feedback.unexplained));
        }
    }
    doubts
}

/// Doubt because the rows of the regression are linearly dependent.
fn of_rows(problem: &Problem<'_>) -> Option<Doubt> {
    let (mut phi, outputs) = regression(problem);
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
    if least > SPREAD * largest {
        return None;
    }
    let size = outputs.norm();
    let left = phi
        .clone()
        .svd(true, true)
        .solve(&outputs, f64::MIN_POSITIVE);
    let noise = left.map_or(f64::INFINITY, |theta| {
        (&outputs - &phi * theta).norm() / size
    });
    let spread = (ABOVE_NOISE * noise).clamp(ROUNDING, SPREAD);
    let known = singular.iter().filter(|s| **s > spread * largest).count();
    (least <= spread * largest).then(|| Doubt::Rank(known, phi.ncols(), least / largest))
}

/// Singular values of the triangular factor, since the matrix may be long; empty if it contains a number that is not finite.
fn singular_values(matrix: &DMatrix<f64>) -> DVector<f64> {
    let nothing = DVector::zeros(matrix.nrows());
    let triangle = Triangle::new(matrix, &nothing);
    triangle.map_or_else(
        |_| DVector::zeros(matrix.ncols()),
        |it| it.singular_values(),
    )
}

/// The input's order of persistent excitation, up to `most`: number of past samples of which it is linearly independent.
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

/// Regressions of each signal on the past of both.
struct Pasts<'a> {
    inputs: &'a [f64],
    outputs: &'a [f64],
    /// Number of lags for which the record has enough samples.
    lags: usize,
}

impl<'a> Pasts<'a> {
    /// `None` for a record that is too short.
    fn new(inputs: &'a [f64], outputs: &'a [f64]) -> Option<Self> {
        let from = inputs.len().saturating_sub(SAMPLES);
        let (inputs, outputs) = (&inputs[from..], &outputs[from..]);
        let lags = LAGS.min(inputs.len() / SAMPLES_PER_LAG);
        (lags >= CONTROLLER_LAGS).then_some(Self {
            inputs,
            outputs,
            lags,
        })
    }

    /// Whether the input may come from a controller with a noisy output: the input has more than two values and is not held.
    fn may_be_fed(&self) -> bool {
        let inputs = self.inputs;
        let (least, largest) = extremes(inputs);
        let has_two_levels = inputs.iter().all(|u| *u == least || *u == largest);
        let moves = inputs.windows(2).filter(|u| u[0] != u[1]).count();
        !has_two_levels && 2 * moves >= inputs.len()
    }

    /// Regression of a signal on a constant and both signals at these lags, for all samples at which all lags are known; optionally only for samples
    /// at which the input moves (`moves`).
    fn regressed(
        &self,
        of: &[f64],
        of_inputs: Range<usize>,
        of_outputs: Range<usize>,
        moves: bool,
    ) -> Option<Regressed> {
        let rows: Vec<usize> = (self.lags..of.len())
            .filter(|k| !moves || self.inputs[*k] != self.inputs[k - 1])
            .collect();
        let at = |signal: &[f64], lag: usize| rows.iter().map(|k| signal[k - lag]).collect();
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; rows.len()]];
        columns.extend(of_inputs.map(|lag| at(self.inputs, lag)));
        let outputs = columns.len();
        columns.extend(of_outputs.map(|lag| at(self.outputs, lag)));
        let of: Vec<f64> = at(of, 0);
        let power = variance(&of) * of.len() as f64;
        let found = regressed(&columns, &of)?;
        let theta = found.solution().ok();
        let sum = |from: usize, to: usize| {
            let theta = theta
                .as_ref()
                .map(|it| it.as_slice()[from..to].iter().sum());
            theta.unwrap_or_default()
        };
        (power > 0.0).then(|| Regressed {
            left: found.cost.max(0.0) / power,
            by_inputs: sum(1, outputs),
            by_outputs: sum(outputs, columns.len()),
        })
    }

    /// The unexplained share of the regression of a signal.
    fn left(
        &self,
        of: &[f64],
        of_inputs: Range<usize>,
        of_outputs: Range<usize>,
        moves: bool,
    ) -> Option<f64> {
        let found = self.regressed(of, of_inputs, of_outputs, moves)?;
        Some(found.left)
    }

    /// The input regressed on its own past and the outputs up to now, and the output regressed on both pasts.
    fn both(&self) -> Option<Both> {
        let own = 1..self.lags + 1;
        Some(Both {
            input: self.regressed(self.inputs, own.clone(), 0..CONTROLLER_LAGS + 1, false)?,
            output: self.regressed(self.outputs, own.clone(), own, false)?,
        })
    }

    /// Whether the output is constant up to and including the sample at which the input moves first: then the output does not move the input.
    fn input_moves_first(&self) -> bool {
        let first = self.inputs.windows(2).position(|u| u[0] != u[1]);
        let until = first.map_or(0, |it| it + 2);
        until > self.lags && self.outputs[..until].iter().all(|y| *y == self.outputs[0])
    }

    /// The part of the input that a linear controller does not explain, with `u_k` from `y_k ... y_(k-3)` and `u_(k-1) ... u_(k-3)`.
    fn feedback(&self) -> Option<Feedback> {
        let (inputs, lags) = (self.inputs, CONTROLLER_LAGS);
        if self.input_moves_first() {
            return None;
        }
        let own = self.left(inputs, 1..lags + 1, 0..0, true)?;
        let unexplained = self.left(inputs, 1..lags + 1, 0..lags + 1, true)?;
        Some(Feedback {
            unexplained,
            of_innovations: unexplained / own.max(f64::MIN_POSITIVE),
            renewed: self.left(self.outputs, 1..self.lags + 1, 1..self.lags + 1, true)?,
            is_against: self.both().is_some_and(|it| it.is_against()),
        })
    }
}

/// The part of an input that a controller does not explain.
struct Feedback {
    /// The share of the input's power that is unexplained.
    unexplained: f64,
    /// The unexplained share of the input's innovations (the part that its own past does not explain).
    of_innovations: f64,
    /// The share of the output's power that the past of both signals does not explain.
    renewed: f64,
    /// Whether the input acts against the output.
    is_against: bool,
}

/// Results of a regression on both signals.
struct Regressed {
    /// The unexplained share of the power.
    left: f64,
    /// The sums of the coefficients of inputs and of outputs.
    by_inputs: f64,
    by_outputs: f64,
}

/// Regressions of the input and of the output on both signals.
struct Both {
    input: Regressed,
    output: Regressed,
}

impl Both {
    /// Whether the outputs move the input in the opposite direction to the input's own effect, as a controller does. If the input is logged with
    /// noise, or the plant responds at once, both signs are equal.
    fn is_against(&self) -> bool {
        self.input.by_outputs * self.output.by_inputs < 0.0
    }
}

impl Feedback {
    /// Whether only the output moves the input, as pure feedback does. The output also explains a smooth input without noise, but then disturbances move
    /// neither signal; without disturbances the rank of the regression decides.
    fn is_alone(&self, is_deficient: bool) -> bool {
        let most = if self.is_against { FED_AGAINST } else { FED };
        let is_disturbed = self.renewed > RENEWED && self.of_innovations < most;
        is_disturbed || (is_deficient && self.unexplained < UNEXPLAINED)
    }
}

/// Whether the input of a run follows its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Following {
    /// It does not.
    No,
    /// An input with two values, or a held input, only seems to follow: a noise-free output shows how long the input has been constant.
    Seems,
    /// The input follows the output, as in a closed loop.
    Yes,
}

/// Whether the input of a run follows its output: whether outputs predict it beyond its own past (Granger, *Econometrica* 37, 1969).
/// The predicted part must act against the input's own effect. An output of the same instant counts only if it explains less than half of the input's
/// innovation: otherwise the plant may respond at once.
#[must_use]
pub fn following(run: &Run<'_>) -> Following {
    let of = |pasts: Pasts<'_>| {
        let own = 1..pasts.lags + 1;
        let freedom = pasts.inputs.len() as f64 - (2 * pasts.lags + CONTROLLER_LAGS + 2) as f64;
        // A sum of sines or a smooth curve needs no output.
        let by_itself = pasts.left(pasts.inputs, own.clone(), 0..0, false)?;
        if freedom <= 0.0 || by_itself <= DETERMINED {
            return None;
        }
        // A clean output only tells what was before the lags.
        let both = pasts.both()?;
        if both.output.left <= DISTURBED || !both.is_against() {
            return None;
        }
        let f = |left: f64, lags: usize| (by_itself - left) / lags as f64 / (left / freedom);
        let by_earlier = pasts.left(pasts.inputs, own, 1..CONTROLLER_LAGS + 1, false)?;
        let by_all = both.input.left;
        Some(
            f(by_earlier, CONTROLLER_LAGS) > FOLLOWS
                || (f(by_all, CONTROLLER_LAGS + 1) > FOLLOWS && by_all > HALF * by_itself),
        )
    };
    let Some(pasts) = Pasts::new(run.inputs, run.outputs) else {
        return Following::No;
    };
    let may_tell = pasts.may_be_fed();
    match (of(pasts), may_tell) {
        (Some(true), true) => Following::Yes,
        (Some(true), false) => Following::Seems,
        _ => Following::No,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::common::{clean, measured, next, pulses};
    use crate::structure::Structure;
    use planesman_linear::polynomial;
    use planesman_record::{filter, noise, with_noise};

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
    fn feedback_of_a_disturbed_output_is_named_as_it_is_and_rounded() {
        // PI on 2/(3 s + 1) in steps of 0.05 s, AR(0.97) on the output, the setpoint at 0.
        let disturbance = filter(&[0.02], &[1.0, -0.97], &noise(4, 1500));
        let (mut inputs, mut outputs): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
        let (mut state, mut integral) = (0.0, 0.0);
        for d in disturbance {
            outputs.push(state + d);
            integral -= 1.2 * 0.05 * (state + d);
            inputs.push(integral - 2.0 * (state + d));
            state = 0.983_471 * state + 0.033_058 * inputs[inputs.len() - 1];
        }
        let rounded =
            |of: &[f64]| -> Vec<f64> { of.iter().map(|v| (v * 1e3).round() / 1e3).collect() };
        for (inputs, outputs) in [(rounded(&inputs), rounded(&outputs)), (inputs, outputs)] {
            let found = doubts_of(Structure::of_order(1), &inputs, &outputs);
            let is_feedback = |doubt: &Doubt| matches!(doubt, Doubt::FeedbackAlone(None, _));
            assert!(found.iter().any(is_feedback), "{found:?}");
        }
    }

    #[test]
    fn an_input_follows_the_output_in_a_loop_and_neither_levels_nor_sines_do() {
        let (e, moves) = (noise(7, 600), noise(8, 600));
        let reference: Vec<f64> = (0..600).map(|k| moves[k / 40]).collect();
        let (mut inputs, mut outputs, mut state, mut integral) = (vec![], vec![], 0.0, 0.0);
        for (r, e) in reference.iter().zip(&e) {
            outputs.push(state + 0.15 * e);
            integral += 0.12 * (r - outputs[outputs.len() - 1]);
            inputs.push(integral + 2.0 * (r - outputs[outputs.len() - 1]));
            state = 0.967_216 * state + 0.065_568 * inputs[inputs.len() - 1];
        }
        let open = with_noise(&filter(&[0.0, 0.07], &[1.0, -0.97], &moves), 9, 0.05);
        let sines: Vec<f64> = (0..600).map(|k| libm::sin(0.1 * f64::from(k))).collect();
        for (inputs, outputs, expected) in [
            (&inputs, &outputs, Following::Yes),
            (&moves, &open, Following::No),
            (&sines, &e, Following::No),
            // Levels that are held.
            (&reference, &e, Following::No),
        ] {
            let run = Run {
                inputs,
                outputs,
                ..Run::default()
            };
            assert_eq!(following(&run), expected);
        }
    }

    #[test]
    fn a_smooth_input_in_open_loop_is_no_feedback_though_a_clean_output_makes_it_up() {
        let smooth = |k: i32| {
            let x = (f64::from(k) / 200.0 - 0.2).clamp(0.0, 1.0);
            (3.0 - 2.0 * x) * x * x
        };
        let sines = |k: i32| {
            [0.03, 0.11, 0.23, 0.41]
                .map(|rate| libm::sin(rate * f64::from(k)))
                .iter()
                .sum()
        };
        let is_feedback = |doubt: &Doubt| matches!(doubt, Doubt::FeedbackAlone(..));
        for inputs in [
            (0..300).map(smooth).collect::<Vec<f64>>(),
            (0..300).map(sines).collect(),
        ] {
            let outputs = filter(&[0.0, 0.03], &[1.0, -0.97], &inputs);
            let found = doubts_of(Structure::of_order(1), &inputs, &outputs);
            assert!(!found.iter().any(is_feedback), "{found:?}");
            for (b, a) in [(vec![0.0, 0.03], vec![1.0, -0.97]), (vec![2.0], vec![1.0])] {
                let outputs = filter(&b, &a, &inputs);
                assert!(
                    !Pasts::new(&inputs, &outputs)
                        .and_then(|it| it.feedback())
                        .is_some_and(|it| it.is_alone(false)),
                    "{b:?}"
                );
            }
        }
    }

    #[test]
    fn a_smooth_input_with_twelve_digits_determines_two_resonances() {
        // The least singular value is 2e-9 of the largest, and what the digits leave of the output is 5e-12.
        let inputs: Vec<f64> = (0..500)
            .map(|k| {
                let x = ((f64::from(k) - 50.0) / 300.0).clamp(0.0, 1.0);
                x.powi(4) * (35.0 - 84.0 * x + 70.0 * x.powi(2) - 20.0 * x.powi(3))
            })
            .collect();
        let resonances = polynomial::product(&[1.0, -1.94, 0.98], &[1.0, -1.84, 0.94]);
        let outputs = filter(&[0.0, 0.02, -0.01, 0.015, -0.005], &resonances, &inputs);
        let digits = |of: &[f64]| -> Vec<f64> {
            let each = of.iter().map(|it| format!("{it:.11e}").parse().unwrap());
            each.collect()
        };
        let structure = Structure::of_order(4).without_offset();
        let found = doubts_of(structure, &digits(&inputs), &digits(&outputs));
        let is_of_rank = |doubt: &Doubt| matches!(doubt, Doubt::Rank(..));
        assert!(!found.iter().any(is_of_rank), "{found:?}");
    }

    #[test]
    fn an_input_that_moves_while_the_output_is_constant_is_not_feedback_alone() {
        // A proportional controller on an integrator: one step of the setpoint, no noise.
        let (mut inputs, mut outputs, mut y) = (vec![], vec![], 0.0);
        for k in 0..300 {
            let setpoint = if k < 60 { 0.0 } else { 1.0 };
            outputs.push(y);
            inputs.push(1.5 * (setpoint - y));
            y += 0.05 * inputs[k];
        }
        let found = doubts_of(Structure::of_order(1), &inputs, &outputs);
        let is_feedback = |doubt: &Doubt| matches!(doubt, Doubt::FeedbackAlone(..));
        assert!(!found.iter().any(is_feedback), "{found:?}");
    }

    #[test]
    fn too_high_an_order_on_a_clean_record_is_found_out() {
        let found = doubts_of(Structure::of_order(4).without_offset(), &pulses(), &clean());
        let lacks_one = |doubt: &Doubt| matches!(doubt, Doubt::Rank(7, 8, _));
        assert!(found.iter().any(lacks_one), "{found:?}");
    }
}
