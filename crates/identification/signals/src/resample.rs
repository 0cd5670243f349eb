//! Resampling of signals with different stamps to one uniform grid: a [`Record`].
//!
//! Signals are processed as they come, roughly in the order of stamps ([`ORDER`] samples are delayed for sorting). The memory grows with
//! the record, not with the data.
//!
//! - **The grid** begins at the first output's first sample, so that data on a grid is not changed. The grid interval is the requested one, or the
//!   median interval of the slowest output among the first [`PRELUDE`] samples (for bursts the mean). If it is within half a per cent of a whole
//!   number of hertz or milliseconds, this rounded interval is used, unless the stamps fit another grid.
//! - **The methods** are explained at [`Method`]. An input acts over the interval that begins at a grid instant; the last sample before a gap is held
//!   to the end of its interval.
//! - **A gap** of an output is an interval longer than `max_gap`, by default five median intervals of that signal or two and a half of the
//!   grid, whichever is longer. A gap is not interpolated: the record's segment ends, and another begins.
//! - **A pause** of a held input (methods mean and hold) is not a gap: a setpoint that is sent only when it changes is known until it
//!   changes. Each sample acts until the next, the last one until the outputs end; [`Channel::held`] is the longest such time. An explicit
//!   `max_gap` makes such pauses gaps too.

use planesman_text::option;
use std::collections::VecDeque;
use std::ops::RangeInclusive;

use planesman_record::{LONGEST_PAST, Record, Segment};
use thiserror::Error;

use crate::channel::{Channel, Method};
use crate::gridder::{Grid, Gridder, Onto, Put};
use crate::mixture::Mixtures;
use crate::sieve::DuplicateFilter;
use crate::signal::LARGEST;
use crate::timing::Meter;
use crate::unwrap::Unwrap;

/// Number of samples of a signal delayed for sorting.
pub const ORDER: usize = 64;

/// Number of samples of each output from which the grid is determined.
pub const PRELUDE: usize = 1000;

/// Maximum number of samples stored until the grid is determined.
const LONGEST_PRELUDE: usize = 500_000;

/// Maximum number of values in a record: 96 MB.
pub const MAX_NUMBERS: usize = 12_000_000;

/// The memory of a run in addition to its values, expressed in values.
const RUN: usize = 10;

/// Stamps beyond this, ns (146 years from the epoch), count as late, so that differences fit 64 bits.
const FARTHEST: i64 = 1 << 62;

/// Reasons why samples do not form a record.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// No signal is requested.
    #[error("no signal is given")]
    NoSignal,
    /// No window is requested.
    #[error("no window is given")]
    NoWindow,
    /// The record would be too long.
    #[error(
        "with an interval of {interval} s the record would have more than {MAX_NUMBERS} numbers. Use a lower {}, or shorten the record with {}",
        option("rate"),
        option("window")
    )]
    TooLong {
        /// The interval between instants, s.
        interval: f64,
    },
    /// A signal has no sample.
    #[error("{signal}: the signal has no sample{reasons}")]
    NoSample {
        /// The signal.
        signal: String,
        /// The counts of samples left out, each after a semicolon.
        reasons: String,
    },
    /// The signals have no common time.
    #[error("at no time{within} are all signals known: {spans}")]
    NoCommonInstant {
        /// The requested window as text; empty without a window.
        within: String,
        /// The time span of each signal.
        spans: String,
    },
}

/// Options of the gridding.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Grid rate, Hz; `None` for the rate of the slowest output.
    pub rate: Option<f64>,
    /// The time window, in seconds from the first output's first sample.
    pub window: RangeInclusive<f64>,
    /// Resampling of inputs.
    pub input_method: Method,
    /// Resampling of outputs.
    pub output_method: Method,
    /// The longest interval that is not a gap, s; `None` for the default, which is unlimited for a held input.
    pub max_gap: Option<f64>,
    /// Treatment of angles and counters that wrap.
    pub unwrap: Unwrap,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            rate: None,
            window: f64::NEG_INFINITY..=f64::INFINITY,
            input_method: Method::Mean,
            output_method: Method::Linear,
            max_gap: None,
            unwrap: Unwrap::Automatic,
        }
    }
}

/// A record, and how each of its signals was resampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    /// The numbers.
    pub record: Record,
    /// The channel of each input.
    pub inputs: Vec<Channel>,
    /// The channel of each output.
    pub outputs: Vec<Channel>,
}

/// A record under construction.
#[derive(Clone, Debug)]
pub struct Resampler {
    options: Options,
    names: Vec<String>,
    inputs: usize,
    meters: Vec<Meter>,
    /// Signal and sample, until there is a grid; `None` if the time between two samples is unknown.
    prelude: Vec<(usize, Option<(i64, f64)>)>,
    /// The number of each signal's samples in the prelude.
    counts: Vec<usize>,
    running: Option<Running>,
}

#[derive(Clone, Debug)]
struct Running {
    /// The grids of inputs and outputs, with the same instants; inputs also need some before the window.
    grids: [Grid; 2],
    inputs: usize,
    tracks: Vec<Track>,
}

impl Resampler {
    /// A record of the named inputs and outputs, before the first sample. Signals are numbered consecutively: inputs, then outputs.
    #[must_use]
    pub fn new(inputs: &[String], outputs: &[String], options: Options) -> Self {
        let names: Vec<String> = inputs.iter().chain(outputs).cloned().collect();
        Self {
            options,
            inputs: inputs.len(),
            meters: vec![Meter::default(); names.len()],
            counts: vec![0; names.len()],
            names,
            prelude: Vec::new(),
            running: None,
        }
    }

    /// Takes a sample of a signal; `None` for a message without the value. Returns whether there is room for more.
    pub fn take(&mut self, signal: usize, stamp: i64, value: Option<f64>) -> bool {
        let Some(meter) = self.meters.get_mut(signal) else {
            return true;
        };
        match value {
            None => meter.absent(),
            Some(value) if value.is_nan() || value.abs() > LARGEST => meter.not_finite(),
            Some(_) if stamp.saturating_abs() >= FARTHEST => meter.late(),
            Some(value) => match &mut self.running {
                Some(running) => running.take(signal, Some((stamp, value)), meter),
                None => {
                    self.prelude.push((signal, Some((stamp, value))));
                    self.counts[signal] += 1;
                    let outputs = &self.counts[self.inputs..];
                    let is_known = outputs.iter().all(|count| *count >= PRELUDE);
                    if is_known || self.prelude.len() >= LONGEST_PRELUDE {
                        self.run();
                    }
                }
            },
        }
        let full = self.running.as_ref().is_some_and(Running::is_full);
        !full
    }

    /// The signal is unknown between the last sample and the next.
    pub(crate) fn begin_anew(&mut self, signal: usize) {
        match &mut self.running {
            None => self.prelude.push((signal, None)),
            Some(running) => running.take(signal, None, &mut self.meters[signal]),
        }
    }

    /// Determines the grid and resamples the samples so far.
    fn run(&mut self) {
        let prelude = std::mem::take(&mut self.prelude);
        let mut samples = vec![Vec::new(); self.names.len()];
        for (signal, sample) in &prelude {
            samples[*signal].extend(*sample);
        }
        let mut intervals = Vec::new();
        let mut sieves = Vec::new();
        for (signal, samples) in samples.iter_mut().enumerate() {
            let sieve = DuplicateFilter::find(samples, signal >= self.inputs, self.options.unwrap);
            intervals.push(sieve.interval);
            sieves.push(sieve);
        }
        let slowest = |signals: &[f64]| signals.iter().copied().fold(0.0, f64::max);
        let steps: Vec<f64> = sieves.iter().map(|it| it.step).collect();
        let step = match (self.options.rate, slowest(&steps[self.inputs..])) {
            (Some(rate), _) => 1e9 / rate,
            // One output sample, or none among so many: the inputs must do.
            (None, 0.0) => slowest(&steps),
            (None, step) => step,
        };
        let step = if step >= 1.0 { step } else { 1e9 };
        let first = |wanted: &dyn Fn(usize) -> bool| {
            let samples = prelude.iter().filter(|it| wanted(it.0));
            let stamps = samples.filter_map(|it| it.1).map(|it| it.0);
            stamps.take(ORDER).min()
        };
        let anchor = first(&|signal| signal == self.inputs).or_else(|| first(&|_| true));
        let grid = Grid::new(anchor.unwrap_or(0), step).within(&self.options.window);
        // What an input does before the window acts in it.
        let grid_of_inputs = grid.clone().reaching_back(LONGEST_PAST as i64);
        let tracks = intervals
            .iter()
            .zip(sieves)
            .enumerate()
            .map(|(signal, (interval, sieve))| {
                let method = self.method(signal);
                let is_held = signal < self.inputs && matches!(method, Method::Mean | Method::Hold);
                let usual = (5.0 * interval).max(2.5 * step) as i64;
                Track {
                    is_held: matches!(method, Method::Mean | Method::Hold),
                    long: usual.min((100.0 * step) as i64),
                    max_gap: match self.options.max_gap {
                        Some(seconds) => Some((seconds * 1e9) as i64),
                        None if is_held => None,
                        None => Some(usual),
                    },
                    longest_hold: 0,
                    mixtures: Mixtures::default(),
                    sieve,
                    pending: VecDeque::new(),
                    last: None,
                    gridder: Gridder::new(method),
                    runs: Runs {
                        are_free: self.options.max_gap.is_none() && is_held,
                        ..Runs::default()
                    },
                }
            })
            .collect();
        let mut running = Running {
            grids: [grid_of_inputs, grid],
            inputs: self.inputs,
            tracks,
        };
        for (signal, sample) in prelude {
            running.take(signal, sample, &mut self.meters[signal]);
        }
        self.running = Some(running);
    }

    fn method(&self, signal: usize) -> Method {
        if signal < self.inputs {
            self.options.input_method
        } else {
            self.options.output_method
        }
    }

    /// Returns the record of all samples.
    ///
    /// # Errors
    /// [`GridError`], if a signal has no sample, at no time all are known, or the record would have more than [`MAX_NUMBERS`] values.
    pub fn finish(mut self) -> Result<Resampled, GridError> {
        if self.running.is_none() {
            self.run();
        }
        let methods: Vec<Method> = (0..self.names.len()).map(|it| self.method(it)).collect();
        let Some(mut running) = self.running else {
            return Err(GridError::NoSignal);
        };
        // Outputs first: inputs that are held act as long as there are outputs.
        let mut until = i64::MIN;
        let tracks = running.tracks.iter_mut().zip(&mut self.meters);
        for (signal, (track, meter)) in tracks.enumerate().rev() {
            track.finish(
                &running.grids[usize::from(signal >= self.inputs)],
                meter,
                until,
            );
            if let (Some(run), true) = (track.runs.list.last(), signal >= self.inputs) {
                until = until.max(running.grids[1].time(run.end()));
            }
        }
        let common = common(&running.tracks);
        let instants = common.iter().map(|(from, to)| to - from);
        let instants = instants.fold(0, i64::saturating_add) as usize;
        let numbers = instants.saturating_mul(running.tracks.len());
        if running.is_full() || numbers > MAX_NUMBERS {
            return Err(GridError::TooLong {
                interval: running.grids[1].step * 1e-9,
            });
        }
        let mut channels: Vec<Channel> = self
            .names
            .into_iter()
            .zip(methods)
            .zip(self.meters.iter().zip(&running.tracks))
            .map(|((name, method), (meter, track))| Channel {
                name,
                method,
                timing: meter.timing(),
                held: track.longest_hold as f64 * 1e-9,
                changes: track.sieve.changes(),
                mixture: track.mixtures.found,
            })
            .collect();
        for channel in &channels {
            if channel.timing.samples == 0 {
                let Timed { absent, not_finite } = Timed::of(channel);
                return Err(GridError::NoSample {
                    signal: channel.name.clone(),
                    reasons: absent + &not_finite,
                });
            }
        }
        if common.is_empty() {
            return Err(no_common_instant(&channels, &self.options.window));
        }
        let inputs = running.tracks.iter().take(self.inputs);
        let known: Vec<_> = inputs.map(|it| it.runs.known()).collect();
        let segments = common
            .into_iter()
            .map(|(first, end)| {
                let mut lists: Vec<Vec<f64>> = running
                    .tracks
                    .iter()
                    .map(|track| track.runs.cut(first, end))
                    .collect();
                let inputs = running.tracks.iter().take(self.inputs);
                // As long as the outputs are: a delay is no longer.
                let longest = (end - first).min(LONGEST_PAST as i64);
                Segment {
                    source: 0,
                    start: running.grids[1].time(first),
                    past: (inputs.zip(&known))
                        .map(|(it, known)| it.runs.before(first, longest, known))
                        .collect(),
                    outputs: lists.split_off(self.inputs),
                    inputs: lists,
                }
            })
            .collect();
        let outputs = channels.split_off(self.inputs);
        let names = |channels: &[Channel]| channels.iter().map(|it| it.name.clone()).collect();
        Ok(Resampled {
            record: Record {
                sample_time: running.grids[1].step * 1e-9,
                inputs: names(&channels),
                outputs: names(&outputs),
                segments,
            },
            inputs: channels,
            outputs,
        })
    }
}

fn no_common_instant(channels: &[Channel], window: &RangeInclusive<f64>) -> GridError {
    let spans: Vec<String> = channels.iter().map(span).collect();
    let is_whole = window.start().is_infinite() && window.end().is_infinite();
    let within = if is_whole {
        String::new()
    } else {
        format!(
            " in the window {}..{} s from the first output",
            window.start(),
            window.end()
        )
    };
    GridError::NoCommonInstant {
        within,
        spans: spans.join("; "),
    }
}

/// Timing of a signal, with the reasons for missing samples.
struct Timed {
    absent: String,
    not_finite: String,
}

impl Timed {
    fn of(channel: &Channel) -> Self {
        let counted = |count: u64, what: &str| match count {
            0 => String::new(),
            count => format!("; {count} {what}"),
        };
        Self {
            absent: counted(channel.timing.absent, "messages do not have this field"),
            not_finite: counted(channel.timing.not_finite, "are not finite"),
        }
    }
}

fn span(channel: &Channel) -> String {
    let (first, last) = channel.timing.span.unwrap_or_default();
    format!(
        "{} from {:.3} to {:.3} s",
        channel.name,
        first as f64 * 1e-9,
        last as f64 * 1e-9
    )
}

impl Running {
    /// Takes a sample, or an unknown interval.
    fn take(&mut self, signal: usize, sample: Option<(i64, f64)>, meter: &mut Meter) {
        let Some(track) = self.tracks.get_mut(signal) else {
            return;
        };
        let grid = &self.grids[usize::from(signal >= self.inputs)];
        match sample {
            Some((stamp, value)) => track.take(stamp, value, grid, meter),
            None => track.begin_anew(grid, meter),
        }
    }

    fn is_full(&self) -> bool {
        let numbers = self.tracks.iter().map(|track| track.runs.numbers);
        numbers.fold(0, usize::saturating_add) > MAX_NUMBERS
    }
}

/// The state of resampling one signal. The track never fills an interval with more instants than a record can have.
#[derive(Clone, Debug)]
struct Track {
    /// Whether samples are held until the next.
    is_held: bool,
    /// Samples that act longer than this are reported, ns.
    long: i64,
    /// The longest interval that is not a gap, ns; unlimited if a sample acts until the next.
    max_gap: Option<i64>,
    /// The longest time for which a sample acted, ns; 0 if no time was long.
    longest_hold: i64,
    mixtures: Mixtures,
    sieve: DuplicateFilter,
    /// The latest samples, in order of stamp.
    pending: VecDeque<(i64, f64)>,
    /// The last sample taken from `pending`.
    last: Option<(i64, f64)>,
    gridder: Gridder,
    runs: Runs,
}

/// A signal's values on the grid.
#[derive(Clone, Debug, Default)]
struct Runs {
    list: Vec<Run>,
    /// The number of values in all runs, plus a few for each run.
    numbers: usize,
    /// Whether held values use no more of the record than the outputs do.
    are_free: bool,
}

/// Values at consecutive instants.
#[derive(Clone, Debug)]
struct Run {
    first: i64,
    values: Values,
}

#[derive(Clone, Debug)]
enum Values {
    List(Vec<f64>),
    /// One value that is repeated this many times.
    Held(f64, i64),
}

impl Run {
    fn end(&self) -> i64 {
        self.first
            + match &self.values {
                Values::List(list) => list.len() as i64,
                Values::Held(_, count) => *count,
            }
    }
}

impl Track {
    /// Resamples all pending samples.
    fn give_out_all(&mut self, grid: &Grid, meter: &mut Meter) {
        while !self.pending.is_empty() {
            self.give_out(grid, meter);
        }
    }

    /// The signal is unknown between the last sample and the next.
    fn begin_anew(&mut self, grid: &Grid, meter: &mut Meter) {
        self.give_out_all(grid, meter);
        if let Some(spreader) = &mut self.sieve.spreader {
            spreader.begin_anew();
        }
        if let Some(last) = self.last.take() {
            let put = &mut |put| self.runs.put(put, grid);
            self.gridder.end(last, &mut Onto { grid, put });
        }
    }

    fn take(&mut self, stamp: i64, value: f64, grid: &Grid, meter: &mut Meter) {
        self.mixtures.take(stamp, value);
        if let Some(samples) = self.sieve.find_lost_digits(stamp, value) {
            let first = samples.first().map_or(stamp, |it| it.0);
            self.pending.retain(|it| it.0 < first);
            for (stamp, value) in samples {
                self.put_in_order(stamp, value, grid, meter);
            }
        }
        self.put_in_order(stamp, value, grid, meter);
    }

    fn put_in_order(&mut self, stamp: i64, value: f64, grid: &Grid, meter: &mut Meter) {
        let spreader = self.sieve.spreader.as_mut();
        let stamp = spreader.map_or(stamp, |it| it.next(stamp));
        match self.last {
            Some((last, _)) if stamp < last => return meter.late(),
            Some((last, _)) if stamp == last => return meter.duplicate(),
            _ => {}
        }
        let place = self.pending.iter().rposition(|(known, _)| *known <= stamp);
        match place {
            Some(place) if self.pending[place].0 == stamp => {
                self.pending[place].1 = value;
                return meter.duplicate();
            }
            Some(place) => self.pending.insert(place + 1, (stamp, value)),
            None => self.pending.push_front((stamp, value)),
        }
        if self.pending.len() > ORDER {
            self.give_out(grid, meter);
        }
    }

    /// Resamples the earliest pending sample.
    fn give_out(&mut self, grid: &Grid, meter: &mut Meter) {
        let Some(next) = self.pending.pop_front() else {
            return;
        };
        if self
            .sieve
            .repeats
            .as_mut()
            .is_some_and(|it| it.is_one(next.1))
        {
            return;
        }
        meter.take(next.0);
        let next = (next.0, self.sieve.unwrapper.next(next.1));
        match self.last {
            Some(last) if self.max_gap.is_none_or(|most| next.0 - last.0 <= most) => {
                self.pair(last, next, grid);
            }
            before => {
                let put = &mut |put| self.runs.put(put, grid);
                let onto = &mut Onto { grid, put };
                if let Some(last) = before {
                    self.gridder.end(last, onto);
                }
                self.gridder.begin(next, onto);
            }
        }
        self.last = Some(next);
    }

    /// Resamples all pending samples; a sample without a gap after it acts until `until`.
    fn finish(&mut self, grid: &Grid, meter: &mut Meter, until: i64) {
        self.give_out_all(grid, meter);
        self.mixtures.finish();
        let Some(last) = self.last else { return };
        if self.max_gap.is_none() && until > last.0 {
            self.pair(last, (until, last.1), grid);
        } else {
            let put = &mut |put| self.runs.put(put, grid);
            self.gridder.end(last, &mut Onto { grid, put });
        }
    }

    /// Takes two samples with no gap between them.
    fn pair(&mut self, first: (i64, f64), second: (i64, f64), grid: &Grid) {
        if self.is_held {
            self.note_hold(second.0 - first.0);
        }
        let put = &mut |put| self.runs.put(put, grid);
        self.gridder
            .pair(first, second, MAX_NUMBERS + 1, &mut Onto { grid, put });
    }

    fn note_hold(&mut self, time: i64) {
        if time > self.long {
            self.longest_hold = self.longest_hold.max(time);
        }
    }
}

impl Runs {
    fn put(&mut self, put: Put, grid: &Grid) {
        match put {
            Put::One(k, input) => self.put_one(k, input.mean, grid),
            Put::Held(first, end, value) => self.put_held(first, end, value, grid),
        }
    }

    /// Sets the same value at the instants from `first` up to `end`.
    fn put_held(&mut self, first: i64, end: i64, value: f64, grid: &Grid) {
        // As many are kept as one.
        const MANY: i64 = 100;
        let done = self.list.last().map_or(i64::MIN, Run::end);
        let first = first.max(grid.first).max(done);
        let end = end.min(grid.last.saturating_add(1));
        if end.saturating_sub(first) < MANY {
            (first..end).for_each(|k| self.put_one(k, value, grid));
        } else {
            let numbers = match self.are_free {
                true => RUN,
                false => (end - first) as usize,
            };
            self.numbers = self.numbers.saturating_add(numbers);
            self.list.push(Run {
                first,
                values: Values::Held(value, end - first),
            });
        }
    }

    fn put_one(&mut self, k: i64, value: f64, grid: &Grid) {
        if !(grid.first..=grid.last).contains(&k) {
            return;
        }
        if self.list.last().is_some_and(|run| run.end() > k) {
            return;
        }
        self.numbers += 1;
        match self.list.last_mut() {
            Some(Run {
                first,
                values: Values::List(list),
            }) if *first + list.len() as i64 == k => list.push(value),
            _ => {
                self.numbers += RUN;
                self.list.push(Run {
                    first: k,
                    values: Values::List(vec![value]),
                });
            }
        }
    }

    /// The ranges in which values are known; adjacent runs are merged.
    fn known(&self) -> Vec<(i64, i64)> {
        let mut known: Vec<(i64, i64)> = Vec::new();
        for run in &self.list {
            match known.last_mut() {
                Some((_, end)) if *end == run.first => *end = run.end(),
                _ => known.push((run.first, run.end())),
            }
        }
        known
    }

    /// At most `most` values before the instant `end`, as far back as all signals are known ([`Self::known`]).
    fn before(&self, end: i64, most: i64, known: &[(i64, i64)]) -> Vec<f64> {
        let place = known.partition_point(|(first, _)| *first < end);
        let run = place.checked_sub(1).map(|it| known[it]);
        match run {
            Some((first, until)) if until >= end => self.cut(first.max(end - most), end),
            _ => Vec::new(),
        }
    }

    /// The values at the instants from `first` up to `end`, all of which are known.
    fn cut(&self, first: i64, end: i64) -> Vec<f64> {
        let mut values = Vec::new();
        let after = self.list.partition_point(|run| run.end() <= first);
        for run in &self.list[after..] {
            let (from, to) = (first.max(run.first), end.min(run.end()));
            if from >= to {
                break;
            }
            let [from, to] = [from, to].map(|k| (k - run.first) as usize);
            match &run.values {
                Values::List(list) => values.extend_from_slice(&list[from..to]),
                Values::Held(value, _) => values.resize(values.len() + to - from, *value),
            }
        }
        values
    }
}

/// The ranges of instants that every track has.
fn common(tracks: &[Track]) -> Vec<(i64, i64)> {
    let Some((first, others)) = tracks.split_first() else {
        return Vec::new();
    };
    others.iter().fold(first.runs.known(), |common, track| {
        let mut both = Vec::new();
        let mut theirs = track.runs.known().into_iter().peekable();
        for (from, to) in common {
            while let Some((first, end)) = theirs.peek().copied() {
                if first.max(from) < end.min(to) {
                    both.push((first.max(from), end.min(to)));
                }
                if end > to {
                    break;
                }
                theirs.next();
            }
        }
        both
    })
}
