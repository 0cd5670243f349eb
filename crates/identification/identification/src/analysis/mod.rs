//! The analysis of a record: order search, fit, residual tests and verdict.
//!
//! Each segment of the record is a run of one model. The order is searched unless it is given; the model
//! is fitted to the first seven tenths of each segment and validated on the rest, by simulation, or on a
//! record of its own; the reported model is fitted to all of it. In a long record the order is searched in the part where the
//! input varies most ([`Problem::part`]).
//!
//! - `verdict`: what the model is good for, and why; `reason`: each reason with its numbers; `sentences`: both in words.
//! - `text`: the results for the terminal.
//! - `lag`: the delay's interval.
//! - `bootstrap`: intervals of poles and gain from refits.
//! - `curve`: static curves in front of the dynamics and behind them; `curved`: the analysis with one, where the evidence asks for it.
//! - `checks`: the figures that the verdict rests on.

mod bootstrap;
mod checks;
mod curve;
mod curved;
pub(crate) mod lag;
mod reason;
mod sentences;
pub(crate) mod text;
pub(crate) mod verdict;

pub use crate::prediction::AHEAD;
pub use crate::selection::process::may_integrate;
pub use bootstrap::{Bootstrap, Interval};
pub use checks::InputPart;
pub use curve::{CurveChoice, Curved};
pub use curved::{analyse, analyse_validated};
pub use lag::Lag;
pub use reason::{FitRemark, Reason, ResidualFinding};
pub use verdict::{GOOD, SAMPLES_PER_PARAMETER, Standing, USABLE, Verdict};

use std::borrow::Cow;

use crate::comparison::{GivenModel, Judgement};
use crate::conversion;
use crate::error::{IdentificationError, Result};
use crate::estimators::{
    Error, Estimate, Estimator, FrequencyDomain, Given, Knowledge, LeastSquares, Method, Physical,
    TwoStages, WarmStarted, Wiener,
};
use crate::model::Model;
use crate::prediction;
use crate::selection::criteria::{Candidate, choice, first_part, search};
use crate::selection::{self, Kind, process, select};
use crate::static_curve::Side;
use crate::structure::{InitialState, Problem, Structure, variance};
use crate::uncertainty::{Reading, Uncertain};
use crate::validation::identifiability::{self, Doubt};
use crate::validation::nonlinearity::{self, Finding};
use crate::validation::residuals::ResidualTests;
use planesman_record::StraightLine;
use planesman_record::{Record, Run, Segment};

/// Options of the analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How to estimate.
    pub method: Method,
    /// Knowledge that the method begins with.
    pub knowledge: Knowledge,
    /// The order, known poles not counted; `None` to search.
    pub order: Option<usize>,
    /// Coefficients of the numerator, known zeros not counted; `None` for as many as the order.
    pub numerator: Option<usize>,
    /// Samples from input to first effect; `None` to search it beside the order, and for 1 with an order
    /// that is given.
    pub delay: Option<usize>,
    /// Zeros known to be at z = 1.
    pub zeros_at_one: usize,
    /// Poles known to be at z = 1.
    pub integrators: usize,
    /// Seek an offset of the output.
    pub offset: bool,
    /// How each segment begins.
    pub start: InitialState,
    /// The segments have only their poles in common.
    pub own_numerators: bool,
    /// The moment of inertia, where it is known: what turns `K/J` into `K`.
    pub inertia: Option<f64>,
    /// The vehicle's speed, m/s, for the model file.
    pub speed: Option<f64>,
    /// Simulated records of a bootstrap; `None` for none.
    pub bootstrap: Option<usize>,
    /// The static curve that is tried.
    pub curve: CurveChoice,
}

impl Default for Options {
    /// Everything searched.
    fn default() -> Self {
        Self {
            method: Method::Automatic,
            knowledge: Knowledge::default(),
            order: None,
            numerator: None,
            delay: None,
            zeros_at_one: 0,
            integrators: 0,
            offset: true,
            start: InitialState::Estimated,
            own_numerators: false,
            inertia: None,
            speed: None,
            bootstrap: None,
            curve: CurveChoice::default(),
        }
    }
}

/// Standard deviations from 0 beyond which a signal's mean is taken off.
const LARGE_MEAN_DEVIATIONS: f64 = 10.0;

/// Orders and delays cross-validated.
const MAX_ORDER: usize = 10;
const MAX_DELAY: usize = 20;

/// Orders and delays searched for a method that was named.
const METHOD_MAX_ORDER: usize = 4;
const METHOD_MAX_DELAY: usize = 3;

/// Times that another delay is taken because it fits better.
const DELAYS: usize = 3;

/// The fit of the best of models, %, up to which the output hardly moves beyond the noise.
pub(crate) const UNINFORMATIVE_FIT: f64 = 10.0;

/// Models of lower order that are shown beside one with such a pole are sought among so many.
const OTHERS: usize = 8;

/// By how much a fit, %, lies below what the noise leaves where another model is asked for.
const BELOW_NOISE: f64 = 5.0;

/// Samples of a trajectory, and points of them that are kept, at most.
const WATCHED: usize = 10_000;
const POINTS: usize = 400;

/// Parameters by time, for a plot of how they were learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// `a1`, `b1` and so on; or `K/J` and so on.
    pub names: Vec<String>,
    /// Seconds, and the parameters then.
    pub points: Vec<(f64, Vec<f64>)>,
}

/// A model and what there is to know of it.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The options it was made with.
    pub options: Options,
    /// The input's name.
    pub input: String,
    /// The output's name.
    pub output: String,
    /// The name of the reference, where one was given.
    pub reference: Option<String>,
    /// The model.
    pub estimate: Estimate,
    /// The same without heed to the reference, where one was given.
    pub direct: Option<Estimate>,
    /// The orders and delays tried; empty when the order was given.
    pub candidates: Vec<Candidate>,
    /// The kinds, orders and delays that were cross-validated, the chosen one first; empty for a method that was named.
    pub selected: Vec<selection::Candidate>,
    /// That the input moves between its samples, where it was found to.
    pub lines: Option<Lines>,
    /// A static curve in front of the dynamics or behind them, where one was fitted: the record and all fits are then of what goes through it.
    pub curved: Option<Curved>,
    /// What leaving out a pole that a zero may cancel, or not, would give.
    pub other_order: Option<OtherOrder>,
    /// The forms of process model tried, the best first; empty where none was.
    pub processes: Vec<process::Candidate>,
    /// The cross-validated fit of the process model, %.
    pub process_fit: Option<f64>,
    /// Samples it was tried on.
    pub searched: usize,
    /// Of each run, the number of the record's segment.
    pub segments: Vec<usize>,
    /// Samples at the beginning of the longest run, behind which it was held out where there is no other data to validate on.
    pub held_out_from: usize,
    /// The simulated fit on the longest run, %.
    pub fit: Option<f64>,
    /// The simulated fit on what was held out of the longest run, or on the validation data, %.
    pub held_out_fit: Option<f64>,
    /// The simulated fit on what was held out, with the state fitted to the samples before it alone, %.
    pub carried_fit: Option<f64>,
    /// The output's standard deviation there, over that of all of the run.
    pub held_out_spread: Option<f64>,
    /// The fit there that the noise leaves to the best of models, %.
    pub attainable_fit: Option<f64>,
    /// The fit of predictions [`AHEAD`] samples ahead on the longest run, or on the validation data, %.
    pub predicted_fit: Option<f64>,
    /// What the input accounts for in the output, beyond constant and free motion.
    pub input_part: Option<InputPart>,
    /// Whether the input stands but for one step or two.
    pub is_step_test: bool,
    /// The share of the output's variation in the longest run that a straight line explains, 0 to 1.
    pub drift: f64,
    /// What the longest run says of the delay, for a model of the output error.
    pub lag: Option<Lag>,
    /// Intervals by a bootstrap, where one was asked for.
    pub bootstrap: Option<Bootstrap>,
    /// The model on the record for validation, where one was given.
    pub validation: Option<Judgement>,
    /// Of the longest run.
    pub residuals: Option<ResidualTests>,
    /// What another model than a linear and steady one would explain of the longest run, where the fit lies well below what
    /// the noise leaves.
    pub finding: Option<Finding>,
    /// The longest run's number.
    pub longest: usize,
    /// What it is good for.
    pub verdict: Verdict,
    /// Why.
    pub reasons: Vec<Reason>,
    /// How the estimator's recursive form learnt.
    pub trajectory: Trajectory,
}

/// What there is beside the linear dynamics.
enum Beside<'a> {
    Nothing,
    /// A curve that the record's input has been through.
    Input(curve::Front<'a>),
    /// A curve of the output, behind dynamics of a structure.
    Output(Structure, Wiener),
}

fn judged_on(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    beside: Beside<'_>,
) -> Result<Analysis> {
    let at_rest = Options {
        start: InitialState::Rest,
        ..options.clone()
    };
    let of_steps = matches!(options.method, Method::Automatic | Method::Process);
    let is_asked = of_steps && options.start == InitialState::Estimated && options.offset;
    let before_step = is_asked
        .then(|| checks::level_before_step(record))
        .flatten()
        .filter(|_| !matches!(beside, Beside::Output(..)));
    let (options, level) = match before_step {
        // A curve has levels of its own.
        None if matches!(beside, Beside::Output(..)) => (options, Level::default()),
        None => (options, Level::of(record, options)),
        Some(input) => (&at_rest, Level { input, output: 0.0 }),
    };
    let data = record;
    let record = &*level.taken_off(record);
    let segments = record.used();
    let of = |number: &usize| &record.segments[*number];
    let mut problem = Problem::new(
        structure(options, options.order.unwrap_or(2)),
        record.sample_time,
        record.runs().ok_or_else(|| {
            IdentificationError::Record("a record with an input and an output is needed".to_owned())
        })?,
    )?;
    let references: Vec<&[f64]> = segments
        .iter()
        .filter_map(|number| Some(of(number).inputs.get(1)?.as_slice()))
        .collect();
    let mut method = options.method.estimator(&options.knowledge);
    let in_a_loop = !references.is_empty();
    // Orders and trajectories are of the second stage.
    let caused = if in_a_loop && options.method != Method::Frf {
        let staged = TwoStages {
            second: method.as_ref(),
            references: references.clone(),
        };
        staged.caused(&problem)?
    } else {
        Vec::new()
    };
    let mut candidates = Vec::new();
    let mut selected = Vec::new();
    let whole = second_stage(&problem, &caused);
    let part = whole.part().unwrap_or(whole);
    let (mut fitted, mut lag, mut other_order) = (None, None, None);
    let (mut processes, mut process_fit, mut lines) = (Vec::new(), None, None);
    // By the reference, without a first stage.
    let mut joint: Option<FrequencyDomain> = None;
    if let Beside::Output(structure, estimator) = &beside {
        problem.structure = structure.clone();
        method = Box::new(estimator.clone());
    } else if options.method == Method::Automatic || options.method == Method::Process {
        let whole = second_stage(&problem, &caused);
        let chosen = match options.method {
            Method::Process => {
                process::choose(&whole, options.knowledge.process, before_step.is_some())?.into()
            }
            _ => chosen(&whole, &part, options, before_step.is_some())?,
        };
        problem.structure = Structure {
            start: options.start,
            ..chosen.structure
        };
        method = chosen.estimator;
        fitted = Some(chosen.estimate);
        lag = chosen.lag;
        selected = chosen.selected;
        other_order = chosen.other_order;
        lines = chosen.lines;
        (processes, process_fit) = (chosen.processes, chosen.process_fit);
    } else if options.method == Method::Frf {
        let search = in_frequency(options, record.sample_time, &references);
        let found = search.fit(&problem)?;
        let again = search.of_found(&found);
        method = Box::new(FrequencyDomain {
            references: Vec::new(),
            ..again.clone()
        });
        problem.structure = found.layout.structure.clone();
        joint = Some(again);
        fitted = Some(found);
    } else if options.order.is_none() && !options.method.is_of_the_vehicle() {
        // A finite impulse response has no poles, and chooses its own length: only its first coefficient is sought.
        let (orders, delays) = match options.method {
            Method::Fir => (0..=0, usize::from(options.speed.is_some())..=1),
            _ => (1..=METHOD_MAX_ORDER, 1..=METHOD_MAX_DELAY),
        };
        let delays = options.delay.map_or(delays, |delay| delay..=delay);
        let structures = orders.flat_map(|order| {
            delays.clone().map(move |delay| Structure {
                delay,
                start: part.structure.start,
                ..structure(options, order)
            })
        });
        candidates = search(&part, method.as_ref(), structures);
        if let Some(chosen) = choice(&candidates) {
            let order = chosen.order;
            problem.structure = Structure {
                delay: chosen.delay,
                ..structure(options, order)
            };
        }
    }

    let staged = TwoStages {
        second: method.as_ref(),
        references,
    };
    let estimator: &dyn Estimator = match &joint {
        Some(joint) => joint,
        None if in_a_loop => &staged,
        None => method.as_ref(),
    };
    let mut estimate = match fitted {
        Some(fitted) => fitted,
        None => estimator.fit(&problem)?,
    };
    if let Beside::Input(front) = &beside {
        front.widen(&mut estimate, estimator, &problem)?;
    }
    let longest = (0..problem.runs.len())
        .max_by_key(|r| problem.runs[*r].outputs.len())
        .unwrap_or_default();
    let direct = in_a_loop.then(|| method.fit(&problem).ok()).flatten();
    let tested_against = match staged.references.get(longest) {
        Some(reference) => reference,
        None => problem.runs[longest].inputs,
    };
    // In a loop the output follows the part of the input that the reference causes, and noise that went round.
    let second = second_stage(&problem, &caused);
    let residuals = estimate
        .residuals
        .get(longest)
        .and_then(|residuals| ResidualTests::new(residuals, tested_against));
    let run = problem.runs[longest];
    let held_out_from = first_part(&run).outputs.len();
    let held_out = &run.outputs[held_out_from..];
    let held_out_spread = match validation {
        None => Some((variance(held_out) / variance(run.outputs)).sqrt()),
        Some(_) => None,
    };
    let HeldOut {
        fit: held_out_fit,
        carried: carried_fit,
        attainable: attainable_fit,
    } = match validation {
        None => match &beside {
            Beside::Input(front) => {
                let through = front.of_first_part(&problem.structure)?;
                let runs = through.runs().unwrap_or_default();
                let by_first_part = Problem {
                    runs,
                    ..problem.clone()
                };
                HeldOut::of(estimator, &by_first_part, longest)
            }
            _ => HeldOut::of(estimator, &problem, longest),
        },
        Some(_) => HeldOut::default(),
    };
    let name = |names: &[String], i: usize| names.get(i).cloned();
    let mut found = Analysis {
        options: options.clone(),
        input: name(&record.inputs, 0).unwrap_or_default(),
        output: name(&record.outputs, 0).unwrap_or_default(),
        reference: name(&record.inputs, 1),
        fit: estimate.simulated_fit(longest, second.runs[longest], 0),
        held_out_from,
        held_out_fit,
        carried_fit,
        held_out_spread,
        attainable_fit,
        predicted_fit: prediction::missed(&estimate, longest, second.runs[longest], AHEAD).fit(),
        input_part: checks::part_of_input(&estimate, longest, second.runs[longest]),
        is_step_test: process::is_step_test(&second),
        drift: StraightLine::nearest_to(second.runs[longest].outputs).share,
        lag: lag
            .or_else(|| lag::lag(&estimate, &second).filter(|_| estimate.output_curve.is_none())),
        bootstrap: (options.bootstrap)
            .map(|refits| {
                // The minimum of a simulated record is near the estimate.
                let near = WarmStarted {
                    poles: estimate.theta.as_slice()[estimate.layout.a()].to_vec(),
                    noise: options.method == Method::BoxJenkins,
                };
                let again: &dyn Estimator = match options.method {
                    Method::OutputError | Method::BoxJenkins => &near,
                    _ => method.as_ref(),
                };
                bootstrap::bootstrap(again, &estimate, &second, longest, refits)
            })
            .transpose()?,
        searched: part.runs.iter().map(|run| run.outputs.len()).sum(),
        validation: None,
        residuals,
        finding: None,
        curved: match &beside {
            Beside::Nothing => None,
            Beside::Input(front) => Some((Side::Input, front.curve.clone())),
            Beside::Output(..) => (estimate.output_curve.clone()).map(|it| (Side::Output, it)),
        }
        .map(|(side, fitted)| Curved {
            side,
            fitted,
            linear_fit: None,
        }),
        longest,
        verdict: Verdict::Undetermined,
        reasons: Vec::new(),
        trajectory: trajectory(method.as_ref(), &second),
        candidates,
        selected,
        other_order,
        lines,
        processes,
        process_fit,
        estimate,
        direct,
        segments,
    };
    level.put_back(&mut found);
    let validated = validation.map(|it| found.validated(it, &problem));
    let validated = validated.transpose()?;
    found.finding = found.beyond_linear(data);
    let mut doubts = match options.method.is_of_the_vehicle() {
        // One step determines the one, the coherence tells where the other is: as their intervals say.
        _ if found.estimate.process.is_some() || found.estimate.frequency.is_some() => Vec::new(),
        true => identifiability::of_inputs(&problem, options.knowledge.vehicle.unknowns()),
        false => identifiability::doubts(&problem),
    };
    // An input that hardly excites some direction determines it where there is little noise.
    if found.response_is_determined() {
        doubts.retain(|it| !matches!(it, Doubt::Excitation(..)));
    }
    found.verdict = found.judged(!doubts.is_empty());
    let step = before_step.map(|_| Reason::AtRest);
    found.reasons = (validated.into_iter().chain(step))
        .chain(found.reasons(doubts, record))
        .collect();
    Ok(found)
}

/// The search in the frequency domain.
fn in_frequency(options: &Options, sample_time: f64, references: &[&[f64]]) -> FrequencyDomain {
    FrequencyDomain {
        given: Given {
            poles: options.order,
            zeros: options.numerator.map(|count| count.saturating_sub(1)),
            // The first effect of a held input is seen a sample later.
            delay: options
                .delay
                .map(|delay| delay.saturating_sub(1) as f64 * sample_time),
            integrators: options.integrators,
            differentiators: options.zeros_at_one,
        },
        coherence: options.knowledge.coherence,
        references: references.iter().map(|it| it.to_vec()).collect(),
        ..FrequencyDomain::default()
    }
}

/// The choice of the default method, or of a process model.
struct Chosen {
    structure: Structure,
    estimator: Box<dyn Estimator>,
    estimate: Estimate,
    /// Of the estimate, where it has been computed.
    lag: Option<Lag>,
    selected: Vec<selection::Candidate>,
    other_order: Option<OtherOrder>,
    lines: Option<Lines>,
    processes: Vec<process::Candidate>,
    process_fit: Option<f64>,
}

/// The input is on straight lines between its samples: parameters and cross-validated fit, %, of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// On straight lines.
    pub lines: (usize, f64),
    /// With the input held.
    pub held: (usize, f64),
}

/// A model with or without a pole that a zero may cancel, beside the one that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherOrder {
    /// Its order.
    pub order: usize,
    /// Whether it has such a pole, which the one chosen has not; or the other way round.
    pub cancels: bool,
    /// Its steady-state gain; `None` with a pole at z = 1.
    pub gain: Option<Uncertain>,
    /// Its cross-validated fit, %.
    pub fit: f64,
}

impl From<process::Chosen> for Chosen {
    fn from(chosen: process::Chosen) -> Self {
        Self {
            structure: chosen.estimate.layout.structure.clone(),
            estimator: Box::new(chosen.estimator),
            estimate: chosen.estimate,
            lag: None,
            selected: Vec::new(),
            other_order: None,
            lines: None,
            processes: chosen.candidates,
            process_fit: chosen.fit,
        }
    }
}

/// The model that cross-validation chooses; of a step test, or where it may integrate, a process model that tells it as well.
fn chosen(
    problem: &Problem<'_>,
    part: &Problem<'_>,
    options: &Options,
    stood: bool,
) -> Result<Chosen> {
    let chosen = between_samples(problem, part, options);
    let is_free = options.order.is_none()
        && options.numerator.is_none()
        && options.delay.is_none()
        && options.zeros_at_one + options.integrators == 0
        && !options.own_numerators;
    let other = chosen.as_ref().ok().map(|it| &it.estimate);
    match is_free
        .then(|| process::instead_of(problem, other, stood))
        .flatten()
    {
        Some(process) => Ok(process.into()),
        None => chosen,
    }
}

/// The model that cross-validation chooses, for an input that is held between its samples; where the output seems to answer at
/// once, or before, for one that moves on straight lines if that is better.
fn between_samples(problem: &Problem<'_>, part: &Problem<'_>, options: &Options) -> Result<Chosen> {
    let held = cross_validated(problem, part, options, false)?;
    let answers_at_once = match held.lag {
        Some(lag) => lag.interval.1 <= 0,
        None => held.structure.delay == 0,
    };
    let is_asked = options.delay.is_none() && options.order != Some(0);
    if !is_asked || !answers_at_once {
        return Ok(held);
    }
    let found = cross_validated(problem, part, options, true).ok();
    let is_better = |lines: &Chosen| {
        let pair = lines.selected.first().zip(held.selected.first());
        pair.is_some_and(|(lines, held)| lines.is_stable() && lines.score() < held.score())
    };
    let judged = |it: &Chosen| (it.selected[0].parameters(), it.selected[0].fit());
    Ok(match found.filter(is_better) {
        Some(lines) => Chosen {
            lines: Some(Lines {
                lines: judged(&lines),
                held: judged(&held),
            }),
            ..lines
        },
        None => held,
    })
}

/// The model that cross-validation on a part of the data chooses, fitted to all of it, with the delay that fits best; for an input
/// that is held between its samples, or on straight `lines`.
fn cross_validated(
    problem: &Problem<'_>,
    part: &Problem<'_>,
    options: &Options,
    lines: bool,
) -> Result<Chosen> {
    let orders = options.order.map_or(1..=MAX_ORDER, |order| order..=order);
    // Planes move a vehicle only later; a model at a speed is one of a vehicle. On lines the input acts in the interval before
    // its sample.
    let least = usize::from(options.speed.is_some() && !lines);
    let delays = options
        .delay
        .map_or(least..=MAX_DELAY, |delay| delay..=delay);
    let structures = |order: usize, delay: usize| {
        let mut structure = structure(options, order);
        structure.delay = delay;
        structure.start = part.structure.start;
        let is_instant = delay == 0 && order > 0 && !lines;
        structure.numerator += usize::from(is_instant && options.numerator.is_none());
        match lines {
            true => structure.with_lines(),
            false => structure,
        }
    };
    let mut selected = select(part, orders.clone(), delays, &structures);
    let with = |structure: &Structure| Problem {
        structure: Structure {
            start: problem.structure.start,
            ..structure.clone()
        },
        ..problem.clone()
    };
    // One that all the data does not determine gives way to the next.
    let determined = selected.iter().enumerate().find_map(|(at, candidate)| {
        let fitted = candidate.estimator().fit(&with(&candidate.structure));
        Some((at, fitted.ok()?))
    });
    let Some((at, mut estimate)) = determined else {
        let of_order = with(&structure(options, options.order.unwrap_or(1)));
        let reason = LeastSquares.fit(&of_order).err();
        return Err(reason.unwrap_or(IdentificationError::Undetermined(
            "the record determines no model of any order",
        )));
    };
    selected.drain(..at);
    // A pole that a zero may cancel is left out where a model of lower order is nearly as good.
    let cancels = |estimate: &Estimate| !Reading::new(estimate, 0).cancelled_poles().is_empty();
    let other = |of: &selection::Candidate, estimate: &Estimate| OtherOrder {
        order: of.order(),
        cancels: cancels(estimate),
        gain: Reading::new(estimate, 0).steady_state_gain(),
        fit: of.fit(),
    };
    let best = selected[0].clone();
    let with_cancelled = other(&best, &estimate);
    while cancels(&estimate)
        && let Some(simpler) = selected[0].simpler(&selected, &best).cloned()
        && let Ok(fitted) = simpler.estimator().fit(&with(&simpler.structure))
    {
        selected.retain(|it| *it != simpler);
        selected.insert(0, simpler);
        estimate = fitted;
    }
    let other_order = match cancels(&estimate) {
        true => selected[0].lower(&selected).take(OTHERS).find_map(|it| {
            let fitted = it.estimator().fit(&with(&it.structure)).ok()?;
            Some(other(it, &fitted)).filter(|it| !it.cancels)
        }),
        false => Some(with_cancelled).filter(|it| it.cancels),
    };
    let mut estimator = selected[0].estimator();
    let mut of = with(&selected[0].structure);
    // The delays that were cross-validated are few.
    let mut lag = lag::lag(&estimate, &of);
    for _ in 0..DELAYS {
        let another = lag.filter(|it| {
            let interval = it.interval.0..=it.interval.1;
            options.delay.is_none() && !interval.contains(&(of.structure.delay as i64))
        });
        let best = another.and_then(|it| usize::try_from(it.best).ok());
        let Some(best) = best.filter(|best| *best >= least) else {
            break;
        };
        // At the right delay fewer poles may do.
        let orders = *orders.start()..=selected[0].structure.poles.max(*orders.start());
        let again = select(part, orders, best..=best, &structures);
        let better = again
            .first()
            .filter(|it| it.is_stable() && it.score() <= selected[0].score());
        let fitted =
            better.and_then(|it| Some((it, it.estimator().fit(&with(&it.structure)).ok()?)));
        if let Some((it, fitted)) = fitted {
            (estimator, of) = (it.estimator(), with(&it.structure));
            estimate = fitted;
            selected.splice(0..0, again);
        } else {
            let before = std::mem::replace(&mut of.structure.delay, best);
            match estimator.fit(&of) {
                Ok(better) => estimate = better,
                Err(_) => {
                    of.structure.delay = before;
                    break;
                }
            }
        }
        // With the other delay another may fit better still.
        lag = lag::lag(&estimate, &of);
    }
    Ok(Chosen {
        structure: of.structure,
        estimator,
        estimate,
        lag,
        selected,
        other_order,
        lines: None,
        processes: Vec::new(),
        process_fit: None,
    })
}

/// Levels of input and output far from 0, which would leave the rest to rounding: taken off before anything is
/// estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Level {
    input: f64,
    output: f64,
}

impl Level {
    /// None, where the model or the method knows of a level.
    fn of(record: &Record, options: &Options) -> Self {
        let free = options.offset
            && options.start == InitialState::Estimated
            && options.integrators == 0
            && !options.method.is_of_the_vehicle();
        let level = |of: fn(&Segment) -> Option<&Vec<f64>>| -> f64 {
            let values = || record.segments.iter().filter_map(of).flatten().copied();
            let count = values().count().max(1) as f64;
            let mean = values().sum::<f64>() / count;
            let deviation = (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
            if free && mean.abs() > LARGE_MEAN_DEVIATIONS * deviation {
                mean
            } else {
                0.0
            }
        };
        Self {
            input: level(|segment| segment.inputs.first()),
            output: level(|segment| segment.outputs.first()),
        }
    }

    fn taken_off(self, record: &Record) -> Cow<'_, Record> {
        if self == Self::default() {
            return Cow::Borrowed(record);
        }
        let mut record = record.clone();
        for segment in &mut record.segments {
            let sides = [
                (segment.past.first_mut(), self.input),
                (segment.inputs.first_mut(), self.input),
                (segment.outputs.first_mut(), self.output),
            ];
            for (signal, level) in sides {
                signal
                    .into_iter()
                    .flatten()
                    .for_each(|value| *value -= level);
            }
        }
        Cow::Owned(record)
    }

    fn put_back(self, found: &mut Analysis) {
        for estimate in std::iter::once(&mut found.estimate).chain(&mut found.direct) {
            estimate.input_level += self.input;
            let steady = match estimate.error {
                Error::Equation => {
                    let a = estimate.layout.denominator(estimate.theta.as_slice());
                    a.iter().sum()
                }
                Error::Output => 1.0,
            };
            for run in 0..estimate.layout.runs {
                if let Some(at) = estimate.layout.offset(run) {
                    estimate.theta[at] += self.output * steady;
                }
            }
        }
    }
}

/// A record whose second input is the reference of a loop, with the part of its first input that the reference causes.
fn caused_by_reference(record: &Record) -> Result<Cow<'_, Record>> {
    let numbers = record.used();
    let reference = |number: &usize| Some(record.segments[*number].inputs.get(1)?.as_slice());
    let references: Option<Vec<&[f64]>> = numbers.iter().map(reference).collect();
    let (Some(references), Some(runs)) = (references, record.runs()) else {
        return Ok(Cow::Borrowed(record));
    };
    let problem = Problem::new(Structure::of_order(1), record.sample_time, runs)?;
    let staged = TwoStages {
        second: &LeastSquares,
        references,
    };
    let caused = staged.caused(&problem)?;
    let mut record = record.clone();
    for (number, caused) in numbers.into_iter().zip(caused) {
        record.segments[number].inputs[0] = caused;
    }
    Ok(Cow::Owned(record))
}

/// The problem with the part of each input that the reference causes, where there is one.
fn second_stage<'a>(problem: &Problem<'a>, caused: &'a [Vec<f64>]) -> Problem<'a> {
    let mut second = problem.clone();
    for (run, caused) in second.runs.iter_mut().zip(caused) {
        run.inputs = caused;
    }
    second
}

/// The fits of what is held out of a run, %, when the estimator is given the first part of each.
#[derive(Clone, Copy, Debug, Default)]
struct HeldOut {
    /// Simulated, with the state fitted there.
    fit: Option<f64>,
    /// Simulated on from the samples before.
    carried: Option<f64>,
    /// What the noise leaves to the best of models.
    attainable: Option<f64>,
}

impl HeldOut {
    /// No fit where the output hardly moves beyond the noise, which can be simulated neither well nor badly, or where the first part
    /// does not determine the model.
    fn of(estimator: &dyn Estimator, problem: &Problem<'_>, longest: usize) -> Self {
        let part = Problem {
            runs: problem.runs.iter().map(first_part).collect(),
            ..problem.clone()
        };
        let fitted = part.runs[longest].outputs.len();
        let run = problem.runs[longest];
        let attainable = checks::attainable_fit(problem, &run.outputs[fitted..]);
        let moves = attainable.is_none_or(|fit| fit > UNINFORMATIVE_FIT);
        let found = moves.then(|| estimator.fit(&part).ok()).flatten();
        let found = found.as_ref();
        Self {
            fit: found.and_then(|it| it.simulated_fit(longest, run, fitted)),
            carried: found.and_then(|it| it.carried_fit(longest, run, fitted)),
            attainable,
        }
    }
}

fn structure(options: &Options, order: usize) -> Structure {
    let order = match options.method {
        Method::Fir => 0,
        _ => order,
    };
    let mut structure = Structure {
        offset: options.offset,
        start: options.start,
        // A static gain acts at once.
        delay: options
            .delay
            .unwrap_or(usize::from(order > 0 || options.method == Method::Fir)),
        own_numerators: options.own_numerators,
        ..Structure::of_order(order)
    };
    for _ in 0..options.zeros_at_one {
        structure = structure.with_zero_at_one();
    }
    for _ in 0..options.integrators {
        structure = structure.with_integrator();
    }
    structure.poles = order;
    structure.numerator = options.numerator.unwrap_or(structure.numerator).max(1);
    structure
}

fn trajectory(estimator: &dyn Estimator, problem: &Problem<'_>) -> Trajectory {
    let Ok(mut learner) = estimator.learner(problem) else {
        return Trajectory {
            names: Vec::new(),
            points: Vec::new(),
        };
    };
    let total: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
    let stride = total.min(WATCHED).div_ceil(POINTS).max(1);
    let samples = problem.runs.iter().flat_map(|run| {
        let before = std::iter::once(None).chain(run.inputs.iter().map(Some));
        before.zip(run.outputs)
    });
    let mut points = Vec::new();
    for (sample, (input, output)) in samples.take(WATCHED).enumerate() {
        match input {
            None => learner.begin(*output),
            Some(input) => learner.push(*input, *output),
        }
        if sample % stride == 0 {
            let learnt = learner.parameters().iter().copied().collect();
            points.push((sample as f64 * problem.sample_time, learnt));
        }
    }
    Trajectory {
        names: learner.names(),
        points,
    }
}

impl Analysis {
    /// Takes the fits of a record for validation.
    fn validated(&mut self, validation: &Record, fitted: &Problem<'_>) -> Result<Reason> {
        let validation = &*match self.estimate.frequency {
            // Its model was not fitted to what the reference causes.
            Some(_) => Cow::Borrowed(validation),
            None => caused_by_reference(validation)?,
        };
        let judgement = GivenModel::new(&self.estimate, self.longest).on(validation, &[AHEAD])?;
        let outputs = validation.segments[judgement.segments[judgement.longest]]
            .outputs
            .first();
        self.attainable_fit = outputs.and_then(|it| checks::attainable_fit(fitted, it));
        let moves = self
            .attainable_fit
            .is_none_or(|fit| fit > UNINFORMATIVE_FIT);
        self.held_out_fit = judgement.fit.filter(|_| moves);
        self.predicted_fit = judgement.predicted[0].1;
        let reason = Reason::Validated(judgement.samples, judgement.fit, self.predicted_fit);
        self.validation = Some(judgement);
        Ok(reason)
    }

    /// What the error of the longest run points to, where the noise would leave a better fit.
    fn beyond_linear(&self, data: &Record) -> Option<Finding> {
        let run = data.segments[self.segments[self.longest]].run()?;
        let finding = || nonlinearity::finding(&self.estimate, self.longest, run);
        self.is_below_noise().then(finding).flatten()
    }

    /// Whether the noise would leave a better fit to another model.
    fn is_below_noise(&self) -> bool {
        let fits = self.attainable_fit.zip(self.held_out_fit);
        fits.is_some_and(|(attainable, held)| attainable - held > BELOW_NOISE)
            && self.reference.is_none()
            && self.estimate.process.is_none()
            && self.estimate.output_curve.is_none()
            && !self.is_unstable()
            && !self.options.method.is_of_the_vehicle()
    }

    /// The output of a run of the record, with the curve where there is one, from its input alone.
    #[must_use]
    pub fn simulate(&self, number: usize, run: Run<'_>) -> Vec<f64> {
        match &self.curved {
            Some(curved) if curved.side == Side::Input => {
                let (past, inputs) = curved.fitted.curve.of_run(&run);
                let through = Run {
                    past: &past,
                    inputs: &inputs,
                    outputs: run.outputs,
                };
                self.estimate.simulate(number, through)
            }
            _ => self.estimate.simulate(number, run),
        }
    }

    /// A record as the linear dynamics have it: with its input through the curve in front of them, where there is one.
    #[must_use]
    pub fn of_dynamics<'a>(&self, record: &'a Record) -> Cow<'a, Record> {
        match &self.curved {
            Some(curved) if curved.side == Side::Input => {
                Cow::Owned(curved.fitted.curve.of_input(record))
            }
            _ => Cow::Borrowed(record),
        }
    }

    /// The reasons, then the verdict.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let reasons = self.reasons.iter().map(Reason::to_string);
        reasons.chain([self.verdict_text()]).collect()
    }

    /// The kind that was chosen by cross-validation.
    #[must_use]
    pub fn kind(&self) -> Option<Kind> {
        self.selected.first().map(|chosen| chosen.kind)
    }

    /// The method's name: that of the kind that was chosen, or of the method that was asked for.
    #[must_use]
    pub fn method_name(&self) -> &'static str {
        match self.estimate.process {
            Some(_) => Method::Process.name(),
            None if self.estimate.output_curve.is_some() => Method::OutputError.name(),
            None => self.kind().map_or(self.options.method.name(), Kind::name),
        }
    }

    /// The model of the longest run.
    #[must_use]
    pub fn model(&self) -> Model {
        self.estimate.model(self.longest)
    }

    /// Poles, zeros, gain and response of that model.
    #[must_use]
    pub fn reading(&self) -> Reading<'_> {
        Reading::new(&self.estimate, self.longest)
    }

    /// The vehicle's coefficients, where they were sought or follow: from second order with a zero at z = 1.
    #[must_use]
    pub fn physical(&self) -> Option<Physical> {
        let sought = self.estimate.physical.clone();
        sought.or_else(|| conversion::pitch_equation(&self.estimate).ok())
    }
}
