//! The choice of each channel's order and delay, and of the inputs with an effect.
//!
//! The search begins with order 1 in every channel, at the delays of the most likely difference equation. Each step changes an order or a
//! delay in one channel; all parameters are fitted again at each step. The search descends twice: first on the simulated error, with the effective
//! number of samples for a coloured residual, then on the error whitened by the residual's autoregression. In the second descent inputs may be left
//! out, or added again, by the Bayesian criterion with the delay counted as a parameter: an F test. Models on the path and near its end are
//! cross-validated, output error and with the noise model, as for one input. The model at the end of the path is chosen if it is within a standard
//! error of the best. Otherwise the rule for one input is used: the model with the fewest parameters within half a standard error.

use nalgebra::DVector;
use planesman_linear::polynomial::product;
use planesman_parallel::{on_all_cores, stop_point};
use planesman_record::{Run, Segment};

use super::equations::Equations;
use super::layout::{Channel, Layout};
use super::options::Options;
use super::regressions::{Equation, Regressions};
use crate::estimators::{Search, independent_share, radius_of_memory};
use crate::free_motion::without_free_motion;
use crate::selection::folds::{Folds, HALVES};
use crate::selection::realisation::from_markov_parameters;
use crate::selection::{
    Kind, MIN_EFFECTIVE_SAMPLES, STANDARD_ERRORS, errors_not_significantly_worse, lagged,
    mean_logarithm,
};
use crate::structure::{InitialState, monic};

/// Largest order of a channel, and the longest delay.
pub(super) const MAX_ORDER: usize = 4;
pub(super) const MAX_DELAY: usize = super::regressions::LAGS;

/// Maximum number of steps of the search.
const ROUNDS: usize = 40;
/// Maximum number of steps of a fit and of a trial start, and the relative decrease of the cost that makes another step worthwhile.
const STEPS: usize = 20;
const FIRST_STEPS: usize = 3;
const ENOUGH: f64 = 1e-5;
/// Maximum number of cross-validated models.
const JUDGED: usize = 14;
/// A model is cross-validated if its criterion exceeds the lowest by at most this.
const NEAR: f64 = 12.0;
/// Number of decay rates per sample for initial real poles: from the record's length to one sample.
const RATES: usize = 7;
/// Changes of a delay in one step, samples.
const MOVES: [i64; 6] = [-1, 1, -2, 2, -4, 4];

/// A model: its channels, with `a1 ... an` of each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) channels: Vec<Channel>,
    pub(super) poles: Vec<Vec<f64>>,
}

impl Model {
    fn parameters(&self) -> usize {
        self.channels.iter().map(Channel::parameters).sum()
    }

    fn has(&self, input: usize) -> bool {
        self.channels.iter().any(|it| it.input == input)
    }

    /// Replaces channel `number` of the model.
    fn with(&self, number: usize, channel: Channel, poles: Vec<f64>) -> Self {
        let mut other = self.clone();
        other.channels[number] = channel;
        other.poles[number] = poles;
        other
    }

    /// Removes a channel from the model.
    fn without(&self, number: usize) -> Self {
        let mut other = self.clone();
        other.channels.remove(number);
        other.poles.remove(number);
        other
    }

    /// Adds a channel to the model.
    fn and(&self, channel: Channel, poles: Vec<f64>) -> Self {
        let mut other = self.clone();
        let place = other
            .channels
            .partition_point(|it| it.input < channel.input);
        other.channels.insert(place, channel);
        other.poles.insert(place, poles);
        other
    }
}

/// A cross-validated model.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The kind of model: output error, or Box-Jenkins with a noise model.
    pub kind: Kind,
    /// Its channels.
    pub channels: Vec<Channel>,
    /// The mean squared error of each block left out, over the output's variance: halves, then fifths.
    pub errors: Vec<f64>,
    /// The effective number of samples of its errors.
    samples: f64,
    poles: Vec<Vec<f64>>,
}

impl Candidate {
    /// The number of poles and numerator coefficients.
    #[must_use]
    pub fn parameters(&self) -> usize {
        let each = self.channels.iter();
        each.map(|it| it.structure.poles + it.structure.numerator)
            .sum()
    }

    fn score(&self) -> f64 {
        mean_logarithm(&self.errors)
            + self.parameters() as f64 * libm::log(self.samples) / self.samples
    }

    /// The fit that corresponds to the errors, %.
    #[must_use]
    pub fn fit(&self) -> f64 {
        100.0 * (1.0 - libm::exp(mean_logarithm(&self.errors) / 2.0))
    }

    /// The ratio of the errors with half the record left out to the errors with a fifth left out.
    #[must_use]
    pub fn half_data_error_ratio(&self) -> f64 {
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let (halves, fifths) = self.errors.split_at(HALVES);
        mean(halves) / mean(fifths).max(f64::MIN_POSITIVE)
    }

    /// The index of the best candidate with fewer parameters than this one, if it is at most a standard error worse.
    pub(super) fn simpler(&self, among: &[Self]) -> Option<usize> {
        let most = among.first()?.parameters();
        let is_as_good = |it: &Self| {
            it.parameters() < most
                && errors_not_significantly_worse(&it.errors, 1.0, 0.0, &self.errors)
        };
        let found = among.iter().enumerate().filter(|(_, it)| is_as_good(it));
        let best = found.min_by(|p, q| p.1.score().total_cmp(&q.1.score()));
        best.map(|it| it.0)
    }

    pub(super) fn model(&self) -> Model {
        Model {
            channels: self.channels.clone(),
            poles: self.poles.clone(),
        }
    }
}

/// The F test for an input's effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// The F statistic of the input's parameters, with the residual whitened.
    pub f: f64,
    /// The F that the Bayesian criterion requires, with the delay counted as a parameter.
    pub needed: f64,
}

impl Effect {
    /// Whether the effect is significant.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.f >= self.needed
    }
}

/// The choice.
pub(super) struct Choice {
    /// The cross-validated models, the chosen one first.
    pub(super) candidates: Vec<Candidate>,
    /// Of each input.
    pub(super) effects: Vec<Effect>,
    /// The residual variance of a high-order equation, over the output's variance.
    pub(super) innovation: Option<f64>,
}

/// Parameters at a point of the search, and the criterion there.
#[derive(Clone)]
struct Point {
    model: Model,
    theta: DVector<f64>,
    cost: f64,
}

/// The error that a descent minimises.
enum By {
    /// The simulated error.
    Simulation,
    /// The whitened error; inputs may be added or left out.
    Whitened,
    /// The whitened error with a fixed set of inputs.
    Present,
}

/// The channel with the smallest effect, if it is not significant.
fn idle(model: &Model, effects: &[Effect]) -> Option<usize> {
    let share = |it: &Channel| effects[it.input].f / effects[it.input].needed;
    let channels = model.channels.iter().enumerate();
    let idle = channels.filter(|(_, it)| !effects[it.input].is_there());
    let least = idle.min_by(|p, q| share(p.1).total_cmp(&share(q.1)));
    least.map(|it| it.0)
}

/// The weighting of errors.
struct Weight {
    /// `1, d1, ..., dk`, the filter applied to the errors.
    whitening: Vec<f64>,
    /// Minimum number of first outputs of each record to ignore.
    first: usize,
}

impl Weight {
    /// Unweighted errors.
    fn plain() -> Self {
        Self {
            whitening: vec![1.0],
            first: 0,
        }
    }
}

/// The records, prepared for the search.
pub(super) struct Chooser<'a> {
    segments: &'a [Segment],
    asked: Options,
    inputs: usize,
    samples: usize,
    radius: f64,
    likely: Option<Equation>,
    high: Option<Equation>,
    /// Poles of order 1, 2, ... of each input from the high-order equation.
    realised: Vec<Vec<Vec<f64>>>,
    /// Real poles to begin with.
    rates: Vec<f64>,
}

impl<'a> Chooser<'a> {
    pub(super) fn new(segments: &'a [Segment], asked: Options) -> Self {
        let inputs = segments.first().map_or(0, |it| it.inputs.len());
        let samples = segments.iter().map(Segment::len).sum();
        let longest = segments.iter().map(Segment::len).max().unwrap_or(2).max(2);
        let regressions = Regressions::of(segments, inputs);
        let high = regressions.high_order();
        let likely = regressions.likely(asked.delay);
        let realised = |input: usize| {
            // A delay would be poles at z = 0.
            let delay = likely.as_ref().map_or(0, |it| it.delays[input]);
            let high = high.as_ref().map(|it| lagged::Equation {
                a: it.a.clone(),
                b: it.b[input][delay.saturating_sub(1).min(it.b[input].len() - 1)..].to_vec(),
                constant: 0.0,
                variance: it.variance,
                rows: it.rows,
            });
            let most = MAX_ORDER.max(asked.order.unwrap_or_default());
            high.map_or(Vec::new(), |it| from_markov_parameters(&it, samples, most))
        };
        let rate =
            |i: usize| libm::exp(-libm::pow(longest as f64, i as f64 / (1.0 - RATES as f64)));
        Self {
            realised: (0..inputs).map(realised).collect(),
            rates: (0..RATES).map(rate).collect(),
            likely,
            radius: radius_of_memory(samples),
            segments,
            asked,
            inputs,
            samples,
            high,
        }
    }

    fn layout(&self, channels: &[Channel]) -> Layout {
        Layout {
            channels: channels.to_vec(),
            offset: self.asked.offset,
            runs: self.segments.len(),
        }
    }

    fn equations(&self, channels: &[Channel], by: &Weight) -> Equations {
        let layout = self.layout(channels);
        Equations::from(self.segments, layout, &by.whitening, by.first)
    }

    /// The number of first outputs for which some model lacks a known input; they are ignored when models are compared.
    fn first<'m>(&self, models: impl Iterator<Item = &'m Model>) -> usize {
        let unknown = models.map(|it| {
            let layout = self.layout(&it.channels);
            let segments = self.segments.iter();
            segments.map(|it| layout.unknown(&it.past)).max()
        });
        unknown.flatten().max().unwrap_or_default()
    }

    fn search(&self, steps: usize, enough: f64) -> Search {
        Search {
            steps,
            enough,
            radius: self.radius,
        }
    }

    fn channel(&self, input: usize, order: usize, delay: usize) -> Channel {
        Channel::new(input, order, delay, self.asked.start)
    }

    /// The smallest error near a model's poles, in at most this many steps.
    fn fitted(&self, model: &Model, by: &Weight, steps: usize) -> Option<Point> {
        let equations = self.equations(&model.channels, by);
        let whole = equations.whole();
        let start = equations.completed(&model.poles, &whole)?;
        let (theta, cost) = equations.minimised(start, &whole, self.search(steps, ENOUGH))?;
        Some(Point {
            model: Model {
                channels: model.channels.clone(),
                poles: equations.poles(&theta),
            },
            theta,
            cost,
        })
    }

    /// The best of several starts: each for a few steps, then the best until it converges.
    fn best_of(&self, starts: &[Model], by: &Weight) -> Option<Point> {
        let steps = match starts.len() {
            1 => STEPS,
            _ => FIRST_STEPS,
        };
        let quick = |it: &Model| self.fitted(it, by, steps);
        let found = starts.iter().filter_map(quick);
        let best = found.min_by(|p, q| p.cost.total_cmp(&q.cost))?;
        match starts.len() {
            1 => Some(best),
            _ => self.fitted(&best.model, by, STEPS),
        }
    }

    /// Initial poles of a given order for a channel: the realised poles, and the present poles with real poles added.
    fn starts(&self, input: usize, order: usize, before: &[f64]) -> Vec<Vec<f64>> {
        let realised = order
            .checked_sub(1)
            .and_then(|it| self.realised[input].get(it).cloned());
        let beside: Vec<Vec<f64>> = match order.checked_sub(before.len()) {
            Some(1) => {
                let rates = self.rates.iter().skip(1).step_by(2);
                rates
                    .map(|rate| product(&monic(before), &[1.0, -rate])[1..].to_vec())
                    .collect()
            }
            _ => Vec::new(),
        };
        let held = |a: Vec<f64>| {
            let held = crate::estimators::held_within(&a, self.radius)?;
            Some(held.unwrap_or(a))
        };
        realised
            .into_iter()
            .chain(beside)
            .chain((order == 0).then(Vec::new))
            .filter(|a| a.len() == order)
            .filter_map(held)
            .collect()
    }

    /// A model of order one in each channel, at the likely delays, with real poles chosen channel by channel.
    fn beginning(&self) -> Option<Point> {
        let order = self.asked.order.unwrap_or(1);
        let delay = |input: usize| {
            let likely = self.likely.as_ref().map(|it| it.delays[input]);
            self.asked.delay.or(likely).unwrap_or(1)
        };
        let middle = self.rates[RATES / 2];
        let all = |poles: &[f64]| poles.iter().fold(vec![1.0], |a, z| product(&a, &[1.0, -z]));
        let of = |z: f64| {
            // Real poles that differ a little.
            let roots: Vec<f64> = (0..order).map(|i| z * 0.9_f64.powi(i as i32)).collect();
            all(&roots)[1..].to_vec()
        };
        let channels = (0..self.inputs).map(|input| self.channel(input, order, delay(input)));
        let mut model = Model {
            channels: channels.collect(),
            poles: vec![of(middle); self.inputs],
        };
        let plain = Weight::plain();
        let completed = |model: &Model| {
            let equations = self.equations(&model.channels, &plain);
            let whole = equations.whole();
            let theta = equations.completed(&model.poles, &whole)?;
            Some(equations.total(&theta, &whole)?.cost)
        };
        for _ in 0..2 {
            for number in 0..self.inputs {
                let tried = self
                    .rates
                    .iter()
                    .map(|rate| model.with(number, model.channels[number].clone(), of(*rate)));
                let tried: Vec<Model> = tried.collect();
                let costs = on_all_cores(&tried, completed);
                let best = tried.iter().zip(costs).filter_map(|it| Some((it.1?, it.0)));
                if let Some((_, best)) = best.min_by(|p, q| p.0.total_cmp(&q.0)) {
                    model = best.clone();
                }
            }
        }
        let mut starts = vec![model.clone()];
        let realised =
            (0..self.inputs).map(|input| self.starts(input, order, &[]).into_iter().next());
        if let Some(poles) = realised.collect::<Option<Vec<_>>>() {
            starts.push(Model { poles, ..model });
        }
        self.best_of(&starts, &plain)
    }

    /// The models one step from another, each with its starts.
    fn steps(&self, from: &Model, by: &By) -> Vec<Vec<Model>> {
        let mut steps = Vec::new();
        for (number, channel) in from.channels.iter().enumerate() {
            let (input, order, delay) = (channel.input, channel.order(), channel.delay());
            if self.asked.order.is_none() {
                let orders = [Some(order + 1), Some(order + 2), order.checked_sub(1)];
                for other in orders.into_iter().flatten().filter(|it| *it <= MAX_ORDER) {
                    let starts = self.starts(input, other, &from.poles[number]).into_iter();
                    let of = self.channel(input, other, delay);
                    steps.push(starts.map(|a| from.with(number, of.clone(), a)).collect());
                }
            }
            if self.asked.delay.is_none() {
                for by in MOVES {
                    let Some(other) = delay.checked_add_signed(by as isize) else {
                        continue;
                    };
                    let of = self.channel(input, order, other);
                    if other <= MAX_DELAY {
                        steps.push(vec![from.with(number, of, from.poles[number].clone())]);
                    }
                }
            }
            if matches!(by, By::Whitened) && from.channels.len() > 1 {
                steps.push(vec![from.without(number)]);
            }
        }
        if matches!(by, By::Whitened) {
            let absent = (0..self.inputs).filter(|input| !from.has(*input));
            steps.extend(absent.map(|input| self.with_input(from, input)));
        }
        steps.retain(|starts: &Vec<Model>| !starts.is_empty());
        steps
    }

    /// A model with an additional first-order input at its likely delay.
    fn with_input(&self, model: &Model, input: usize) -> Vec<Model> {
        let likely = self.likely.as_ref().map(|it| it.delays[input]);
        let delay = self.asked.delay.or(likely).unwrap_or(1);
        let order = self.asked.order.unwrap_or(1);
        let starts = self.starts(input, order, &vec![0.0; order.saturating_sub(1)]);
        let channel = self.channel(input, order, delay);
        let with = starts.into_iter().map(|a| model.and(channel.clone(), a));
        with.collect()
    }

    /// Descends from a point; returns the points on the path, and those one step from the last with their criterion.
    fn downhill(&self, begin: Point, by: &By) -> (Vec<Point>, Vec<(f64, Point)>) {
        let mut path = vec![begin];
        let mut beside = Vec::new();
        for _ in 0..ROUNDS {
            stop_point();
            let Some(here) = path.last().cloned() else {
                break;
            };
            let colour = self.colour(&here);
            let samples = match by {
                By::Simulation => self.worth(&colour),
                By::Whitened | By::Present => self.samples as f64,
            };
            let steps = self.steps(&here.model, by);
            let all = steps.iter().flatten().chain([&here.model]);
            let weight = Weight {
                first: self.first(all),
                whitening: match by {
                    By::Simulation => vec![1.0],
                    By::Whitened | By::Present => colour,
                },
            };
            let criterion = |point: &Point| {
                let squares = point.cost.max(f64::MIN_POSITIVE) / self.samples as f64;
                samples * libm::log(squares) + point.model.parameters() as f64 * libm::log(samples)
            };
            let Some(own) = self.fitted(&here.model, &weight, STEPS) else {
                break;
            };
            let found = on_all_cores(&steps, |starts| self.best_of(starts, &weight));
            let least = criterion(&own);
            beside = (found.into_iter().flatten())
                .map(|it| (criterion(&it) - least, it))
                .filter(|it| it.0.is_finite())
                .collect();
            beside.sort_by(|p, q| p.0.total_cmp(&q.0));
            if let Some(last) = path.last_mut() {
                *last = own;
            }
            match beside.first() {
                Some((worse, next)) if *worse < -1e-6 => path.push(next.clone()),
                _ => break,
            }
        }
        (path, beside)
    }

    /// `1, d1, ..., dk` that whiten the simulated error at a point.
    fn colour(&self, point: &Point) -> Vec<f64> {
        self.equations(&point.model.channels, &Weight::plain())
            .whitening(&point.theta)
    }

    /// The effective number of samples for squares of a residual of this colour.
    fn worth(&self, colour: &[f64]) -> f64 {
        (self.samples as f64 * independent_share(colour)).max(MIN_EFFECTIVE_SAMPLES)
    }

    /// The chosen model; `None` if the records determine no model.
    pub(super) fn choice(&self) -> Option<Choice> {
        let begin = self.beginning()?;
        let (mut way, _) = self.downhill(begin, &By::Simulation);
        let last = way.last()?.clone();
        let (mut by_whitened, mut beside) = self.downhill(last, &By::Whitened);
        let mut end = by_whitened.last()?.clone();
        let mut effects = self.effects(&end);
        // The least of those that do nothing goes first: the others may do something without it.
        while end.model.channels.len() > 1
            && let Some(number) = idle(&end.model, &effects)
        {
            let without = end.model.without(number);
            let without = self.fitted(&without, &Weight::plain(), STEPS)?;
            (by_whitened, beside) = self.downhill(without, &By::Present);
            end = by_whitened.last()?.clone();
            effects = self.effects(&end);
        }
        // One that went while another's work was not yet told from the noise comes back.
        let mut came_back = Vec::new();
        for _ in 0..self.inputs {
            let is_absent = |input: &usize| !end.model.has(*input) && !came_back.contains(input);
            let absent = (0..self.inputs).filter(is_absent);
            let of = |input: usize| (input, effects[input].f / effects[input].needed);
            let Some((input, _)) =
                (absent.map(of).filter(|it| it.1 >= 1.0)).max_by(|p, q| p.1.total_cmp(&q.1))
            else {
                break;
            };
            came_back.push(input);
            let with = self.with_input(&end.model, input);
            let with = self.best_of(&with, &Weight::plain())?;
            (by_whitened, beside) = self.downhill(with, &By::Present);
            end = by_whitened.last()?.clone();
            effects = self.effects(&end);
        }
        let colour = self.colour(&end);
        // Which inputs do anything is settled; order and delay are cross-validated.
        let present: Vec<usize> = end.model.channels.iter().map(|it| it.input).collect();
        way.extend(by_whitened);
        way.reverse();
        let beside = beside.into_iter().filter(|it| it.0 < NEAR).map(|it| it.1);
        let mut models: Vec<Model> = Vec::new();
        for point in way.into_iter().chain(beside) {
            let is_new = models.iter().all(|it| it.channels != point.model.channels);
            let inputs = point.model.channels.iter().map(|it| it.input);
            if is_new && inputs.eq(present.iter().copied()) {
                models.push(point.model);
            }
        }
        models.truncate(JUDGED);
        let kinds = [Kind::OutputError, Kind::BoxJenkins];
        let kinds = kinds
            .into_iter()
            .filter(|it| self.asked.kind.is_none_or(|kind| kind == *it));
        let pairs: Vec<(Kind, &Model)> = kinds
            .flat_map(|kind| models.iter().map(move |model| (kind, model)))
            .collect();
        let folds = self.folds();
        let judged = on_all_cores(&pairs, |(kind, model)| self.judged(&folds, *kind, model));
        let mut candidates: Vec<Candidate> = judged.into_iter().flatten().collect();
        let samples = self.worth(&colour);
        candidates.iter_mut().for_each(|it| it.samples = samples);
        candidates.sort_by(|p, q| p.score().total_cmp(&q.score()));
        let best = candidates.first()?.errors.clone();
        // Slow noise makes more poles seem worth while: what the whitened error has led to stays, if it is as good.
        let own = candidates
            .iter()
            .find(|it| it.channels == end.model.channels);
        let own = own.filter(|it| errors_not_significantly_worse(&it.errors, 1.0, 0.0, &best));
        let is_as_good = |it: &&Candidate| {
            errors_not_significantly_worse(&it.errors, STANDARD_ERRORS, 0.0, &best)
        };
        let fewest = || {
            let as_good = candidates.iter().filter(is_as_good);
            as_good.min_by(|p, q| {
                (p.parameters().cmp(&q.parameters())).then(p.score().total_cmp(&q.score()))
            })
        };
        let chosen = own.or_else(fewest)?.clone();
        let at = candidates.iter().position(|it| *it == chosen)?;
        let chosen = candidates.remove(at);
        candidates.insert(0, chosen);
        Some(Choice {
            candidates,
            effects,
            innovation: self.high.as_ref().map(Equation::noise_variance),
        })
    }

    /// The F test of each input: inputs in the model are tested against the model without them; other inputs against the model with them. The
    /// residual is whitened by the model's autoregression, because slow noise resembles an input's effect.
    fn effects(&self, point: &Point) -> Vec<Effect> {
        let n = self.samples as f64;
        let model = &point.model;
        let whitening = self.colour(point);
        let of = |input: usize| {
            let number = model.channels.iter().position(|it| it.input == input);
            let (with, without) = match number {
                Some(number) => (vec![model.clone()], model.without(number)),
                None => (self.with_input(model, input), model.clone()),
            };
            let weight = Weight {
                whitening: whitening.clone(),
                first: self.first(with.iter().chain([&without])),
            };
            let with = self.best_of(&with, &weight)?;
            let without = self.cost(&without, &weight)?;
            let mut channels = with.model.channels.iter();
            let channel = channels.find(|it| it.input == input)?;
            let motions = match self.asked.start {
                InitialState::Rest => 0,
                InitialState::Estimated => channel.order() * self.segments.len(),
            };
            let k = (channel.parameters() + motions) as f64;
            let freedom = (n - with.theta.len() as f64).max(1.0);
            let share = |ratio: f64| (ratio - 1.0) * freedom / (k - 1.0);
            Some(Effect {
                f: share(without / with.cost.max(f64::MIN_POSITIVE)).max(0.0),
                needed: share(libm::exp(k * libm::log(n) / n)),
            })
        };
        let none = Effect {
            f: 0.0,
            needed: f64::INFINITY,
        };
        let inputs: Vec<usize> = (0..self.inputs).collect();
        on_all_cores(&inputs, |input| of(*input).unwrap_or(none))
    }

    /// The smallest error of a model; the model may have no channel.
    fn cost(&self, model: &Model, by: &Weight) -> Option<f64> {
        if !model.channels.is_empty() || self.asked.offset {
            return self.fitted(model, by, STEPS).map(|it| it.cost);
        }
        let equations = self.equations(&[], by);
        let none = DVector::zeros(0);
        let errors = equations.counted_errors(&none).concat();
        Some(errors.iter().map(|e| e * e).sum())
    }

    fn folds(&self) -> Folds {
        let run = |segment: &'a Segment| Run {
            past: &[],
            inputs: &segment.inputs[0],
            outputs: &segment.outputs[0],
        };
        let runs: Vec<Run<'_>> = self.segments.iter().map(run).collect();
        Folds::of(&runs, &vec![0; runs.len()])
    }

    /// A model with the errors of each fold; `None` if a fold does not determine it.
    fn judged(&self, folds: &Folds, kind: Kind, model: &Model) -> Option<Candidate> {
        let mut weight = Weight::plain();
        let plain = self.equations(&model.channels, &weight);
        let mut at = self.fitted(model, &weight, STEPS)?;
        if kind == Kind::BoxJenkins {
            weight.whitening = plain.whitening(&at.theta);
            if weight.whitening.len() == 1 {
                return None;
            }
            at = self.fitted(&at.model, &weight, STEPS)?;
        }
        let equations = self.equations(&model.channels, &weight);
        let errors = (0..folds.count()).map(|fold| {
            let kept = folds.kept(fold, weight.whitening.len() - 1);
            let search = self.search(3, 1e-6);
            let (found, _) = equations.minimised(at.theta.clone(), &kept, search)?;
            let mean = self.error(folds, fold, &plain, &found);
            mean.is_finite().then_some(mean)
        });
        Some(Candidate {
            kind,
            channels: model.channels.clone(),
            errors: errors.collect::<Option<_>>()?,
            samples: self.samples as f64,
            poles: at.model.poles,
        })
    }

    /// The mean squared simulation error over a block, relative to the output's variance. The simulation comes from before the block, or its state is
    /// fitted in the block if the record begins there.
    fn error(&self, folds: &Folds, fold: usize, plain: &Equations, found: &DVector<f64>) -> f64 {
        let free = plain.free(found);
        let order = free.len() - 1;
        let (mut squares, mut samples) = (0.0, 0);
        for (run, block) in folds.blocks(fold) {
            let segment = &self.segments[run];
            let unknown = plain.layout.unknown(&segment.past);
            let begin = block.start.max(unknown).min(block.end);
            if begin > unknown || self.asked.start == InitialState::Rest {
                let errors = plain.errors(found, run);
                squares += errors[begin..block.end].iter().map(|e| e * e).sum::<f64>();
                samples += block.end - begin;
            } else {
                let left = plain.errors_from_rest(found, run, begin..block.end);
                squares += without_free_motion(&left, &free);
                samples += (block.end - begin).saturating_sub(order);
            }
        }
        squares / samples.max(1) as f64 / folds.variance()
    }
}
