//! A model simulated from stamp to stamp, with the sensitivities of its states.
//!
//! ```text
//! x_dot = f,   S_dot = df/dx S + df/dp,   dy/dp = dh/dx S + dh/dp        S = dx/dp
//! ```
//! (Ljung, *System Identification*, 2nd ed. 1999, sec. 10.2; Hairer, Norsett and Wanner 1993, sec. I.14.) The method is the method of order 5 by
//! Dormand and Prince with an error estimate of order 4 (ibid., sec. II.5); it chooses the steps between two stamps by the states' errors. The
//! sensitivities use the same steps, so they are the slopes of the computed values.

use planesman_identification::stop_point;

use crate::expression::Numbers;
use crate::model::{Begin, Equations};

/// The allowed error of a step, relative to the state.
const TOLERANCE: f64 = 1e-7;
/// The smallest size of a state in the relative error, as a share of its largest value so far.
const SMALL: f64 = 1e-3;
/// The shortest step, relative to the interval between two stamps; at a corner of the equations no step would be short enough.
const SHORTEST: f64 = 1e-4;
/// Maximum number of steps: per interval on average, and in addition.
const MOST_STEPS: (usize, usize) = (100, 20_000);

const NODES: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
const WEIGHTS: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
/// The result minus the result of order 4: weights of the six slopes, and of the slope at the end.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Samples of a signal at their own increasing times, s from the run's first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Times, s.
    pub times: Vec<f64>,
    /// Values.
    pub values: Vec<f64>,
}

impl Track {
    /// The samples before a time.
    fn until(&self, time: f64) -> Self {
        let count = self.times.partition_point(|it| *it <= time);
        Self {
            times: self.times[..count].to_vec(),
            values: self.values[..count].to_vec(),
        }
    }

    /// The current value at a time, or the first; 0 without samples.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.values.get(self.acting(time)).copied().unwrap_or(0.0)
    }

    /// The number of the current sample at a time, or the first.
    fn acting(&self, time: f64) -> usize {
        self.times
            .partition_point(|it| *it <= time)
            .saturating_sub(1)
    }
}

/// The course of an input between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// The input is held until the next sample.
    #[default]
    Held,
    /// The input is linear to the next sample.
    Lines,
}

/// A part of the data without gaps, with its own initial state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// The inputs, in the order of the equations. Before its first sample an input has the value of that sample.
    pub inputs: Vec<Track>,
    /// The outputs, in the order of the equations.
    pub outputs: Vec<Track>,
    /// The course of inputs between their samples.
    pub between: Between,
}

impl Run {
    /// The time of the last output, s.
    #[must_use]
    pub fn end(&self) -> f64 {
        let last = self.outputs.iter().filter_map(|it| it.times.last());
        last.copied().fold(0.0, f64::max)
    }

    /// The outputs' samples up to a time.
    #[must_use]
    pub fn until(&self, time: f64) -> Self {
        Self {
            outputs: self.outputs.iter().map(|it| it.until(time)).collect(),
            ..self.clone()
        }
    }

    pub(crate) fn samples(&self) -> usize {
        self.outputs.iter().map(|it| it.times.len()).sum()
    }

    /// The inputs that act from a time on.
    pub(crate) fn inputs_at(&self, time: f64) -> Vec<f64> {
        self.inputs.iter().map(|it| it.at(time)).collect()
    }

    /// All times at which a measurement is made or an input changes, from 0 to the last output.
    pub(crate) fn stamps(&self) -> Vec<f64> {
        let end = self.end();
        let all = self.inputs.iter().chain(&self.outputs);
        let times = all.flat_map(|it| it.times.iter().copied());
        let mut times: Vec<f64> = times.filter(|it| *it > 0.0 && *it <= end).collect();
        times.push(0.0);
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

/// A simulated output.
#[derive(Clone, Debug, Default)]
pub(crate) struct Simulated {
    pub(crate) values: Vec<f64>,
    /// The slopes of each value by the parameters, then by the estimated initial states; empty if not requested.
    pub(crate) slopes: Vec<f64>,
}

/// The state of a simulation.
struct Integrator<'a> {
    equations: &'a Equations,
    numbers: Numbers,
    /// Inputs, states, parameters, time.
    variables: Vec<f64>,
    gradient: Vec<f64>,
    /// Number of slopes of each state.
    sought: usize,
    /// The value and the slope of each input over the interval, and the beginning of the interval, s.
    inputs: Vec<(f64, f64)>,
    from: f64,
}

impl Integrator<'_> {
    fn put(&mut self, time: f64, x: &[f64]) {
        for (slot, (value, slope)) in self.variables.iter_mut().zip(&self.inputs) {
            *slot = value + slope * (time - self.from);
        }
        let (m, n) = (self.equations.inputs(), self.equations.states());
        self.variables[m..m + n].copy_from_slice(&x[..n]);
        if let Some(last) = self.variables.last_mut() {
            *last = time;
        }
        self.equations
            .tape
            .evaluate(&self.variables, &mut self.numbers);
    }

    /// `df/dx S + df/dp` for one result, after [`Self::put`].
    fn carried(&mut self, root: &crate::expression::Root, s: &[f64], to: &mut [f64]) {
        let (m, n) = (self.equations.inputs(), self.equations.states());
        let of_parameters = self.equations.parameters();
        for slot in &root.variables {
            self.gradient[*slot] = 0.0;
        }
        let tape = &self.equations.tape;
        tape.slopes(root, &mut self.numbers, &mut self.gradient);
        to.fill(0.0);
        for slot in &root.variables {
            let slope = self.gradient[*slot];
            if (m..m + n).contains(slot) {
                let row = &s[(slot - m) * self.sought..][..self.sought];
                for (to, s) in to.iter_mut().zip(row) {
                    *to += slope * s;
                }
            } else if of_parameters.contains(slot) {
                to[slot - of_parameters.start] += slope;
            }
        }
    }

    /// The derivatives of states and sensitivities.
    fn derivatives(&mut self, time: f64, z: &[f64], to: &mut [f64]) {
        let equations = self.equations;
        let n = equations.states();
        self.put(time, z);
        for (to, root) in to.iter_mut().zip(&equations.derivatives) {
            *to = self.numbers.value(root);
        }
        if self.sought > 0 {
            for (state, root) in equations.derivatives.iter().enumerate() {
                let row = n + state * self.sought;
                self.carried(root, &z[n..], &mut to[row..row + self.sought]);
            }
        }
    }
}

impl Integrator<'_> {
    /// Initial states and sensitivities; the first estimated initial state has the parameter number `number`.
    fn beginning(&mut self, states: &[f64], mut number: usize) -> Vec<f64> {
        let (n, sought) = (states.len(), self.sought);
        let mut z = vec![0.0; n + n * sought];
        self.put(0.0, &z);
        z[..n].copy_from_slice(states);
        let begins = self.equations.begins.iter().enumerate();
        for (state, begin) in begins.filter(|_| sought > 0) {
            let row = n + state * sought;
            match begin {
                Begin::Sought(_) => {
                    z[row + number] = 1.0;
                    number += 1;
                }
                Begin::Given(root) => {
                    let mut slopes = vec![0.0; sought];
                    self.carried(root, &vec![0.0; n * sought], &mut slopes);
                    z[row..row + sought].copy_from_slice(&slopes);
                }
            }
        }
        z
    }

    /// Sets the inputs of the interval that begins at `time`; `acting` has the number of each input's current sample.
    fn take_inputs(&mut self, run: &Run, acting: &mut [usize], time: f64) {
        self.from = time;
        for ((input, track), acting) in self.inputs.iter_mut().zip(&run.inputs).zip(acting) {
            while track.times.get(*acting + 1).is_some_and(|it| *it <= time) {
                *acting += 1;
            }
            let sample =
                |number: usize| Some((*track.times.get(number)?, *track.values.get(number)?));
            let Some((begin, value)) = sample(*acting) else {
                continue;
            };
            *input = match (run.between, sample(*acting + 1)) {
                (Between::Lines, Some((end, next))) if time >= begin => {
                    let slope = (next - value) / (end - begin);
                    (value + slope * (time - begin), slope)
                }
                _ => (value, 0.0),
            };
        }
    }

    /// Appends an output, and its slopes if requested, after [`Self::put`].
    fn measure(&mut self, output: usize, sensitivities: &[f64], to: &mut Simulated) {
        let root = &self.equations.outputs[output].root;
        to.values.push(self.numbers.value(root));
        if self.sought > 0 {
            let first = to.slopes.len();
            to.slopes.resize(first + self.sought, 0.0);
            self.carried(root, sensitivities, &mut to.slopes[first..]);
        }
    }
}

/// The point at which a simulation stops before the end of its data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unfinished {
    /// s
    pub time: f64,
    /// Whether too many or too short steps would have been needed; otherwise a number is not finite.
    pub stiff: bool,
}

/// Simulates a run with parameters and estimated initial states.
///
/// # Errors
/// [`Unfinished`].
pub(crate) fn simulate(
    equations: &Equations,
    parameters: &[f64],
    initial: &[f64],
    run: &Run,
    with_slopes: bool,
) -> Result<Vec<Simulated>, Unfinished> {
    let (m, n) = (equations.inputs(), equations.states());
    let sought = if with_slopes {
        parameters.len() + initial.len()
    } else {
        0
    };
    let mut variables = vec![0.0; m + n];
    variables.extend(parameters);
    variables.push(0.0);
    let mut of = Integrator {
        equations,
        numbers: Numbers::default(),
        gradient: vec![0.0; variables.len()],
        variables,
        sought,
        inputs: run.inputs_at(0.0).into_iter().map(|it| (it, 0.0)).collect(),
        from: 0.0,
    };
    let stamps = run.stamps();
    let z = of.beginning(
        &initial_states(equations, parameters, initial, run),
        parameters.len(),
    );
    let mut steps = Steps::from(z, n, stamps.len());
    let mut found: Vec<Simulated> = vec![Simulated::default(); equations.outputs.len()];
    let mut next: Vec<usize> = vec![0; found.len()];
    let mut acting: Vec<usize> = vec![0; m];
    for (k, time) in stamps.iter().copied().enumerate() {
        of.take_inputs(run, &mut acting, time);
        let is_measured =
            |(output, next): (usize, &usize)| run.outputs[output].times.get(*next) == Some(&time);
        if next.iter().enumerate().any(is_measured) {
            of.put(time, &steps.z);
            for output in 0..found.len() {
                if is_measured((output, &next[output])) {
                    next[output] += 1;
                    of.measure(output, &steps.z[n..], &mut found[output]);
                }
            }
        }
        let Some(end) = stamps.get(k + 1).copied() else {
            break;
        };
        if k % 512 == 0 {
            stop_point();
        }
        steps.advance(&mut of, time, end)?;
    }
    let mut values = (found.iter()).flat_map(|it| it.values.iter().chain(&it.slopes));
    match values.all(|it| it.is_finite()) {
        true => Ok(found),
        false => Err(Unfinished {
            time: stamps.last().copied().unwrap_or_default(),
            stiff: steps.stiff,
        }),
    }
}

/// The adaptive steps of a simulation by the pair of Dormand and Prince.
struct Steps {
    /// States, then their slopes: current, in a stage, after a step.
    z: Vec<f64>,
    at: Vec<f64>,
    after: Vec<f64>,
    stages: Vec<Vec<f64>>,
    /// The largest magnitude of each state so far.
    largest: Vec<f64>,
    /// The length of the next step, s.
    step: f64,
    /// Number of steps left.
    left: usize,
    /// Whether even the shortest allowed step was too long.
    stiff: bool,
}

impl Steps {
    fn from(z: Vec<f64>, states: usize, stamps: usize) -> Self {
        Self {
            largest: z[..states].iter().map(|it| it.abs()).collect(),
            at: z.clone(),
            after: z.clone(),
            stages: vec![vec![0.0; z.len()]; 7],
            z,
            step: f64::INFINITY,
            left: MOST_STEPS.0 * stamps + MOST_STEPS.1,
            stiff: false,
        }
    }

    /// Integrates from one time to another.
    fn advance(&mut self, of: &mut Integrator<'_>, time: f64, end: f64) -> Result<(), Unfinished> {
        let mut now = time;
        while now < end && !self.largest.is_empty() {
            let Some(left) = self.left.checked_sub(1) else {
                let (time, stiff) = (now, true);
                return Err(Unfinished { time, stiff });
            };
            self.left = left;
            let rest = end - now;
            // No last step of hardly any length.
            let is_last = self.step >= 0.999 * rest;
            let h = if is_last { rest } else { self.step };
            let error = self.attempt(of, now, h);
            let is_shortest = h <= SHORTEST * (end - time);
            if error.is_nan() || self.after.iter().any(|it| !it.is_finite()) {
                if is_shortest {
                    let stiff = self.stiff;
                    return Err(Unfinished { time: now, stiff });
                }
                self.step = 0.1 * h;
                continue;
            }
            let factor = (0.9 * libm::pow(error.max(1e-10), -0.2)).clamp(0.2, 5.0);
            self.stiff |= error > 1.0 && is_shortest;
            if error > 1.0 && !is_shortest {
                self.step = (h * factor).max(SHORTEST * (end - time));
                continue;
            }
            now = if is_last { end } else { now + h };
            self.step = match is_last {
                // What a short interval allows says nothing of a long one.
                true => self.step.max(h * factor),
                false => h * factor,
            };
            std::mem::swap(&mut self.z, &mut self.after);
            for (largest, x) in self.largest.iter_mut().zip(&self.z) {
                *largest = largest.max(x.abs());
            }
        }
        Ok(())
    }

    /// Computes the state after a step of length `h`, and its error over the allowed one.
    fn attempt(&mut self, of: &mut Integrator<'_>, now: f64, h: f64) -> f64 {
        let n = self.largest.len();
        of.derivatives(now, &self.z, &mut self.stages[0]);
        for stage in 0..6 {
            self.at.copy_from_slice(&self.z);
            for (slopes, weight) in self.stages.iter().zip(WEIGHTS[stage]).take(stage + 1) {
                if weight != 0.0 {
                    for (at, slope) in self.at.iter_mut().zip(slopes) {
                        *at += h * weight * slope;
                    }
                }
            }
            if stage == 5 {
                self.after.copy_from_slice(&self.at);
                break;
            }
            let to = &mut self.stages[stage + 1];
            of.derivatives(now + h * NODES[stage + 1], &self.at, to);
        }
        // The slope at the end is needed of the states alone.
        let with = std::mem::replace(&mut of.sought, 0);
        of.derivatives(now + h, &self.after[..n], &mut self.stages[6][..n]);
        of.sought = with;
        let mut error = 0.0_f64;
        for i in 0..n {
            let local: f64 = (self.stages.iter().zip(ERROR))
                .map(|(it, w)| w * it[i])
                .sum();
            let scale = self.largest[i].max(self.after[i].abs());
            let size = self.z[i].abs().max(self.after[i].abs()) + SMALL * scale;
            if local != 0.0 {
                error = error.max(h * local.abs() / (TOLERANCE * size));
            }
        }
        error
    }
}

/// The initial states of a run.
pub(crate) fn initial_states(
    equations: &Equations,
    parameters: &[f64],
    initial: &[f64],
    run: &Run,
) -> Vec<f64> {
    let mut variables = run.inputs_at(0.0);
    variables.resize(equations.inputs() + equations.states(), 0.0);
    variables.extend(parameters);
    variables.push(0.0);
    let mut numbers = Numbers::default();
    equations.tape.evaluate(&variables, &mut numbers);
    let mut sought = initial.iter();
    let begins = equations.begins.iter();
    let begins = begins.map(|it| match it {
        Begin::Sought(_) => sought.next().copied().unwrap_or(0.0),
        Begin::Given(root) => numbers.value(root),
    });
    begins.collect()
}
