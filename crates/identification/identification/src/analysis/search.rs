//! The search for a model's structure: by cross-validation, by criteria, in the frequency domain.

use std::ops::RangeInclusive;

use super::lag::{self, Lag};
use super::{Data, Options};
use crate::error::{IdentificationError, Result};
use crate::estimators::{Estimate, Estimator, FrequencyDomain, LeastSquares, Method, Property};
use crate::selection::criteria::{self, choice};
use crate::selection::{self, process, select};
use crate::structure::{Problem, Structure};
use crate::uncertainty::{Reading, Uncertain};
use crate::validation::identifiability::Following;

/// Maximum order and delay in cross-validation.
pub(super) const MAX_ORDER: usize = 10;
pub(super) const MAX_DELAY: usize = 20;

/// Maximum order and delay searched for a requested method.
pub(super) const METHOD_MAX_ORDER: usize = 4;
pub(super) const METHOD_MAX_DELAY: usize = 3;

/// Maximum number of times that the delay is changed because another fits better.
const DELAYS: usize = 3;

/// Number of cross-validated models among which a model of lower order without the cancelled pole is searched.
const OTHERS: usize = 8;

/// Structures tried in the search for a model.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The orders and delays tried; empty if the order was given.
    pub candidates: Vec<criteria::Candidate>,
    /// The cross-validated kinds, orders and delays, the chosen one first; empty for a requested method.
    pub selected: Vec<selection::Candidate>,
    /// Evidence that the input moves between its samples; `None` without evidence.
    pub lines: Option<FirstOrderHold>,
    /// The result of leaving out, or keeping, a pole that a zero may cancel.
    pub other_order: Option<OtherOrder>,
    /// The forms of process model tried, best first; empty if none was tried.
    pub processes: Vec<process::Candidate>,
    /// The cross-validated fit of the process model, %.
    pub process_fit: Option<f64>,
    /// Number of samples used in the search.
    pub samples: usize,
}

/// The input moves on straight lines between its samples: number of parameters and cross-validated fit, %, for this input and for a held input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderHold {
    /// On straight lines.
    pub lines: (usize, f64),
    /// Values for a held input.
    pub held: (usize, f64),
}

/// A model with or without a pole that a zero may cancel, for comparison with the chosen model.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherOrder {
    /// Its order.
    pub order: usize,
    /// Whether this model has the pole and the chosen model does not; `false` for the reverse.
    pub cancels: bool,
    /// The model's steady-state gain; `None` for a pole at z = 1.
    pub gain: Option<Uncertain>,
    /// The model's cross-validated fit, %.
    pub fit: f64,
}

/// The structure and the estimator to use.
pub(super) struct Chosen {
    pub(super) structure: Structure,
    pub(super) estimator: Box<dyn Estimator>,
    /// The estimator that uses the references directly, without a first stage.
    pub(super) joint: Option<FrequencyDomain>,
    /// The estimate, if the search has already computed it.
    pub(super) estimate: Option<Estimate>,
    /// The interval of the estimate's delay, if already computed.
    pub(super) lag: Option<Lag>,
    pub(super) search: Search,
}

impl Chosen {
    /// Nothing searched.
    pub(super) fn of(structure: Structure, estimator: Box<dyn Estimator>) -> Self {
        Self {
            structure,
            estimator,
            joint: None,
            estimate: None,
            lag: None,
            search: Search::default(),
        }
    }

    /// The best cross-validated model; there is at least one.
    fn best(&self) -> &selection::Candidate {
        &self.search.selected[0]
    }
}

impl From<process::Chosen> for Chosen {
    fn from(chosen: process::Chosen) -> Self {
        let structure = chosen.estimate.layout.structure.clone();
        Self {
            estimate: Some(chosen.estimate),
            search: Search {
                processes: chosen.candidates,
                process_fit: chosen.fit,
                ..Search::default()
            },
            ..Self::of(structure, Box::new(chosen.estimator))
        }
    }
}

/// Searches for the properties that the options leave open. `stood`: the output was constant until a step.
pub(super) fn search(data: &Data<'_>, options: &Options, stood: bool) -> Result<Chosen> {
    let (problem, whole) = (&data.problem, data.on_noise_free_inputs(&data.problem));
    let part = whole.part().unwrap_or_else(|| whole.clone());
    let given = || {
        let estimator = options.method.estimator(&options.knowledge);
        Chosen::of(problem.structure.clone(), estimator)
    };
    let mut chosen = match options.method {
        Method::Process => process::choose(&whole, options.knowledge.process, stood)?.into(),
        Method::Automatic => automatic(&whole, &part, options, stood, data.following)?,
        Method::Frf => in_frequency(data, options)?,
        method if options.order.is_none() && method.has(Property::SearchedByCriteria) => {
            by_criteria(&part, options, given())
        }
        _ => given(),
    };
    if options.method.has(Property::KnowsStepTests) {
        chosen.structure.start = options.start;
    }
    chosen.search.samples = part.runs.iter().map(|run| run.outputs.len()).sum();
    Ok(chosen)
}

/// A transfer function fitted to the frequency response; in a closed loop it uses the reference, without a first stage.
fn in_frequency(data: &Data<'_>, options: &Options) -> Result<Chosen> {
    let search = options.frequency_domain(data.problem.sample_time, &data.references);
    let found = search.fit(&data.problem)?;
    let joint = search.of_found(&found);
    let estimator = FrequencyDomain {
        references: Vec::new(),
        ..joint.clone()
    };
    Ok(Chosen {
        joint: Some(joint),
        estimate: Some(found.clone()),
        ..Chosen::of(found.layout.structure, Box::new(estimator))
    })
}

/// Order and delay for a requested method.
fn by_criteria(part: &Problem<'_>, options: &Options, mut chosen: Chosen) -> Chosen {
    // A finite impulse response has no poles, and chooses its own length: only its first coefficient is sought.
    let (orders, delays) = match options.method.has(Property::HasNoPoles) {
        true => (0..=0, usize::from(options.speed.is_some())..=1),
        false => (1..=METHOD_MAX_ORDER, 1..=METHOD_MAX_DELAY),
    };
    let delays = options.delay.map_or(delays, |delay| delay..=delay);
    let structures = orders.flat_map(|order| {
        delays.clone().map(move |delay| Structure {
            delay,
            start: part.structure.start,
            ..options.structure(order)
        })
    });
    let candidates = criteria::search(part, chosen.estimator.as_ref(), structures);
    if let Some(it) = choice(&candidates) {
        chosen.structure = Structure {
            delay: it.delay,
            ..options.structure(it.order)
        };
    }
    chosen.search.candidates = candidates;
    chosen
}

/// The model chosen by cross-validation; for a step test, or if the plant may integrate, a process model if it fits equally well.
fn automatic(
    problem: &Problem<'_>,
    part: &Problem<'_>,
    options: &Options,
    stood: bool,
    following: Following,
) -> Result<Chosen> {
    let chosen = between_samples(problem, part, options, following);
    let is_free = options.order.is_none()
        && options.numerator.is_none()
        && options.delay.is_none()
        && options.zeros_at_one + options.integrators == 0
        && !options.own_numerators;
    let other = chosen.as_ref().ok();
    let other = other.and_then(|it| Some((it.estimate.as_ref()?, it.best().fit())));
    let process = is_free.then(|| process::instead_of(problem, other, stood));
    match process.flatten() {
        Some(process) => Ok(process.into()),
        None => chosen,
    }
}

/// The model chosen by cross-validation for an input held between its samples. If the output seems to respond at once or earlier, an input that moves
/// on straight lines is used if it fits better.
fn between_samples(
    problem: &Problem<'_>,
    part: &Problem<'_>,
    options: &Options,
    following: Following,
) -> Result<Chosen> {
    let validation = |lines| CrossValidation {
        problem,
        part,
        options,
        lines,
        following,
    };
    let held = validation(false).chosen()?;
    let answers_at_once = match held.lag {
        Some(lag) => lag.interval.1 <= 0,
        None => held.structure.delay == 0,
    };
    let is_asked = options.delay.is_none() && options.order != Some(0);
    if !is_asked || !answers_at_once {
        return Ok(held);
    }
    let is_better = |lines: &Chosen| {
        let (lines, held) = (lines.best(), held.best());
        lines.is_stable() && lines.score() < held.score()
    };
    let judged = |of: &Chosen| (of.best().parameters(), of.best().fit());
    Ok(match validation(true).chosen().ok().filter(is_better) {
        Some(mut lines) => {
            lines.search.lines = Some(FirstOrderHold {
                lines: judged(&lines),
                held: judged(&held),
            });
            lines
        }
        None => held,
    })
}

/// Cross-validation on a part of the data, for an input held between its samples or moving on straight lines (`lines`).
struct CrossValidation<'a> {
    problem: &'a Problem<'a>,
    part: &'a Problem<'a>,
    options: &'a Options,
    lines: bool,
    following: Following,
}

impl CrossValidation<'_> {
    /// The chosen model, fitted to all data, with the delay that fits best.
    fn chosen(&self) -> Result<Chosen> {
        let mut selected = self.select(self.orders(), self.delays());
        // One that all the data does not determine gives way to the next.
        let fitted = |(at, it): (usize, &selection::Candidate)| Some((at, self.fit(it).ok()?));
        let Some((at, mut estimate)) = selected.iter().enumerate().find_map(fitted) else {
            let structure = self.options.structure(self.options.order.unwrap_or(1));
            let reason = LeastSquares.fit(&self.whole(&structure)).err();
            return Err(reason.unwrap_or(IdentificationError::Undetermined(
                "the record determines no model of any order",
            )));
        };
        selected.drain(..at);
        let other_order = self.leave_out_cancelled(&mut selected, &mut estimate);
        let (structure, estimator, lag) = self.seek_delay(&mut selected, &mut estimate);
        Ok(Chosen {
            estimate: Some(estimate),
            lag,
            search: Search {
                selected,
                other_order,
                ..Search::default()
            },
            ..Chosen::of(structure, estimator)
        })
    }

    fn orders(&self) -> RangeInclusive<usize> {
        self.options
            .order
            .map_or(1..=MAX_ORDER, |order| order..=order)
    }

    /// Planes move a vehicle only after a delay; a model with a given speed is a model of a vehicle. In a closed loop the input also acts only after
    /// a delay. If the input moves on straight lines, it acts in the interval before its sample.
    fn delays(&self) -> RangeInclusive<usize> {
        let is_later = self.options.speed.is_some() || self.following == Following::Yes;
        let least = usize::from(!self.lines && is_later);
        let given = self.options.delay;
        given.map_or(least..=MAX_DELAY, |delay| delay..=delay)
    }

    fn structure(&self, order: usize, delay: usize) -> Structure {
        let mut structure = self.options.structure(order);
        structure.delay = delay;
        structure.start = self.part.structure.start;
        let is_instant = delay == 0 && order > 0 && !self.lines;
        structure.numerator += usize::from(is_instant && self.options.numerator.is_none());
        match self.lines {
            true => structure.with_lines(),
            false => structure,
        }
    }

    fn select(
        &self,
        orders: RangeInclusive<usize>,
        delays: RangeInclusive<usize>,
    ) -> Vec<selection::Candidate> {
        select(self.part, orders, delays, &|order, delay| {
            self.structure(order, delay)
        })
    }

    /// The problem of fitting a given structure to all data.
    fn whole(&self, structure: &Structure) -> Problem<'_> {
        Problem {
            structure: Structure {
                start: self.problem.structure.start,
                ..structure.clone()
            },
            ..self.problem.clone()
        }
    }

    fn fit(&self, candidate: &selection::Candidate) -> Result<Estimate> {
        candidate.estimator().fit(&self.whole(&candidate.structure))
    }

    /// Leaves out a pole that a zero may cancel, if a model of lower order is nearly as good. Returns the alternative model: with such a pole, or
    /// without one if the chosen model still has one.
    fn leave_out_cancelled(
        &self,
        selected: &mut Vec<selection::Candidate>,
        estimate: &mut Estimate,
    ) -> Option<OtherOrder> {
        let cancels = |of: &Estimate| !Reading::new(of, 0).cancelled_poles().is_empty();
        let other = |of: &selection::Candidate, estimate: &Estimate| OtherOrder {
            order: of.order(),
            cancels: cancels(estimate),
            gain: Reading::new(estimate, 0).steady_state_gain(),
            fit: of.fit(),
        };
        let best = selected[0].clone();
        let with_cancelled = other(&best, estimate);
        while cancels(estimate)
            && let Some(simpler) = selected[0].simpler(selected, &best).cloned()
            && let Ok(fitted) = self.fit(&simpler)
        {
            selected.retain(|it| *it != simpler);
            selected.insert(0, simpler);
            *estimate = fitted;
        }
        match cancels(estimate) {
            true => selected[0]
                .lower(selected)
                .take(OTHERS)
                .find_map(|it| Some(other(it, &self.fit(it).ok()?)).filter(|it| !it.cancels)),
            false => Some(with_cancelled).filter(|it| it.cancels),
        }
    }

    /// The delay that fits best; cross-validation tries only a few delays.
    fn seek_delay(
        &self,
        selected: &mut Vec<selection::Candidate>,
        estimate: &mut Estimate,
    ) -> (Structure, Box<dyn Estimator>, Option<Lag>) {
        let least = *self.delays().start();
        let mut estimator = selected[0].estimator();
        let mut of = self.whole(&selected[0].structure);
        let mut lag = lag::lag(estimate, &of, self.following);
        for _ in 0..DELAYS {
            let another = lag.filter(|it| {
                let interval = it.interval.0..=it.interval.1;
                self.options.delay.is_none() && !interval.contains(&(of.structure.delay as i64))
            });
            let best = another.and_then(|it| usize::try_from(it.best).ok());
            let Some(best) = best.filter(|best| *best >= least) else {
                break;
            };
            // At the right delay fewer poles may do.
            let fewest = *self.orders().start();
            let orders = fewest..=selected[0].structure.poles.max(fewest);
            let again = self.select(orders, best..=best);
            let better = again
                .first()
                .filter(|it| it.is_stable() && it.score() <= selected[0].score());
            if let Some((it, fitted)) = better.and_then(|it| Some((it, self.fit(it).ok()?))) {
                (estimator, of) = (it.estimator(), self.whole(&it.structure));
                *estimate = fitted;
                selected.splice(0..0, again);
            } else {
                let before = std::mem::replace(&mut of.structure.delay, best);
                match estimator.fit(&of) {
                    Ok(better) => *estimate = better,
                    Err(_) => {
                        of.structure.delay = before;
                        break;
                    }
                }
            }
            // With the other delay another may fit better still.
            lag = lag::lag(estimate, &of, self.following);
        }
        (of.structure, estimator, lag)
    }
}
