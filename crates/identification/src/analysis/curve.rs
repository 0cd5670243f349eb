//! A static curve in front of the linear dynamics or behind them, where the evidence asks for one.
//!
//! What the linear model's error points to ([`super::Analysis::finding`]) says which curve is tried, or the user does. Its levels are fitted
//! beside the dynamics; it is kept where what is held out is simulated better by a good part.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::{Analysis, Beside, Options, Reason, judged_on};
use crate::error::{IdentificationError, Result};
use crate::estimators::{
    Estimate, Estimator, Method, Wiener, cost_in_front, in_front, moved_by, of_least_criterion,
};
use crate::static_curve::{FittedCurve, Side, StaticCurve};
use crate::structure::{Problem, Structure};
use crate::uncertainty::SIGMAS_95;
use crate::validation::nonlinearity::{Cause, Curve};
use planesman_linear::digits::with_interval;
use planesman_record::{Record, Run};

/// What a curve must leave at most of the error of the held-out simulation by the linear model.
const BETTER: f64 = 0.7;
/// The share of the error's squares that a cause must take away for its curve to be tried.
const WORTH_A_TRY: f64 = 0.6;
/// The share of the linear model's squares that a curve with its levels about right leaves at most, where nothing points to one.
const MAY_CURE: f64 = 0.7;
/// Levels tried of a curve whose place is not known, as shares of the samples.
const PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Rounds of dynamics and curve.
const ROUNDS: usize = 2;
/// Samples by which the kind of a curve is chosen, the last of the longest segment.
const SEARCHED: usize = 1000;
/// A slope beside one of 1 where the search begins.
const SLIGHTLY_BENT: f64 = 0.5;
/// Standard deviations from 0 within which a parameter may be 0.
const SIGNIFICANT: f64 = 1.96;

/// Which curve is tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveChoice {
    /// The one that the error of the linear model points to.
    #[default]
    Automatic,
    /// None.
    None,
    /// A dead zone of the input.
    DeadZone,
    /// Limits of the input.
    Saturation,
    /// The input's square with its sign, and a part of the input itself.
    Square,
    /// Straight lines of the input that meet at two levels.
    Piecewise,
    /// Backlash of the input.
    Backlash,
    /// A dead zone of the output.
    OutputDeadZone,
    /// Limits of the output.
    OutputSaturation,
    /// Straight lines of the output that meet at two levels.
    OutputPiecewise,
}

impl CurveChoice {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Automatic,
        Self::None,
        Self::DeadZone,
        Self::Saturation,
        Self::Square,
        Self::Piecewise,
        Self::Backlash,
        Self::OutputDeadZone,
        Self::OutputSaturation,
        Self::OutputPiecewise,
    ];

    /// Its name and its help line.
    #[must_use]
    pub fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Automatic => (
                "automatic",
                "The curve that the error of the linear model points to, where it simulates held-out data better",
            ),
            Self::None => ("none", "A linear model"),
            Self::DeadZone => (
                "dead_zone",
                "Dead zone of the input, in front of the dynamics",
            ),
            Self::Saturation => ("saturation", "Limits of the input"),
            Self::Square => ("square", "u|u| + c u, as of a thruster"),
            Self::Piecewise => (
                "piecewise",
                "Three straight lines that meet at two levels of the input",
            ),
            Self::Backlash => ("backlash", "Backlash of the input"),
            Self::OutputDeadZone => ("output_dead_zone", "Dead zone behind the dynamics"),
            Self::OutputSaturation => (
                "output_saturation",
                "Limits behind the dynamics, as of a sensor",
            ),
            Self::OutputPiecewise => (
                "output_piecewise",
                "Three straight lines behind the dynamics",
            ),
        }
    }

    /// The side, and curves to begin at by levels among the signal's own.
    fn starts(self, signal: &[f64]) -> Option<(Side, Vec<StaticCurve>)> {
        let mut sorted = signal.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: &f64| {
            let place = (share * sorted.len() as f64) as usize;
            sorted.get(place).copied()
        };
        let levels: Vec<f64> = PLACES.iter().filter_map(at).collect();
        let pairs = |make: &dyn Fn(f64, f64) -> StaticCurve| {
            let places = levels.iter().enumerate();
            let pairs =
                places.flat_map(|(i, low)| levels[i + 1..].iter().map(|high| (*low, *high)));
            let pairs = pairs.filter(|(low, high)| low < high);
            pairs.map(|(low, high)| make(low, high)).collect::<Vec<_>>()
        };
        let range = sorted.last()? - sorted.first()?;
        let dead_zone = |lower, upper| StaticCurve::DeadZone { lower, upper };
        let saturation = |lower, upper| StaticCurve::Saturation {
            lower: Some(lower),
            upper: Some(upper),
        };
        let piecewise = || {
            let alone = levels.iter().map(|level| vec![*level]);
            let places = levels.iter().enumerate();
            let pairs =
                places.flat_map(|(i, low)| levels[i + 1..].iter().map(|high| vec![*low, *high]));
            let rising = |it: &Vec<f64>| it.windows(2).all(|pair| pair[0] < pair[1]);
            let all = alone.chain(pairs).filter(rising);
            all.flat_map(|it| bent(&it)).collect()
        };
        Some(match self {
            Self::Automatic | Self::None => return None,
            Self::DeadZone => (Side::Input, pairs(&dead_zone)),
            Self::Saturation => (Side::Input, pairs(&saturation)),
            Self::Square => (Side::Input, vec![StaticCurve::Square { linear: Some(0.0) }]),
            Self::Piecewise => (Side::Input, piecewise()),
            Self::Backlash => {
                let widths = [0.05, 0.15, 0.3, 0.5].map(|it| it * range);
                let curves = widths.map(|width| StaticCurve::Backlash { width });
                (Side::Input, curves.into())
            }
            Self::OutputDeadZone => (Side::Output, pairs(&dead_zone)),
            Self::OutputSaturation => (Side::Output, pairs(&saturation)),
            Self::OutputPiecewise => (Side::Output, piecewise()),
        })
    }
}

/// Straight lines that meet at levels, flatter on every other side of them.
fn bent(levels: &[f64]) -> [StaticCurve; 2] {
    [0, 1].map(|first| StaticCurve::Piecewise {
        levels: levels.to_vec(),
        slopes: (0..=levels.len())
            .map(|i| if i % 2 == first { 1.0 } else { SLIGHTLY_BENT })
            .collect(),
    })
}

/// A curve that was found, and the linear model's held-out fit beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curved {
    /// Where it is.
    pub side: Side,
    /// The curve, with its uncertainty.
    pub fitted: FittedCurve,
    /// The held-out fit of the linear model, %; `None` where it has none.
    pub linear_fit: Option<f64>,
}

impl Curved {
    /// Its kind, and what was sought of it with 95 % intervals.
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

/// The analysis of the curve that the options ask for, or the linear model's where none simulates better.
///
/// # Errors
/// Those of the linear analysis; of a curve that was asked for, its own.
pub(super) fn analysed(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
) -> Result<Analysis> {
    let linear = judged_on(record, options, validation, Beside::Nothing)?;
    let run = record.segments[linear.segments[linear.longest]].run();
    let Run {
        inputs, outputs, ..
    } = run.unwrap_or_default();
    match options.curve {
        CurveChoice::None => Ok(linear),
        CurveChoice::Automatic => {
            let found = tried(&linear, inputs)
                .filter(|_| options.method == Method::Automatic)
                .and_then(|(side, starts)| {
                    beside(record, options, validation, &linear, side, &starts).ok()
                });
            let missed = |it: &Analysis| it.held_out_fit.map(|fit| 100.0 - fit);
            let is_better = |it: &Analysis| {
                let pair = missed(it).zip(missed(&linear));
                pair.is_some_and(|(curved, linear)| curved < BETTER * linear)
            };
            Ok(found.filter(is_better).unwrap_or(linear))
        }
        choice => {
            let signal = match choice.starts(inputs) {
                Some((Side::Output, _)) => outputs,
                _ => inputs,
            };
            let starts = choice.starts(signal).filter(|(_, it)| !it.is_empty());
            let (side, starts) = starts.ok_or_else(|| {
                IdentificationError::Option(format!(
                    "--curve {}: the signal has too few levels for it",
                    choice.described().0
                ))
            })?;
            beside(record, options, validation, &linear, side, &starts)
        }
    }
}

/// The curves that are worth a try: those of the cause that was found, or those of an input where the noise would leave a better
/// fit and no cause was.
fn tried(linear: &Analysis, inputs: &[f64]) -> Option<(Side, Vec<StaticCurve>)> {
    match &linear.finding {
        Some(finding) => {
            let is_large = finding.gain.is_some_and(|(share, _)| share > WORTH_A_TRY);
            of_cause(&finding.cause, inputs).filter(|_| is_large)
        }
        None => linear.is_below_noise().then(|| {
            let curves = of_inputs(inputs).chain(starts_of(CurveChoice::Backlash, inputs));
            (Side::Input, curves.collect())
        }),
    }
}

/// A curve that was asked for, to begin at.
fn starts_of(choice: CurveChoice, signal: &[f64]) -> impl Iterator<Item = StaticCurve> {
    choice.starts(signal).into_iter().flat_map(|it| it.1)
}

/// Curves of an input without memory.
fn of_inputs(inputs: &[f64]) -> impl Iterator<Item = StaticCurve> {
    let choices = [
        CurveChoice::DeadZone,
        CurveChoice::Saturation,
        CurveChoice::Square,
    ];
    choices
        .into_iter()
        .flat_map(|choice| starts_of(choice, inputs))
}

/// Curves that may cure the cause of an error: its own, and straight lines that meet where it bends.
fn of_cause(cause: &Cause, inputs: &[f64]) -> Option<(Side, Vec<StaticCurve>)> {
    let of = |curve: &Curve| {
        let (own, levels) = match curve {
            Curve::DeadZone(lower, upper) => {
                let (lower, upper) = (*lower, *upper);
                let own = StaticCurve::DeadZone { lower, upper };
                (own, vec![lower, upper])
            }
            Curve::Limits(lower, upper) => {
                let (lower, upper) = (*lower, *upper);
                let levels = lower.into_iter().chain(upper).collect();
                (StaticCurve::Saturation { lower, upper }, levels)
            }
            Curve::Slopes(levels, slopes) => {
                let (levels, slopes) = (levels.clone(), slopes.clone());
                let own = StaticCurve::Piecewise {
                    levels: levels.clone(),
                    slopes,
                };
                (own, levels)
            }
        };
        let mut curves = vec![own];
        curves.extend(levels.iter().flat_map(|level| bent(&[*level])));
        if levels.len() > 1 {
            curves.extend(bent(&levels));
        }
        curves
    };
    // What bends may be told by a square, and the other way round.
    let of_input = |mut curves: Vec<StaticCurve>| {
        curves.extend(of_inputs(inputs));
        (Side::Input, curves)
    };
    Some(match cause {
        Cause::Input(curve) => of_input(of(curve)),
        Cause::Square => of_input(Vec::new()),
        Cause::Output(curve) => (Side::Output, of(curve)),
        Cause::Backlash(width) => (Side::Input, vec![StaticCurve::Backlash { width: *width }]),
        _ => return None,
    })
}

/// A linear structure on a record.
fn problem<'a>(record: &'a Record, structure: &Structure) -> Result<Problem<'a>> {
    let none =
        || IdentificationError::Record("a record with an input and an output is needed".to_owned());
    let runs = record.runs().ok_or_else(none)?;
    Problem::new(structure.clone(), record.sample_time, runs)
}

/// The curve of the input near the best of several, in front of dynamics of a structure.
fn fitted(
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
    Ok(near(&part, &start)?.0)
}

/// The curve near one, and the errors that are left: without a part of the input itself beside its square that may be 0, the largest
/// slope of straight lines 1.
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

/// The curve of the least Bayesian criterion near any of these that leave a share of the linear model's squares at `most`; of each kind
/// and number of parameters near the best.
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
    of_least_criterion(found.collect()).ok_or(IdentificationError::Undetermined(
        "the record determines no curve of that kind",
    ))
}

fn beside(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    side: Side,
    starts: &[StaticCurve],
) -> Result<Analysis> {
    let mut found = match side {
        Side::Input => hammerstein(record, options, validation, linear, starts)?,
        Side::Output => wiener(record, options, validation, linear, starts)?,
    };
    if let Some(curved) = &mut found.curved {
        curved.linear_fit = linear.held_out_fit;
        let reason = Reason::Curve(curved.clone());
        found.reasons.insert(0, reason);
    }
    Ok(found)
}

/// Curve and dynamics in turns: the dynamics' order and delay are chosen anew behind the curve, then its levels in front of those.
fn hammerstein(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    starts: &[StaticCurve],
) -> Result<Analysis> {
    let mut structure = linear.estimate.layout.structure.clone();
    let is_pointed_to = options.curve != CurveChoice::Automatic || linear.finding.is_some();
    let mut starts = Cow::Borrowed(starts);
    let mut curve = fitted(record, &structure, &starts, is_pointed_to)?;
    for _ in 1..ROUNDS {
        let behind = judged_on(
            &curve.curve.of_input(record),
            options,
            None,
            Beside::Nothing,
        )?;
        structure = behind.estimate.layout.structure;
        starts = Cow::Owned(vec![curve.curve]);
        curve = fitted(record, &structure, &starts, is_pointed_to)?;
    }
    let through = curve.curve.of_input(record);
    let validation = validation.map(|it| curve.curve.of_input(it));
    let front = Front {
        record,
        curve: &curve,
    };
    judged_on(&through, options, validation.as_ref(), Beside::Input(front))
}

/// A curve in front of the input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Front<'a> {
    /// The record before the curve.
    pub(super) record: &'a Record,
    /// The curve.
    pub(super) curve: &'a FittedCurve,
}

impl Front<'_> {
    /// Widens the uncertainty of dynamics by that of the curve: `cov + S cov_w S'`, with S the slopes of theta by the curve's parameters.
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

    /// The record through the curve that the first part of each segment gives by itself, behind which dynamics have this structure.
    pub(super) fn of_first_part(&self, structure: &Structure) -> Result<Record> {
        let all = problem(self.record, structure)?;
        let runs = all.runs.iter().map(super::first_part).collect();
        let part = Problem { runs, ..all };
        let (found, _) = in_front(&part, &self.curve.curve)?;
        Ok(found.curve.of_input(self.record))
    }
}

/// The order and delay of the dynamics are chosen for the outputs in front of the curve, as well as a first model tells them.
fn wiener(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    starts: &[StaticCurve],
) -> Result<Analysis> {
    let poles = |of: &Estimate| of.theta.as_slice()[of.layout.a()].to_vec();
    let all = problem(record, &linear.estimate.layout.structure)?;
    let signal: Vec<f64> = all.runs.iter().flat_map(|it| it.outputs).copied().collect();
    let fitted = starts.iter().filter_map(|start| {
        let estimator = Wiener {
            start: start.clone(),
            poles: poles(&linear.estimate),
        };
        let found = estimator.fit(&all).ok()?;
        let curve = found.output_curve.as_ref()?;
        let parameters = curve.curve.parameters().len();
        let is_determined = curve.is_determined(&signal);
        is_determined.then_some((parameters, found.residuals.concat(), found))
    });
    let least = of_least_criterion(fitted.collect());
    let none = IdentificationError::Search("the search for the curve found no minimum");
    let mut first = least.ok_or(none.clone())?;
    let start = first.output_curve.take().ok_or(none)?.curve.normalised();
    let simulated: Vec<_> = (all.runs.iter().enumerate())
        .map(|(number, run)| first.simulate(number, *run))
        .collect();
    let outputs = Wiener::in_front_of(&start, &all.runs, &simulated);
    let mut in_front = record.clone();
    for (number, outputs) in linear.segments.iter().zip(outputs) {
        if let Some(first) = in_front.segments[*number].outputs.first_mut() {
            *first = outputs;
        }
    }
    let chosen = judged_on(&in_front, options, None, Beside::Nothing)?.estimate;
    // What the outputs in front of the curve owe to the first model does not ask for fewer poles: the curve's own criterion does.
    let most = chosen.layout.structure.poles;
    let orders = match options.order {
        Some(_) => most..=most,
        None => 1.min(most)..=most,
    };
    let of_orders = orders.filter_map(|order| {
        let structure = Structure {
            poles: order,
            numerator: chosen.layout.structure.numerator.min(order.max(1)),
            ..chosen.layout.structure.clone()
        };
        let estimator = Wiener {
            poles: poles(&chosen),
            start: start.clone(),
        };
        let found = estimator.fit(&problem(record, &structure).ok()?).ok()?;
        let estimator = Wiener {
            poles: poles(&found),
            ..estimator
        };
        Some((
            found.theta.len(),
            found.residuals.concat(),
            (structure, estimator),
        ))
    });
    let (structure, estimator) = of_least_criterion(of_orders.collect()).ok_or(
        IdentificationError::Search("the search for the curve found no minimum"),
    )?;
    judged_on(
        record,
        options,
        validation,
        Beside::Output(structure, estimator),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{analyse, analyse_validated};
    use crate::comparison::GivenModel;
    use planesman_record::{filter, noise};

    const SAMPLES: usize = 600;
    const A: [f64; 3] = [1.0, -1.6, 0.68];
    const GAIN: f64 = 0.08;

    /// Levels of -2 to 2, held for 5 to 30 samples.
    fn levels(seed: u32) -> Vec<f64> {
        let random = noise(seed, SAMPLES);
        let mut input = Vec::new();
        for pair in random.chunks(2) {
            let long = 5 + (pair[1].abs() * 10.0) as usize;
            input.extend(std::iter::repeat_n(1.2 * pair[0].clamp(-1.7, 1.7), long));
        }
        input.truncate(SAMPLES);
        input
    }

    /// `y = f(G u) + noise` or `y = G f(u) + noise`, G of second order with the gain 1.
    fn record(seed: u32, side: Side, curve: &StaticCurve) -> Record {
        let input = levels(seed);
        let linear = |u: &[f64]| filter(&[0.0, GAIN], &A, u);
        let output = match side {
            Side::Input => linear(&curve.of(&input)),
            Side::Output => curve.of(&linear(&input)),
        };
        let output = output.iter().zip(noise(seed + 50, SAMPLES));
        let output = output.map(|(y, e)| y + 0.02 * e).collect();
        Record::of_run(0.1, vec![("u", input)], vec![("y", output)]).unwrap()
    }

    fn all() -> Vec<(Side, StaticCurve, CurveChoice)> {
        let dead_zone = StaticCurve::DeadZone {
            lower: -0.6,
            upper: 0.4,
        };
        let saturation = StaticCurve::Saturation {
            lower: Some(-0.8),
            upper: Some(0.7),
        };
        let bent = StaticCurve::Piecewise {
            levels: vec![0.4],
            slopes: vec![1.0, 0.3],
        };
        let square = StaticCurve::Square { linear: None };
        let backlash = StaticCurve::Backlash { width: 0.8 };
        vec![
            (Side::Input, dead_zone, CurveChoice::DeadZone),
            (Side::Input, saturation.clone(), CurveChoice::Saturation),
            (Side::Input, square, CurveChoice::Square),
            (Side::Input, backlash, CurveChoice::Backlash),
            (Side::Input, bent.clone(), CurveChoice::Piecewise),
            (Side::Output, saturation, CurveChoice::OutputSaturation),
            (Side::Output, bent, CurveChoice::OutputPiecewise),
        ]
    }

    #[test]
    fn a_curve_is_found_by_default_with_intervals_that_hold_it_and_judges_other_data() {
        for (side, curve, _) in all() {
            let (first, second) = (record(3, side, &curve), record(8, side, &curve));
            let found = analyse_validated(&first, &Options::default(), &second).unwrap();
            let curved = found.curved.as_ref().unwrap();
            assert_eq!(curved.side, side, "{curve:?}");
            assert_eq!(curved.fitted.curve.name(), curve.name());
            let pairs = curved.fitted.named().zip(curve.parameters());
            for ((name, value, deviation), (_, truth)) in pairs {
                let told = format!("{name} {value} {deviation} {curve:?}");
                assert!((value - truth).abs() < 3.5 * deviation, "{told}");
                assert!(deviation < 0.02, "{told}");
            }
            let gain = found.reading().steady_state_gain().unwrap();
            let (value, deviation) = (gain.value.re, gain.real_deviation());
            let told = format!("{value} {deviation} {curve:?}");
            assert!((value - 1.0).abs() < 3.5 * deviation, "{told}");
            let (held, linear) = (found.held_out_fit.unwrap(), curved.linear_fit.unwrap());
            assert!(held > 90.0 && linear < 85.0, "{held} {linear} {curve:?}");
            let given = GivenModel {
                curve: Some((side, curved.fitted.curve.clone())),
                ..GivenModel::new(&found.estimate, 0)
            };
            let judged = given.on(&second, &[1]).unwrap().fit.unwrap();
            assert!((judged - held).abs() < 0.1, "{judged} {held} {curve:?}");
            let run = first.segments[0].run().unwrap();
            let simulated = found.simulate(0, run);
            let missed: f64 = (run.outputs.iter().zip(simulated).skip(5))
                .map(|(y, x)| (y - x).powi(2))
                .sum();
            let rms = (missed / SAMPLES as f64).sqrt();
            assert!((rms - 0.02).abs() < 0.003, "{rms} {curve:?}");
        }
    }

    #[test]
    fn a_curve_that_is_asked_for_is_sought_from_levels_of_its_own() {
        for (side, curve, choice) in all().into_iter().step_by(2) {
            let options = Options {
                curve: choice,
                order: Some(2),
                delay: Some(1),
                ..Options::default()
            };
            let found = analyse(&record(5, side, &curve), &options).unwrap();
            assert!(
                found.held_out_fit.unwrap() > 90.0,
                "{curve:?} {:?}",
                found.curved
            );
        }
    }

    #[test]
    fn a_linear_plant_has_no_curve_and_neither_has_one_without_levels() {
        let straight = StaticCurve::Piecewise {
            levels: Vec::new(),
            slopes: vec![1.0],
        };
        let linear = record(4, Side::Input, &straight);
        assert_eq!(analyse(&linear, &Options::default()).unwrap().curved, None);
        let none = Options {
            curve: CurveChoice::None,
            ..Options::default()
        };
        let (side, curve, _) = &all()[0];
        let found = analyse(&record(3, *side, curve), &none).unwrap();
        assert!(found.curved.is_none() && found.finding.is_some());
        let mut two = linear;
        let input = &mut two.segments[0].inputs[0];
        input.iter_mut().for_each(|u| *u = u.signum());
        let dead_zone = Options {
            curve: CurveChoice::Saturation,
            ..Options::default()
        };
        let refusal = analyse(&two, &dead_zone).map(drop);
        assert!(refusal.is_err(), "two levels tell of no curve");
    }
}
