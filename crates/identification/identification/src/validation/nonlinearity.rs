//! Tests whether a nonlinear or time-varying model would explain the error of a linear, constant model: tests of the simulated error by Lagrange
//! multipliers (Billings and Voon, *Int. J. Control* 44, 1986).
//!
//! The error is whitened, and regressed on the derivatives of the linear model, extended by two poles and several zeros: no linear model near this
//! one explains the rest. This is compared with the gain from driving the fitted dynamics by one of these terms, or from adding the term to their
//! output:
//! ```text
//! c1 max(u - w1, 0) + c2 max(u - w2, 0)      a curve of the input: dead zone, saturation, a gain that changes with the input
//! c u |u|                                    a square law, as a thruster's
//! c play(u; w), c play(y; w)                 backlash of input and output
//! c1 max(y - w1, 0) + c2 max(y - w2, 0)      a curve of the output: limit of a sensor or a stroke
//! c y |y|, c sign(dy)                        drag, dry friction
//! c1 u [t > t1] + c2 u [t > t2]              a gain that changes in time
//! c1 [t > t1] + c2 [t > t2] + ...            steps of an input that is not recorded
//! ```
//! The term with the lowest Bayesian criterion counts if it is significant (F test), improves the fit in blocks that were left out, and explains a
//! good part of the simulated error. If no term counts, the whitened error is tested for an interval in which it is larger.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::batch::squares_left;
use crate::estimators::{Estimate, dot, impulse, through_poles, whitened, whitening};
use crate::static_curve::StaticCurve;
use crate::structure::range;
use crate::validation::identifiability::{Following, following};
use planesman_record::{LONGEST_PAST, Run, filter};

/// Maximum number of samples tested, at the end of a record.
const TESTED: usize = 4000;
/// Number of poles and zeros added to the linear model, and of samples by which its delay may shrink.
const MORE_POLES: usize = 2;
const MORE_ZEROS: usize = 4;
const LESS_DELAY: i64 = 2;
/// Number of breakpoints tried for a curve, and of widths tried for a backlash.
const BENDS: usize = 19;
const WIDTHS: usize = 12;
/// Number of times at which the gain may change.
const GAIN_TIMES: usize = 19;
/// Number of times at which an unrecorded input may step, minimum number of samples between two steps, and maximum number of steps.
const STEP_TIMES: usize = 199;
const BETWEEN_STEPS: usize = 5;
const STEPS: usize = 12;
/// A term is significant if its F, times its number of columns, is above this value: a sum of two squares exceeds it by chance in 3e-7 of all cases,
/// and about 600 terms are tried.
const SIGNIFICANT: f64 = 30.0;
/// The required F of each further step.
const NEXT_STEP: f64 = 30.0;
/// Minimum share of the squared simulated error that a term must explain. In linear plants with coloured noise, and in loops, significant terms
/// except steps explained at most 0.04 (111 records whose fit was below the noise).
const MATTERS: f64 = 0.1;
/// The minimum share for steps; it is higher, because a random force also contains apparent steps.
const STEPS_MATTER: f64 = 0.25;
/// Number of lags of the difference equation that a term must improve, number of lags of the term, and the required F.
const PREDICTED_FROM: usize = 11;
const TERM_LAGS: usize = 2;
const PREDICTS: f64 = 10.0;
/// Minimum share of the squared whitened error that a larger linear model must leave.
const NOT_LINEAR: f64 = 0.5;
/// Number of blocks in the cross-validation, and number of blocks in which a term must help.
const BLOCKS: usize = 5;
const HELPED: usize = 4;
/// Minimum number of samples per column.
const SAMPLES_PER_COLUMN: usize = 4;
/// Maximum remaining share of a column that other columns explain, and the determinant of correlations below which columns count as alike.
const NOTHING: f64 = 1e-5;
const ALIKE: f64 = 1e-6;
/// A slope below this share of the largest counts as 0; slopes that differ by less than the second value count as equal.
const FLAT: f64 = 0.25;
const SAME: f64 = 0.35;
/// Number of parts of the run, of which one or several in a row may have a larger error: required factor, required number of standard deviations, and
/// maximum share of the run.
const PARTS: usize = 20;
const LARGER: f64 = 4.0;
const SURELY: f64 = 6.0;
const A_WHILE: usize = PARTS / 3;

/// The cause of a linear model's error. Breakpoints are in the signal's unit, times are samples of the run.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// A static curve of the input, before the dynamics.
    Input(StaticCurve),
    /// A static curve of the output, after the dynamics.
    Output(StaticCurve),
    /// Damping that grows with the square of the output.
    Drag,
    /// Damping that does not grow with the output's rate.
    Friction,
    /// The gain changes at each of these times; each factor is relative to the gain before the first.
    Gain(Vec<(usize, f64)>),
    /// An unrecorded input steps at these times.
    Steps(Vec<usize>),
    /// An unrecorded input oscillates, rad per sample.
    Oscillation(f64),
    /// The error is larger by this factor between two times.
    While(usize, usize, f64),
}

impl Cause {
    /// Whether the cause is an unrecorded input, and not the plant.
    #[must_use]
    pub const fn is_disturbance(&self) -> bool {
        matches!(
            self,
            Self::Steps(_) | Self::Oscillation(_) | Self::While(..)
        )
    }
}

/// A cause and its significance.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is.
    pub cause: Cause,
    /// The share of the squared simulated error that the cause explains, 0 to 1, and F; `None` for [`Cause::While`] and [`Cause::Oscillation`].
    pub gain: Option<(f64, f64)>,
}

/// A term added to the linear model.
struct Term {
    /// The indices of the term's columns.
    columns: Vec<usize>,
    kind: Kind,
}

/// The kind of a term, with its breakpoints or times.
#[derive(Clone)]
enum Kind {
    Input(Vec<f64>),
    Output(Vec<f64>),
    Gain(Vec<usize>),
    Steps(Vec<usize>),
    Other(Cause),
}

/// The cause of a run's simulated error; `None` if linear dynamics and stationary noise explain the error, or the run is too short. For a long run
/// only the end is tested, because the fit is evaluated there.
pub(crate) fn finding(estimate: &Estimate, number: usize, run: Run<'_>) -> Option<Finding> {
    let unknown = estimate.layout.structure.unknown(run.past.len());
    let count = run.outputs.len();
    let first = unknown.max(count.saturating_sub(TESTED)).min(count);
    // Of what is before these, free motion is left, which is no cause.
    let skipped = first.saturating_sub(TESTED);
    let past = match skipped {
        0 => run.past,
        _ => &run.inputs[skipped.saturating_sub(LONGEST_PAST)..skipped],
    };
    let tested = Tested {
        estimate,
        number,
        run: Run {
            past,
            inputs: &run.inputs[skipped..],
            outputs: &run.outputs[skipped..],
        },
        simulated: estimate.simulate(number, run).split_off(skipped),
        first: first - skipped,
    };
    let mut found = tested.finding()?;
    match &mut found.cause {
        Cause::Steps(times) => times.iter_mut().for_each(|time| *time += skipped),
        Cause::Gain(times) => times.iter_mut().for_each(|(time, _)| *time += skipped),
        Cause::While(from, to, _) => {
            *from += skipped;
            *to += skipped;
        }
        _ => {}
    }
    Some(found)
}

/// A run whose error is tested from sample `first` on.
struct Tested<'a> {
    estimate: &'a Estimate,
    number: usize,
    run: Run<'a>,
    simulated: Vec<f64>,
    first: usize,
}

impl Tested<'_> {
    fn finding(&self) -> Option<Finding> {
        let pairs = self.run.outputs.iter().zip(&self.simulated);
        let errors: Vec<f64> = pairs.map(|(y, x)| y - x).skip(self.first).collect();
        let linear = self.linear();
        let (columns, mut terms) = self.terms();
        let enough = SAMPLES_PER_COLUMN * (linear.len() + STEPS);
        if errors.len() < enough || !errors.iter().any(|e| *e != 0.0) {
            return None;
        }
        // As they are, and through the filter that whitens the error.
        let plain = Left::of(&errors, &linear, &columns);
        let d = whitening([errors.as_slice()].into_iter());
        let white = |it: &Vec<f64>| whitened(&d, it);
        let all_white = |of: &[Vec<f64>]| of.iter().map(white).collect::<Vec<_>>();
        let left = Left::of(&white(&errors), &all_white(&linear), &all_white(&columns));
        if left.squares() < NOT_LINEAR * left.before {
            return None;
        }
        terms.extend(steps(&terms, &left));
        let freedom = left.error.len() as f64 - linear.len() as f64;
        let criterion = |term: &Term| {
            let (_, squares) = left.with(&term.columns, 0..0)?;
            let parameters = term.columns.len() as f64;
            Some(
                freedom * libm::log(squares.max(f64::MIN_POSITIVE))
                    + parameters * libm::log(freedom),
            )
        };
        let best = (terms
            .iter()
            .filter_map(|term| Some((criterion(term)?, term))))
        .min_by(|p, q| p.0.total_cmp(&q.0));
        let found = best.and_then(|(_, term)| {
            let f = left.f(&term.columns, freedom)?;
            let (_, squares) = plain.with(&term.columns, 0..0)?;
            let share = 1.0 - squares / plain.squares();
            // A step in a block is not known from the others.
            let is_steps = matches!(term.kind, Kind::Steps(_));
            let matters = if is_steps { STEPS_MATTER } else { MATTERS };
            let counts = f * term.columns.len() as f64 > SIGNIFICANT
                && share > matters
                && (is_steps || left.helped(&term.columns) >= HELPED);
            let in_loop = || following(&self.run) == Following::Yes;
            let cause = self.cause(term, &columns).filter(|_| counts)?;
            if in_loop() && !self.predicts(term, &columns) {
                return None;
            }
            Some(Finding {
                cause,
                gain: Some((share, f)),
            })
        });
        found.or_else(|| {
            let (from, to, times) = left.larger_for_a_while()?;
            let begin = self.first + d.len() - 1;
            Some(Finding {
                cause: Cause::While(begin + from, begin + to, times),
                gain: None,
            })
        })
    }

    /// Whether a term improves the prediction of the output by a difference equation in both signals. In a closed loop the simulated error correlates
    /// with the input, but prediction errors do not.
    fn predicts(&self, term: &Term, columns: &[Vec<f64>]) -> bool {
        let past = |signal: &[f64], from: usize| -> Vec<Vec<f64>> {
            let lags = from..PREDICTED_FROM;
            lags.map(|by| self.delayed(signal, by as i64)).collect()
        };
        let later = |column: &Vec<f64>| -> Vec<Vec<f64>> {
            let begins = |by: usize| std::iter::repeat_n(0.0, by);
            let at = |by: usize| begins(by).chain(column.iter().copied()).take(column.len());
            (0..TERM_LAGS).map(|by| at(by).collect()).collect()
        };
        let linear = [
            vec![vec![1.0; columns[0].len()]],
            past(self.run.outputs, 1),
            past(self.run.inputs, 0),
        ]
        .concat();
        let terms = (term.columns.iter()).flat_map(|it| later(&columns[*it]));
        let all: Vec<Vec<f64>> = linear.iter().cloned().chain(terms).collect();
        let outputs = &self.run.outputs[self.first..];
        let left = |columns: &[Vec<f64>]| squares_left(columns, outputs);
        let Some((linear_left, with)) = left(&linear).zip(left(&all)) else {
            return false;
        };
        let more = (all.len() - linear.len()) as f64;
        let freedom = outputs.len() as f64 - all.len() as f64;
        (linear_left - with) / more > PREDICTS * with / freedom
    }

    fn a(&self) -> Vec<f64> {
        let theta = self.estimate.theta.as_slice();
        self.estimate.layout.denominator(theta)
    }

    fn through_poles(&self, signal: &[f64]) -> Vec<f64> {
        through_poles(&self.a(), signal)
    }

    /// A signal of the run, delayed by this many samples, at the tested samples.
    fn delayed(&self, signal: &[f64], by: i64) -> Vec<f64> {
        let at = |k: usize| signal.get(usize::try_from(k as i64 - by).ok()?).copied();
        let samples = self.first..self.run.outputs.len();
        samples.map(|k| at(k).unwrap_or_default()).collect()
    }

    /// Columns that a larger linear model may add.
    fn linear(&self) -> Vec<Vec<f64>> {
        [self.at_rest(), self.slopes()].concat()
    }

    /// A constant, and columns of free motions.
    fn at_rest(&self) -> Vec<Vec<f64>> {
        let count = self.run.outputs.len();
        let free = self.through_poles(&impulse(self.first, count));
        let motions = self.estimate.layout.structure.poles + MORE_POLES;
        let motions = (0..motions).map(|by| self.delayed(&free, by as i64));
        std::iter::once(vec![1.0; count - self.first])
            .chain(motions)
            .collect()
    }

    /// The derivatives of a linear model larger than the fitted one.
    fn slopes(&self) -> Vec<Vec<f64>> {
        let s = &self.estimate.layout.structure;
        let offset = self.estimate.offset(self.number);
        let moved: Vec<f64> = self.simulated.iter().map(|y| y - offset).collect();
        let by_input = self.through_poles(&self.estimate.driving(self.run));
        let by_pole = self.through_poles(&moved);
        let zeros = -LESS_DELAY..(s.numerator + MORE_ZEROS) as i64;
        let poles = 1..=(s.poles + MORE_POLES) as i64;
        let zeros = zeros.map(|by| self.delayed(&by_input, by));
        zeros
            .chain(poles.map(|by| self.delayed(&by_pole, by)))
            .collect()
    }

    /// The response of the fitted dynamics to the input after a curve.
    fn in_front(&self, curve: impl FnOnce(&[f64]) -> Vec<f64>) -> Vec<f64> {
        let layout = &self.estimate.layout;
        let b = &self.estimate.theta.as_slice()[layout.b(self.number)];
        let all = curve(&[self.run.past, self.run.inputs].concat());
        let (past, inputs) = all.split_at(self.run.past.len());
        let driving = layout.structure.driving(past, inputs);
        filter(b, &[1.0], &self.through_poles(&driving)).split_off(self.first)
    }

    /// The columns of all terms, and the terms themselves.
    fn terms(&self) -> (Vec<Vec<f64>>, Vec<Term>) {
        let (inputs, outputs) = (
            &self.run.inputs[self.first..],
            &self.simulated[self.first..],
        );
        let past = self.run.past.len();
        let times = |count: usize| -> Vec<usize> {
            (1..=count)
                .map(|i| self.first + i * inputs.len() / (count + 1))
                .collect()
        };
        let since = |start: usize, of: &dyn Fn(f64) -> f64| {
            self.in_front(|u| {
                let from = (past + start).min(u.len());
                let later = u[from..].iter().map(|u| of(*u));
                std::iter::repeat_n(0.0, from).chain(later).collect()
            })
        };
        let mut columns = Vec::new();
        let mut terms = Vec::new();
        let levels_of_input = levels(inputs);
        let above = |level: f64| move |it: &f64| (it - level).max(0.0);
        let of_input = |level: &f64| self.in_front(|u| u.iter().map(above(*level)).collect());
        let of_output = |level: &f64| outputs.iter().map(above(*level)).collect();
        let of_gain = |time: &usize| since(*time, &|u| u);
        let levels_of_output = levels(outputs);
        in_pairs(
            &mut columns,
            &mut terms,
            &levels_of_input,
            of_input,
            Kind::Input,
        );
        in_pairs(
            &mut columns,
            &mut terms,
            &levels_of_output,
            of_output,
            Kind::Output,
        );
        in_pairs(
            &mut columns,
            &mut terms,
            &times(GAIN_TIMES),
            of_gain,
            Kind::Gain,
        );
        let mut alone = |column: Vec<f64>, kind: Kind| {
            terms.push(Term {
                columns: vec![columns.len()],
                kind,
            });
            columns.push(column);
        };
        for time in times(STEP_TIMES.min(inputs.len() / BETWEEN_STEPS)) {
            alone(since(time, &|_| 1.0), Kind::Steps(vec![time]));
        }
        let square = |it: &f64| it * it.abs();
        let squared = self.in_front(|u| u.iter().map(square).collect());
        alone(
            squared,
            Kind::Other(Cause::Input(StaticCurve::Square { linear: None })),
        );
        let play = |width| StaticCurve::Backlash { width };
        for i in 1..=WIDTHS {
            let width = |signal: &[f64]| range(signal) * i as f64 / (WIDTHS + 2) as f64;
            let (front, behind) = (width(inputs), width(outputs));
            let played = self.in_front(|u| play(front).of(u));
            alone(played, Kind::Other(Cause::Input(play(front))));
            let played = play(behind).of(outputs);
            alone(played, Kind::Other(Cause::Output(play(behind))));
        }
        let damped = |force: Vec<f64>| self.delayed(&self.through_poles(&force), 1);
        let drag = damped(self.simulated.iter().map(square).collect());
        alone(drag, Kind::Other(Cause::Drag));
        let rates = self.simulated.windows(2).map(|y| (y[1] - y[0]).signum());
        alone(damped(rates.collect()), Kind::Other(Cause::Friction));
        (columns, terms)
    }

    /// What a term says. A curve's shape is estimated from the output.
    fn cause(&self, term: &Term, columns: &[Vec<f64>]) -> Option<Cause> {
        let slopes = |straight: Vec<f64>| {
            let own = term.columns.iter().map(|it| columns[*it].clone());
            let parts: Vec<Vec<f64>> = std::iter::once(straight).chain(own).collect();
            let left = Left::of(&self.run.outputs[self.first..], &self.at_rest(), &parts);
            let all: Vec<usize> = (0..parts.len()).collect();
            let (changes, _) = left.with(&all, 0..0)?;
            let slopes = changes.iter().scan(0.0, |slope, change| {
                *slope += change;
                Some(*slope)
            });
            Some(slopes.collect::<Vec<f64>>())
        };
        let input = || self.in_front(<[f64]>::to_vec);
        Some(match &term.kind {
            // Less damping at a larger output than a linear model has is that of dry friction.
            Kind::Other(Cause::Drag) => {
                let own = [columns[term.columns[0]].clone()];
                let left = Left::of(&self.run.outputs[self.first..], &self.linear(), &own);
                let (coefficients, _) = left.with(&[0], 0..0)?;
                match coefficients[0] < 0.0 {
                    true => Cause::Drag,
                    false => Cause::Friction,
                }
            }
            Kind::Other(cause) => cause.clone(),
            Kind::Steps(times) => {
                let mut times = times.clone();
                times.sort_unstable();
                Cause::Steps(times)
            }
            Kind::Gain(times) => {
                let slopes = slopes(input())?;
                let times = times.iter().zip(&slopes[1..]);
                Cause::Gain(times.map(|(time, it)| (*time, it / slopes[0])).collect())
            }
            Kind::Input(levels) => Cause::Input(curve_of(levels, &slopes(input())?)),
            Kind::Output(levels) => {
                let straight = self.simulated[self.first..].to_vec();
                Cause::Output(curve_of(levels, &slopes(straight)?))
            }
        })
    }
}

/// Terms with each place alone, and with each pair of places.
fn in_pairs<T: Clone>(
    columns: &mut Vec<Vec<f64>>,
    terms: &mut Vec<Term>,
    places: &[T],
    column: impl Fn(&T) -> Vec<f64>,
    kind: fn(Vec<T>) -> Kind,
) {
    let from = columns.len();
    columns.extend(places.iter().map(column));
    for (i, one) in places.iter().enumerate() {
        terms.push(Term {
            columns: vec![from + i],
            kind: kind(vec![one.clone()]),
        });
        for (j, other) in places.iter().enumerate().skip(i + 1) {
            terms.push(Term {
                columns: vec![from + i, from + j],
                kind: kind(vec![one.clone(), other.clone()]),
            });
        }
    }
}

/// Successive steps; each explains the most of the remaining error.
fn steps(terms: &[Term], left: &Left) -> Vec<Term> {
    let each: Vec<(usize, usize)> = (terms.iter())
        .filter_map(|term| match &term.kind {
            Kind::Steps(times) => Some((term.columns[0], times[0])),
            _ => None,
        })
        .collect();
    let (mut columns, mut times) = (Vec::new(), Vec::new());
    let mut found = Vec::new();
    let mut rest = Left {
        before: left.before,
        error: left.error.clone(),
        columns: each.iter().map(|it| left.columns[it.0].clone()).collect(),
    };
    while columns.len() < STEPS {
        let f = |at: usize| Some((at, rest.f(&[at], rest.error.len() as f64)?));
        let best = (0..each.len())
            .filter_map(f)
            .max_by(|p, q| p.1.total_cmp(&q.1));
        let Some((at, _)) = best.filter(|it| it.1 > NEXT_STEP) else {
            break;
        };
        columns.push(each[at].0);
        times.push(each[at].1);
        found.push(Term {
            columns: columns.clone(),
            kind: Kind::Steps(times.clone()),
        });
        rest = Left::of(&rest.error, &[rest.columns[at].clone()], &rest.columns);
    }
    found
}

/// A curve from its breakpoints, and the slopes below, between and above them.
fn curve_of(levels: &[f64], slopes: &[f64]) -> StaticCurve {
    let size = |largest: f64, it: &f64| {
        if it.abs() > largest.abs() {
            *it
        } else {
            largest
        }
    };
    let largest = slopes.iter().fold(0.0, size);
    let slopes: Vec<f64> = slopes.iter().map(|it| it / largest).collect();
    let flat = |slope: f64| slope.abs() < FLAT;
    let same = |one: f64, other: f64| (one - other).abs() < SAME;
    let dead_zone = |lower, upper| StaticCurve::DeadZone { lower, upper };
    let limits = |lower, upper| StaticCurve::Saturation { lower, upper };
    let bent = |slopes| StaticCurve::Piecewise {
        levels: levels.to_vec(),
        slopes,
    };
    match (levels, &slopes[..]) {
        ([level], [below, _]) if flat(*below) => limits(Some(*level), None),
        ([level], [_, above]) if flat(*above) => limits(None, Some(*level)),
        ([low, high], [below, between, above]) => {
            match (flat(*below), flat(*between), flat(*above)) {
                (false, true, false) => dead_zone(*low, *high),
                (true, false, true) => limits(Some(*low), Some(*high)),
                (true, false, false) if same(*between, *above) => limits(Some(*low), None),
                (false, false, true) if same(*between, *below) => limits(None, Some(*high)),
                _ => bent(slopes),
            }
        }
        _ => bent(slopes),
    }
}

/// The remaining error and columns, after the part explained by a linear model has been removed.
struct Left {
    /// The squared error before.
    before: f64,
    error: Vec<f64>,
    /// Columns that the linear model explains are empty.
    columns: Vec<Vec<f64>>,
}

impl Left {
    fn of(error: &[f64], linear: &[Vec<f64>], columns: &[Vec<f64>]) -> Self {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in linear {
            if let Some(mut left) = beside(&basis, column) {
                let size = dot(&left, &left).sqrt();
                left.iter_mut().for_each(|it| *it /= size);
                basis.push(left);
            }
        }
        let columns = columns.iter().map(|it| beside(&basis, it));
        Self {
            before: dot(error, error),
            columns: columns.map(Option::unwrap_or_default).collect(),
            error: without(&basis, error),
        }
    }

    fn squares(&self) -> f64 {
        dot(&self.error, &self.error)
    }

    /// Coefficients of the columns from all samples except `left_out`, and the remaining squared error; `None` if the samples do not determine them.
    fn with(&self, columns: &[usize], left_out: Range<usize>) -> Option<(Vec<f64>, f64)> {
        let columns: Vec<&[f64]> = columns.iter().map(|it| &self.columns[*it][..]).collect();
        if columns.iter().any(|it| it.is_empty()) {
            return None;
        }
        let (end, first) = (left_out.start, left_out.end);
        let product =
            |p: &[f64], q: &[f64]| dot(&p[..end], &q[..end]) + dot(&p[first..], &q[first..]);
        let count = columns.len();
        let products = DMatrix::from_fn(count, count, |i, j| product(columns[i], columns[j]));
        let by_error = DVector::from_fn(count, |i, _| product(columns[i], &self.error));
        let sizes = products.diagonal().map(f64::sqrt);
        let alike = DMatrix::from_fn(count, count, |i, j| {
            products[(i, j)] / (sizes[i] * sizes[j])
        });
        // No number where a column is 0 on the samples.
        if alike.determinant().is_nan() || alike.determinant() < ALIKE {
            return None;
        }
        let coefficients = products.cholesky()?.solve(&by_error);
        let left = product(&self.error, &self.error) - coefficients.dot(&by_error);
        Some((coefficients.iter().copied().collect(), left))
    }

    /// The F statistic of columns, with this many degrees of freedom without these columns.
    fn f(&self, columns: &[usize], freedom: f64) -> Option<f64> {
        let (_, squares) = self.with(columns, 0..0)?;
        let parameters = columns.len() as f64;
        let gained = (self.squares() - squares) / parameters;
        Some(gained * (freedom - parameters) / squares.max(f64::MIN_POSITIVE))
    }

    /// Number of blocks in which the columns help, with coefficients from the other blocks.
    fn helped(&self, columns: &[usize]) -> usize {
        let edge = |block: usize| block * self.error.len() / BLOCKS;
        let helps = |block: &usize| {
            let own = edge(*block)..edge(block + 1);
            let Some((c, _)) = self.with(columns, own.clone()) else {
                return false;
            };
            let gained = own.map(|k| {
                let pairs = columns.iter().zip(&c);
                let term: f64 = pairs.map(|(it, c)| c * self.columns[*it][k]).sum();
                self.error[k].powi(2) - (self.error[k] - term).powi(2)
            });
            gained.sum::<f64>() > 0.0
        };
        (0..BLOCKS).filter(helps).count()
    }

    /// The samples between which the squared error is much larger than elsewhere, and the factor; the scatter of the squared errors determines the
    /// significance.
    fn larger_for_a_while(&self) -> Option<(usize, usize, f64)> {
        let count = self.error.len();
        let edge = |part: usize| part * count / PARTS;
        let mean = |power: i32, of: &dyn Fn(usize) -> bool| {
            let samples = (0..count).filter(|k| of(*k));
            let (sum, count) = samples.fold((0.0, 0.0), |(sum, count), k| {
                (sum + self.error[k].powi(power), count + 1.0)
            });
            (sum / count, count)
        };
        let windows =
            (0..PARTS).flat_map(|from| (1..=A_WHILE).map(move |long| (from, from + long)));
        let judged = windows.filter(|(_, to)| *to <= PARTS).map(|(from, to)| {
            let samples = edge(from)..edge(to);
            let (inside, few) = mean(2, &|k| samples.contains(&k));
            let (outside, _) = mean(2, &|k| !samples.contains(&k));
            let (fourth, _) = mean(4, &|k| samples.contains(&k));
            let deviation = ((fourth - inside * inside).max(0.0) / few).sqrt();
            ((inside - outside) / deviation, samples, inside / outside)
        });
        judged
            .filter(|(sure, _, times)| *sure > SURELY && *times > LARGER)
            .max_by(|p, q| p.0.total_cmp(&q.0))
            .map(|(_, samples, times)| (samples.start, samples.end, times.sqrt()))
    }
}

/// The part of a signal that an orthonormal basis does not explain.
fn without(basis: &[Vec<f64>], signal: &[f64]) -> Vec<f64> {
    let mut left = signal.to_vec();
    // Twice, against rounding.
    for direction in basis.iter().chain(basis) {
        let part = dot(direction, &left);
        for (left, it) in left.iter_mut().zip(direction) {
            *left -= part * it;
        }
    }
    left
}

/// The part of a signal that the basis does not explain; `None` if nothing remains.
fn beside(basis: &[Vec<f64>], signal: &[f64]) -> Option<Vec<f64>> {
    let left = without(basis, signal);
    let is_left = dot(&left, &left) > NOTHING * NOTHING * dot(signal, signal);
    is_left.then_some(left)
}

/// Values that divide the samples into parts of equal size.
fn levels(signal: &[f64]) -> Vec<f64> {
    let mut sorted = signal.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |i: usize| sorted.get(i * sorted.len() / (BENDS + 1)).copied();
    let mut levels: Vec<f64> = (1..=BENDS).filter_map(at).collect();
    levels.dedup();
    levels
}
