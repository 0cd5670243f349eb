//! Fits a vehicle of six degrees of freedom to a recording: coefficients with intervals, undetermined numbers, the next run.

mod error;
mod experiments;
mod input_signs;
mod kinematics;
mod options;
mod prediction;
mod problem;
mod recording;
mod signals;
mod windows;

use std::fmt;

use nalgebra::DMatrix;
use planesman_equations::Run;
use planesman_fit::StampedRuns;
use planesman_identification::SIGMAS_95;
use planesman_identification::analysis::Standing;
use planesman_linear::digits::significant;
use planesman_parallel::Progress;
use planesman_vehicle::six_dof::EditableFile;
use serde::Serialize;

pub use error::SixDofError;
use experiments::experiments;
use prediction::predictions;
use problem::{Problem, VELOCITIES, Window};
use windows::Cutter;

pub use experiments::{Expected, NextRun};
pub use input_signs::ReversedInput;
pub use kinematics::{Agreement, Contradiction, Reset, Saturated};
pub use options::{Axes, Cost, Delay, SixDofOptions};
pub use prediction::{Errors, Prediction, Predictor, Trajectory};
pub use signals::SIGNALS;

/// The share of a recording that is fitted if the rest is used for validation.
const FITTED: f64 = 0.7;
/// Correlations above this are reported.
const CORRELATED: f64 = 0.95;
/// Windows of the first search, if the cost is of velocities \[s\].
const SHORT: f64 = 1.0;

/// A value with half its 95 % interval.
#[derive(Clone, Debug, Serialize)]
pub struct Estimated {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Half of its 95 % interval.
    pub interval: f64,
    /// Its value in the initial vehicle; 0 for a bias, a current and a delay.
    pub like: f64,
    /// The least size to which its interval is compared: that of a number that is 0 in the initial vehicle, else 0.
    pub size: f64,
}

impl Estimated {
    /// Half the interval relative to the value, or to its size.
    #[must_use]
    pub fn relative(&self) -> f64 {
        self.interval / self.value.abs().max(self.size)
    }
}

/// Errors on the last three tenths, by a fit of the first seven.
#[derive(Clone, Debug, Serialize)]
pub struct HeldOut {
    /// Duration of the held-out data \[s\].
    pub seconds: f64,
    /// For each signal: root mean squares with the fitted and with the initial vehicle.
    pub signals: Vec<(&'static str, f64, f64)>,
}

/// A vehicle fitted to a recording.
#[derive(Debug, Serialize)]
pub struct SixDofResult {
    /// The initial vehicle.
    pub like: String,
    /// What was read.
    #[serde(skip)]
    pub data: StampedRuns,
    /// Duration of the fitted data \[s\].
    pub seconds: f64,
    /// Number of windows, each with its own initial state.
    pub windows: usize,
    /// Number of samples of all signals.
    pub samples: usize,
    /// The estimated numbers.
    pub numbers: Vec<Estimated>,
    /// Current, north and east \[m/s\].
    pub current: Vec<Estimated>,
    /// Biases, the signals' units.
    pub biases: Vec<Estimated>,
    /// The delays \[s\]: of each input, or one of all.
    pub delays: Vec<Estimated>,
    /// The noise of each signal: a standard deviation.
    pub noise: Vec<(&'static str, f64)>,
    /// Pairs of numbers that can hardly be separated, with their correlation.
    pub correlated: Vec<(String, String, f64)>,
    /// Poses that contradict the recorded velocities.
    pub contradictions: Vec<Contradiction>,
    /// Inputs that act against their direction in the vehicle file.
    pub reversed_inputs: Vec<ReversedInput>,
    /// The agreement of each pose with the velocities.
    pub agreements: Vec<Agreement>,
    /// Jumps of the recorded pose, which are left out.
    pub resets: Vec<Reset>,
    /// Inputs that stay at a limit.
    pub saturated: Vec<Saturated>,
    /// Errors of predictions from measured states of the held-out data.
    pub predictions: Vec<Prediction>,
    /// Some of these predictions.
    #[serde(skip)]
    pub trajectories: Vec<Trajectory>,
    /// `None` if one of the vehicles diverges there, or too little time is left.
    pub held_out: Option<HeldOut>,
    /// The numbers that the data does not determine.
    pub undetermined: Vec<Expected>,
    /// The run that minimises the largest interval.
    pub next: Option<NextRun>,
    /// The relative prior standard deviation of each number.
    pub prior: f64,
    /// The range of each signal.
    #[serde(skip)]
    ranges: Vec<(&'static str, f64)>,
    #[serde(skip)]
    file: EditableFile,
    #[serde(skip)]
    sought: Vec<usize>,
}

/// The fitted vehicle counts as worse than the initial one if its errors on held-out data are at least this many times as large.
const WORSE: f64 = 1.05;
/// Errors within this many times the noise do not count as worse.
const WITHIN_NOISE: f64 = 1.5;
/// Predictions with errors this many times those of constant velocity, or of the initial vehicle, are not usable.
const NO_BETTER: f64 = 1.1;
/// Errors below this share of a signal's range are no worse.
const SMALL: f64 = 1e-3;

/// The verdict on a fitted vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SixDofVerdict {
    /// The recording contradicts itself.
    Contradictory,
    /// The fitted vehicle predicts or simulates held-out data worse than the initial vehicle: the ratio of their errors.
    Worse {
        /// Errors of the fitted vehicle over the initial one's, geometric mean over the signals.
        ratio: f64,
    },
    /// The vehicle predicts worse than a constant velocity; contains the ratio of the errors.
    NoPrediction {
        /// Errors of the fitted vehicle over those of constant velocity, geometric mean of velocity, rate and position.
        ratio: f64,
    },
    /// The vehicle predicts no better than a linear model per axis; contains the ratio of the errors.
    LinearAsGood {
        /// Errors of the fitted vehicle over those of the linear model, geometric mean of velocity, rate and position.
        ratio: f64,
    },
    /// There is no data to validate the vehicle on.
    NotValidated,
    /// Some numbers are not determined.
    NotDetermined {
        /// Their count.
        count: usize,
        /// The total of estimated numbers.
        of: usize,
    },
    /// The fitted vehicle predicts well, and each number is determined.
    Good,
}

impl SixDofVerdict {
    /// The permitted use of the vehicle.
    #[must_use]
    pub const fn standing(&self) -> Standing {
        match self {
            Self::Contradictory | Self::Worse { .. } | Self::NoPrediction { .. } => {
                Standing::NotUsable
            }
            Self::NotValidated => Standing::NotValidated,
            Self::NotDetermined { .. } | Self::LinearAsGood { .. } => Standing::UsableWithCare,
            Self::Good => Standing::Good,
        }
    }
}

impl fmt::Display for SixDofVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contradictory => {
                f.write_str("not usable: signals of the recording contradict each other")
            }
            Self::Worse { ratio } => write!(
                f,
                "not usable: the errors on the held-out data are {ratio:.2} times those of the initial vehicle"
            ),
            Self::NoPrediction { ratio } => write!(
                f,
                "not usable: it predicts the held-out data worse than if the velocity stayed the \
                 same (errors {ratio:.2} times as large); do the signs of inputs and motion agree?"
            ),
            Self::LinearAsGood { ratio } => write!(
                f,
                "usable with care: a linear model per axis predicts the held-out data as well, so \
                 use that (errors of the vehicle: {ratio:.2} times those of the linear model)"
            ),
            Self::NotValidated => f.write_str("not validated: nothing was held out"),
            Self::NotDetermined { count, of } => write!(
                f,
                "usable with care: the recording does not determine {count} of {of} numbers"
            ),
            Self::Good => f.write_str("good: every number is determined"),
        }
    }
}

/// The largest ratio of the fitted vehicle's errors to those of another model; 0 without predictions by both.
fn largest_ratio<'p>(of: impl Iterator<Item = &'p Prediction>, other: Predictor) -> f64 {
    let ratio = |at: &Prediction| Some(at.of(Predictor::Fitted)?.over(&at.of(other)?));
    of.filter_map(ratio).fold(0.0, f64::max)
}

impl SixDofResult {
    /// The verdict on the vehicle.
    #[must_use]
    pub fn verdict(&self) -> SixDofVerdict {
        if !self.contradictions.is_empty() || !self.reversed_inputs.is_empty() {
            return SixDofVerdict::Contradictory;
        }
        let Some(held) = &self.held_out else {
            return SixDofVerdict::NotValidated;
        };
        let of = |all: &[(&str, f64)], name: &str| {
            all.iter().find(|it| it.0 == name).map_or(0.0, |it| it.1)
        };
        let is_large = held
            .signals
            .iter()
            .any(|it| it.1 > SMALL * of(&self.ranges, it.0));
        let is_seen = held.signals.iter().any(|(name, fitted, _)| {
            *fitted > WITHIN_NOISE * of(&self.noise, name)
                && *fitted > SMALL * of(&self.ranges, name)
        });
        let ratios = held.signals.iter().map(|it| libm::log(it.1 / it.2));
        let ratio = libm::exp(ratios.sum::<f64>() / held.signals.len().max(1) as f64);
        let judged = self.predictions.iter().filter(|it| it.is_judged);
        let over_like = largest_ratio(judged.clone(), Predictor::Like);
        if (is_seen && ratio > WORSE) || (is_large && over_like > NO_BETTER) {
            let ratio = over_like.max(if is_seen { ratio } else { 0.0 });
            return SixDofVerdict::Worse { ratio };
        }
        // Over any horizon: over a long one the measured motion may average out.
        let ratio = largest_ratio(self.predictions.iter(), Predictor::ConstantVelocity);
        if is_large && ratio > NO_BETTER {
            return SixDofVerdict::NoPrediction { ratio };
        }
        let ratio = largest_ratio(judged, Predictor::LinearPerAxis);
        if is_large && ratio > 1.0 {
            return SixDofVerdict::LinearAsGood { ratio };
        }
        match self.undetermined.len() {
            0 => SixDofVerdict::Good,
            count => SixDofVerdict::NotDetermined {
                count,
                of: self.numbers.len(),
            },
        }
    }

    /// The vehicle as a file with that name: the text of the initial one with the estimated numbers.
    #[must_use]
    pub fn text(&self, name: &str, recording: &str) -> String {
        let head = format!(
            "{name}: fitted by planesman six-dof fit to {recording}, {:.0} s in {} windows, like \
             {}.\nVerdict: {}.\nEstimated numbers are marked, with half of their 95 % interval; all other numbers are unchanged.",
            self.seconds,
            self.windows,
            self.like,
            self.verdict()
        );
        let found = self.sought.iter().zip(&self.numbers);
        let found = found.map(|(place, it)| {
            let is_undetermined = self.undetermined.iter().any(|of| of.name == it.name);
            let remark = match is_undetermined {
                true => "not determined by the data".to_owned(),
                false => format!("95 % +-{}", significant(it.interval, 2)),
            };
            ((*place, it.value), remark)
        });
        self.file.text(name, &head, &found.collect::<Vec<_>>())
    }
}

/// Fits a vehicle to a recording.
///
/// # Errors
/// If the vehicle is invalid, a word matches none of its numbers, the recording lacks signals, or the motion diverges.
pub fn fit_six_dof(
    options: &SixDofOptions,
    progress: &dyn Progress,
) -> Result<SixDofResult, SixDofError> {
    options.data.check_stamped()?;
    let file = EditableFile::load(&options.like)?;
    let sought = options.sought(&file)?;
    let vehicle = file.vehicle(&[])?;
    let (data, channels) = recording::read(options, &vehicle.parts().inputs, progress)?;
    let biased = options.biased(&channels)?;
    let resets = kinematics::resets(&data.runs, &channels);
    let mut cutter = Cutter::new(&data.runs, &channels, &resets, options.cost);
    let mut all = cutter.windows(options.horizon, 0.0..1.0);
    let samples = samples(&all);
    let inputs = vehicle.parts().inputs.len();
    let mut problem = Problem {
        file: &file,
        sought,
        prior: options.prior,
        biased,
        noise: [1.0; 12],
        is_known: false,
        delays: options.delay.count(inputs),
        cost: options.cost,
    };
    let unknown = unknown(&problem, &all);
    if samples <= 2 * unknown {
        return Err(SixDofError::FewSamples { samples, unknown });
    }
    if let Some(longer) = cutter.with_longer_steps(&problem, options.horizon, &all) {
        (cutter, all) = longer;
    }
    progress.begin("models", 0, 0);
    let short = match options.cost {
        Cost::All => Vec::new(),
        Cost::Velocities => cutter.windows(SHORT, 0.0..1.0),
    };
    let found = problem.weighed(&all, &short);
    let found = found.and_then(|it| Some((problem.covariance(&all, &it)?, it)));
    progress.end();
    let contradictions = kinematics::contradictions(&data.runs, &channels);
    let ((covariance, information), theta) =
        found.ok_or_else(|| match contradictions.is_empty() {
            true => SixDofError::Diverges(options.like.clone()),
            false => SixDofError::Contradictory(contradictions.clone()),
        })?;
    let globals = &theta.as_slice()[..problem.globals()];
    let (numbers, current, biases, mut delays) = estimated(&problem, globals, &covariance);
    if delays.len() == inputs {
        let named = delays.iter_mut().zip(&vehicle.parts().inputs);
        named.for_each(|(it, name)| it.name.clone_from(name));
    }
    let relative: Vec<f64> = numbers.iter().map(Estimated::relative).collect();
    let (undetermined, next) = experiments(
        &problem,
        globals,
        &information,
        (&data.runs, &channels),
        (&relative, options.bound),
    )
    .unwrap_or_default();
    let judged = judged(
        &problem,
        &cutter,
        (&all, globals),
        &data.validation,
        options,
    );
    let noise = channels
        .iter()
        .map(|it| (SIGNALS[*it].0, problem.noise[*it]));
    Ok(SixDofResult {
        prior: options.prior,
        like: options.like.clone(),
        seconds: all.iter().map(Window::duration).sum(),
        windows: all.len(),
        samples,
        contradictions,
        reversed_inputs: input_signs::reversed_inputs(&problem, &all, &vehicle.parts().inputs),
        agreements: kinematics::agreements(&data.runs, &channels),
        saturated: kinematics::saturated(&data.runs, &vehicle.parts().inputs),
        ranges: ranges(&data.runs, &channels),
        held_out: judged.held_out,
        predictions: judged.predictions,
        trajectories: judged.trajectories,
        resets,
        delays,
        noise: noise.collect(),
        sought: problem.sought.clone(),
        file: file.clone(),
        correlated: correlated(&numbers, &covariance),
        numbers,
        current,
        biases,
        undetermined,
        next,
        data,
    })
}

/// The range of each signal.
fn ranges(runs: &[Run], channels: &[usize]) -> Vec<(&'static str, f64)> {
    let range = |(place, channel): (usize, &usize)| {
        let values = runs.iter().flat_map(|it| &it.outputs[place].values);
        let least = values.clone().copied().fold(f64::INFINITY, f64::min);
        let largest = values.copied().fold(f64::NEG_INFINITY, f64::max);
        (SIGNALS[*channel].0, largest - least)
    };
    channels.iter().enumerate().map(range).collect()
}

/// The performance of a vehicle on held-out data.
#[derive(Default)]
struct Judged {
    held_out: Option<HeldOut>,
    predictions: Vec<Prediction>,
    trajectories: Vec<Trajectory>,
}

/// A fitted vehicle on the validation data, or on the rest of the data by a fit of its first part.
fn judged(
    problem: &Problem<'_>,
    cutter: &Cutter<'_>,
    (all, globals): (&[Window], &[f64]),
    validation: &[Run],
    options: &SixDofOptions,
) -> Judged {
    if validation.is_empty() {
        let first = cutter.windows(options.horizon, 0.0..FITTED);
        let rest = cutter.windows(options.horizon, FITTED..1.0);
        let Some((held, of_first)) = held_out(problem, (&first, &rest), globals) else {
            return Judged::default();
        };
        let windows = |horizon| cutter.overlapping(horizon, FITTED..1.0);
        let (predictions, trajectories) =
            predictions(problem, &of_first, &first, (options.predict, &windows));
        return Judged {
            held_out: Some(held),
            predictions,
            trajectories,
        };
    }
    let resets = kinematics::resets(validation, cutter.channels);
    let of = cutter.of_other_runs(validation, &resets);
    let rest = of.windows(options.horizon, 0.0..1.0);
    let windows = |horizon| of.overlapping(horizon, 0.0..1.0);
    let (predictions, trajectories) =
        predictions(problem, globals, all, (options.predict, &windows));
    Judged {
        held_out: compared(problem, globals, &globals[problem.sought.len()..], &rest),
        predictions,
        trajectories,
    }
}

/// The numbers, the current, the biases, and the delays, each with its interval.
type AllEstimated = (
    Vec<Estimated>,
    Vec<Estimated>,
    Vec<Estimated>,
    Vec<Estimated>,
);

fn estimated(problem: &Problem<'_>, globals: &[f64], covariance: &DMatrix<f64>) -> AllEstimated {
    let estimated = |k: usize, name: &str, like: f64| {
        // A number is sought relative to itself, all else in its unit.
        let (value, unit) = match k < problem.sought.len() {
            true => (problem.value(k, globals), problem.unit(k)),
            false => (globals[k], 1.0),
        };
        Estimated {
            name: name.to_owned(),
            value,
            interval: SIGMAS_95 * deviation(covariance, k) * unit.abs(),
            like,
            size: match k < problem.sought.len() {
                true => problem.least_size(k),
                false => 0.0,
            },
        }
    };
    let of_file = problem.sought.iter().map(|it| &problem.file.numbers()[*it]);
    let numbers = of_file
        .enumerate()
        .map(|(k, it)| estimated(k, &it.name, it.value));
    let numbers: Vec<Estimated> = numbers.collect();
    let others = problem.biased.iter().map(|it| SIGNALS[*it].0);
    let others = ["north", "east"].into_iter().chain(others).enumerate();
    let mut current: Vec<Estimated> = others
        .map(|(k, name)| estimated(numbers.len() + k, name, 0.0))
        .collect();
    let biases = current.split_off(2);
    let delays = problem.of_delays().map(|k| estimated(k, "all", 0.0));
    let delays = delays.collect();
    (numbers, current, biases, delays)
}

fn deviation(covariance: &DMatrix<f64>, k: usize) -> f64 {
    covariance[(k, k)].max(0.0).sqrt()
}

/// Pairs of numbers whose correlation exceeds [`CORRELATED`], with the correlation.
fn correlated(numbers: &[Estimated], covariance: &DMatrix<f64>) -> Vec<(String, String, f64)> {
    let mut pairs = Vec::new();
    for i in 0..numbers.len() {
        for j in 0..i {
            let deviations = deviation(covariance, i) * deviation(covariance, j);
            let of = covariance[(i, j)] / deviations;
            if of.abs() > CORRELATED {
                pairs.push((numbers[j].name.clone(), numbers[i].name.clone(), of));
            }
        }
    }
    pairs
}

fn samples(of: &[Window]) -> usize {
    of.iter().map(|it| it.samples.len()).sum()
}

/// The number of globals and initial states.
fn unknown(problem: &Problem<'_>, windows: &[Window]) -> usize {
    problem.globals() + 12 * windows.len()
}

/// Errors on the rest of the data, with numbers fitted to the first seven tenths and with those of the initial vehicle, and the globals of that
/// fit; for both, current and biases are fitted to the first part.
fn held_out(
    problem: &Problem<'_>,
    (first, rest): (&[Window], &[Window]),
    found: &[f64],
) -> Option<(HeldOut, Vec<f64>)> {
    if rest.is_empty() || samples(first) <= 2 * unknown(problem, first) {
        return None;
    }
    let of_first = |sought: &[usize], start: &[f64]| {
        let of = Problem {
            sought: sought.to_vec(),
            ..problem.clone()
        };
        let theta = of.minimised(first, start)?;
        Some(theta.as_slice()[..of.globals()].to_vec())
    };
    let fitted = of_first(&problem.sought, found)?;
    let like = of_first(&[], &found[problem.sought.len()..])?;
    Some((compared(problem, &fitted, &like, rest)?, fitted))
}

/// Errors on data by a fitted vehicle with these globals, and by the initial one with its own; initial states are fitted for both.
fn compared(
    problem: &Problem<'_>,
    fitted: &[f64],
    like: &[f64],
    rest: &[Window],
) -> Option<HeldOut> {
    let left = |sought: &[usize], globals: &[f64]| {
        let of = Problem {
            sought: sought.to_vec(),
            is_known: true,
            ..problem.clone()
        };
        let theta = of.minimised(rest, globals)?;
        of.left(rest, &theta)
    };
    let (fitted, like) = (left(&problem.sought, fitted)?, left(&[], like)?);
    let signals = SIGNALS.iter().zip(fitted.into_iter().zip(like));
    Some(HeldOut {
        seconds: rest.iter().map(Window::duration).sum(),
        // With the recorded pose at the beginning nothing is left of its first sample.
        signals: signals
            .skip(match problem.cost {
                Cost::Velocities => VELOCITIES,
                Cost::All => 0,
            })
            .filter_map(|(it, (fitted, like))| Some((it.0, fitted?, like?)))
            .collect(),
    })
}
