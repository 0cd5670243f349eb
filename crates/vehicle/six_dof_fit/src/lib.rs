//! Fits a vehicle of six degrees of freedom to a recording: coefficients with intervals, undetermined numbers, the next run.

mod error;
mod experiments;
mod kinematics;
mod problem;
mod recording;

use std::fmt;
use std::ops::Range;

use nalgebra::DMatrix;
use planesman_equations::Run;
use planesman_fit::{FitOptions, StampedRuns};
use planesman_identification::SIGMAS_95;
use planesman_identification::analysis::Standing;
use planesman_linear::digits::significant;
use planesman_parallel::Progress;
use planesman_vehicle::six_dof::EditableFile;
use serde::Serialize;

pub use error::SixDofError;
use experiments::experiments;
use problem::{Problem, Window};

pub use experiments::{Expected, NextRun};
pub use kinematics::Contradiction;
pub use problem::SIGNALS;

/// The share of a recording that is fitted if the rest is used for validation.
const FITTED: f64 = 0.7;
/// Correlations above this are reported.
const CORRELATED: f64 = 0.95;
/// Maximum number of windows.
const WINDOWS: f64 = 60.0;

/// The options of [`fit_six_dof`].
#[derive(Clone, Debug)]
pub struct SixDofOptions {
    /// The recording, with the windows used and the definition of a gap.
    pub data: FitOptions,
    /// `NAME=SIGNAL`, where the name is that of an input of the vehicle or one of [`SIGNALS`].
    pub signals: Vec<String>,
    /// The initial vehicle: a built-in one or a file.
    pub like: String,
    /// Inputs of the vehicle that are not recorded and assumed to be 0.
    pub zero: Vec<String>,
    /// Numbers or groups that are not changed.
    pub fixed: Vec<String>,
    /// Numbers or groups to estimate; empty for all except `body`.
    pub free: Vec<String>,
    /// The relative prior standard deviation of each number.
    pub prior: f64,
    /// A number is determined if half of its 95 % interval is at most this share of its value.
    pub bound: f64,
    /// Signals with a constant error to be estimated.
    pub bias: Vec<String>,
    /// The longest time that the motion is simulated from one initial state \[s\].
    pub horizon: f64,
}

impl Default for SixDofOptions {
    fn default() -> Self {
        Self {
            data: FitOptions::default(),
            signals: Vec::new(),
            like: String::new(),
            zero: Vec::new(),
            fixed: Vec::new(),
            free: Vec::new(),
            prior: 0.5,
            bound: 0.5,
            bias: ["u", "v", "w", "p", "q", "r"].map(str::to_owned).into(),
            horizon: 30.0,
        }
    }
}

/// A value with half its 95 % interval.
#[derive(Clone, Debug, Serialize)]
pub struct Estimated {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Half of its 95 % interval.
    pub interval: f64,
    /// The number's value in the initial vehicle; 0 for a bias and a current.
    pub like: f64,
}

impl Estimated {
    /// Half the interval relative to the value.
    #[must_use]
    pub fn relative(&self) -> f64 {
        self.interval / self.value.abs()
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
    /// The noise of each signal: a standard deviation.
    pub noise: Vec<(&'static str, f64)>,
    /// Pairs of numbers that can hardly be separated, with their correlation.
    pub correlated: Vec<(String, String, f64)>,
    /// Poses that contradict the recorded velocities.
    pub contradictions: Vec<Contradiction>,
    /// `None` if one of the vehicles diverges there, or too little data is left.
    pub held_out: Option<HeldOut>,
    /// The numbers that the data does not determine.
    pub undetermined: Vec<Expected>,
    /// The run that minimises the largest interval.
    pub next: Option<NextRun>,
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
/// Errors below this share of a signal's range are no worse.
const SMALL: f64 = 1e-3;

/// The verdict on a fitted vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SixDofVerdict {
    /// The recording contradicts itself.
    Contradictory,
    /// The fitted vehicle predicts held-out data no better than the initial vehicle: the ratio of their errors.
    Worse {
        /// Errors of the fitted vehicle over the initial one's, geometric mean over the signals.
        ratio: f64,
    },
    /// No data was held out for validation.
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
            Self::Contradictory | Self::Worse { .. } => Standing::NotUsable,
            Self::NotValidated => Standing::NotValidated,
            Self::NotDetermined { .. } => Standing::UsableWithCare,
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
            Self::NotValidated => f.write_str("not validated: no data was held out"),
            Self::NotDetermined { count, of } => write!(
                f,
                "usable with care: the recording does not determine {count} of {of} numbers"
            ),
            Self::Good => f.write_str("good: every number is determined"),
        }
    }
}

impl SixDofResult {
    /// The verdict on the vehicle.
    #[must_use]
    pub fn verdict(&self) -> SixDofVerdict {
        if !self.contradictions.is_empty() {
            return SixDofVerdict::Contradictory;
        }
        let Some(held) = &self.held_out else {
            return SixDofVerdict::NotValidated;
        };
        let of = |all: &[(&str, f64)], name: &str| {
            all.iter().find(|it| it.0 == name).map_or(0.0, |it| it.1)
        };
        let is_seen = held.signals.iter().any(|(name, fitted, _)| {
            *fitted > WITHIN_NOISE * of(&self.noise, name)
                && *fitted > SMALL * of(&self.ranges, name)
        });
        let ratios = held.signals.iter().map(|it| libm::log(it.1 / it.2));
        let ratio = libm::exp(ratios.sum::<f64>() / held.signals.len().max(1) as f64);
        let count = self.undetermined.len();
        match (is_seen && ratio > WORSE, count) {
            (true, _) => SixDofVerdict::Worse { ratio },
            (_, 0) => SixDofVerdict::Good,
            _ => SixDofVerdict::NotDetermined {
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
    let (data, channels) = recording::read(
        &options.data,
        &options.signals,
        (&vehicle.parts().inputs, &options.zero),
        progress,
    )?;
    let mut biased = Vec::new();
    for name in &options.bias {
        let names = SIGNALS.iter().map(|it| it.0);
        let place = names.clone().position(|it| it == name);
        let place = place.ok_or_else(|| SixDofError::no_number("bias", name, names))?;
        biased.extend(channels.contains(&place).then_some(place));
    }
    let cut = |share| windows(&data.runs, &channels, options.horizon, share);
    let all = cut(0.0..1.0);
    let samples = samples(&all);
    let mut problem = Problem {
        file: &file,
        sought,
        prior: options.prior,
        biased,
        noise: [1.0; 12],
        is_known: false,
    };
    let unknown = unknown(&problem, &all);
    if samples <= 2 * unknown {
        return Err(SixDofError::FewSamples { samples, unknown });
    }
    progress.begin("models", 0, 0);
    let found = problem.weighed(&all);
    let found = found.and_then(|it| Some((problem.covariance(&all, &it)?, it)));
    progress.end();
    let ((covariance, information), theta) =
        found.ok_or_else(|| SixDofError::Diverges(options.like.clone()))?;
    let globals = &theta.as_slice()[..problem.globals()];
    let (numbers, current, biases) = estimated(&problem, globals, &covariance);
    let relative: Vec<f64> = numbers.iter().map(Estimated::relative).collect();
    let (undetermined, next) = experiments(
        &problem,
        globals,
        &information,
        (&data.runs, &channels),
        (&relative, options.bound),
    )
    .unwrap_or_default();
    let noise = channels
        .iter()
        .map(|it| (SIGNALS[*it].0, problem.noise[*it]));
    Ok(SixDofResult {
        like: options.like.clone(),
        seconds: all.iter().map(Window::duration).sum(),
        windows: all.len(),
        samples,
        contradictions: kinematics::contradictions(&data.runs, &channels),
        ranges: (channels.iter().enumerate())
            .map(|(place, channel)| {
                let values = data.runs.iter().flat_map(|it| &it.outputs[place].values);
                let least = values.clone().copied().fold(f64::INFINITY, f64::min);
                let largest = values.copied().fold(f64::NEG_INFINITY, f64::max);
                (SIGNALS[*channel].0, largest - least)
            })
            .collect(),
        held_out: held_out(&problem, (&cut(0.0..FITTED), &cut(FITTED..1.0)), globals),
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

/// The numbers, the current and the biases, each with its interval.
fn estimated(
    problem: &Problem<'_>,
    globals: &[f64],
    covariance: &DMatrix<f64>,
) -> (Vec<Estimated>, Vec<Estimated>, Vec<Estimated>) {
    let estimated = |k: usize, name: &str, like: f64| {
        // A number is sought relative to itself, all else in its unit.
        let scale = if k < problem.sought.len() { like } else { 1.0 };
        Estimated {
            name: name.to_owned(),
            value: globals[k] * scale,
            interval: SIGMAS_95 * deviation(covariance, k) * scale.abs(),
            like,
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
    (numbers, current, biases)
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

impl SixDofOptions {
    /// The indices of the numbers to estimate.
    fn sought(&self, file: &EditableFile) -> Result<Vec<usize>, SixDofError> {
        let names = || file.numbers().iter().map(|it| it.name.as_str());
        let named = |option, words: &[String]| {
            let each = words.iter().map(|word| {
                let found = file.named(word);
                found.ok_or_else(|| SixDofError::no_number(option, word, names()))
            });
            Ok::<_, SixDofError>(each.collect::<Result<Vec<_>, _>>()?.concat())
        };
        let (free, fixed) = (named("free", &self.free)?, named("fixed", &self.fixed)?);
        let is_sought = |place: &usize| match self.free.is_empty() {
            true => file.numbers()[*place].group != "body" && !fixed.contains(place),
            false => free.contains(place) && !fixed.contains(place),
        };
        let sought: Vec<usize> = (0..file.numbers().len()).filter(is_sought).collect();
        match sought.is_empty() {
            true => Err(SixDofError::NothingSought),
            false => Ok(sought),
        }
    }
}

/// The windows of a share of each run.
fn windows(runs: &[Run], channels: &[usize], longest: f64, share: Range<f64>) -> Vec<Window> {
    let total: f64 = runs.iter().map(Run::end).sum();
    let longest = longest.max(total / WINDOWS);
    let of = |run: &Run| {
        let (from, to) = (share.start * run.end(), share.end * run.end());
        let count = ((to - from) / longest - 1e-9).ceil().max(1.0) as usize;
        let edge = |k: usize| from + (to - from) * k as f64 / count as f64;
        let parts = (0..count).filter_map(|k| {
            // The last sample of all is in the last window.
            let is_last = k + 1 == count && share.end == 1.0;
            let until = if is_last { f64::INFINITY } else { edge(k + 1) };
            Window::of(run, channels, edge(k)..until)
        });
        parts.collect::<Vec<_>>()
    };
    runs.iter().flat_map(of).collect()
}

/// Errors on the rest of the data: with numbers fitted to the first 70 %, and with the numbers of the initial vehicle. In both cases, current and
/// biases are fitted to the first part.
fn held_out(
    problem: &Problem<'_>,
    (first, rest): (&[Window], &[Window]),
    found: &[f64],
) -> Option<HeldOut> {
    if rest.is_empty() || samples(first) <= 2 * unknown(problem, first) {
        return None;
    }
    let left = |sought: &[usize], start: &[f64]| {
        let mut of = Problem {
            sought: sought.to_vec(),
            ..problem.clone()
        };
        let theta = of.minimised(first, start)?;
        of.is_known = true;
        let theta = of.minimised(rest, &theta.as_slice()[..of.globals()])?;
        of.left(rest, &theta)
    };
    let fitted = left(&problem.sought, found)?;
    let like = left(&[], &found[problem.sought.len()..])?;
    let signals = SIGNALS.iter().zip(fitted.into_iter().zip(like));
    Some(HeldOut {
        seconds: rest.iter().map(Window::duration).sum(),
        signals: signals
            .filter_map(|(it, (fitted, like))| Some((it.0, fitted?, like?)))
            .collect(),
    })
}
