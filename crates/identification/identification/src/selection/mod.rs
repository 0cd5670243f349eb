//! The choice of order, delay and kind of model: for a named method by [`criteria`], otherwise by cross-validation.
//!
//! For every order and delay three kinds are tried: output error, the same with an autoregressive noise model (Box-Jenkins), and the
//! difference equation by least squares (ARX). The searches begin at poles of a high-order equation, reduced to the order (`realisation`).
//! Each candidate is fitted again with a half, and with a fifth, of every record left out, and simulated there. The state comes from the
//! samples before; for an ARX model it is fitted in the block. Candidates are compared block by block, by the logarithm of the mean squared
//! error plus `ln N / N` for each parameter, with N the effective number of samples for coloured residuals. Among the candidates within half a
//! standard error of the best, the one with the fewest parameters is chosen (Hastie, Tibshirani and Friedman, *The Elements of Statistical Learning*,
//! 2nd ed., 2009, sec. 7.10). The memory of a pole is limited to the length of the record, unless an unstable difference equation has half the error
//! or less: then the data demands it. The simulation of an unstable plant has no meaning beyond its time constant. If the equation with the lowest
//! criterion is unstable, the two are compared in windows of two of its time constants, with the state fitted in each. An unstable plant is in a
//! closed loop, where output noise biases an equation error: models with a noise model (ARMAX) are tried too. A stable difference equation is chosen
//! only if there is nothing else: with its state fitted in the block, its error is optimistic.
//!
//! A model with a pole at that limit is replaced by a model without such a pole, if that model is within a standard error, or nearly as good. If the
//! best stable model has a pole at that limit, models with an integrator are tried too; they are kept if their error is smaller in either half.

mod candidate;
pub mod criteria;
pub(crate) mod dead_time;
pub(crate) mod folds;
pub(crate) mod lagged;
pub mod process;
pub(crate) mod realisation;

use nalgebra::{DMatrix, DVector};
use planesman_linear::ComplexFunctions as _;
use planesman_linear::polynomial::{self, product};

pub use candidate::{Candidate, Kind};
pub(crate) use candidate::{errors_not_significantly_worse, mean_logarithm};

use crate::estimators::{
    Armax, Estimator, LeastSquares, NormalEquations, Search, held_within, independent_share,
    lies_within, radius_of_memory,
};
use crate::scale::Scale;
use crate::states::poles_of_states;
use crate::structure::{InitialState, Problem, Structure, monic};
use folds::{Fold, Folds, State};
use lagged::Lagged;
use planesman_parallel::on_all_cores;
use planesman_record::Run;

/// Largest lag of the regressions.
const LAGS: usize = 40;
/// Minimum number of samples for each of an order's parameters.
const SAMPLES_PER_PARAMETER: usize = 4;
/// Minimum effective number of samples of the errors.
pub(crate) const MIN_EFFECTIVE_SAMPLES: f64 = 10.0;
/// Number of orders tried beyond the best so far.
const PATIENCE: usize = 4;
/// The noise is modelled if the logarithm of the output error exceeds the smallest so far by at most this.
const NOISE_MODEL_LOG_ERROR: f64 = 0.7;
/// Rounds of noise model and model.
const ROUNDS: usize = 2;
/// Standard errors by which a candidate with fewer parameters may be worse than the best. The usual one standard error, in addition to
/// the criterion's own penalty, gave too low an order on four of eleven public data sets.
pub(crate) const STANDARD_ERRORS: f64 = 0.5;
/// A model without a pole at the memory limit may have a logarithm of the error that is larger by this, which is a twentieth of the root-mean-square error.
const SLACK: f64 = 0.1;
/// The error of an unstable model with half the record left out must be below this share of a stable model's.
const DEMANDS: f64 = 0.5;
/// Length of the windows in which unstable models are compared, in time constants, and their minimum number of samples.
const UNSTABLE_TIME_CONSTANTS: f64 = 2.0;
const MIN_WINDOW: usize = 20;
/// Number of these windows in the records above which the motion of an unstable plant counts as growing strongly, and the maximum order of stable models
/// for such a plant.
const GROWN: usize = 4;
const CALM_ORDERS: usize = 2;

/// The candidates, the chosen one first, then sorted by their errors.
#[must_use]
pub fn select(
    problem: &Problem<'_>,
    orders: std::ops::RangeInclusive<usize>,
    delays: std::ops::RangeInclusive<usize>,
    structure: &(dyn Fn(usize, usize) -> Structure + Sync),
) -> Vec<Candidate> {
    let mut candidates = cross_validated(problem, orders.clone(), delays.clone(), structure);
    // A delay that was given is the only one.
    let is_searched = delays.start() < delays.end();
    let farther = is_searched.then(|| dead_time::beyond(problem, &delays));
    let mut delays = delays;
    if let Some(farther) = farther.flatten() {
        candidates.extend(cross_validated(
            problem,
            orders.clone(),
            farther.clone(),
            structure,
        ));
        delays = farther;
    }
    let (stable, _) = by_stability(&candidates);
    if structure(1, 1).known_denominator == [1.0]
        && let Some(slow) = least(&stable).filter(|it| it.at_limit).cloned()
    {
        let integrating = |order, delay| structure(order, delay).with_integrator();
        let mut others = cross_validated(problem, orders, delays, &integrating);
        others.retain(|it| it.is_stable() && !it.at_limit && it.leaves_less(1.0, &slow));
        candidates.extend(others);
    }
    let mut chosen = choice(&candidates);
    if let Some(wild) = chosen.as_ref().filter(|it| !it.is_stable())
        && let Some(better) = with_noise_model(problem, wild, structure)
    {
        candidates.push(better.clone());
        chosen = Some(better);
    }
    candidates.sort_by(|p, q| p.score().total_cmp(&q.score()));
    if let Some(chosen) = chosen
        && let Some(at) = candidates.iter().position(|of| *of == chosen)
    {
        let chosen = candidates.remove(at);
        candidates.insert(0, chosen);
    }
    candidates
}

/// The candidates of one structure, unsorted.
fn cross_validated(
    problem: &Problem<'_>,
    orders: std::ops::RangeInclusive<usize>,
    delays: std::ops::RangeInclusive<usize>,
    structure: &(dyn Fn(usize, usize) -> Structure + Sync),
) -> Vec<Candidate> {
    // The regressions look back so far behind the first of long delays.
    let base = if *delays.end() > LAGS / 2 {
        *delays.start()
    } else {
        0
    };
    let plain = Structure {
        delay: base,
        ..structure(1, base)
    };
    let scaled = Scaled::of(problem, &plain);
    let runs = scaled.runs();
    let samples: usize = runs.iter().map(|run| run.outputs.len()).sum();
    let lags = LAGS.min(samples / 8);
    let plain = Problem {
        structure: plain,
        sample_time: problem.sample_time,
        runs: runs.clone(),
    };
    let driving = plain.driving();
    let outputs: Vec<Vec<f64>> = runs.iter().map(|run| run.outputs.to_vec()).collect();
    let unknown = plain.unknown();
    let folds = Folds::of(&runs, &unknown);
    let at_rest = plain.structure.start == InitialState::Rest;
    let lagged = Lagged::of(&driving, &outputs, lags, &folds.parts, &unknown, at_rest);
    let constant = plain.structure.offset;
    let from_base = delays.start() - base..=delays.end() - base;
    let equation = likely_equation(&lagged, from_base, constant);
    let likely = base + equation.as_ref().map_or(*delays.start() - base, |it| it.0);
    let window = equation.and_then(|(_, equation)| window_of_unstable(&equation.a));
    // Of long delays the first is no more likely than others.
    let other = if base > 0 {
        likely + 1
    } else {
        *delays.start()
    };
    let mut tried: Vec<usize> = [likely, other, 1]
        .into_iter()
        .filter(|delay| delays.contains(delay))
        .collect();
    tried.sort_unstable();
    tried.dedup();
    let orders: Vec<usize> = orders
        .filter(|order| *order == 1 || samples > SAMPLES_PER_PARAMETER * (3 * order + 1))
        .collect();
    let most = orders.iter().copied().max().unwrap_or(1);
    let longest = (0..runs.len())
        .max_by_key(|r| runs[*r].outputs.len())
        .unwrap_or_default();
    let mut poles = Vec::new();
    if let Some(high) = realisation::high_order(&lagged, constant) {
        let run = (&driving[longest][..], &outputs[longest][..]);
        poles.push(poles_of_states((&high.a, &high.b), &[run], most));
        poles.push(realisation::from_markov_parameters(&high, samples, most));
    }
    let shared = Shared {
        runs: &runs,
        sample_time: problem.sample_time,
        folds: &folds,
        lagged: &lagged,
        base,
        products: lagged.over(&|_| true),
        kept: (0..folds.count())
            .map(|fold| lagged.over(&|part| !folds.is_left_out(fold, part)))
            .collect(),
        poles: &poles,
        radius: radius_of_memory(samples),
        samples,
        grows: grows(window, samples),
        window,
    };
    let of_delay = on_all_cores(&tried, |delay| {
        shared.candidates(*delay, &orders, structure)
    });
    let mut candidates = of_delay.concat();
    candidates.retain(|of| of.errors.iter().all(|e| e.is_finite()));
    let effective = shared.effective_samples(&candidates);
    for candidate in &mut candidates {
        candidate.samples = effective;
    }
    candidates
}

fn least<'a>(of: &[&'a Candidate]) -> Option<&'a Candidate> {
    of.iter()
        .copied()
        .min_by(|p, q| p.score().total_cmp(&q.score()))
}

/// The stable candidates (ARX models only if there are no others), and the unstable ones.
fn by_stability(candidates: &[Candidate]) -> (Vec<&Candidate>, Vec<&Candidate>) {
    let (mut stable, unstable): (Vec<&Candidate>, Vec<&Candidate>) =
        candidates.iter().partition(|of| of.is_stable());
    if stable.iter().any(|of| of.kind != Kind::Arx) {
        stable.retain(|of| of.kind != Kind::Arx);
    }
    (stable, unstable)
}

/// The chosen candidate.
fn choice(candidates: &[Candidate]) -> Option<Candidate> {
    let (stable, unstable) = by_stability(candidates);
    let demanded = match (least(&stable), least(&unstable)) {
        (Some(calm), Some(wild)) => wild.leaves_less(DEMANDS, calm),
        (calm, _) => calm.is_none(),
    };
    // At no delay the equation of a loop may be its controller's.
    let late = |of: &&Candidate| of.structure.delay > 0;
    let unstable = match unstable.iter().any(late) {
        true => unstable.into_iter().filter(late).collect(),
        false => unstable,
    };
    let among = if demanded { unstable } else { stable };
    let best = least(&among)?;
    let determined: Vec<&Candidate> = among.iter().copied().filter(|of| !of.at_limit).collect();
    let among = match least(&determined) {
        Some(it) if it.is_within(1.0, SLACK, best) => determined,
        _ => among,
    };
    let best = least(&among)?;
    among
        .into_iter()
        .filter(|of| of.is_within(STANDARD_ERRORS, 0.0, best))
        .min_by(|p, q| (p.parameters().cmp(&q.parameters())).then(p.score().total_cmp(&q.score())))
        .cloned()
}

/// Whether a motion that at least doubles in the window grows strongly in this many samples.
fn grows(window: Option<usize>, samples: usize) -> bool {
    window.is_some_and(|window| GROWN * window < samples)
}

/// An ARMAX model of an unstable plant, of at most its ARX model's order, if its Bayesian criterion is lower.
fn with_noise_model(
    problem: &Problem<'_>,
    wild: &Candidate,
    structure: &(dyn Fn(usize, usize) -> Structure + Sync),
) -> Option<Candidate> {
    let samples: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
    if wild.structure.own_numerators || !grows(window_of_unstable(&wild.poles), samples) {
        return None;
    }
    let of_order = |order| structure(order, wild.structure.delay);
    let plain = criteria::search(problem, &LeastSquares, [wild.structure.clone()].into_iter());
    let found = criteria::search(problem, &Armax, (1..=wild.order()).map(of_order));
    let best = found.first()?;
    if plain.first().is_some_and(|plain| plain.bic <= best.bic) {
        return None;
    }
    let structure = of_order(best.order);
    let within = |runs| Problem {
        structure: structure.clone(),
        sample_time: problem.sample_time,
        runs,
    };
    let fit = |runs| Armax.fit(&within(runs)).ok();
    let unknown = problem.unknown();
    let folds = Folds::of(&problem.runs, &unknown);
    let whole = fit(problem.runs.clone())?;
    let poles = whole.theta.as_slice()[whole.layout.a()].to_vec();
    let window = window_of_unstable(&poles);
    let of_structure = within(problem.runs.clone());
    let driving = of_structure.driving();
    let errors: Vec<f64> = (0..folds.count())
        .map(|fold| {
            let found = fit(folds.around(fold, &problem.runs))?;
            let runs = found.layout.runs;
            let offset = (0..runs).map(|run| found.offset(run)).sum::<f64>() / runs as f64;
            let model = Fold {
                a: &found.theta.as_slice()[found.layout.a()],
                numerator: &|_| &found.theta.as_slice()[found.layout.b(0)],
                offset: &|_| offset,
            };
            Some(folds.error(fold, &of_structure, &driving, &model, State::Fitted(window)))
        })
        .collect::<Option<_>>()?;
    Some(Candidate {
        kind: Kind::Armax,
        poles,
        structure,
        in_windows: errors[..folds::HALVES].to_vec(),
        afresh: errors.clone(),
        errors,
        ..wild.clone()
    })
}

/// The residual variance of a high-order equation of the records, as a model-independent estimate of the noise.
pub(crate) fn innovation_variance(problem: &Problem<'_>) -> Option<f64> {
    let delay = problem.structure.delay;
    let plain = Problem {
        structure: Structure {
            delay: if delay > LAGS / 2 { delay } else { 0 },
            ..problem.structure.clone()
        },
        ..problem.clone()
    };
    let plain = plain.part().unwrap_or(plain);
    let outputs: Vec<Vec<f64>> = plain.runs.iter().map(|run| run.outputs.to_vec()).collect();
    let samples: usize = outputs.iter().map(Vec::len).sum();
    let unknown = plain.unknown();
    let parts = Folds::of(&plain.runs, &unknown).parts;
    let (driving, lags) = (plain.driving(), LAGS.min(samples / 8));
    let lagged = Lagged::of(&driving, &outputs, lags, &parts, &unknown, false);
    let found = realisation::high_order(&lagged, true)?;
    let freedom = found.rows.checked_sub(found.a.len() + found.b.len() + 1)?;
    Some(found.variance * found.rows as f64 / freedom.max(1) as f64)
}

/// The difference equation with the lowest Bayesian criterion, and its delay.
fn likely_equation(
    lagged: &Lagged,
    delays: std::ops::RangeInclusive<usize>,
    constant: bool,
) -> Option<(usize, lagged::Equation)> {
    const ORDERS: [usize; 6] = [1, 2, 3, 4, 6, 8];
    let all = lagged.over(&|_| true);
    let criterion = |of: &lagged::Equation| {
        let n = of.rows as f64;
        n * libm::log(of.variance.max(f64::MIN_POSITIVE))
            + (of.a.len() + of.b.len()) as f64 * libm::log(n)
    };
    let pairs = delays
        .clone()
        .flat_map(|delay| ORDERS.map(|order| (delay, order)));
    pairs
        .filter_map(|(delay, order)| {
            let found = lagged.equation(&all, order, delay, order, constant)?;
            Some((criterion(&found), (delay, found)))
        })
        .min_by(|p, q| p.0.total_cmp(&q.0))
        .map(|(_, found)| found)
}

/// The window in which models of a plant with an unstable pole are compared, samples; `None` for a stable plant.
fn window_of_unstable(a: &[f64]) -> Option<usize> {
    let poles = polynomial::roots(&monic(a)).ok()?;
    let growth = poles
        .iter()
        .map(|pole| libm::log(pole.modulus()))
        .fold(0.0, f64::max);
    let window = UNSTABLE_TIME_CONSTANTS / growth;
    (growth > 0.0).then(|| (window as usize).max(MIN_WINDOW))
}

/// Data shared by the candidates of all delays.
struct Shared<'a> {
    runs: &'a [Run<'a>],
    sample_time: f64,
    folds: &'a Folds,
    lagged: &'a Lagged,
    /// The delay of the inputs.
    base: usize,
    /// The products of its columns over all rows, and with each block left out.
    products: (DMatrix<f64>, usize),
    kept: Vec<(DMatrix<f64>, usize)>,
    /// Starts: poles of order 1, 2, ... from each realisation.
    poles: &'a [Vec<Vec<f64>>],
    radius: f64,
    samples: usize,
    /// Whether the plant is unstable and grows strongly: then a search for stable models would be long and futile.
    grows: bool,
    /// The window in which a state is fitted, instead of a simulation through the record, samples.
    window: Option<usize>,
}

impl Shared<'_> {
    fn problem(&self, structure: Structure) -> Problem<'_> {
        Problem {
            structure,
            sample_time: self.sample_time,
            runs: self.runs.to_vec(),
        }
    }

    fn candidates(
        &self,
        delay: usize,
        orders: &[usize],
        structure: &dyn Fn(usize, usize) -> Structure,
    ) -> Vec<Candidate> {
        let mut found = Vec::new();
        let mut before: Option<Vec<f64>> = None;
        let mut least: Option<(usize, f64)> = None;
        for order in orders {
            if least.is_some_and(|(at, _)| *order > at + PATIENCE) {
                break;
            }
            let problem = self.problem(structure(*order, delay));
            found.extend(self.arx(&problem));
            if self.grows && *order > CALM_ORDERS {
                continue;
            }
            let plain = NormalEquations::new(&problem, &[1.0]);
            let Some(theta) = self.output_error(&problem, &plain, before.as_deref()) else {
                continue;
            };
            before = Some(theta.as_slice()[..problem.structure.poles].to_vec());
            let candidate = self.judged(&problem, &plain, None, &theta);
            let score = candidate.as_ref().map_or(f64::INFINITY, Candidate::score);
            found.extend(candidate);
            if !self.grows && least.is_none_or(|(_, least)| score < least + NOISE_MODEL_LOG_ERROR) {
                found.extend(self.box_jenkins(&problem, &plain, theta));
            }
            if least.is_none_or(|(_, least)| score < least) {
                least = Some((*order, score));
            }
        }
        found
    }

    /// The effective number of samples of the errors: fewer if the best model's residual is coloured.
    fn effective_samples(&self, candidates: &[Candidate]) -> f64 {
        let (stable, _) = by_stability(candidates);
        let best = stable
            .into_iter()
            .min_by(|p, q| p.mean().total_cmp(&q.mean()));
        let share = best.and_then(|best| {
            let problem = self.problem(best.structure.clone());
            let equations = NormalEquations::new(&problem, &[1.0]);
            let theta = equations.completed(&best.poles, &equations.whole())?;
            Some(independent_share(&equations.whitening(&theta)))
        });
        (self.samples as f64 * share.unwrap_or(1.0)).max(MIN_EFFECTIVE_SAMPLES)
    }

    /// A radius just below the largest allowed radius.
    fn inside(&self) -> f64 {
        1.0 - 1.01 * (1.0 - self.radius)
    }

    /// Whether a zero is so near z = 1 that the record cannot distinguish the pair from no pole and zero.
    fn cancels_integrator(&self, problem: &Problem<'_>, numerator: &[f64]) -> bool {
        let room = 1.0 - self.radius;
        problem.structure.known_denominator.len() > 1
            && (polynomial::roots(numerator).unwrap_or_default().iter())
                .any(|zero| (zero - 1.0).modulus() < room)
    }

    fn search(&self, steps: usize) -> Search {
        Search {
            steps,
            enough: 1e-6,
            radius: self.radius,
        }
    }

    /// The smallest output error of the searches from every start.
    fn output_error(
        &self,
        problem: &Problem<'_>,
        equations: &NormalEquations,
        before: Option<&[f64]>,
    ) -> Option<DVector<f64>> {
        let n = problem.structure.poles;
        let whole = equations.whole();
        let of_equation = self.equation(problem, &self.products).map(|it| it.a);
        let longer = before.map(|a| {
            let mut longer = product(&monic(a), &[1.0, -0.5]);
            longer.remove(0);
            longer
        });
        let realised = self
            .poles
            .iter()
            .filter_map(|by| by.get(n.checked_sub(1)?).cloned());
        let mut starts: Vec<(f64, DVector<f64>)> = realised
            .chain(of_equation)
            .chain(longer)
            .filter(|a| a.len() == n)
            .filter_map(|a| {
                let a = held_within(&a, self.radius)?.unwrap_or(a);
                let theta = equations.completed(&a, &whole)?;
                Some((equations.total(&theta, &whole)?.cost, theta))
            })
            .collect();
        starts.sort_by(|p, q| p.0.total_cmp(&q.0));
        starts.truncate(2);
        starts
            .into_iter()
            .filter_map(|(_, start)| equations.minimised(start, &whole, self.search(40)))
            .min_by(|p, q| p.1.total_cmp(&q.1))
            .map(|(theta, _)| theta)
    }

    /// Starts at the output error's minimum, and alternates between fitting a noise model to the residual and refitting the model.
    fn box_jenkins(
        &self,
        problem: &Problem<'_>,
        plain: &NormalEquations,
        start: DVector<f64>,
    ) -> Option<Candidate> {
        let mut theta = start;
        let mut noise = None;
        for _ in 0..ROUNDS {
            let d = plain.whitening(&theta);
            if d.len() == 1 {
                break;
            }
            let whitened = NormalEquations::new(problem, &d);
            theta = whitened
                .minimised(theta, &whitened.whole(), self.search(20))?
                .0;
            noise = Some((whitened, d));
        }
        self.judged(problem, plain, Some(noise?), &theta)
    }

    /// A candidate with the errors of each fold: output error, or Box-Jenkins with a noise model.
    fn judged(
        &self,
        problem: &Problem<'_>,
        plain: &NormalEquations,
        noise: Option<(NormalEquations, Vec<f64>)>,
        theta: &DVector<f64>,
    ) -> Option<Candidate> {
        let kind = match noise {
            None => Kind::OutputError,
            Some(_) => Kind::BoxJenkins,
        };
        let (equations, whitening) = match &noise {
            None => (plain, &[1.0][..]),
            Some((whitened, d)) => (whitened, d.as_slice()),
        };
        let lead = whitening.len() - 1;
        let layout = problem.layout();
        let driving = problem.driving();
        let mut errors = Vec::new();
        let (mut afresh, mut in_windows) = (Vec::new(), Vec::new());
        for fold in 0..self.folds.count() {
            let kept = self.folds.kept(fold, lead);
            let (found, _) = equations.minimised(theta.clone(), &kept, self.search(3))?;
            let model = Fold {
                a: &found.as_slice()[layout.a()],
                numerator: &|run| &found.as_slice()[layout.b(run)],
                offset: &|run| layout.offset(run).map_or(0.0, |at| found[at]),
            };
            let through: Vec<Vec<f64>> = (0..self.runs.len())
                .map(|run| plain.errors(&found, run))
                .collect();
            let error = |state| (self.folds).error(fold, problem, &driving, &model, state);
            errors.push(error(State::Through(&through)));
            afresh.push(error(State::Before));
            if fold < folds::HALVES {
                in_windows.push(error(State::Fitted(self.window)));
            }
        }
        Some(Candidate {
            kind,
            structure: problem.structure.clone(),
            poles: theta.as_slice()[layout.a()].to_vec(),
            whitening: whitening.to_vec(),
            errors,
            afresh,
            in_windows,
            at_limit: held_within(&theta.as_slice()[layout.a()], self.inside()) != Some(None)
                || self.cancels_integrator(problem, &theta.as_slice()[layout.b(0)]),
            samples: self.samples as f64,
        })
    }

    fn equation(
        &self,
        problem: &Problem<'_>,
        products: &(DMatrix<f64>, usize),
    ) -> Option<lagged::Equation> {
        let s = &problem.structure;
        self.lagged.equation(
            products,
            s.poles,
            s.delay - self.base,
            s.numerator,
            s.offset,
        )
    }

    fn arx(&self, problem: &Problem<'_>) -> Option<Candidate> {
        let whole = self.equation(problem, &self.products)?;
        let driving = problem.driving();
        let is_stable = lies_within(&whole.a, 1.0);
        let errors: Vec<f64> = (0..self.folds.count())
            .map(|fold| {
                let found = self.equation(problem, &self.kept[fold])?;
                let offset = found.constant / (1.0 + found.a.iter().sum::<f64>());
                let model = Fold {
                    a: &found.a,
                    numerator: &|_| &found.b,
                    offset: &|_| offset,
                };
                let state = State::Fitted(self.window.filter(|_| !is_stable));
                Some((self.folds).error(fold, problem, &driving, &model, state))
            })
            .collect::<Option<_>>()?;
        Some(Candidate {
            kind: Kind::Arx,
            structure: problem.structure.clone(),
            poles: whole.a,
            whitening: vec![1.0],
            in_windows: errors[..folds::HALVES].to_vec(),
            afresh: errors.clone(),
            errors,
            at_limit: false,
            samples: self.samples as f64,
        })
    }
}

/// The records minus their means, divided by their standard deviations, if the structure allows it.
struct Scaled {
    past: Vec<Vec<f64>>,
    inputs: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
}

impl Scaled {
    fn of<'a>(problem: &Problem<'a>, s: &Structure) -> Self {
        let scaled = |signals: &[&[f64]], scale: Scale| {
            let signals = signals.iter();
            signals.map(|it| scale.taken_off(it)).collect()
        };
        let free = s.offset && s.start == InitialState::Estimated;
        let all = |of: fn(&Run<'a>) -> &'a [f64]| problem.runs.iter().map(of).collect::<Vec<_>>();
        let (past, inputs) = (all(|run| run.past), all(|run| run.inputs));
        let outputs = all(|run| run.outputs);
        let of_inputs = Scale::of(&inputs, free && s.known_denominator == [1.0]);
        Self {
            past: scaled(&past, of_inputs),
            inputs: scaled(&inputs, of_inputs),
            outputs: scaled(&outputs, Scale::of(&outputs, s.offset)),
        }
    }

    fn runs(&self) -> Vec<Run<'_>> {
        let pairs = self.past.iter().zip(&self.inputs).zip(&self.outputs);
        pairs
            .map(|((past, inputs), outputs)| Run {
                past,
                inputs,
                outputs,
            })
            .collect()
    }
}
