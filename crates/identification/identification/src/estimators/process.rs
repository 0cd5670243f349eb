//! Process models: gain, one or two time constants and a dead time, in continuous time.
//!
//! ```text
//! 1    K e^(-theta s) / (T1 s + 1)                       2     K e^(-theta s) / ((T1 s + 1) (T2 s + 1))
//! i    K e^(-theta s) / s                                2u    K e^(-theta s) / ((s/wn)^2 + 2 zeta s/wn + 1)
//! 1i   K e^(-theta s) / (s (T1 s + 1))
//! ```
//! Under zero-order hold the sampled model is exact. `s_k` is the response to a unit step at k samples minus the fraction of the dead time, `A` is
//! the sampled denominator,
//! ```text
//! B(q) = A(q) (1 - q^-1) (s_1 q^-1 + s_2 q^-2 + ...)     one coefficient more than poles
//! ```
//! The few parameters minimise the simulated error, from the best points of a grid; the covariance allows for a residual of any colour. The
//! errors are not whitened: with whitened errors the dead time would depend on the single sample at which the response begins, and a search by
//! derivatives cannot follow that. If the input before a record is not known, it is assumed to have been constant at its first known value. A record in motion
//! has an initial state; in a record at rest the output was constant too. An integrating process has an input level at which its output is
//! constant.
//!
//! Source: Ljung 1999, sec. 4.2 and 10.2; the forms as in Astrom and Hagglund, *Advanced PID Control*, 2006, ch. 2.

use nalgebra::{DMatrix, DVector};

use super::estimate::{Error, Estimate};
use super::estimator::{Estimator, Recursive};
use super::levenberg_marquardt::{Linearised, minimise};
use super::process_model::{Form, ProcessModel};
use super::rows::{freedom, impulse, samples_by_run};
use super::simulator::coloured_factor;
use super::sums::dot;
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::structure::{InitialState, Layout, Problem, Structure, monic};
use planesman_record::{LONGEST_PAST, Run};

/// The reason why there is no process model.
const UNDETERMINED: IdentificationError =
    IdentificationError::Undetermined("the records determine no process model");
/// Points of the grid: time constants, the ratio of dead times, damping ratios.
const TIME_CONSTANTS: usize = 14;
const NEXT_DEAD_TIME: f64 = 1.2;
const DAMPING_RATIOS: [f64; 4] = [0.2, 0.5, 1.1, 2.5];
/// Number of grid points at which a search begins.
const STARTS: usize = 3;
/// A dead time this near to a whole sample, where the slope jumps, may be exactly there.
const NEAR_A_SAMPLE: f64 = 0.05;
/// Blocks in each part that is left out.
const BLOCKS_PER_PART: usize = 10;
/// The longest dead time, samples, limited by the samples kept from before a record.
const LONGEST_DEAD_TIME: usize = LONGEST_PAST - 10;
/// Time constants: the shortest in samples, the longest in record lengths.
const SHORTEST: f64 = 0.02;
const LONGEST: f64 = 100.0;
/// Damping ratios.
const LEAST_DAMPED: f64 = 1e-3;
const MOST_DAMPED: f64 = 1e3;

/// Initial state of the records of a process model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Begins {
    /// The initial state is the one given in the problem.
    AsGiven,
    /// The records begin at rest with this input.
    AtRest(f64),
    /// The records begin in motion, with an initial state.
    InMotion,
}

impl Begins {
    /// The initial state to estimate, and the input at rest.
    fn of(self, problem: &Problem<'_>) -> (InitialState, f64) {
        match self {
            Self::AsGiven => (problem.structure.start, 0.0),
            Self::AtRest(input) => (InitialState::Rest, input),
            Self::InMotion => (InitialState::Estimated, 0.0),
        }
    }
}

/// The process model with the smallest simulated error. Of the problem's structure only the offset and the initial state are used.
#[derive(Clone, Debug)]
pub struct Process {
    /// The form; `Second` and `Underdamped` are one family, and the data decides between them unless `is_named`.
    pub form: Form,
    /// Whether a pair of poles must be of the form's kind, real or complex.
    pub is_named: bool,
    /// Initial state of the records.
    pub begins: Begins,
    /// A model near the solution, from which the search starts instead of from a grid.
    pub near: Option<ProcessModel>,
}

impl Process {
    /// Of a form.
    #[must_use]
    pub fn of(form: Form) -> Self {
        Self {
            form,
            is_named: false,
            begins: Begins::AsGiven,
            near: None,
        }
    }

    /// The errors of cross-validation: parts of the records are left out of the fit, one in `parts` at a time, and simulated. Each search
    /// begins near the model.
    ///
    /// # Errors
    /// Like [`Estimator::fit`].
    pub(crate) fn left_out(&self, problem: &Problem<'_>, parts: usize) -> Result<Vec<Vec<f64>>> {
        let model = self.near.as_ref().ok_or(UNDETERMINED)?;
        let search = Search::new(self, problem);
        let start = search.near(model).ok_or(UNDETERMINED)?;
        let rows = search.rows();
        let block = (rows / (BLOCKS_PER_PART * parts)).max(1);
        let is_left_out = |part: usize, row: usize| (row / block) % parts == part;
        let mut errors = vec![0.0; rows];
        for part in 0..parts {
            let (found, _) = minimise(start.clone(), |theta| {
                let mut at = search.linearised(theta);
                for row in (0..rows).filter(|row| is_left_out(part, *row)) {
                    at.errors[row] = 0.0;
                    at.slopes.row_mut(row).fill(0.0);
                }
                at
            })?;
            let at = search.linearised(&found);
            for row in (0..rows).filter(|row| is_left_out(part, *row)) {
                errors[row] = at.errors[row];
            }
        }
        Ok(samples_by_run(problem, &errors))
    }
}

impl Estimator for Process {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let search = Search::new(self, problem);
        let starts = match &self.near {
            Some(model) => search.near(model).into_iter().collect(),
            None => search.starts(),
        };
        let (theta, _) = (starts.into_iter())
            .filter_map(|start| search.least(start).ok())
            .min_by(|p, q| p.1.cost().total_cmp(&q.1.cost()))
            .ok_or(UNDETERMINED)?;
        search.estimate(problem, &theta)
    }

    fn learner(&self, _: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        Err(IdentificationError::Option(
            "a process model has no recursive form".to_owned(),
        ))
    }
}

/// The signals of a record.
struct Signals {
    /// The input, starting as many samples earlier as the longest dead time.
    driving: Vec<f64>,
    /// The signal `driving` for a constant input of 1.
    ones: Vec<f64>,
    outputs: Vec<f64>,
}

/// A search. The search's parameters are the gain, the shape, the dead time in samples, the input level if estimated, and offset and initial state of
/// each record.
struct Search<'a> {
    of: &'a Process,
    /// The sampled model's layout, with the delay for a dead time below one sample.
    layout: Layout,
    sample_time: f64,
    signals: Vec<Signals>,
    /// The longest dead time, samples.
    longest: usize,
}

impl<'a> Search<'a> {
    fn new(of: &'a Process, problem: &Problem<'_>) -> Self {
        let mut structure = of.form.structure(&problem.structure);
        let (start, rest) = of.begins.of(problem);
        structure.start = start;
        let longest = problem.runs.iter().map(|run| run.outputs.len()).max();
        let longest = longest.unwrap_or(0).min(LONGEST_DEAD_TIME);
        let integrates = of.form.integrates();
        let before = longest + structure.numerator + 1;
        let signals = |run: &Run<'_>| {
            let extended = |past: &[f64], inputs: &[f64]| {
                let known = past.len().min(before);
                let first = past.first().or(inputs.first()).copied().unwrap_or_default();
                let stood = match structure.start {
                    InitialState::Rest => vec![0.0; before],
                    InitialState::Estimated => [
                        vec![first; before - known],
                        past[past.len() - known..].to_vec(),
                    ]
                    .concat(),
                };
                let mut all = [stood, inputs.to_vec()].concat();
                if integrates {
                    let mut sum = 0.0;
                    for u in &mut all {
                        sum += *u;
                        *u = sum;
                    }
                    let anchor = match structure.start {
                        InitialState::Rest => 0.0,
                        InitialState::Estimated => all[before],
                    };
                    all.iter_mut().for_each(|it| *it -= anchor);
                }
                all
            };
            let inputs: Vec<f64> = run.inputs.iter().map(|u| u - rest).collect();
            Signals {
                driving: extended(run.past, &inputs),
                ones: extended(&[], &vec![1.0; inputs.len()]),
                outputs: run.outputs.to_vec(),
            }
        };
        Self {
            of,
            signals: problem.runs.iter().map(signals).collect(),
            layout: Layout {
                structure,
                runs: problem.runs.len(),
            },
            sample_time: problem.sample_time,
            longest,
        }
    }

    fn rows(&self) -> usize {
        self.signals.iter().map(|of| of.outputs.len()).sum()
    }

    /// The place of the dead time.
    fn delay_at(&self) -> usize {
        self.of.form.parameters().len() - 1
    }

    fn has_level(&self) -> bool {
        let s = &self.layout.structure;
        self.of.form.integrates() && s.offset && s.start == InitialState::Estimated
    }

    /// The first place of offsets and initial states.
    fn rest_at(&self) -> usize {
        self.delay_at() + 1 + usize::from(self.has_level())
    }

    /// The coefficients of the sampled model.
    fn sampled_count(&self) -> usize {
        self.layout.structure.poles + self.layout.structure.numerator
    }

    fn count(&self) -> usize {
        self.rest_at() + self.layout.count() - self.sampled_count()
    }

    /// The input level for which an integrating process is constant.
    fn level(&self, theta: &DVector<f64>) -> f64 {
        match self.has_level() {
            true => theta[self.delay_at() + 1],
            false => 0.0,
        }
    }

    /// The dead time in whole samples and the fraction; a negative dead time is all fraction.
    fn split(&self, theta: &DVector<f64>) -> (usize, f64) {
        let delay = theta[self.delay_at()];
        let whole = delay.max(0.0).floor();
        (whole as usize, delay - whole)
    }

    /// Whether shape and dead time are within the search's limits.
    fn is_inside(&self, theta: &DVector<f64>) -> bool {
        let at = self.delay_at();
        let (shortest, longest) = (SHORTEST, LONGEST * self.longest.max(1) as f64);
        let (shortest, longest) = (shortest * self.sample_time, longest * self.sample_time);
        let is_time = |it: f64| (libm::log(shortest)..=libm::log(longest)).contains(&it);
        let shape_is = match &theta.as_slice()[1..at] {
            [constant] => is_time(*constant),
            [omega, zeta] => {
                is_time(-omega) && (libm::log(LEAST_DAMPED)..=libm::log(MOST_DAMPED)).contains(zeta)
            }
            _ => true,
        };
        shape_is && (-1.0..=self.longest as f64).contains(&theta[at])
    }

    /// `a1 ... an`, `b1 ... bm` of the sampled model for a gain of 1, and their slopes by shape and dead time.
    fn sampled(&self, theta: &DVector<f64>) -> (Vec<f64>, Vec<f64>, DMatrix<f64>) {
        const BY: f64 = 1e-5;
        let at = self.delay_at();
        let (_, fraction) = self.split(theta);
        let (form, dt) = (self.of.form, self.sample_time);
        let shape = &theta.as_slice()[1..at];
        let (a, b) = form.sampled(shape, fraction, dt);
        let mut slopes = DMatrix::zeros(a.len() + b.len(), at);
        for i in 0..at {
            let moved = |by: f64| {
                let mut shape = shape.to_vec();
                let mut fraction = fraction;
                match shape.get_mut(i) {
                    Some(it) => *it += by,
                    None => fraction += by,
                }
                let (a, b) = form.sampled(&shape, fraction, dt);
                DVector::from_vec([a, b].concat())
            };
            slopes.set_column(i, &((moved(BY) - moved(-BY)) / (2.0 * BY)));
        }
        (a, b, slopes)
    }

    /// The input of record `run` minus a level, delayed by `whole` samples beyond one.
    fn driving(&self, run: usize, whole: usize, level: f64) -> Vec<f64> {
        let of = &self.signals[run];
        let first = of.driving.len() - of.outputs.len() - 1 - whole;
        let pairs = of.driving.iter().zip(&of.ones).skip(first);
        let about = pairs.map(|(u, one)| u - level * one);
        about.take(of.outputs.len()).collect()
    }

    /// Errors and slopes.
    fn linearised(&self, theta: &DVector<f64>) -> Linearised {
        let rows = self.rows();
        let mut slopes = DMatrix::zeros(rows, theta.len());
        if !self.is_inside(theta) {
            let errors = DVector::from_element(rows, f64::INFINITY);
            return Linearised { errors, slopes };
        }
        let mut errors = DVector::zeros(rows);
        let (at, gain, level) = (self.delay_at(), theta[0], self.level(theta));
        let (whole, _) = self.split(theta);
        let (a, b, by) = self.sampled(theta);
        let (n, den) = (a.len(), monic(&a));
        let mut first = 0;
        for (run, of) in self.signals.iter().enumerate() {
            let count = of.outputs.len();
            let mut column = |place: usize, signal: &[f64]| {
                slopes
                    .view_mut((first, place), (count, 1))
                    .copy_from_slice(signal);
            };
            let driving = self.driving(run, whole, level);
            let caused = filtered(&b, &den, &driving);
            column(0, &caused);
            let places = self.places(run);
            let motion: Vec<f64> = places.1.clone().map(|place| theta[place]).collect();
            let free = filtered(&motion, &den, &impulse(0, count));
            let total: Vec<f64> = (caused.iter().zip(&free))
                .map(|(x, m)| gain * x + m)
                .collect();
            for i in 0..at {
                let of_b: Vec<f64> = (n..n + b.len()).map(|row| gain * by[(row, i)]).collect();
                let mut slope = filtered(&of_b, &den, &driving);
                if n > 0 && i + 1 < at {
                    let of_a: Vec<f64> = std::iter::once(0.0)
                        .chain((0..n).map(|row| -by[(row, i)]))
                        .collect();
                    let through = filtered(&of_a, &den, &total);
                    slope.iter_mut().zip(through).for_each(|(s, it)| *s += it);
                }
                column(i + 1, &slope);
            }
            if self.has_level() {
                let first = of.ones.len() - count - 1 - whole;
                let mut slope = filtered(&b, &den, &of.ones[first..first + count]);
                slope.iter_mut().for_each(|it| *it *= -gain);
                column(at + 1, &slope);
            }
            let offset = places.0.map_or(0.0, |place| theta[place]);
            if let Some(place) = places.0 {
                column(place, &vec![1.0; count]);
            }
            for (i, place) in places.1.enumerate() {
                column(place, &filtered(&[1.0], &den, &impulse(i, count)));
            }
            let pairs = of.outputs.iter().zip(&total);
            let left: Vec<f64> = pairs.map(|(y, x)| y - x - offset).collect();
            errors.rows_mut(first, count).copy_from_slice(&left);
            first += count;
        }
        Linearised { errors, slopes }
    }

    /// The places of a record's offset and initial state.
    fn places(&self, run: usize) -> (Option<usize>, std::ops::Range<usize>) {
        let shift = |place: usize| place - self.sampled_count() + self.rest_at();
        let motion = self.layout.motion(run);
        let motion = match motion.is_empty() {
            true => 0..0,
            false => shift(motion.start)..shift(motion.end),
        };
        (self.layout.offset(run).map(shift), motion)
    }

    /// With given shape and dead time, computes all other parameters by least squares.
    fn completed(&self, shape: &[f64], delay: f64) -> Option<DVector<f64>> {
        let at = self.delay_at();
        let mut theta = DVector::zeros(self.count());
        theta[0] = 1.0;
        theta.rows_mut(1, shape.len()).copy_from_slice(shape);
        theta[at] = delay;
        if !self.is_inside(&theta) {
            return None;
        }
        let here = self.linearised(&theta);
        let linear: Vec<usize> = std::iter::once(0).chain(at + 1..theta.len()).collect();
        let columns = here.slopes.select_columns(&linear);
        let sizes: Vec<f64> = (columns.column_iter())
            .map(|it| it.norm().max(f64::MIN_POSITIVE))
            .collect();
        let triangle = Triangle::new(&columns, &here.errors).ok()?.scaled(&sizes);
        let step = triangle.damped(1e-7).solution().ok()?;
        for ((place, step), size) in linear.iter().zip(step.iter()).zip(&sizes) {
            theta[*place] += step / size;
        }
        if self.has_level() {
            // It was sought for a gain of 1.
            theta[at + 1] /= theta[0];
        }
        theta.iter().all(|it| it.is_finite()).then_some(theta)
    }

    /// Initial parameters near a given model.
    fn near(&self, model: &ProcessModel) -> Option<DVector<f64>> {
        let values = model.values.as_slice();
        let (last, middle) = values.split_last()?;
        let shape = match (model.form, &middle[1..]) {
            (Form::Second, [slow, fast]) => {
                let omega = 1.0 / (slow * fast).sqrt();
                vec![libm::log(omega), libm::log(omega * (slow + fast) / 2.0)]
            }
            (_, shape) => shape.iter().map(|it| libm::log(*it)).collect(),
        };
        self.completed(&shape, last / self.sample_time)
    }

    /// Starts: the best points of a grid of shapes and dead times.
    fn starts(&self) -> Vec<DVector<f64>> {
        let longest = self.longest.max(2) as f64;
        let mut delays = vec![0];
        while let Some(last) = delays.last().filter(|last| (**last as f64) < longest / 2.0) {
            let next = (*last as f64 * NEXT_DEAD_TIME) as usize;
            delays.push(next.max(last + 1).min(self.longest));
        }
        let constants = (0..TIME_CONSTANTS).map(|i| {
            let exponent = i as f64 / (TIME_CONSTANTS - 1) as f64;
            libm::log(0.5 * libm::pow(2.0 * longest, exponent) * self.sample_time)
        });
        let shapes: Vec<Vec<f64>> = match self.of.form.poles() {
            0 => vec![Vec::new()],
            1 => constants.map(|it| vec![it]).collect(),
            _ => constants
                .flat_map(|it| DAMPING_RATIOS.map(|zeta| vec![-it, libm::log(zeta)]))
                .collect(),
        };
        let mut points: Vec<(f64, &Vec<f64>, usize)> = Vec::new();
        for shape in &shapes {
            let costs = self.costs(shape, &delays);
            points.extend(
                costs
                    .into_iter()
                    .zip(&delays)
                    .map(|(cost, delay)| (cost, shape, *delay)),
            );
        }
        points.sort_by(|p, q| p.0.total_cmp(&q.0));
        // One of each neighbourhood.
        let mut kept: Vec<(f64, &Vec<f64>, usize)> = Vec::new();
        for point in points {
            let near = |other: &(f64, &Vec<f64>, usize)| {
                let shapes = point.1.iter().zip(other.1);
                shapes.map(|(p, q)| (p - q).abs()).fold(0.0, f64::max) < 1.0
            };
            if kept.len() < STARTS && !kept.iter().any(near) {
                kept.push(point);
            }
        }
        kept.into_iter()
            .filter_map(|(_, shape, delay)| self.completed(shape, delay as f64 + 0.5))
            .collect()
    }

    /// The smallest squared errors for a shape with each of the dead times plus half a sample.
    fn costs(&self, shape: &[f64], delays: &[usize]) -> Vec<f64> {
        let (a, b) = self.of.form.sampled(shape, 0.5, self.sample_time);
        let den = monic(&a);
        // Of all records: by the dead time, the sums of x x, x y and y y beside what offset, motion and level explain.
        let mut sums = vec![[0.0_f64; 3]; delays.len()];
        for of in &self.signals {
            let count = of.outputs.len();
            let before = of.driving.len() - count;
            let mut others: Vec<Vec<f64>> = Vec::new();
            if self.layout.structure.offset {
                others.push(vec![1.0; count]);
            }
            if self.layout.structure.start == InitialState::Estimated {
                others.extend((0..a.len()).map(|i| filtered(&[1.0], &den, &impulse(i, count))));
            }
            if self.has_level() {
                let ones = filtered(&b, &den, &of.ones);
                others.push(ones[before..].to_vec());
            }
            let mut basis: Vec<Vec<f64>> = Vec::new();
            for mut other in others {
                let whole = dot(&other, &other);
                for of in &basis {
                    let along = dot(of, &other);
                    other.iter_mut().zip(of).for_each(|(v, q)| *v -= along * q);
                }
                let left = dot(&other, &other);
                if left > 1e-12 * whole {
                    let size = left.sqrt();
                    other.iter_mut().for_each(|v| *v /= size);
                    basis.push(other);
                }
            }
            let along = |signal: &[f64]| basis.iter().map(|q| dot(q, signal)).collect::<Vec<f64>>();
            let (caused, of_outputs) = (filtered(&b, &den, &of.driving), along(&of.outputs));
            for (sums, delay) in sums.iter_mut().zip(delays) {
                let first = before - 1 - delay;
                let x = &caused[first..first + count];
                let of_x = along(x);
                let y = of.outputs.as_slice();
                for (sum, (p, q, of_p, of_q)) in sums.iter_mut().zip([
                    (x, x, &of_x, &of_x),
                    (x, y, &of_x, &of_outputs),
                    (y, y, &of_outputs, &of_outputs),
                ]) {
                    *sum += dot(p, q) - dot(of_p, of_q);
                }
            }
        }
        let cost = |[xx, xy, yy]: [f64; 3]| match xx > 0.0 {
            true => yy - xy * xy / xx,
            false => yy,
        };
        sums.into_iter().map(cost).collect()
    }

    /// The minimum of the error near a start. If poles would change from real to complex or the reverse, both are set to `-wn`.
    fn least(&self, start: DVector<f64>) -> Result<(DVector<f64>, Linearised)> {
        const ZETA: usize = 2;
        let found = self.least_with(start, &[])?;
        let is_other = self.of.is_named
            && match self.of.form {
                Form::Second => found.0[ZETA] < 0.0,
                Form::Underdamped => found.0[ZETA] > 0.0,
                _ => false,
            };
        if !is_other {
            return Ok(found);
        }
        let mut start = found.0;
        start[ZETA] = 0.0;
        self.least_with(start, &[ZETA])
    }

    /// The parameters with the smallest error when some of them are fixed.
    fn least_with(
        &self,
        start: DVector<f64>,
        fixed: &[usize],
    ) -> Result<(DVector<f64>, Linearised)> {
        let minimised = |start: DVector<f64>, fixed: &[usize]| {
            minimise(start, |theta| {
                let mut here = self.linearised(theta);
                for place in fixed {
                    here.slopes.column_mut(*place).fill(0.0);
                }
                here
            })
        };
        let found = minimised(start, fixed)?;
        let at = self.delay_at();
        let nearest = found.0[at].round().max(0.0);
        if found.0[at] >= 0.0 && (found.0[at] - nearest).abs() > NEAR_A_SAMPLE {
            return Ok(found);
        }
        // From both sides the least error may be at the whole sample, and a dead time is not below 0.
        let mut start = found.0.clone();
        start[at] = nearest;
        let whole = minimised(start, &[fixed, &[at]].concat())?;
        match found.0[at] >= 0.0 && found.1.cost() <= whole.1.cost() {
            true => Ok(found),
            false => Ok(whole),
        }
    }

    fn estimate(&self, problem: &Problem<'_>, theta: &DVector<f64>) -> Result<Estimate> {
        // At a limit the slopes are those of free parameters: the intervals reach beyond it.
        let here = self.linearised(theta);
        let freedom = freedom(here.errors.len(), theta.len())?;
        let variance = here.errors.norm_squared() / freedom;
        let residuals = samples_by_run(problem, here.errors.as_slice());
        let factor = coloured_factor(&here, &residuals, variance)?;
        let at = self.delay_at();
        let shape = &theta.as_slice()[1..at];
        let form = match (self.of.is_named, shape) {
            (false, [_, zeta]) if *zeta >= 0.0 => Form::Second,
            (false, [_, _]) => Form::Underdamped,
            _ => self.of.form,
        };
        let spread = factor.row(at - 1).norm();
        let (values, by) = form.natural(theta[0], shape, theta[at], self.sample_time, spread);
        let own = by * factor.rows(0, values.len());
        let process = ProcessModel {
            form,
            values: DVector::from_vec(values),
            covariance: &own * own.transpose(),
            sought: theta.len(),
        };
        let (whole, _) = self.split(theta);
        let structure = Structure {
            delay: whole + 1,
            ..self.layout.structure.clone()
        };
        let (coefficients, slopes) = self.coefficients(theta);
        let sampled = Problem {
            structure,
            ..problem.clone()
        };
        let (error, factor) = (Error::Output, slopes * factor);
        Ok(Estimate {
            input_level: self.level(theta) + self.of.begins.of(problem).1,
            process: Some(process),
            ..Estimate::of(&sampled, error, coefficients, factor, variance, residuals)
        })
    }

    /// The sampled model's parameters, and their slopes by the search's parameters.
    fn coefficients(&self, theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (n, count, gain) = (self.layout.structure.poles, self.sampled_count(), theta[0]);
        let (a, b, by) = self.sampled(theta);
        let mut all = DVector::zeros(self.layout.count());
        let mut slopes = DMatrix::zeros(all.len(), theta.len());
        for (i, value) in a.iter().enumerate() {
            all[i] = *value;
        }
        for (i, value) in b.iter().enumerate() {
            all[n + i] = gain * value;
            slopes[(n + i, 0)] = *value;
        }
        slopes.view_mut((0, 1), by.shape()).copy_from(&by);
        slopes
            .view_mut((n, 1), (count - n, by.ncols()))
            .scale_mut(gain);
        for i in count..all.len() {
            let from = self.rest_at() + i - count;
            all[i] = theta[from];
            slopes[(i, from)] = 1.0;
        }
        (all, slopes)
    }
}

/// `num(q^-1) / den(q^-1)` from rest, in the transposed form, in which the sums of one sample are independent of each other.
fn filtered(num: &[f64], den: &[f64], signal: &[f64]) -> Vec<f64> {
    let order = num.len().max(den.len());
    let mut state = vec![0.0; order];
    let of = |coefficients: &[f64]| {
        let mut of = coefficients.to_vec();
        of.resize(order, 0.0);
        of
    };
    let (num, den) = (of(num), of(den));
    let sample = |u: &f64| {
        let y = num.first().map_or(0.0, |b| b * u) + state[0];
        for i in 1..order {
            let next = state.get(i).copied().unwrap_or_default();
            state[i - 1] = next + num[i] * u - den[i] * y;
        }
        y
    };
    signal.iter().map(sample).collect()
}
