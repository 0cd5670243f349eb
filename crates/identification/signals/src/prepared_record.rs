//! A record from data: named signals of one source, resampled to a common grid.

use planesman_text::{option, setting};
use std::cell::Cell;

use crate::channel::{Channel, Method, hertz};
use crate::clock::{ClockFollower, Followed};
use crate::error::{Result, SourceError};
use crate::preparation::{Preparation, Step, StepName, prepare};
use crate::request::{Reading, Request, Role};
use crate::resample::{GridError, Options, Resampled, Resampler};
use crate::source::Source;

/// A grid faster than an output by more than this factor would contain numbers that were never measured.
const MAX_RATE_FACTOR: f64 = 1.05;

/// An output this many times faster than the grid is decimated.
const DECIMATED_RATE_FACTOR: f64 = 1.9;

/// The share of samples out of order that is reported.
const LATE: f64 = 0.02;

/// One source of a record, with the same number as in [`Segment::source`](planesman_record::Segment).
#[derive(Clone, Debug, PartialEq)]
pub struct SourceOfRecord {
    /// Its files.
    pub name: String,
    /// The signals of this source alone, inputs first, and how each was resampled.
    pub channels: Vec<Channel>,
}

/// A record, and how it was made from data.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedRecord {
    /// The record, and how its signals were resampled.
    pub resampled: Resampled,
    /// The sources, in the order of reading.
    pub sources: Vec<SourceOfRecord>,
    /// Information on the reading of the data.
    pub reading: Reading,
    /// The steps of the record's preparation.
    pub steps: Vec<Step>,
}

impl PreparedRecord {
    /// Appends runs from another source to the record.
    #[must_use]
    pub fn followed_by(mut self, next: Self) -> Self {
        let (ours, mut theirs) = (&mut self.resampled, next.resampled);
        for segment in &mut theirs.record.segments {
            segment.source += self.sources.len();
        }
        self.sources.extend(next.sources);
        ours.record.segments.extend(theirs.record.segments);
        let channels = ours.inputs.iter_mut().chain(&mut ours.outputs);
        for (channel, other) in channels.zip(theirs.inputs.into_iter().chain(theirs.outputs)) {
            channel.timing = channel.timing.joined(&other.timing);
        }
        self.reading.notes.extend(next.reading.notes);
        self.reading.clock.extend(next.reading.clock);
        self.reading.mixed.extend(next.reading.mixed);
        self.reading.is_time_doubtful |= next.reading.is_time_doubtful;
        self
    }

    /// Applies further preparation to the record.
    #[must_use]
    pub fn prepared(mut self, preparation: &Preparation) -> Self {
        self.steps = decimation(&self.resampled);
        self.steps
            .extend(prepare(&mut self.resampled.record, preparation));
        self
    }

    /// Description of how the record was made.
    #[must_use]
    pub fn description(&self) -> String {
        let Resampled {
            record,
            inputs,
            outputs,
        } = &self.resampled;
        let mut text = format!(
            "{:<12} {} Hz, {} samples in {} segment{}, {:.3} s; stamps {}\n",
            "record",
            hertz(1.0 / record.sample_time),
            record.samples(),
            record.segments.len(),
            if record.segments.len() == 1 { "" } else { "s" },
            record.duration(),
            self.reading.stamps
        );
        for (kind, channels) in [("input", inputs), ("output", outputs)] {
            for channel in channels {
                text += &format!(
                    "{kind:<12} {}: {}\n",
                    channel.name,
                    channel_description(channel)
                );
            }
        }
        for note in &self.reading.clock {
            text += &format!("{:<12} {note}\n", "clock");
        }
        for note in self.reading.mixed.iter().chain(&self.reading.notes) {
            text += &format!("{:<12} {note}\n", "note");
        }
        for step in &self.steps {
            text += &format!("{:<12} {}\n", step.name.name(), step.text);
        }
        text
    }
}

/// Reads the named inputs and outputs of one source as a record, in one pass for all windows; `progress` receives the number of bytes read.
///
/// # Errors
/// One line: a signal is missing, none of the data can be read, or the signals have no common time.
pub fn read_record(
    source: &dyn Source,
    inputs: &[String],
    outputs: &[String],
    windows: &[Options],
    progress: &dyn Fn(u64),
) -> Result<PreparedRecord> {
    let requests: Vec<Request> = [(inputs, Role::Input), (outputs, Role::Output)]
        .into_iter()
        .flat_map(|(names, role)| {
            names.iter().map(move |name| Request {
                name: name.clone(),
                role,
            })
        })
        .collect();
    let resamplers = windows.iter();
    let mut resamplers: Vec<Resampler> = resamplers
        .map(|options| Resampler::new(inputs, outputs, options.clone()))
        .collect();
    let is_wanted = Cell::new(true);
    // Every window takes every sample: none may be asked first and spare the others.
    let mut give = |followed: Followed| match followed {
        Followed::Sample(signal, stamp, value) => {
            let wanted = resamplers.iter_mut();
            let wanted = wanted.map(|it| it.take(signal, stamp, value));
            is_wanted.set(wanted.fold(false, |any, one| any | one));
        }
        Followed::Break(signal) => {
            let resamplers = resamplers.iter_mut();
            resamplers.for_each(|it| it.begin_anew(signal));
        }
    };
    let mut clock = ClockFollower::new(requests.len());
    let mut reading = source.read(
        &requests,
        &mut |signal, stamp, value| {
            clock.take(signal, stamp, value, &mut give);
            is_wanted.get()
        },
        progress,
    )?;
    clock.finish(&mut give);
    reading.clock = clock.notes();
    let records = resamplers.into_iter().map(Resampler::finish);
    let joined = records.reduce(|joined, next| {
        let (mut joined, next) = (joined?, next?);
        joined.record.segments.extend(next.record.segments);
        Ok(joined)
    });
    let resampled = joined
        .unwrap_or(Err(GridError::NoWindow))
        .map_err(|reason| match &reading.notes[..] {
            [] => SourceError::Grid(reason),
            notes => SourceError::GridOf(reason, notes.join("; ")),
        })?;
    check_times(&resampled, windows)?;
    check_order(&resampled, &mut reading)?;
    for channel in resampled.inputs.iter().chain(&resampled.outputs) {
        let told = channel.mixture.iter();
        let told = told.map(|it| format!("{}: {it}", channel.name));
        reading.mixed.extend(told);
    }
    reading.question_unit(1.0 / resampled.record.sample_time);
    let channels = resampled.inputs.iter().chain(&resampled.outputs);
    Ok(PreparedRecord {
        sources: vec![SourceOfRecord {
            name: source.name(),
            channels: channels.cloned().collect(),
        }],
        resampled,
        reading,
        steps: Vec::new(),
    })
}

/// Reports outputs that are much faster than the grid.
fn decimation(resampled: &Resampled) -> Vec<Step> {
    let rate = 1.0 / resampled.record.sample_time;
    let outputs = resampled.outputs.iter();
    let decimated = outputs.filter(|it| it.timing.rate() > DECIMATED_RATE_FACTOR * rate);
    let step = |output: &Channel| {
        let how = match output.method {
            Method::Centred | Method::Mean | Method::Foh => {
                "samples between two grid points are averaged".to_owned()
            }
            Method::Linear | Method::Hold => format!(
                "samples between two grid points are left out, so motion faster than the grid is aliased ({} averages them)",
                setting("output_method", "centred")
            ),
        };
        Step {
            name: StepName::Decimation,
            text: format!(
                "{}: {:.6} samples per second become {rate:.6}: {how}",
                output.name,
                output.timing.rate()
            ),
        }
    };
    decimated.map(step).collect()
}

/// Checks that inputs and outputs have a common time, and that the grid is not finer than the outputs.
fn check_times(resampled: &Resampled, windows: &[Options]) -> Result<()> {
    for output in &resampled.outputs {
        let rate = 1.0 / resampled.record.sample_time;
        let own = output.timing.rate();
        let is_asked = windows.iter().any(|it| it.rate.is_some());
        if is_asked && own > 0.0 && rate > MAX_RATE_FACTOR * own {
            return Err(SourceError::Request(format!(
                "{} has {own:.6} samples per second, but the grid would have {rate:.6}, so most values would not be measured. {} may be at most {own:.6}",
                output.name,
                option("rate")
            )));
        }
        for input in &resampled.inputs {
            // A setpoint that was sent once is held.
            let (Some(ours), Some(theirs)) = (input.timing.span, output.timing.span) else {
                continue;
            };
            let apart = (theirs.0.saturating_sub(ours.1)).max(ours.0.saturating_sub(theirs.1));
            if input.timing.samples > 1 && apart > 0 {
                let seconds = |(first, last): (i64, i64)| {
                    format!("{:.3} to {:.3} s", first as f64 * 1e-9, last as f64 * 1e-9)
                };
                let clock = setting("stamp", "log");
                return Err(SourceError::Request(format!(
                    "{} is known from {}, but {} from {}, {:.3} s apart, so no output sample has an input sample at its time. If their stamps come from different clocks, {clock} uses the recorder's time for both signals of a bag",
                    input.name,
                    seconds(ours),
                    output.name,
                    seconds(theirs),
                    apart as f64 * 1e-9
                )));
            }
        }
    }
    Ok(())
}

/// Reports samples that were left out because their stamps are earlier than those of the samples before.
fn check_order(resampled: &Resampled, reading: &mut Reading) -> Result<()> {
    for channel in resampled.inputs.iter().chain(&resampled.outputs) {
        let timing = &channel.timing;
        let late = timing.late;
        let all = timing.samples + timing.duplicates + late;
        if let Some(refusal) = timing.refusal(all) {
            return Err(SourceError::Data(format!("{}: {refusal}", channel.name)));
        }
        if late as f64 <= LATE * all as f64 {
            continue;
        }
        let told = format!(
            "{}: {late} of {all} samples have earlier stamps than samples before them",
            channel.name
        );
        reading.clock.push(told + ", and these are left out");
        reading.is_time_doubtful = true;
    }
    Ok(())
}

fn channel_description(channel: &Channel) -> String {
    let timing = &channel.timing;
    let mut text = format!(
        "{} samples at {} Hz, {}",
        timing.samples,
        hertz(timing.rate()),
        channel.method
    );
    if timing.jitter >= 1e-6 {
        text += &format!("; jitter {:.3} ms", timing.jitter * 1e3);
    }
    if timing.gaps > 0 {
        text += &format!(
            "; {} gaps, the longest {:.3} s",
            timing.gaps, timing.longest
        );
    }
    if channel.held > 0.0 {
        text += &format!(
            "; a sample is held for up to {:.3} s ({} limits it)",
            channel.held,
            setting("max_gap", "SECONDS")
        );
    }
    for change in &channel.changes {
        text += &format!("; {change}");
    }
    for (count, what) in [
        (timing.duplicates, "with a repeated stamp"),
        (timing.late, "too late to be sorted"),
        (timing.not_finite, "not finite"),
        (timing.absent, "without a value"),
    ] {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}
