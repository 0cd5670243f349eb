//! The vehicle's motion over windows of data: the unknowns, the errors with their slopes, and the information in the data.
//!
//! ```text
//! V = sum over windows and signals (y - yhat(theta))^2 / noise^2  +  sum (theta - theta_0)^2 / prior^2
//! theta = numbers of the file, relative to it | current | biases | delay of the inputs | initial state of each window
//! ```
//! Output error with a priori weighting: Maine and Iliff, *Application of Parameter Estimation to Aircraft Stability and Control*, NASA
//! RP-1168 (1986), ch. 5. Slopes are difference quotients of simulations by the classical Runge-Kutta method.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use planesman_equations::{Run, Track};
use planesman_identification::estimators::{Trial, coloured_covariance, descend};
use planesman_parallel::on_all_cores;
use planesman_vehicle::six_dof::{EditableFile, State, Vehicle, Water, rotation, runge_kutta};

use crate::options::Cost;
use crate::signals::apart;

/// Prior standard deviations of the 12 numbers of an initial state, about the first samples.
const INITIAL_PRIOR: [f64; 12] = [
    100.0, 100.0, 100.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0,
];
/// Prior standard deviation of a current \[m/s\], and of a bias of each signal.
const CURRENT_PRIOR: f64 = 1.0;
const BIAS_PRIOR: [f64; 12] = [
    10.0, 10.0, 10.0, 0.2, 0.2, 0.5, 0.5, 0.5, 0.5, 0.1, 0.1, 0.1,
];
/// Longest steps of the simulation that are tried \[s\]; the last one is exact enough for any vehicle.
pub(super) const STEPS: [f64; 5] = [0.8, 0.4, 0.2, 0.1, 0.05];
/// A step is short enough if it moves no signal by more than this share of its noise.
const EXACT: f64 = 0.02;
/// Steps of difference quotients: of a number relative to itself, and of everything else in its unit.
const DIFFERENCE: f64 = 1e-6;
/// Maximum number of steps of a search, of trials of a step, and the relative decrease of the error at which it ends.
const SEARCH: (usize, usize, f64) = (40, 12, 1e-8);
/// Prior standard deviation of the inputs' delay \[s\].
const DELAY_PRIOR: f64 = 0.3;
/// Residuals beyond this many times the noise count linearly (Huber), if outliers are expected.
const OUTLIER: f64 = 2.5;
/// The noise of a first pose, if the cost is of velocities alone \[m\], \[rad\].
const FIRST_POSE: f64 = 2e-3;
/// Number of updates of the noise estimate.
const WEIGHINGS: usize = 8;
/// The number of initial states of a window.
const INITIAL: usize = 12;

/// An interval of data with its own initial state.
#[derive(Clone, Debug)]
pub(super) struct Window {
    /// The steps' lengths \[s\] and the constant inputs.
    pub(super) steps: Vec<Step>,
    /// The time of the first step in its run \[s\].
    pub(super) from: f64,
    /// The run's inputs; empty if they have no delay.
    pub(super) held: Arc<Vec<Held>>,
    /// For each sample the number of steps before it, its signal, and its value.
    pub(super) samples: Vec<(usize, usize, f64)>,
    /// The initial guess of the initial state.
    pub(super) start: [f64; INITIAL],
}

/// The length of a step \[s\] and its constant inputs.
pub(super) type Step = (f64, Vec<f64>);

/// An input that is held between its samples, with its integral.
#[derive(Clone, Debug)]
pub(super) struct Held {
    track: Track,
    integral: Vec<f64>,
}

impl Held {
    pub(super) fn new(track: &Track) -> Self {
        let mut sum = 0.0;
        let lengths = track.times.windows(2).zip(&track.values);
        let rest = lengths.map(|(times, value)| {
            sum += (times[1] - times[0]) * value;
            sum
        });
        let integral = std::iter::once(0.0).chain(rest).collect();
        let track = track.clone();
        Self { track, integral }
    }

    fn until(&self, time: f64) -> f64 {
        let times = &self.track.times;
        let at = times.partition_point(|it| *it <= time).saturating_sub(1);
        self.integral[at] + (time - times[at]) * self.track.values[at]
    }

    /// The mean over an interval.
    fn mean(&self, from: f64, length: f64) -> f64 {
        match self.track.times.is_empty() {
            true => 0.0,
            false => (self.until(from + length) - self.until(from)) / length,
        }
    }
}

impl Window {
    /// The steps with inputs that act after their delays: one of all, or one of each.
    pub(super) fn steps_after(&self, delays: &[f64]) -> Cow<'_, [Step]> {
        if delays.iter().all(|it| *it == 0.0) || self.held.is_empty() {
            return Cow::Borrowed(&self.steps);
        }
        let delay = |input: usize| delays.get(input).unwrap_or(&delays[0]);
        let mut time = self.from;
        let step = |(length, _): &Step| {
            let held = self.held.iter().enumerate();
            let inputs = held.map(|(input, it)| it.mean(time - delay(input), *length));
            let inputs = inputs.collect();
            time += length;
            (*length, inputs)
        };
        Cow::Owned(self.steps.iter().map(step).collect())
    }

    /// The times before each step and after the last one, from the window's beginning \[s\].
    pub(super) fn times(&self) -> Vec<f64> {
        let mut time = 0.0;
        let ends = self.steps.iter().map(|it| {
            time += it.0;
            time
        });
        std::iter::once(0.0).chain(ends).collect()
    }

    /// A part of a run \[s\]; `channels` are the signals of its outputs. `None` if a signal has no sample.
    pub(super) fn of(
        run: &Run,
        channels: &[usize],
        span: Range<f64>,
        (cost, longest): (Cost, f64),
        held: &Arc<Vec<Held>>,
    ) -> Option<Self> {
        let inside = |time: &f64| span.contains(time);
        let tracks = run.inputs.iter().chain(&run.outputs);
        let times = tracks.flat_map(|it| it.times.iter().copied().filter(inside));
        let mut stamps: Vec<f64> = times.chain([span.start]).collect();
        stamps.sort_by(f64::total_cmp);
        stamps.dedup();
        let (mut steps, mut reached) = (Vec::new(), vec![0]);
        for pair in stamps.windows(2) {
            let inputs: Vec<f64> = run.inputs.iter().map(|it| it.at(pair[0])).collect();
            let length = pair[1] - pair[0];
            let count = (length / longest - 1e-9).ceil().max(1.0);
            (0..count as usize).for_each(|_| steps.push((length / count, inputs.clone())));
            reached.push(steps.len());
        }
        let (mut samples, mut start) = (Vec::new(), [0.0; INITIAL]);
        for (track, channel) in run.outputs.iter().zip(channels) {
            let of = track.times.iter().zip(&track.values);
            let first = samples.len();
            let most = match cost {
                Cost::Velocities if *channel < VELOCITIES => 1,
                Cost::Velocities | Cost::All => usize::MAX,
            };
            for (time, value) in of.filter(|it| inside(it.0)).take(most) {
                let stamp = stamps.partition_point(|it| it < time);
                samples.push((reached[stamp], *channel, *value));
            }
            start[*channel] = samples.get(first)?.2;
        }
        Some(Self {
            steps,
            from: span.start,
            held: held.clone(),
            samples,
            start,
        })
    }

    /// Its length \[s\].
    pub(super) fn duration(&self) -> f64 {
        self.steps.iter().map(|it| it.0).sum()
    }
}

fn state(of: &[f64]) -> State {
    State {
        position: [of[0], of[1], of[2]],
        attitude: rotation::from_euler([of[3], of[4], of[5]]),
        velocity: [of[6], of[7], of[8], of[9], of[10], of[11]],
    }
}

/// The signals of a state, with their biases.
fn signals(of: &State, biases: &[f64; INITIAL]) -> [f64; INITIAL] {
    let ([x, y, z], [u, v, w, p, q, r]) = (of.position, of.velocity);
    let [roll, pitch, yaw] = rotation::euler(of.attitude);
    let of = [x, y, z, roll, pitch, yaw, u, v, w, p, q, r];
    std::array::from_fn(|it| of[it] + biases[it])
}

/// The first of [`SIGNALS`](crate::SIGNALS) that is a velocity.
pub(super) const VELOCITIES: usize = 6;

/// A window at a point, each sample in units of its noise: the residuals, and their slopes by the globals and the initial state.
pub(super) struct Linearised {
    errors: DVector<f64>,
    slopes: DMatrix<f64>,
    cost: f64,
}

/// The sum of squares of residuals, with outliers that count linearly if they are expected, and each row's factor then.
fn robust(cost: Cost, errors: &mut DVector<f64>) -> (f64, Vec<f64>) {
    if cost == Cost::All {
        return (errors.norm_squared(), Vec::new());
    }
    let sizes = errors.iter().map(|it| it.abs());
    let of = sizes.clone().map(|it| match it <= OUTLIER {
        true => it * it,
        false => OUTLIER * (2.0 * it - OUTLIER),
    });
    let total = of.sum();
    let factors = sizes.map(|it| (OUTLIER / it).min(1.0).sqrt());
    let factors: Vec<f64> = factors.collect();
    for (error, factor) in errors.iter_mut().zip(&factors) {
        *error *= factor;
    }
    (total, factors)
}

/// The normal equations: of the globals, and of each window's initial state, which no other window determines.
struct Equations {
    globals: DMatrix<f64>,
    gradient: DVector<f64>,
    windows: Vec<OfInitial>,
    cost: f64,
}

/// The normal equations of an initial state: its own matrix, with the globals, and the gradient.
struct OfInitial {
    own: DMatrix<f64>,
    cross: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// A matrix with its diagonal enlarged by a share.
fn damped(of: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut of = of.clone();
    for i in 0..of.nrows() {
        let scale = of[(i, i)];
        of[(i, i)] += damping.max(1e-14) * if scale > 0.0 { scale } else { 1.0 };
    }
    of
}

impl Equations {
    /// The damped step, by elimination of the initial states, without the globals that stay; `None` if the matrix is not positive definite.
    fn step(&self, damping: f64, stay: &[usize]) -> Option<DVector<f64>> {
        let mut matrix = damped(&self.globals, damping);
        let mut right = self.gradient.clone();
        let mut solved = Vec::new();
        for of in &self.windows {
            let own = damped(&of.own, damping).cholesky()?;
            let (by, alone) = (own.solve(&of.cross), own.solve(&of.gradient));
            matrix -= of.cross.tr_mul(&by);
            right -= of.cross.tr_mul(&alone);
            solved.push((by, alone));
        }
        for k in stay {
            matrix.row_mut(*k).fill(0.0);
            matrix.column_mut(*k).fill(0.0);
            matrix[(*k, *k)] = 1.0;
            right[*k] = 0.0;
        }
        let globals = matrix.cholesky()?.solve(&right);
        let mut step: Vec<f64> = globals.iter().copied().collect();
        for (by, alone) in solved {
            step.extend((alone - by * &globals).iter());
        }
        let step = DVector::from_vec(step);
        step.iter().all(|it| it.is_finite()).then_some(step)
    }
}

/// The unknowns and the signals.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    /// The initial vehicle.
    pub(super) file: &'a EditableFile,
    /// The numbers to estimate.
    pub(super) sought: Vec<usize>,
    /// The relative prior standard deviation of each.
    pub(super) prior: f64,
    /// Signals with a bias to estimate.
    pub(super) biased: Vec<usize>,
    /// The noise of each signal, its unit.
    pub(super) noise: [f64; INITIAL],
    /// Whether numbers, current, biases and delay are fixed.
    pub(super) is_known: bool,
    /// The number of delays to estimate: none, one of all inputs, or one of each.
    pub(super) delays: usize,
    /// The signals whose errors are minimised.
    pub(super) cost: Cost,
}

impl Problem<'_> {
    /// The number of globals: numbers, current, biases and delay, which all windows share.
    pub(super) fn globals(&self) -> usize {
        self.of_delays().end
    }

    /// The places of the delays.
    pub(super) fn of_delays(&self) -> Range<usize> {
        let begin = self.of_current().end + self.biased.len();
        begin..begin + self.delays
    }

    /// The delays of the inputs \[s\].
    pub(super) fn delays<'g>(&self, globals: &'g [f64]) -> &'g [f64] {
        &globals[self.of_delays()]
    }

    /// The unit of a sought number, with its sign: its value in the initial vehicle, or the size of one that is 0 there.
    pub(super) fn unit(&self, k: usize) -> f64 {
        let number = &self.file.numbers()[self.sought[k]];
        match number.value {
            0.0 => number.size,
            value => value,
        }
    }

    /// The least size to which the interval of a sought number is compared: that of a number that is 0 in the initial vehicle, else 0.
    pub(super) fn least_size(&self, k: usize) -> f64 {
        let number = &self.file.numbers()[self.sought[k]];
        match number.value {
            0.0 => number.size,
            _ => 0.0,
        }
    }

    /// The value of a sought number.
    pub(super) fn value(&self, k: usize, globals: &[f64]) -> f64 {
        let number = &self.file.numbers()[self.sought[k]];
        match number.value {
            0.0 => (globals[k] - 1.0) * number.size,
            value => globals[k] * value,
        }
    }

    /// The place of the current, north and east.
    pub(super) fn of_current(&self) -> Range<usize> {
        self.sought.len()..self.sought.len() + 2
    }

    /// The priors of the globals, value and standard deviation, at which a search begins.
    pub(super) fn priors(&self) -> Vec<(f64, f64)> {
        let numbers = self.sought.iter().map(|_| (1.0, self.prior));
        let biases = self.biased.iter().map(|it| (0.0, BIAS_PRIOR[*it]));
        let current = [(0.0, CURRENT_PRIOR); 2];
        let delays = std::iter::repeat_n((0.0, DELAY_PRIOR), self.delays);
        numbers.chain(current).chain(biases).chain(delays).collect()
    }

    /// The vehicle with these globals; `None` if such a vehicle is physically impossible.
    pub(super) fn vehicle(&self, globals: &[f64]) -> Option<Vehicle> {
        let changes = self.sought.iter().enumerate();
        let changes = changes.map(|(k, place)| (*place, self.value(k, globals)));
        self.file.vehicle(&changes.collect::<Vec<_>>()).ok()
    }

    fn water(&self, globals: &[f64]) -> Water<f64> {
        let [north, east] = [0, 1].map(|it| globals[self.sought.len() + it]);
        Water::steady([north, east, 0.0])
    }

    pub(super) fn biases(&self, globals: &[f64]) -> [f64; INITIAL] {
        let mut biases = [0.0; INITIAL];
        let found = self.biased.iter().zip(&globals[self.of_current().end..]);
        found.for_each(|(channel, bias)| biases[*channel] = *bias);
        biases
    }

    /// The signals after each step, from an initial state; `None` if the motion diverges.
    pub(super) fn simulated(
        &self,
        vehicle: &Vehicle,
        globals: &[f64],
        steps: &[Step],
        initial: &[f64],
    ) -> Option<Vec<[f64; INITIAL]>> {
        let (water, biases) = (self.water(globals), self.biases(globals));
        let mut now = state(initial);
        let mut way = vec![signals(&now, &biases)];
        for (dt, inputs) in steps {
            now = runge_kutta(vehicle, &now, inputs, &water, *dt);
            way.push(signals(&now, &biases));
        }
        let is_finite = way.iter().flatten().all(|it| it.is_finite());
        is_finite.then_some(way)
    }

    /// The residuals of a window at a point, in units of the noise, and the simulated signals.
    fn errors(
        &self,
        vehicle: &Vehicle,
        globals: &[f64],
        (window, steps): (&Window, &[Step]),
        initial: &[f64],
    ) -> Option<(DVector<f64>, Vec<[f64; INITIAL]>)> {
        let here = self.simulated(vehicle, globals, steps, initial)?;
        let errors = window.samples.iter();
        let errors = errors.map(|(k, of, y)| apart(*of, *y, here[*k][*of]) / self.noise[*of]);
        let errors = DVector::from_iterator(window.samples.len(), errors);
        Some((errors, here))
    }

    /// A window at a point; `varied` has a vehicle for each number, changed by [`DIFFERENCE`].
    fn linearised(
        &self,
        (vehicle, varied): (&Vehicle, &[Vehicle]),
        globals: &[f64],
        window: &Window,
        initial: &[f64],
    ) -> Option<Linearised> {
        let steps = window.steps_after(self.delays(globals));
        let (mut errors, here) = self.errors(vehicle, globals, (window, &steps), initial)?;
        let (cost, factors) = robust(self.cost, &mut errors);
        let count = self.globals();
        let samples = &window.samples;
        let mut slopes = DMatrix::zeros(samples.len(), count + INITIAL);
        let first = if self.is_known { count } else { 0 };
        for column in first..count + INITIAL {
            let mut point = [globals, initial].concat();
            point[column] += DIFFERENCE;
            let (globals, initial) = point.split_at(count);
            let vehicle = varied.get(column).unwrap_or(vehicle);
            let is_delay = self.of_delays().contains(&column);
            let later = is_delay.then(|| window.steps_after(self.delays(globals)));
            let steps = later.as_ref().unwrap_or(&steps);
            let there = self.simulated(vehicle, globals, steps, initial)?;
            for (row, (k, of, _)) in samples.iter().enumerate() {
                let change = apart(*of, there[*k][*of], here[*k][*of]);
                let factor = factors.get(row).unwrap_or(&1.0);
                slopes[(row, column)] = factor * change / (DIFFERENCE * self.noise[*of]);
            }
        }
        let is_finite = slopes.iter().all(|it| it.is_finite());
        is_finite.then_some(Linearised {
            errors,
            slopes,
            cost,
        })
    }

    /// Each window at a point: the globals, then the initial state of each window.
    fn at(&self, windows: &[Window], theta: &DVector<f64>) -> Option<Vec<Linearised>> {
        let (globals, initial) = theta.as_slice().split_at(self.globals());
        let vehicle = self.vehicle(globals)?;
        let varied = (0..self.sought.len()).filter(|_| !self.is_known).map(|k| {
            let mut moved = globals.to_vec();
            moved[k] += DIFFERENCE;
            self.vehicle(&moved)
        });
        let varied: Vec<Vehicle> = varied.collect::<Option<_>>()?;
        let all: Vec<(&Window, &[f64])> = windows.iter().zip(initial.chunks(INITIAL)).collect();
        let of = |(window, initial): &(&Window, &[f64])| {
            self.linearised((&vehicle, &varied), globals, window, initial)
        };
        on_all_cores(&all, of).into_iter().collect()
    }

    /// Each unknown's prior: value and standard deviation; of the globals, then of each initial state.
    fn all_priors(&self, windows: &[Window]) -> impl Iterator<Item = (usize, (f64, f64))> {
        let initial = (windows.iter()).flat_map(|it| it.start.into_iter().zip(INITIAL_PRIOR));
        let count = self.globals();
        let all = self.priors().into_iter().chain(initial).enumerate();
        let is_known = self.is_known;
        all.filter(move |it| it.0 >= count || !is_known)
    }

    /// The squares that the priors add to the error.
    fn prior_cost(&self, windows: &[Window], theta: &DVector<f64>) -> f64 {
        let each = self.all_priors(windows);
        let each = each.map(|(i, (known, prior))| ((known - theta[i]) / prior).powi(2));
        each.sum()
    }

    /// The normal equations at a point.
    fn equations(&self, windows: &[Window], theta: &DVector<f64>) -> Option<Equations> {
        let count = self.globals();
        let mut found = Equations {
            globals: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            windows: Vec::new(),
            cost: self.prior_cost(windows, theta),
        };
        for of in self.at(windows, theta)? {
            let (globals, initial) = of.slopes.columns_range_pair(..count, count..);
            found.globals += globals.tr_mul(&globals);
            found.gradient += globals.tr_mul(&of.errors);
            found.windows.push(OfInitial {
                own: initial.tr_mul(&initial),
                cross: initial.tr_mul(&globals),
                gradient: initial.tr_mul(&of.errors),
            });
            found.cost += of.cost;
        }
        for (i, (known, prior)) in self.all_priors(windows) {
            let (weight, pull) = (prior.powi(-2), (known - theta[i]) / prior.powi(2));
            match i.checked_sub(count) {
                None => {
                    found.globals[(i, i)] += weight;
                    found.gradient[i] += pull;
                }
                Some(at) => {
                    let (window, i) = (&mut found.windows[at / INITIAL], at % INITIAL);
                    window.own[(i, i)] += weight;
                    window.gradient[i] += pull;
                }
            }
        }
        Some(found).filter(|it| it.cost.is_finite())
    }

    /// The error at a point; `None` if the motion diverges.
    fn cost_at(&self, windows: &[Window], theta: &DVector<f64>) -> Option<f64> {
        let (globals, initial) = theta.as_slice().split_at(self.globals());
        let vehicle = self.vehicle(globals)?;
        let delays = self.delays(globals);
        let all: Vec<(&Window, &[f64])> = windows.iter().zip(initial.chunks(INITIAL)).collect();
        let costs = on_all_cores(&all, |(window, initial)| {
            let steps = window.steps_after(delays);
            let (mut errors, _) = self.errors(&vehicle, globals, (window, &steps), initial)?;
            Some(robust(self.cost, &mut errors).0)
        });
        let cost: f64 = costs.into_iter().sum::<Option<f64>>()?;
        Some(cost + self.prior_cost(windows, theta)).filter(|it| it.is_finite())
    }

    /// Globals and initial states with the smallest error, starting from these globals; `None` if the motion diverges.
    pub(super) fn minimised(&self, windows: &[Window], globals: &[f64]) -> Option<DVector<f64>> {
        let initial = windows.iter().flat_map(|it| it.start);
        let start: Vec<f64> = globals.iter().copied().chain(initial).collect();
        self.nearer(windows, DVector::from_vec(start))
    }

    /// The least value of a global: that of a damping that would feed energy below it.
    fn least(&self, k: usize) -> f64 {
        let number = self.sought.get(k).map(|it| &self.file.numbers()[*it]);
        match number {
            Some(it) if it.is_damping() && it.value == 0.0 => 1.0,
            Some(it) if it.is_damping() && it.value > 0.0 => 0.0,
            _ => f64::NEG_INFINITY,
        }
    }

    /// A damped step from a point; globals at their least value stay there while the error would decrease beyond it.
    fn step_from(
        &self,
        theta: &DVector<f64>,
        here: &Equations,
        damping: f64,
    ) -> Option<DVector<f64>> {
        let numbers = if self.is_known { 0 } else { self.sought.len() };
        let is_at_bound = |k: &usize| theta[*k] <= self.least(*k) && here.gradient[*k] < 0.0;
        let stay: Vec<usize> = (0..numbers).filter(is_at_bound).collect();
        let mut there = theta + here.step(damping, &stay)?;
        for k in 0..numbers {
            there[k] = there[k].max(self.least(k));
        }
        Some(there)
    }

    /// Globals and initial states with the smallest error, by damped Gauss-Newton steps.
    fn nearer(&self, windows: &[Window], start: DVector<f64>) -> Option<DVector<f64>> {
        let (steps, trials, enough) = SEARCH;
        let here = self.equations(windows, &start)?;
        let trial = |theta: &DVector<f64>, here: &Equations, damping| {
            let lower = || {
                let there = self.step_from(theta, here, damping)?;
                // The slopes are computed only where the error is lower.
                let is_lower = self.cost_at(windows, &there)? < here.cost;
                let found = is_lower.then(|| self.equations(windows, &there))??;
                Some(Trial::Lower(there, found))
            };
            Ok(lower().unwrap_or(Trial::NotLower))
        };
        let settled =
            |here: &Equations, next: &Equations| here.cost - next.cost <= enough * here.cost;
        let (theta, _) = descend((start, here), (steps, trials), trial, settled).ok()?;
        Some(theta)
    }

    /// Whether windows with longer steps than others give the same motion.
    pub(super) fn is_exact(&self, windows: &[Window], exact: &[Window]) -> bool {
        let globals: Vec<f64> = self.priors().iter().map(|it| it.0).collect();
        let Some(vehicle) = self.vehicle(&globals) else {
            return false;
        };
        let noise = first_noise(exact);
        let pairs: Vec<(&Window, &Window)> = windows.iter().zip(exact).collect();
        let of = |(one, other): &(&Window, &Window)| {
            let ends = [one, other].map(|it| {
                let way = self.simulated(&vehicle, &globals, &it.steps, &it.start)?;
                way.last().copied()
            });
            let [Some(one), Some(other)] = ends else {
                return false;
            };
            let near = |k: usize| apart(k, one[k], other[k]).abs() <= EXACT * noise[k];
            exact[0].samples.iter().all(|it| near(it.1))
        };
        windows.len() == exact.len() && on_all_cores(&pairs, of).into_iter().all(|it| it)
    }

    /// Searches from the priors; the search alternates with estimates of each signal's noise from the residuals. The first search is over `short` windows,
    /// if there are any: over a short time even a vehicle that would tumble stays near the recorded motion.
    pub(super) fn weighed(&mut self, windows: &[Window], short: &[Window]) -> Option<DVector<f64>> {
        self.noise = first_noise(windows);
        if self.cost == Cost::Velocities {
            self.noise[..VELOCITIES].fill(FIRST_POSE);
        }
        let globals: Vec<f64> = self.priors().iter().map(|it| it.0).collect();
        let of_short = match short.is_empty() {
            true => None,
            false => self.minimised(short, &globals),
        };
        let near = of_short.and_then(|it| self.minimised(windows, &it.as_slice()[..globals.len()]));
        let mut theta = near.or_else(|| self.minimised(windows, &globals))?;
        let samples: usize = windows.iter().map(|it| it.samples.len()).sum();
        // Each signal pays for its share of what is sought.
        let share = 1.0 - (theta.len() as f64 / samples as f64).min(0.9);
        for _ in 0..WEIGHINGS {
            let left = self.left(windows, &theta)?;
            let mut moved = 0.0_f64;
            let pose = match self.cost {
                Cost::Velocities => VELOCITIES,
                Cost::All => 0,
            };
            for (noise, left) in self.noise.iter_mut().zip(left).skip(pose) {
                let now = left.map_or(1.0, |it| (it / share.sqrt()).max(LEAST_NOISE));
                moved = moved.max((now / *noise - 1.0).abs());
                *noise = now;
            }
            theta = self.nearer(windows, theta)?;
            if moved < 0.01 {
                break;
            }
        }
        Some(theta)
    }

    /// RMS residual of each signal, in its unit; `None` without samples.
    pub(super) fn left(
        &self,
        windows: &[Window],
        theta: &DVector<f64>,
    ) -> Option<[Option<f64>; INITIAL]> {
        let (mut squares, mut counts) = ([0.0; INITIAL], [0.0; INITIAL]);
        for (window, of) in windows.iter().zip(self.at(windows, theta)?) {
            for ((_, channel, _), error) in window.samples.iter().zip(of.errors.iter()) {
                squares[*channel] += error * error;
                counts[*channel] += 1.0;
            }
        }
        let left = |it: usize| self.noise[it] * f64::sqrt(squares[it] / counts[it]);
        Some(std::array::from_fn(|it| {
            (counts[it] > 0.0).then(|| left(it))
        }))
    }

    /// The information in the windows about the globals, with initial states eliminated and without priors, and the remaining slopes,
    /// window by window.
    pub(super) fn eliminated(
        &self,
        windows: &[Window],
        theta: &DVector<f64>,
    ) -> Option<(DMatrix<f64>, Vec<Linearised>)> {
        let count = self.globals();
        let mut information = DMatrix::zeros(count, count);
        let mut all = self.at(windows, theta)?;
        for of in &mut all {
            let (globals, initial) = of.slopes.columns_range_pair(..count, count..);
            let mut inner = initial.tr_mul(&initial);
            for (i, prior) in INITIAL_PRIOR.iter().enumerate() {
                inner[(i, i)] += 1.0 / (prior * prior);
            }
            let cross = initial.tr_mul(&globals);
            let taken = inner.cholesky()?.solve(&cross);
            information += globals.tr_mul(&globals) - cross.tr_mul(&taken);
            of.slopes = globals - initial * taken;
        }
        Some((information, all))
    }

    /// The covariance of the global unknowns at a minimum, for residuals of any colour of each signal; and the data's information about these
    /// unknowns.
    pub(super) fn covariance(
        &self,
        windows: &[Window],
        theta: &DVector<f64>,
    ) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let count = self.globals();
        let (information, left) = self.eliminated(windows, theta)?;
        let priors = self.priors().into_iter().map(|it| 1.0 / (it.1 * it.1));
        let priors = DMatrix::from_diagonal(&DVector::from_iterator(count, priors));
        let factored = (&information + &priors).cholesky()?;
        let identity = DMatrix::identity(count, count);
        let unit = factored.l().solve_lower_triangular(&identity)?.transpose();
        let inverse = factored.inverse();
        let mut covariance = &inverse * priors * &inverse;
        for channel in 0..INITIAL {
            let (mut rows, mut residuals) = (Vec::new(), Vec::new());
            for (window, of) in windows.iter().zip(&left) {
                let samples = window.samples.iter().enumerate();
                let samples = samples.filter(|it| it.1.1 == channel).map(|it| it.0);
                residuals.push(
                    samples
                        .clone()
                        .map(|it| of.errors[it])
                        .collect::<Vec<f64>>(),
                );
                rows.extend(samples.map(|it| of.slopes.row(it)));
            }
            if !rows.is_empty() {
                // The noise is what is left by the degrees of freedom: the variance is 1.
                let slopes = DMatrix::from_rows(&rows);
                covariance += coloured_covariance(&unit, slopes, &residuals, 1.0);
            }
        }
        Some((covariance, information))
    }
}

/// The smallest noise, in any unit, because the data may have no noise.
const LEAST_NOISE: f64 = 1e-6;

/// A first estimate of the noise, from second differences; they multiply white noise by sqrt(6).
fn first_noise(windows: &[Window]) -> [f64; INITIAL] {
    std::array::from_fn(|channel| {
        let (mut squares, mut count) = (0.0, 0.0);
        for window in windows {
            let of = window.samples.iter().filter(|it| it.1 == channel);
            let values: Vec<f64> = of.map(|it| it.2).collect();
            for of in values.windows(3) {
                let second = apart(channel, of[2], of[1]) - apart(channel, of[1], of[0]);
                squares += second * second / 6.0;
                count += 1.0;
            }
        }
        (squares / f64::max(count, 1.0)).sqrt().max(LEAST_NOISE)
    })
}
