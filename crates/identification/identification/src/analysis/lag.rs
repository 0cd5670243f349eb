//! The interval of the delay: the shortest and longest delays at which the model fits as well.
//!
//! For each delay all other parameters are fitted again, with the residual whitened by its autoregression. A delay with sum of squares S lies outside
//! the 95 % interval if `N ln(S / S_least)` exceeds 3.84 (profile likelihood; Wilks 1938). Delays below 0 are tried as well: then the output moves
//! before its input. In a closed loop they are not tried, because a model without delay would be that of the controller.
//!
//! A model of too low an order has a longer delay, to replace missing lags. So a part of the delay is replaced by one, two or three equal lags before
//! the model, with time constants that sum to about that part. The number of parameters is the same; if the model fits as well, the interval begins
//! at the remaining delay.

use std::ops::Range;

use crate::estimators::{Error, Estimate, NormalEquations, Search, radius_of_memory};
use crate::selection::Candidate;
use crate::structure::{InitialState, Problem};
use crate::validation::identifiability::Following;
use planesman_record::Run;

/// The 95 % and 99.9 % quantiles of the chi-squared distribution with one degree of freedom.
const WITHIN: f64 = 3.841_459;
const BEYOND_DOUBT: f64 = 10.827_566;
/// Maximum number of samples by which a delay is moved, and by which the output may precede its input.
pub(crate) const FARTHEST: i64 = 20;
const EARLIEST: i64 = -10;
/// Maximum number of lags that replace a part of the delay.
const MOST_LAGS: usize = 3;
/// Up to this many samples of additional delay, every output of the record is used.
const LATER: usize = 4;
/// Sum of the lags' time constants relative to the replaced part of the delay; the model's own lags compensate for the rest.
const LONGER: [f64; 3] = [1.0, 1.5, 0.7];

/// Information in the record about the delay, samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lag {
    /// The delay that fits best.
    pub best: i64,
    /// Lower and upper end of the 95 % interval.
    pub interval: (i64, i64),
    /// Whether the best delay fits significantly better than the model's delay (99.9 %).
    pub is_another: bool,
}

/// First-order lags with equal time constants, in series before a model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lags {
    count: usize,
    pole: f64,
}

impl Lags {
    pub(crate) const NONE: Self = Self {
        count: 0,
        pole: 0.0,
    };

    /// `count` lags with a total mean delay of `delay` samples.
    fn instead_of(delay: f64, count: usize) -> Self {
        let pole = delay / (delay + count as f64);
        Self { count, pole }
    }

    /// Filters an input by the lags. The state starts from 0 if the record begins at rest, otherwise from its first value.
    pub(crate) fn of(self, input: &[f64], rests: bool) -> Vec<f64> {
        let mut all = input.to_vec();
        for _ in 0..self.count {
            let mut state = all.first().copied().filter(|_| !rests).unwrap_or_default();
            for value in &mut all {
                state = self.pole * state + (1.0 - self.pole) * *value;
                *value = state;
            }
        }
        all
    }
}

impl Lag {
    /// Extends the interval by the delays of models that cross-validation cannot distinguish: their Bayesian criterion is within the bound of the
    /// lowest one.
    pub(super) fn with_candidates(self, candidates: &[Candidate]) -> Self {
        let stable = || candidates.iter().filter(|it| it.is_stable());
        let Some(best) = stable().min_by(|p, q| p.criterion().total_cmp(&q.criterion())) else {
            return self;
        };
        let alike = stable().filter(|it| it.is_alike(best, WITHIN));
        let delays = alike.map(|it| it.structure.delay as i64);
        let (least, most) = self.interval;
        let interval = delays.fold((least, most), |(p, q), it| (p.min(it), q.max(it)));
        Self { interval, ..self }
    }
}

/// A model and the longest record it was fitted to, with other delays.
struct Moved<'a> {
    one: Problem<'a>,
    poles: Vec<f64>,
    whitening: Vec<f64>,
    /// Range of outputs that count: from the first whose inputs are known at every delay to the last that the record allows with the output one
    /// sample ahead.
    outputs: Range<usize>,
    earliest: i64,
}

impl<'a> Moved<'a> {
    /// `None` for models other than output error, and for models with a separate dead time.
    fn of(found: &Estimate, problem: &Problem<'a>, following: Following) -> Option<Self> {
        let has_dead_time = found.process.is_some() || found.frequency.is_some();
        if found.error != Error::Output || found.physical.is_some() || has_dead_time {
            return None;
        }
        let one = Problem {
            runs: vec![*problem.runs.iter().max_by_key(|run| run.outputs.len())?],
            structure: found.layout.structure.clone(),
            sample_time: problem.sample_time,
        };
        let one = one.part().unwrap_or(one);
        let poles = found.theta.as_slice()[found.layout.a()].to_vec();
        let equations = NormalEquations::new(&one, &[1.0]);
        let whitening = equations.whitening(&equations.completed(&poles, &equations.whole())?);
        let count = one.runs[0].outputs.len();
        let last = count.checked_sub(EARLIEST.unsigned_abs() as usize)?;
        let first = match one.structure.start {
            InitialState::Rest => 0,
            InitialState::Estimated => (one.structure.history() + LATER).min(last / 4),
        };
        let earliest = match following {
            Following::Yes => i64::try_from(one.structure.delay.min(1)).ok()?,
            _ => EARLIEST,
        };
        Some(Self {
            one,
            poles,
            whitening,
            outputs: first..last,
            earliest,
        })
    }

    fn samples(&self) -> usize {
        self.outputs.len()
    }

    /// The minimum sum of squared errors with a given delay and these lags.
    fn cost(&self, delay: i64, lags: Lags) -> Option<f64> {
        if delay < self.earliest {
            return None;
        }
        let (run, rests) = (
            &self.one.runs[0],
            self.one.structure.start == InitialState::Rest,
        );
        let inputs = lags.of(&[run.past, run.inputs].concat(), rests);
        let ahead = delay.min(0).unsigned_abs() as usize;
        let [first, end] =
            [self.outputs.start, self.outputs.end].map(|it| run.past.len() + ahead + it);
        let mut of = self.one.clone();
        of.structure.delay = delay.max(0) as usize;
        of.runs[0] = Run {
            past: &inputs[..first],
            inputs: &inputs[first..end],
            outputs: &run.outputs[self.outputs.clone()],
        };
        let equations = NormalEquations::new(&of, &self.whitening);
        let whole = equations.whole();
        let search = Search {
            steps: 20,
            enough: 1e-7,
            radius: radius_of_memory(self.outputs.end),
        };
        let start = equations.completed(&self.poles, &whole)?;
        Some(equations.minimised(start, &whole, search)?.1)
    }
}

/// The delay's interval of an output-error model, from the longest record that the model was fitted to.
pub(super) fn lag(found: &Estimate, problem: &Problem<'_>, following: Following) -> Option<Lag> {
    let of = Moved::of(found, problem, following)?;
    let chosen = i64::try_from(of.one.structure.delay).ok()?;
    profile(chosen, of.samples(), |delay| of.cost(delay, Lags::NONE))
}

/// The delay's interval, including models whose lags replace a part of the delay.
pub(super) fn with_lags(
    lag: Lag,
    found: &Estimate,
    problem: &Problem<'_>,
    following: Following,
) -> Lag {
    match Moved::of(found, problem, following) {
        Some(of) => lag.with_lags(of.samples(), |delay, lags| of.cost(delay, lags)),
        None => lag,
    }
}

/// Significance by which one sum of squares is worse than another, for this many samples.
fn worse(samples: usize, cost: f64, than: f64) -> f64 {
    samples as f64 * libm::log(cost / than)
}

/// The interval of the delay from the sum of squares at each delay: from `chosen` in both directions, as far as the delays are inside the interval.
pub(crate) fn profile(
    chosen: i64,
    samples: usize,
    mut cost: impl FnMut(i64) -> Option<f64>,
) -> Option<Lag> {
    let own = cost(chosen)?;
    let mut costs = vec![(chosen, own)];
    for step in [-1, 1] {
        let mut delay = chosen;
        loop {
            delay += step;
            if (delay - chosen).abs() > FARTHEST {
                break;
            }
            let Some(cost) = cost(delay) else {
                break;
            };
            let least = costs.iter().map(|it| it.1).fold(f64::INFINITY, f64::min);
            costs.push((delay, cost));
            if worse(samples, cost, least) > WITHIN {
                break;
            }
        }
    }
    let (best, least) = costs.iter().copied().min_by(|p, q| p.1.total_cmp(&q.1))?;
    let within = || {
        costs
            .iter()
            .filter(|it| worse(samples, it.1, least) <= WITHIN)
            .map(|it| it.0)
    };
    Some(Lag {
        best,
        interval: (within().min()?, within().max()?),
        is_another: worse(samples, own, least) > BEYOND_DOUBT,
    })
}

impl Lag {
    /// Extends the interval to shorter delays at which the model with lags fits as well.
    pub(crate) fn with_lags(
        self,
        samples: usize,
        mut cost: impl FnMut(i64, Lags) -> Option<f64>,
    ) -> Self {
        let Some(least) = cost(self.best, Lags::NONE) else {
            return self;
        };
        let mut earliest = self.interval.0;
        for count in 1..=MOST_LAGS {
            let delays = ((self.best - FARTHEST).max(0)..self.best).rev();
            let is_within = |delay: &i64| {
                LONGER.into_iter().any(|longer| {
                    let lags = Lags::instead_of(longer * (self.best - delay) as f64, count);
                    cost(*delay, lags).is_some_and(|it| worse(samples, it, least) <= WITHIN)
                })
            };
            let last = delays.take_while(is_within).last();
            earliest = last.map_or(earliest, |it| earliest.min(it));
        }
        Self {
            interval: (earliest, self.interval.1),
            ..self
        }
    }
}
