//! One pair of signals: sorts its samples, updates the estimate, and counts.
//!
//! - **A gap** in the stamps restarts the history and keeps the estimate.
//! - **Time going back** (a vehicle that is reset, a bag that loops, a restarted peer) restarts everything, and is counted; a frozen model
//!   is kept, only its history restarts.
//! - **A jump of the parameters** detected by the estimator is counted, and its estimate is published at once.
//! - **An output whose message marks the earlier input as invalid** (`break_on`: the planes were held, the actuator had not answered) is
//!   not learnt from.

use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::sync::Arc;

use planesman_identification::{Input, Model};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_parameters::{Parameters as _, file};
use planesman_signals::{Aligner, GridSample, LiveGrid, Offer, WINDOW};

use crate::error::Error;
use crate::learner::Learner;
use crate::parameters::{self, Config, IdentifierParameters};
use crate::reader::Sample;

/// The name of the pair given by the parameters `input` and `output`.
pub const FIRST: &str = "model";

/// Maximum number of scheduled changes.
const MOST_CHANGES: usize = 10_000;

/// A user's change to an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Forget everything.
    Reset,
    /// Keep the estimate unchanged, or resume.
    Freeze(bool),
}

/// A change to be made after a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scheduled {
    /// Number of times that time had gone back.
    pub restarts: u32,
    /// The stamp of the sample before the change, ns.
    pub stamp: i64,
    /// The change.
    pub change: Change,
}

/// Counts of a pair's messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Account {
    /// Number of gaps.
    pub gaps: u64,
    /// Number of times that time went back, each a restart of the estimate.
    pub restarts: u32,
    /// Number of detected parameter jumps.
    pub jumps: u64,
    /// Messages that were repeated, late, or off the grid.
    pub left_out: u64,
    /// Messages without a finite number for the signal.
    pub refused: u64,
}

/// A jump of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jump {
    /// The stamp of the sample that showed it, ns.
    pub stamp: i64,
    /// The estimate is based on the samples since this stamp, ns.
    pub since: i64,
}

impl fmt::Display for Jump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |stamp: i64| stamp as f64 * 1e-9;
        write!(
            f,
            "the plant has changed: detected at {:.3} s, so the estimate uses only the samples since {:.3} s",
            seconds(self.stamp),
            seconds(self.since)
        )
    }
}

/// A pair of signals and the model between them.
#[derive(Clone, Debug)]
pub struct Pair {
    name: Arc<str>,
    config: Arc<Config>,
    /// The grid to which the signals are resampled first, if requested.
    grid: Option<LiveGrid>,
    aligner: Aligner,
    learner: Learner,
    /// The first sample's stamp, ns.
    began: Option<i64>,
    /// The last sample's stamp, ns.
    last: i64,
    /// Stamps of outputs not yet learnt whose input is invalid, ns.
    broken: BTreeSet<i64>,
    account: Account,
    /// The last jump.
    jump: Option<Jump>,
    /// Future changes, in the order of time.
    changes: VecDeque<Scheduled>,
}

/// An estimate due for publication, built when it is read.
#[derive(Clone, Debug)]
pub struct DueEstimate {
    name: Arc<str>,
    config: Arc<Config>,
    learner: Learner,
    restarts: u32,
    stamp: i64,
}

impl DueEstimate {
    /// The pair's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The estimate, if all its numbers are finite: others never leave the node.
    #[must_use]
    pub fn estimate(&self) -> Option<ModelEstimate> {
        let estimate = self.as_it_is();
        let finite = planesman_msgs::Message::first_non_finite(&estimate).is_none();
        finite.then_some(estimate)
    }

    fn as_it_is(&self) -> ModelEstimate {
        let Config { input, output, .. } = &*self.config;
        let mut estimate = self.learner.estimate(&self.config);
        estimate.header.stamp = Time::from_nanos(self.stamp);
        estimate.name = self.name.to_string();
        estimate.input = input.to_string();
        estimate.output = output.to_string();
        estimate.restarts = self.restarts;
        estimate
    }
}

/// The estimates themselves.
pub(crate) fn made(due: &[DueEstimate]) -> Vec<ModelEstimate> {
    due.iter().filter_map(DueEstimate::estimate).collect()
}

/// The pairs that the parameters describe, by name, each with its own parameters.
///
/// # Errors
/// [`Error::Entry`], if an entry of `pairs` is malformed, two have the same name, or one would change a parameter of the whole node.
pub fn described(
    parameters: &IdentifierParameters,
) -> Result<Vec<(String, IdentifierParameters)>, Error> {
    let mut all = vec![(FIRST.to_owned(), parameters.clone())];
    for text in &parameters.pairs {
        let refuse = |reason: &str| Error::Entry {
            text: text.clone(),
            reason: reason.to_owned(),
        };
        let (name, rest) = text
            .split_once(": ")
            .ok_or_else(|| refuse("it has no name"))?;
        let (input, rest) = rest
            .split_once(" -> ")
            .ok_or_else(|| refuse("it has no '->'"))?;
        let mut parts = rest.split_whitespace();
        let output = parts.next().ok_or_else(|| refuse("it has no output"))?;
        let name = name.trim();
        if name.is_empty() || name.contains(char::is_whitespace) {
            return Err(refuse("its name contains a space"));
        }
        if all.iter().any(|(other, _)| other == name) {
            return Err(refuse("another pair has that name"));
        }
        let mut changes = vec![("input", input.trim().into()), ("output", output.into())];
        for part in parts {
            let (parameter, value) = part
                .split_once('=')
                .ok_or_else(|| refuse(&format!("'{part}' is not PARAMETER=VALUE")))?;
            if parameters::OF_THE_NODE.contains(&parameter) {
                return Err(refuse(&format!(
                    "'{parameter}' belongs to the node, not to a pair"
                )));
            }
            let value = file::parse_value(parameter, value).map_err(|e| refuse(&e.to_string()))?;
            changes.push((parameter, value));
        }
        let own = parameters
            .with(&changes)
            .map_err(|e| refuse(&e.to_string()))?;
        all.push((name.to_owned(), own));
    }
    Ok(all)
}

impl Pair {
    /// A pair before its first message.
    ///
    /// # Errors
    /// If a parameter is rejected.
    pub fn new(name: String, parameters: &IdentifierParameters) -> Result<Self, Error> {
        let of_pair = |reason: Error| match name.as_str() {
            FIRST => reason,
            name => Error::Pair {
                name: name.to_owned(),
                reason: Box::new(reason),
            },
        };
        let config = Config::new(parameters).map_err(of_pair)?;
        Ok(Self {
            grid: config
                .resample
                .map(|max_gap| LiveGrid::new(period(&config), max_gap)),
            aligner: Aligner::new(period(&config)),
            learner: Learner::new(&config).map_err(|e| of_pair(e.into()))?,
            name: name.into(),
            config: Arc::new(config),
            began: None,
            last: 0,
            broken: BTreeSet::new(),
            account: Account::default(),
            jump: None,
            changes: VecDeque::new(),
        })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The current parameters.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The counts of its messages.
    #[must_use]
    pub fn account(&self) -> Account {
        self.account
    }

    /// The last jump of the parameters.
    #[must_use]
    pub fn jump(&self) -> Option<Jump> {
        self.jump
    }

    /// Whether learning is stopped.
    #[must_use]
    pub fn frozen(&self) -> bool {
        self.learner.frozen()
    }

    /// Applies a changed configuration: without a restart if possible, otherwise the estimate restarts.
    ///
    /// # Errors
    /// If the estimator refuses it; then nothing changes.
    pub(crate) fn set_config(&mut self, new: Config) -> Result<(), Error> {
        if self.config.retuned(&new) == new {
            self.learner.retune(&new)?;
        } else if *self.config != new {
            let mut learner = Learner::new(&new)?;
            learner.set_frozen(self.frozen());
            self.learner = learner;
            self.began = None;
        }
        self.config = Arc::new(new);
        Ok(())
    }

    /// Processes a message's values for one of the signals, with its stamp; returns the estimates due for publication. Repeats change
    /// nothing.
    pub fn on_sample(&mut self, stamp: Time, sample: &Sample) -> Vec<ModelEstimate> {
        made(&self.take(stamp, sample))
    }

    /// Like [`Pair::on_sample`], without building the estimates.
    pub(crate) fn take(&mut self, stamp: Time, sample: &Sample) -> Vec<DueEstimate> {
        let stamp = stamp.nanos();
        if let Some(grid) = &mut self.grid {
            let input = sample.input.map(|it| grid.input(stamp, it.mean));
            let output = sample
                .output
                .map(|it| grid.output(stamp, it, sample.breaks));
            for given in [input, output].into_iter().flatten() {
                match given {
                    Some(given) => self.offer(given),
                    None => self.account.left_out += 1,
                }
            }
            return self.learn();
        }
        if let Some(output) = sample.output {
            self.offer_output(stamp, output);
        }
        if sample.breaks {
            self.broken.insert(stamp);
            if self.broken.len() > 2 * WINDOW as usize {
                self.broken.pop_first();
            }
        }
        if let Some(input) = sample.input {
            self.offer_input(stamp, input);
        }
        self.learn()
    }

    fn offer(&mut self, given: Vec<GridSample>) {
        for given in given {
            match given {
                GridSample::Output(stamp, output) => self.offer_output(stamp, output),
                GridSample::Input(stamp, input) => self.offer_input(stamp, input),
            }
        }
    }

    fn offer_output(&mut self, stamp: i64, output: f64) {
        match self.aligner.offer_output(stamp, output) {
            Offer::Accepted => {}
            Offer::LeftOut => self.account.left_out += 1,
            Offer::WentBack => self.on_time_back(),
        }
    }

    fn offer_input(&mut self, stamp: i64, input: Input) {
        if self.aligner.offer_input(stamp, input) == Offer::LeftOut {
            self.account.left_out += 1;
        }
    }

    fn on_time_back(&mut self) {
        self.account.restarts += 1;
        self.broken.clear();
        self.began = None;
        self.last = 0;
        if !self.learner.frozen() {
            self.learner.reset();
        }
    }

    /// Counts a message without the signal.
    pub(crate) fn refuse(&mut self) {
        self.account.refused += 1;
    }

    /// Ends the data: delayed samples are processed. Returns the estimates due.
    pub fn finish(&mut self) -> Vec<ModelEstimate> {
        let rest = self.grid.as_mut().map(LiveGrid::finish);
        self.offer(rest.unwrap_or_default());
        self.aligner.finish();
        let mut due = self.learn();
        while let Some(scheduled) = self.changes.pop_front() {
            due.extend(self.take_change(scheduled.change));
        }
        made(&due)
    }

    /// Changes the learnt state, between two samples. Returns an estimate that shows the change; `None` if nothing has changed.
    pub fn change(&mut self, change: Change) -> Option<ModelEstimate> {
        self.take_change(change)?.estimate()
    }

    fn take_change(&mut self, change: Change) -> Option<DueEstimate> {
        match change {
            Change::Reset => {
                self.learner.reset();
                self.began = None;
            }
            Change::Freeze(frozen) if frozen == self.learner.frozen() => return None,
            Change::Freeze(frozen) => self.learner.set_frozen(frozen),
        }
        Some(self.due(self.last))
    }

    /// Schedules a change, to reproduce an earlier one.
    pub fn schedule(&mut self, scheduled: Scheduled) {
        if self.changes.len() < MOST_CHANGES {
            self.changes.push_back(scheduled);
        }
    }

    /// The latest output stamp for which all data of its lockstep tick has arrived: the input over the interval before the output, unless the output
    /// at the beginning of that interval is missing.
    #[must_use]
    pub fn answered(&self) -> Option<Time> {
        self.aligner.answered().map(Time::from_nanos)
    }

    /// The reason why nothing is learnt although messages come: a signal has stopped, or the two never have a common instant.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        let Config { input, output, .. } = &*self.config;
        if self.aligner.inputs_are_off_grid() {
            return Some(format!(
                "{input} has no sample with the stamp of {output}: the stamps must be whole sample_times apart; otherwise set resample"
            ));
        }
        let lead = self.aligner.outputs_ahead();
        let (silent, lead) = if lead > WINDOW {
            (input, lead)
        } else if lead < -WINDOW {
            (output, -lead)
        } else {
            return None;
        };
        let seconds = lead as f64 * self.config.sample_time;
        Some(format!("no messages of {silent} for {seconds:.1} s"))
    }

    /// The current estimate, with this stamp.
    #[must_use]
    pub fn estimate(&self, stamp: Time) -> ModelEstimate {
        self.due(stamp.nanos()).as_it_is()
    }

    /// The current model.
    #[must_use]
    pub fn model(&self) -> Model {
        self.learner.model(&self.config)
    }

    /// The current estimate, with this stamp.
    fn due(&self, stamp: i64) -> DueEstimate {
        DueEstimate {
            name: Arc::clone(&self.name),
            config: Arc::clone(&self.config),
            learner: self.learner.clone(),
            restarts: self.account.restarts,
            stamp,
        }
    }

    fn learn(&mut self) -> Vec<DueEstimate> {
        let mut due = Vec::new();
        while let Some(sample) = self.aligner.take() {
            let restarts = self.account.restarts;
            while let Some(next) = self.changes.pop_front_if(|next| {
                next.restarts < restarts || (next.restarts == restarts && next.stamp < sample.stamp)
            }) {
                due.extend(self.take_change(next.change));
            }
            self.last = sample.stamp;
            let began = *self.began.get_or_insert(sample.stamp);
            if sample.stamp - began < self.config.start || self.broken.remove(&sample.stamp) {
                self.learner.begin(sample.output);
                continue;
            }
            if sample.input.is_none() && sample.stamp > began {
                self.account.gaps += 1;
            }
            let is_predicted = self.learner.take(sample);
            let jump = self.learner.jump();
            if let Some(rows) = jump {
                self.account.jumps += 1;
                self.jump = Some(Jump {
                    stamp: sample.stamp,
                    since: sample.stamp - rows as i64 * period(&self.config),
                });
            }
            let every = self.config.publish_every;
            let is_due = jump.is_some() || self.learner.predicted().is_multiple_of(every);
            if is_predicted && is_due {
                due.push(self.due(sample.stamp));
            }
        }
        due
    }
}

fn period(config: &Config) -> i64 {
    (config.sample_time * 1e9).round() as i64
}
