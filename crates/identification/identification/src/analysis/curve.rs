//! Static curves before or after linear dynamics: which curves are tried, and which input curve fits best.

use std::collections::BTreeMap;

use crate::error::{IdentificationError, Result};
use crate::estimators::{
    Estimate, Estimator, cost_in_front, in_front, moved_by, of_least_criterion,
};
use crate::selection::criteria::first_part;
use crate::static_curve::{FittedCurve, Side, StaticCurve};
use crate::structure::{Problem, Structure, extremes, range};
use crate::uncertainty::SIGMAS_95;
use crate::validation::nonlinearity::Cause;
use planesman_linear::digits::with_interval;
use planesman_record::Record;

const NOT_DETERMINED: IdentificationError = IdentificationError::Undetermined(
    "the record does not determine this kind of curve, because the input takes too few distinct values",
);
/// A curve is tried if its cause explains at least this share of the squared error.
pub(super) const WORTH_A_TRY: f64 = 0.4;
/// Without evidence for a curve, a curve with approximate breakpoints may leave at most this share of the linear model's squared error.
const MAY_CURE: f64 = 0.7;
/// Breakpoints tried for a curve of unknown position, as quantiles of the samples.
const PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Widths tried for a backlash, as shares of the signal's range.
const WIDTHS: [f64; 4] = [0.05, 0.15, 0.3, 0.5];
/// Number of samples used to choose the kind of a curve: the last ones of the longest segment.
pub(super) const SEARCHED: usize = 1000;
/// An output dwells at a limit if this share of the samples is in the outermost part of its range, and this many times as many as in the next part.
const PARTS_OF_RANGE: f64 = 10.0;
const DWELT: f64 = 0.08;
/// An output counts as clipped if this many consecutive samples are equal, after it moved there by this share of its largest move.
const CLIPPED: usize = 5;
const CLIPPED_FROM: f64 = 0.05;
const MORE_OFTEN: f64 = 2.5;
/// The search begins with this slope next to a slope of 1.
const SLIGHTLY_BENT: f64 = 0.5;
/// A parameter within this number of standard deviations from 0 may be 0.
const SIGNIFICANT: f64 = 1.96;

planesman_wording::choices! {
    /// The static curve to try.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum CurveChoice {
        #[default]
        Automatic = "automatic": "The curve that explains the error of the linear model, if it simulates held-out data better",
        None = "none": "A linear model",
        DeadZone = "dead_zone": "Dead zone of the input, before the dynamics",
        Saturation = "saturation": "Limits of the input",
        Square = "square": "u|u| + c u, as of a thruster",
        Piecewise = "piecewise": "Three straight lines that meet at two input values",
        Backlash = "backlash": "Backlash of the input",
        OutputDeadZone = "output_dead_zone": "Dead zone of the output, after the dynamics",
        OutputSaturation = "output_saturation": "Limits of the output, after the dynamics, such as those of a sensor",
        OutputPiecewise = "output_piecewise": "Three straight lines at the output, after the dynamics",
    }
}

impl CurveChoice {
    /// The curve to try for a cause of the error; `None` if the cause is not a curve.
    pub(super) const fn of(cause: &Cause) -> Option<Self> {
        Some(match cause {
            Cause::Input(StaticCurve::DeadZone { .. }) => Self::DeadZone,
            Cause::Input(StaticCurve::Saturation { .. }) => Self::Saturation,
            Cause::Input(StaticCurve::Square { .. }) => Self::Square,
            Cause::Input(StaticCurve::Piecewise { .. }) => Self::Piecewise,
            Cause::Input(StaticCurve::Backlash { .. }) => Self::Backlash,
            Cause::Output(StaticCurve::DeadZone { .. }) => Self::OutputDeadZone,
            Cause::Output(StaticCurve::Saturation { .. }) => Self::OutputSaturation,
            Cause::Output(StaticCurve::Piecewise { .. }) => Self::OutputPiecewise,
            _ => return None,
        })
    }

    /// Whether the curve belongs to the input or the output.
    pub(super) const fn side(self) -> Side {
        match self {
            Self::OutputDeadZone | Self::OutputSaturation | Self::OutputPiecewise => Side::Output,
            _ => Side::Input,
        }
    }

    /// Initial curves with breakpoints among the signal's values; empty if the signal has too few values, or no curve is named.
    pub(super) fn starts(self, signal: &[f64]) -> Vec<StaticCurve> {
        let mut sorted = signal.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: &f64| {
            let place = (share * sorted.len() as f64) as usize;
            sorted.get(place).copied()
        };
        let levels: Vec<f64> = PLACES.iter().filter_map(at).collect();
        let places = levels.iter().enumerate();
        let pairs = places.flat_map(|(i, low)| levels[i + 1..].iter().map(|high| (*low, *high)));
        let pairs = pairs.filter(|(low, high)| low < high);
        match self {
            Self::Automatic | Self::None => Vec::new(),
            Self::DeadZone | Self::OutputDeadZone => pairs
                .map(|(lower, upper)| StaticCurve::DeadZone { lower, upper })
                .collect(),
            Self::Saturation | Self::OutputSaturation => pairs
                .map(|(lower, upper)| StaticCurve::Saturation {
                    lower: Some(lower),
                    upper: Some(upper),
                })
                .collect(),
            Self::Square => vec![StaticCurve::Square { linear: Some(0.0) }],
            Self::Piecewise | Self::OutputPiecewise => {
                let alone = levels.iter().flat_map(|level| bent(&[*level]));
                alone
                    .chain(pairs.flat_map(|(low, high)| bent(&[low, high])))
                    .collect()
            }
            Self::Backlash => {
                let widths = WIDTHS.map(|it| it * range(signal));
                widths.map(|width| StaticCurve::Backlash { width }).into()
            }
        }
    }
}

/// Straight lines that meet at these breakpoints; every other slope is smaller.
fn bent(levels: &[f64]) -> [StaticCurve; 2] {
    [0, 1].map(|first| StaticCurve::Piecewise {
        levels: levels.to_vec(),
        slopes: (0..=levels.len())
            .map(|i| if i % 2 == first { 1.0 } else { SLIGHTLY_BENT })
            .collect(),
    })
}

/// The curve found, and the held-out fit of the linear model for comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Curved {
    /// Where it is.
    pub side: Side,
    /// The curve, with its uncertainty.
    pub fitted: FittedCurve,
    /// The held-out fit of the linear model, %; `None` if it is not known.
    pub linear_fit: Option<f64>,
}

impl Curved {
    /// The curve's signal: input or output.
    #[must_use]
    pub const fn label(&self) -> &'static str {
        match self.side {
            Side::Input => "input curve",
            Side::Output => "output curve",
        }
    }

    /// The kind of curve, and its estimated parameters with 95 % intervals.
    #[must_use]
    pub fn in_words(&self) -> String {
        let named = self.fitted.named();
        let each: Vec<String> = named
            .map(|(name, value, deviation)| {
                format!("{name} {}", with_interval(value, SIGMAS_95 * deviation))
            })
            .collect();
        let kind = match self.fitted.curve {
            StaticCurve::Square { linear: None } => "square law, u|u|".to_owned(),
            StaticCurve::Square { .. } => "square law, u|u| + linear u".to_owned(),
            _ => self.fitted.curve.name().to_owned(),
        };
        match each.is_empty() {
            true => kind,
            false => format!("{kind}, {}", each.join(", ")),
        }
    }
}

/// All input curves except straight lines.
pub(super) fn of_inputs(inputs: &[f64]) -> impl Iterator<Item = StaticCurve> {
    let choices = [
        CurveChoice::DeadZone,
        CurveChoice::Saturation,
        CurveChoice::Square,
        CurveChoice::Backlash,
    ];
    choices.into_iter().flat_map(|choice| choice.starts(inputs))
}

/// Curves that may remove the cause of an error: the cause's own curve, and straight lines that meet at its breakpoints. A bend can look like a
/// square, and a square like a bend, so both are tried.
pub(super) fn of_cause(
    cause: &Cause,
    inputs: &[f64],
    outputs: &[f64],
) -> Option<(Side, Vec<StaticCurve>)> {
    let of = |curve: &StaticCurve| {
        let levels = curve.levels();
        let mut curves = vec![curve.clone()];
        curves.extend(levels.iter().flat_map(|level| bent(&[*level])));
        if levels.len() > 1 {
            curves.extend(bent(&levels));
        }
        curves
    };
    Some(match cause {
        // Which of them it is their own criterion tells, with levels that were sought.
        Cause::Input(curve) => {
            let all = of(curve).into_iter().chain(of_inputs(inputs));
            (Side::Input, all.collect())
        }
        Cause::Output(StaticCurve::Backlash { .. }) => return None,
        Cause::Output(curve) => {
            let choices = match curve {
                StaticCurve::DeadZone { .. } => &[CurveChoice::OutputDeadZone][..],
                StaticCurve::Saturation { .. } => &[CurveChoice::OutputSaturation],
                _ => &[CurveChoice::OutputDeadZone, CurveChoice::OutputSaturation],
            };
            let starts = choices.iter().flat_map(|it| it.starts(outputs));
            (Side::Output, of(curve).into_iter().chain(starts).collect())
        }
        _ => return None,
    })
}

/// Limits at which an output dwells: many samples lie within a tenth of the range from the largest or smallest value, and few in the next tenth.
pub(super) fn dwelt_at(outputs: &[f64]) -> Option<StaticCurve> {
    let (least, largest) = extremes(outputs);
    let part = (largest - least) / PARTS_OF_RANGE;
    let dwells = |away: &dyn Fn(f64) -> f64| {
        let parts = outputs.iter().map(|y| away(*y) / part);
        let [near, next] = [0.0, 1.0].map(|from| {
            let within = |it: &f64| (from..from + 1.0).contains(it);
            parts.clone().filter(within).count() as f64
        });
        near > DWELT * outputs.len() as f64 && near > MORE_OFTEN * next
    };
    let lower = dwells(&|y| y - least).then_some(least + part / 2.0);
    let upper = dwells(&|y| largest - y).then_some(largest - part / 2.0);
    (lower.is_some() || upper.is_some()).then_some(StaticCurve::Saturation { lower, upper })
}

/// Limits at which an output is clipped: it stays exactly at its largest or smallest value after moving there. An output that settles there, or is
/// rounded to that value, approaches it by ever smaller or the smallest steps.
pub(super) fn clipped_at(outputs: &[f64]) -> Option<StaticCurve> {
    let moves = || outputs.windows(2).map(|y| (y[1] - y[0]).abs());
    let largest_move = moves().fold(0.0, f64::max);
    let least_move = moves().filter(|it| *it > 0.0).fold(f64::INFINITY, f64::min);
    let is_large = |it: f64| it > CLIPPED_FROM * largest_move && it > 2.0 * least_move;
    let is_clipped = |limit: f64| {
        outputs.windows(CLIPPED + 2).any(|y| {
            let is_moving = y[0] != y[1] && (y[1] - y[0]) * (y[2] - y[1]) > 0.0;
            is_moving && is_large((y[1] - y[0]).abs()) && y[2..].iter().all(|y| *y == limit)
        })
    };
    let (least, largest) = extremes(outputs);
    let [lower, upper] = [least, largest].map(|it| is_clipped(it).then_some(it));
    (lower.is_some() || upper.is_some()).then_some(StaticCurve::Saturation { lower, upper })
}

/// The problem of fitting a linear structure to a record.
pub(super) fn problem<'a>(record: &'a Record, structure: &Structure) -> Result<Problem<'a>> {
    let none =
        || IdentificationError::Record("a record with an input and an output is needed".to_owned());
    let runs = record.runs().ok_or_else(none)?;
    Problem::new(structure.clone(), record.sample_time, runs)
}

/// The best input curve, refined from several, before dynamics of a given structure.
pub(super) fn fitted(
    record: &Record,
    structure: &Structure,
    starts: &[StaticCurve],
    is_pointed_to: bool,
) -> Result<FittedCurve> {
    let all = problem(record, structure)?;
    let part = all.part().unwrap_or(all);
    let start = match starts {
        [start] => start.clone(),
        _ => {
            let most = if is_pointed_to {
                f64::INFINITY
            } else {
                MAY_CURE
            };
            of_best_kind(&part.last_samples(SEARCHED), starts, most)?
        }
    };
    let (found, _) = near(&part, &start)?;
    let signal: Vec<f64> = part.runs.iter().flat_map(|it| it.inputs).copied().collect();
    match found.is_determined(&signal) {
        true => Ok(found),
        false => Err(NOT_DETERMINED),
    }
}

/// Refines a curve; returns it with the remaining errors. A linear part beside the square is omitted if it may be 0; the largest slope of straight
/// lines is 1.
fn near(problem: &Problem<'_>, start: &StaticCurve) -> Result<(FittedCurve, Vec<f64>)> {
    let found = in_front(problem, start)?;
    let may_be_0 =
        |(_, value, deviation): (String, f64, f64)| value.abs() < SIGNIFICANT * deviation;
    let better = match &found.0.curve {
        StaticCurve::Square { .. } if found.0.named().next().is_some_and(may_be_0) => {
            StaticCurve::Square { linear: None }
        }
        curve => curve.clone().normalised(),
    };
    match better == found.0.curve {
        true => Ok(found),
        false => in_front(problem, &better),
    }
}

/// The curve with the lowest Bayesian criterion, refined from those that leave at most the share `most` of the linear model's squared error; for each
/// kind and number of parameters only the best is refined.
fn of_best_kind(problem: &Problem<'_>, starts: &[StaticCurve], most: f64) -> Result<StaticCurve> {
    let straight = StaticCurve::Piecewise {
        levels: Vec::new(),
        slopes: vec![1.0],
    };
    let linear = cost_in_front(problem, &straight);
    let mut kinds: BTreeMap<(&str, usize), (f64, &StaticCurve)> = BTreeMap::new();
    for start in starts {
        let kind = (start.name(), start.parameters().len());
        let cost = cost_in_front(problem, start);
        if cost > most * linear {
            continue;
        }
        let best = kinds.entry(kind).or_insert((cost, start));
        if cost < best.0 {
            *best = (cost, start);
        }
    }
    let signal: Vec<f64> = (problem.runs.iter().flat_map(|it| it.inputs).copied()).collect();
    let found = kinds.into_values().filter_map(|(_, start)| {
        let (found, errors) = near(problem, start).ok()?;
        let is_determined = found.is_determined(&signal);
        is_determined.then_some((found.curve.parameters().len(), errors, found.curve))
    });
    of_least_criterion(found.collect()).ok_or(NOT_DETERMINED)
}

/// A static curve at the input, before the dynamics.
#[derive(Clone, Copy, Debug)]
pub(super) struct Front<'a> {
    /// The record, with the input as measured, before the curve.
    pub(super) record: &'a Record,
    /// The curve.
    pub(super) curve: &'a FittedCurve,
}

impl Front<'_> {
    /// Adds the curve's uncertainty to that of the dynamics: `cov + S cov_w S'`, with S the derivatives of theta with respect to the curve's
    /// parameters.
    pub(super) fn widen(
        &self,
        estimate: &mut Estimate,
        estimator: &dyn Estimator,
        through: &Problem<'_>,
    ) -> Result<()> {
        let Some(root) = self.curve.covariance.clone().cholesky() else {
            return Ok(()); // A curve without parameters.
        };
        let own = problem(self.record, &through.structure)?;
        let moved = moved_by(estimator, &own, self.curve)?;
        if moved.nrows() != estimate.theta.len() {
            return Ok(());
        }
        let wider = moved * root.l();
        estimate.covariance += &wider * wider.transpose();
        if let Some(factor) = estimate.factor.take() {
            let columns = factor.ncols();
            let mut joined = factor.insert_columns(columns, wider.ncols(), 0.0);
            joined.columns_mut(columns, wider.ncols()).copy_from(&wider);
            estimate.factor = Some(joined);
        }
        Ok(())
    }

    /// The record with its input passed through the curve, where the curve was fitted to the first part of each segment, before dynamics of this
    /// structure.
    pub(super) fn of_first_part(&self, structure: &Structure) -> Result<Record> {
        let all = problem(self.record, structure)?;
        let runs = all.runs.iter().map(first_part).collect();
        let part = Problem { runs, ..all };
        let (found, _) = in_front(&part, &self.curve.curve)?;
        Ok(found.curve.of_input(self.record))
    }
}
