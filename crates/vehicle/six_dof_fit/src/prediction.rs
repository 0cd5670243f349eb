//! Predicts held-out motion from measured states, by the fitted vehicle and by simpler models, over several horizons.
//!
//! ```text
//! constant velocity   nu' = 0
//! linear per axis     nu_i' = (b_i1 tau_1 + ... + c_i - nu_i) / T_i        by least squares over windows from measured states
//! ```
//! The pose follows from the velocities (Fossen 2021, eq. 2.40).

use nalgebra::{DMatrix, DVector};
use planesman_parallel::on_all_cores;
use planesman_vehicle::six_dof::rotation;
use serde::Serialize;

use crate::problem::{Problem, Step, VELOCITIES, Window};
use crate::signals::apart;

/// The horizons, relative to the one that is judged.
const HORIZONS: [f64; 3] = [0.5, 1.0, 2.0];
/// Time constants tried for an axis \[s\].
pub(super) const TIME_CONSTANTS: [f64; 24] = {
    let (mut all, mut k) = ([0.0; 24], 0);
    let mut now = 0.1;
    while k < 24 {
        all[k] = now;
        now *= 1.35;
        k += 1;
    }
    all
};

/// Root mean squares of the errors of the quantities that are recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Velocity \[m/s\].
    pub velocity: f64,
    /// Angular rate \[rad/s\].
    pub rate: f64,
    /// Position \[m\].
    pub position: f64,
    /// Attitude \[rad\].
    pub attitude: f64,
}

impl Errors {
    /// Velocity, rate, position and attitude.
    #[must_use]
    pub const fn all(&self) -> [f64; 4] {
        [self.velocity, self.rate, self.position, self.attitude]
    }

    /// The geometric mean of the ratios to other errors, of velocity, rate and position where the other has any.
    #[must_use]
    pub fn over(&self, other: &Self) -> f64 {
        let pairs = self.all().into_iter().zip(other.all()).take(3);
        let logs: Vec<f64> = pairs
            .filter(|it| it.1 > 0.0)
            .map(|(own, other)| libm::log(own / other))
            .collect();
        libm::exp(logs.iter().sum::<f64>() / logs.len().max(1) as f64)
    }
}

/// A model that predicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Predictor {
    /// The fitted vehicle.
    Fitted,
    /// The initial vehicle, with the fitted current and delays.
    Like,
    /// A first-order lag of each velocity, with all inputs.
    LinearPerAxis,
    /// The velocity at the start.
    ConstantVelocity,
}

impl Predictor {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Fitted,
        Self::Like,
        Self::LinearPerAxis,
        Self::ConstantVelocity,
    ];

    /// Its name in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fitted => "fitted vehicle",
            Self::Like => "initial vehicle",
            Self::LinearPerAxis => "linear model per axis",
            Self::ConstantVelocity => "constant velocity",
        }
    }
}

/// The errors of all models over one horizon.
#[derive(Clone, Debug, Serialize)]
pub struct Prediction {
    /// The horizon's length \[s\].
    pub horizon: f64,
    /// Whether the verdict uses this horizon.
    pub is_judged: bool,
    /// Number of windows, each from a measured state.
    pub windows: usize,
    /// The errors of each model; `None` for a model that diverges.
    pub errors: Vec<(Predictor, Option<Errors>)>,
}

impl Prediction {
    /// The errors of a model.
    #[must_use]
    pub fn of(&self, predictor: Predictor) -> Option<Errors> {
        let mut all = self.errors.iter();
        all.find(|it| it.0 == predictor).and_then(|it| it.1)
    }
}

/// A predicted part of the held-out data: from a measured state, over the horizon that is judged.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// Its beginning in its run \[s\].
    pub from: f64,
    /// For each sample: time since the beginning \[s\], the number of its signal among [`SIGNALS`](crate::SIGNALS), its measured value, and the
    /// one that the fitted vehicle predicts.
    pub samples: Vec<(f64, usize, f64, f64)>,
}

/// Trajectories that are kept.
const KEPT: usize = 12;

/// The measured and the predicted signals of windows that do not overlap.
fn trajectories(windows: &[Window], ways: &[Option<Vec<[f64; 12]>>]) -> Vec<Trajectory> {
    let mut kept: Vec<Trajectory> = Vec::new();
    let mut end = (f64::NEG_INFINITY, 0.0);
    for (window, way) in windows.iter().zip(ways) {
        // Of another run, or after the last one.
        let is_next = window.from < end.1 || window.from >= end.0;
        let Some(way) = way.as_ref().filter(|_| is_next && kept.len() < KEPT) else {
            continue;
        };
        let times = window.times();
        end = (window.from + times[times.len() - 1], window.from);
        kept.push(Trajectory {
            from: window.from,
            samples: (window.samples.iter())
                .map(|(k, channel, value)| (times[*k], *channel, *value, way[*k][*channel]))
                .collect(),
        });
    }
    kept
}

/// Velocities after each step.
type Velocities = Vec<[f64; 6]>;

/// A first-order lag of a velocity: time constant, offset, and the gain of each input.
struct Lag {
    time_constant: f64,
    numbers: DVector<f64>,
}

/// The samples of a signal in a window: number of steps before each, and its value.
pub(super) fn samples(window: &Window, channel: usize) -> impl Iterator<Item = (usize, f64)> {
    let all = window.samples.iter().filter(move |it| it.1 == channel);
    all.map(|it| (it.0, it.2))
}

/// The response of a lag to each input and to the offset, from rest, after each step.
pub(super) fn responses(steps: &[Step], time_constant: f64) -> Vec<Vec<f64>> {
    let inputs = steps.first().map_or(0, |it| it.1.len());
    let mut now = vec![0.0; inputs + 1];
    let mut all = vec![now.clone()];
    for (length, inputs) in steps {
        let left = libm::exp(-length / time_constant);
        for (k, it) in now.iter_mut().enumerate() {
            let input = if k == 0 { 1.0 } else { inputs[k - 1] };
            *it = left * *it + (1.0 - left) * input;
        }
        all.push(now.clone());
    }
    all
}

/// The lag that fits a velocity best over windows.
fn lag(windows: &[(&Window, Vec<Step>)], channel: usize) -> Option<Lag> {
    let tried = on_all_cores(&TIME_CONSTANTS, |time_constant| {
        let (mut rows, mut right): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut width = 0;
        for (window, steps) in windows {
            let of = responses(steps, *time_constant);
            let times = window.times();
            width = of[0].len();
            for (k, value) in samples(window, channel) {
                rows.extend(&of[k]);
                let left = libm::exp(-times[k] / time_constant);
                right.push(value - left * window.start[channel]);
            }
        }
        let count = right.len();
        let matrix = DMatrix::from_row_slice(count, width, &rows);
        let right = DVector::from_vec(right);
        let mut squares = matrix.tr_mul(&matrix);
        let most = squares.diagonal().max();
        for i in 0..width {
            squares[(i, i)] += 1e-9 * most;
        }
        let numbers = squares.cholesky()?.solve(&matrix.tr_mul(&right));
        let error = (right - matrix * &numbers).norm_squared();
        let time_constant = *time_constant;
        Some((
            error,
            Lag {
                time_constant,
                numbers,
            },
        ))
    });
    let found = tried.into_iter().flatten();
    found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|it| it.1)
}

/// The velocities that lags predict from the start of a window.
fn by_lags(lags: &[Option<Lag>; 6], steps: &[Step], start: &[f64; 12]) -> Velocities {
    let mut all = vec![[0.0; 6]; steps.len() + 1];
    for (axis, lag) in lags.iter().enumerate() {
        let first = start[VELOCITIES + axis];
        let Some(lag) = lag else {
            all.iter_mut().for_each(|it| it[axis] = first);
            continue;
        };
        let mut left = 1.0;
        let lengths = std::iter::once(0.0).chain(steps.iter().map(|it| it.0));
        let forced = responses(steps, lag.time_constant);
        for ((it, of), length) in all.iter_mut().zip(forced).zip(lengths) {
            left *= libm::exp(-length / lag.time_constant);
            let forced: f64 = of.iter().zip(lag.numbers.iter()).map(|(r, b)| r * b).sum();
            it[axis] = left * first + forced;
        }
    }
    all
}

/// An attitude after a time at an angular rate, by the midpoint rule.
fn turned(attitude: [f64; 4], rate: [f64; 3], time: f64) -> [f64; 4] {
    let by = |from: [f64; 4], time: f64| {
        let slope = rotation::rate(from, rate);
        std::array::from_fn(|i| attitude[i] + time * slope[i])
    };
    let middle = rotation::normalised(by(attitude, 0.5 * time));
    rotation::normalised(by(middle, time))
}

/// The signals that follow from velocities over ground.
fn posed(velocities: &[[f64; 6]], steps: &[Step], start: &[f64; 12]) -> Vec<[f64; 12]> {
    let mut position = [start[0], start[1], start[2]];
    let mut attitude = rotation::from_euler([start[3], start[4], start[5]]);
    let signals = |position: [f64; 3], attitude, nu: &[f64; 6]| {
        let mut all = [0.0; 12];
        all[..3].copy_from_slice(&position);
        all[3..6].copy_from_slice(&rotation::euler(attitude));
        all[6..].copy_from_slice(nu);
        all
    };
    let mut all = vec![signals(position, attitude, &velocities[0])];
    for (pair, (length, _)) in velocities.windows(2).zip(steps) {
        let mean: [f64; 6] = std::array::from_fn(|i| 0.5 * (pair[0][i] + pair[1][i]));
        let to_fixed = rotation::matrix(attitude);
        let moved = rotation::to_fixed(&to_fixed, [mean[0], mean[1], mean[2]]);
        (0..3).for_each(|i| position[i] += length * moved[i]);
        attitude = turned(attitude, [mean[3], mean[4], mean[5]], *length);
        all.push(signals(position, attitude, &pair[1]));
    }
    all
}

/// Sums of squares and counts of the four quantities; each sample counts once, however many of its components are recorded.
#[derive(Default)]
struct Sums([(f64, f64); 4]);

impl Sums {
    fn add(&mut self, window: &Window, way: &[[f64; 12]]) {
        for (quantity, first) in [6, 9, 0, 3].into_iter().enumerate() {
            let mut counted = 0.0_f64;
            for component in 0..3 {
                let channel = first + component;
                let mut count = 0.0;
                for (k, value) in samples(window, channel) {
                    let error = apart(channel, value, way[k][channel]);
                    self.0[quantity].0 += error * error;
                    count += 1.0;
                }
                counted = counted.max(count);
            }
            self.0[quantity].1 += counted;
        }
    }

    fn errors(&self) -> Errors {
        let of = |k: usize| (self.0[k].0 / f64::max(self.0[k].1, 1.0)).sqrt();
        Errors {
            velocity: of(0),
            rate: of(1),
            position: of(2),
            attitude: of(3),
        }
    }
}

/// The errors of the fitted vehicle and of simpler models over windows from measured states. `first` are the windows of the data that was
/// fitted; `held` gives those of the held-out data for a horizon, and `judged` is the horizon of the verdict \[s\].
pub(super) fn predictions(
    problem: &Problem<'_>,
    globals: &[f64],
    first: &[Window],
    (judged, held): (f64, &dyn Fn(f64) -> Vec<Window>),
) -> (Vec<Prediction>, Vec<Trajectory>) {
    let delays = problem.delays(globals);
    let delayed = |it: &Window| it.steps_after(delays).into_owned();
    let fitted: Vec<(&Window, Vec<Step>)> = first.iter().map(|it| (it, delayed(it))).collect();
    let lags = std::array::from_fn(|axis| {
        let channel = VELOCITIES + axis;
        let is_recorded = first.iter().any(|it| samples(it, channel).next().is_some());
        is_recorded.then(|| lag(&fitted, channel)).flatten()
    });
    let mut unchanged = globals.to_vec();
    unchanged[..problem.sought.len()].fill(1.0);
    let simulated = |globals: &[f64], window: &Window, steps: &[Step]| {
        let biases = problem.biases(globals);
        let start: [f64; 12] = std::array::from_fn(|i| window.start[i] - biases[i]);
        let vehicle = problem.vehicle(globals)?;
        problem.simulated(&vehicle, globals, steps, &start)
    };
    let of = |predictor: Predictor, window: &Window| {
        let steps = window.steps_after(delays);
        let start = &window.start;
        match predictor {
            Predictor::Fitted => simulated(globals, window, &steps),
            Predictor::Like => simulated(&unchanged, window, &steps),
            Predictor::LinearPerAxis => Some(posed(&by_lags(&lags, &steps, start), &steps, start)),
            Predictor::ConstantVelocity => {
                let nu: [f64; 6] = std::array::from_fn(|i| start[VELOCITIES + i]);
                Some(posed(&vec![nu; steps.len() + 1], &steps, start))
            }
        }
    };
    let (mut all, mut kept) = (Vec::new(), Vec::new());
    for share in HORIZONS {
        let horizon = share * judged;
        let windows = held(horizon);
        if windows.is_empty() {
            continue;
        }
        let errors = Predictor::ALL.map(|predictor| {
            let ways = on_all_cores(&windows, |it| of(predictor, it));
            if share == 1.0 && predictor == Predictor::Fitted {
                kept = trajectories(&windows, &ways);
            }
            let mut sums = Sums::default();
            let each = windows.iter().zip(ways);
            let whole = each.map(|(window, way)| way.map(|way| sums.add(window, &way)));
            let is_whole = whole.collect::<Option<Vec<()>>>().is_some();
            (predictor, is_whole.then(|| sums.errors()))
        });
        all.push(Prediction {
            horizon,
            is_judged: share == 1.0,
            windows: windows.len(),
            errors: errors.to_vec(),
        });
    }
    (all, kept)
}
