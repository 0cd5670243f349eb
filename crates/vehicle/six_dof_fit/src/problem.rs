//! The vehicle's motion over windows of data: the unknowns, the errors with their slopes, and the information in the data.
//!
//! ```text
//! V = sum over windows and signals (y - yhat(theta))^2 / noise^2  +  sum (theta - theta_0)^2 / prior^2
//! theta = numbers of the file, relative to it | current | biases | initial state of each window
//! ```
//! Output error with a priori weighting: Maine and Iliff, *Application of Parameter Estimation to Aircraft Stability and Control*, NASA
//! RP-1168 (1986), ch. 5. Slopes are difference quotients of simulations by the classical Runge-Kutta method.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use planesman_equations::Run;
use planesman_identification::estimators::{Search, Total, coloured_covariance, least};
use planesman_parallel::on_all_cores;
use planesman_vehicle::six_dof::{EditableFile, State, Vehicle, Water, rotation, runge_kutta};

/// The signals of a vehicle's motion that may be measured: name and unit.
pub const SIGNALS: [(&str, &str); 12] = [
    ("north", "m"),
    ("east", "m"),
    ("depth", "m"),
    ("roll", "rad"),
    ("pitch", "rad"),
    ("yaw", "rad"),
    ("u", "m/s"),
    ("v", "m/s"),
    ("w", "m/s"),
    ("p", "rad/s"),
    ("q", "rad/s"),
    ("r", "rad/s"),
];
/// Indices of the angles among the signals.
const ANGLES: Range<usize> = 3..6;
/// Prior standard deviations of the 12 numbers of an initial state, about the first samples.
const INITIAL_PRIOR: [f64; 12] = [
    100.0, 100.0, 100.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0,
];
/// Prior standard deviation of a current \[m/s\], and of a bias of each signal.
const CURRENT_PRIOR: f64 = 1.0;
const BIAS_PRIOR: [f64; 12] = [
    10.0, 10.0, 10.0, 0.2, 0.2, 0.5, 0.5, 0.5, 0.5, 0.1, 0.1, 0.1,
];
/// The longest step of the simulation \[s\].
const STEP: f64 = 0.05;
/// Steps of difference quotients: of a number relative to itself, and of everything else in its unit.
const DIFFERENCE: f64 = 1e-6;
const SEARCH: Search = Search {
    steps: 40,
    enough: 1e-8,
    radius: f64::INFINITY,
};
/// Number of updates of the noise estimate.
const WEIGHINGS: usize = 8;
/// The number of initial states of a window.
const INITIAL: usize = 12;

/// An interval of data with its own initial state.
#[derive(Clone, Debug)]
pub(super) struct Window {
    /// The steps' lengths \[s\] and the constant inputs.
    pub(super) steps: Vec<(f64, Vec<f64>)>,
    /// For each sample: the number of steps before it, its signal, and its value.
    pub(super) samples: Vec<(usize, usize, f64)>,
    /// The initial guess of the initial state.
    pub(super) start: [f64; INITIAL],
}

impl Window {
    /// A part of a run \[s\]; `channels` are the signals of its outputs. `None` if a signal has no sample.
    pub(super) fn of(run: &Run, channels: &[usize], span: Range<f64>) -> Option<Self> {
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
            let count = (length / STEP - 1e-9).ceil().max(1.0);
            (0..count as usize).for_each(|_| steps.push((length / count, inputs.clone())));
            reached.push(steps.len());
        }
        let (mut samples, mut start) = (Vec::new(), [0.0; INITIAL]);
        for (track, channel) in run.outputs.iter().zip(channels) {
            let of = track.times.iter().zip(&track.values);
            let first = samples.len();
            for (time, value) in of.filter(|it| inside(it.0)) {
                let stamp = stamps.partition_point(|it| it < time);
                samples.push((reached[stamp], *channel, *value));
            }
            start[*channel] = samples.get(first)?.2;
        }
        Some(Self {
            steps,
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

/// `a - b` of a signal; for angles the shorter way.
pub(super) fn apart(channel: usize, a: f64, b: f64) -> f64 {
    let turns = match ANGLES.contains(&channel) {
        true => ((a - b) / TAU).round(),
        false => 0.0,
    };
    a - b - TAU * turns
}

/// A window at a point, each sample in units of its noise: the residuals, and their slopes by the globals and the initial state.
pub(super) struct Linearised {
    errors: DVector<f64>,
    slopes: DMatrix<f64>,
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
    /// Whether numbers, current and biases are fixed.
    pub(super) is_known: bool,
}

impl Problem<'_> {
    /// The number of globals: numbers, current and biases, which all windows share.
    pub(super) fn globals(&self) -> usize {
        self.of_current().end + self.biased.len()
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
        numbers.chain(current).chain(biases).collect()
    }

    /// The vehicle with these globals; `None` if it is impossible.
    pub(super) fn vehicle(&self, globals: &[f64]) -> Option<Vehicle> {
        let numbers = self.file.numbers();
        let changes = self.sought.iter().zip(globals);
        let changes = changes.map(|(place, by)| (*place, by * numbers[*place].value));
        self.file.vehicle(&changes.collect::<Vec<_>>()).ok()
    }

    fn water(&self, globals: &[f64]) -> Water<f64> {
        let [north, east] = [0, 1].map(|it| globals[self.sought.len() + it]);
        Water::steady([north, east, 0.0])
    }

    fn biases(&self, globals: &[f64]) -> [f64; INITIAL] {
        let mut biases = [0.0; INITIAL];
        let found = self.biased.iter().zip(&globals[self.of_current().end..]);
        found.for_each(|(channel, bias)| biases[*channel] = *bias);
        biases
    }

    /// The signals after each step of a window; `None` if the motion diverges.
    pub(super) fn simulated(
        &self,
        vehicle: &Vehicle,
        globals: &[f64],
        window: &Window,
        initial: &[f64],
    ) -> Option<Vec<[f64; INITIAL]>> {
        let (water, biases) = (self.water(globals), self.biases(globals));
        let mut now = state(initial);
        let mut way = vec![signals(&now, &biases)];
        for (dt, inputs) in &window.steps {
            now = runge_kutta(vehicle, &now, inputs, &water, *dt);
            way.push(signals(&now, &biases));
        }
        let is_finite = way.iter().flatten().all(|it| it.is_finite());
        is_finite.then_some(way)
    }

    /// A window at a point; `varied` has a vehicle for each number, changed by [`DIFFERENCE`].
    fn linearised(
        &self,
        (vehicle, varied): (&Vehicle, &[Vehicle]),
        globals: &[f64],
        window: &Window,
        initial: &[f64],
    ) -> Option<Linearised> {
        let here = self.simulated(vehicle, globals, window, initial)?;
        let samples = &window.samples;
        let errors = samples.iter();
        let errors = errors.map(|(k, of, y)| apart(*of, *y, here[*k][*of]) / self.noise[*of]);
        let errors = DVector::from_iterator(samples.len(), errors);
        let count = self.globals();
        let mut slopes = DMatrix::zeros(samples.len(), count + INITIAL);
        let first = if self.is_known { count } else { 0 };
        for column in first..count + INITIAL {
            let mut point = [globals, initial].concat();
            point[column] += DIFFERENCE;
            let (globals, initial) = point.split_at(count);
            let vehicle = varied.get(column).unwrap_or(vehicle);
            let there = self.simulated(vehicle, globals, window, initial)?;
            for (row, (k, of, _)) in samples.iter().enumerate() {
                let change = apart(*of, there[*k][*of], here[*k][*of]);
                slopes[(row, column)] = change / (DIFFERENCE * self.noise[*of]);
            }
        }
        let is_finite = slopes.iter().all(|it| it.is_finite());
        is_finite.then_some(Linearised { errors, slopes })
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

    /// The normal equations at a point.
    fn total(&self, windows: &[Window], theta: &DVector<f64>) -> Option<Total> {
        let (count, size) = (self.globals(), theta.len());
        let mut information = DMatrix::zeros(size, size);
        let mut gradient = DVector::zeros(size);
        let mut cost = 0.0;
        for (k, of) in self.at(windows, theta)?.iter().enumerate() {
            let squares = of.slopes.tr_mul(&of.slopes);
            let products = of.slopes.tr_mul(&of.errors);
            let place = |i: usize| if i < count { i } else { i + INITIAL * k };
            for i in 0..products.len() {
                gradient[place(i)] += products[i];
                for j in 0..products.len() {
                    information[(place(i), place(j))] += squares[(i, j)];
                }
            }
            cost += of.errors.norm_squared();
        }
        let initial = windows
            .iter()
            .flat_map(|it| it.start.into_iter().zip(INITIAL_PRIOR));
        let priors = self.priors().into_iter().chain(initial).enumerate();
        for (i, (known, prior)) in priors.filter(|it| it.0 >= count || !self.is_known) {
            let off = (known - theta[i]) / prior;
            information[(i, i)] += 1.0 / (prior * prior);
            gradient[i] += off / prior;
            cost += off * off;
        }
        Some(Total {
            information,
            gradient,
            cost,
        })
        .filter(|it| it.cost.is_finite())
    }

    /// Globals and initial states with the smallest error, starting from these globals; `None` if the motion diverges.
    pub(super) fn minimised(&self, windows: &[Window], globals: &[f64]) -> Option<DVector<f64>> {
        let initial = windows.iter().flat_map(|it| it.start);
        let start: Vec<f64> = globals.iter().copied().chain(initial).collect();
        self.nearer(windows, DVector::from_vec(start))
    }

    fn nearer(&self, windows: &[Window], start: DVector<f64>) -> Option<DVector<f64>> {
        let found = least(start, SEARCH, &|it| self.total(windows, it), &Some)?;
        Some(found.0)
    }

    /// The minimum from the priors, alternating with estimates of each signal's noise from its residuals.
    pub(super) fn weighed(&mut self, windows: &[Window]) -> Option<DVector<f64>> {
        self.noise = first_noise(windows);
        let globals: Vec<f64> = self.priors().iter().map(|it| it.0).collect();
        let mut theta = self.minimised(windows, &globals)?;
        let samples: usize = windows.iter().map(|it| it.samples.len()).sum();
        // Each signal pays for its share of what is sought.
        let share = 1.0 - (theta.len() as f64 / samples as f64).min(0.9);
        for _ in 0..WEIGHINGS {
            let left = self.left(windows, &theta)?;
            let mut moved = 0.0_f64;
            for (noise, left) in self.noise.iter_mut().zip(left) {
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
