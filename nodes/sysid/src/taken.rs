//! A record taken from data: signals named on the command line, put on one grid.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use serde::Serialize;

use crate::record::{Channel, Method, Record};
use crate::resample::{Options, Resampler};
use crate::source::{DataArgs, Reading, Request, Role, Source, progress_bar};

/// Signals of some data, on one grid.
#[derive(Clone, Debug, clap::Args)]
pub struct SignalArgs {
    #[command(flatten)]
    data: DataArgs,
    /// The signal that drives: TOPIC:FIELD, or a CSV column
    #[arg(long, short, value_name = "SIGNAL")]
    input: String,
    /// The signal that responds
    #[arg(long, short, value_name = "SIGNAL")]
    output: String,
    /// The reference of the loop that the input is made in: the model is then found in two stages
    #[arg(long, short, value_name = "SIGNAL")]
    reference: Option<String>,
    #[command(flatten)]
    grid: GridArgs,
}

impl SignalArgs {
    /// Reads them as a record: the input, then the reference if there is one. Each window of each source is a
    /// stretch, or several.
    ///
    /// # Errors
    /// One line: data that cannot be read, a signal that is not in it, signals that have no instant in common,
    /// sources sampled at different rates.
    pub fn record(&self) -> Result<Taken> {
        let inputs: Vec<String> = std::iter::once(&self.input)
            .chain(&self.reference)
            .cloned()
            .collect();
        let outputs = [self.output.clone()];
        let mut taken: Option<Taken> = None;
        for data in sources(&self.data) {
            let rate = taken.as_ref().map(|taken| 1.0 / taken.record.sample_time);
            let options = self.grid.options(rate);
            let next = record(&data, &inputs, &outputs, &options)?;
            taken = Some(match taken {
                None => next,
                Some(before) => before.followed_by(next),
            });
        }
        taken.ok_or_else(|| anyhow!("there is no data"))
    }
}

/// The parts of a split bag belong together; every other path is a source of its own.
fn sources(data: &DataArgs) -> Vec<DataArgs> {
    let is_part = |path: &&PathBuf| path.extension().is_some_and(|it| it == "mcap");
    let (parts, others): (Vec<&PathBuf>, Vec<&PathBuf>) = data.data.iter().partition(is_part);
    let parts = parts.into_iter().cloned().collect::<Vec<_>>();
    let others = others.into_iter().map(|path| vec![path.clone()]);
    std::iter::once(parts)
        .filter(|parts| !parts.is_empty())
        .chain(others)
        .map(|paths| DataArgs {
            data: paths,
            ..data.clone()
        })
        .collect()
}

/// How samples are put on a grid.
#[derive(Clone, Debug, clap::Args)]
pub struct GridArgs {
    /// Instants per second [default: that of the slowest output]
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    rate: Option<f64>,
    /// Only what lies between these times, in seconds from the first output's first sample; several make runs
    /// of one model
    #[arg(long, value_name = "FROM..TO", value_parser = window, allow_hyphen_values = true)]
    window: Vec<(f64, f64)>,
    /// How inputs are put on the grid
    #[arg(long, value_enum, default_value = "mean")]
    input_method: Method,
    /// How outputs are put on the grid
    #[arg(long, value_enum, default_value = "linear")]
    output_method: Method,
    /// The longest pause that is no gap [default: five sample intervals; an input that is held has none]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    max_gap: Option<f64>,
}

impl GridArgs {
    /// The options they stand for, one for each window; `rate` where none was asked for.
    fn options(&self, rate: Option<f64>) -> Vec<Options> {
        let all = [(f64::NEG_INFINITY, f64::INFINITY)];
        let windows = match &self.window[..] {
            [] => &all[..],
            windows => windows,
        };
        let of = |(from, to): &(f64, f64)| Options {
            rate: self.rate.or(rate),
            window: *from..=*to,
            input_method: self.input_method,
            output_method: self.output_method,
            max_gap: self.max_gap,
        };
        windows.iter().map(of).collect()
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("'{text}' is no number"))
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = number(text)?;
    if (1e-6..=1e6).contains(&rate) {
        Ok(rate)
    } else {
        Err("a rate lies between 1e-6 and 1e6 Hz".to_owned())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = number(text)?;
    if seconds > 0.0 && seconds <= 1e9 {
        Ok(seconds)
    } else {
        Err("a time between 0 and 1e9 s is expected".to_owned())
    }
}

fn window(text: &str) -> Result<(f64, f64), String> {
    let rule =
        || format!("'{text}' is no window; one is written FROM..TO, as 10..60, 10.. or ..60");
    let (from, to) = text.split_once("..").ok_or_else(rule)?;
    let edge = |text: &str, open: f64| match text {
        "" => Ok(open),
        text => number(text).map_err(|_| rule()),
    };
    let (from, to) = (edge(from, f64::NEG_INFINITY)?, edge(to, f64::INFINITY)?);
    if from < to {
        Ok((from, to))
    } else {
        Err(rule())
    }
}

/// A record made from data, and what there is to say of the making.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Taken {
    /// The record.
    pub record: Record,
    /// How the data was read.
    pub reading: Reading,
}

impl Taken {
    /// The same, followed by runs from another source.
    fn followed_by(mut self, next: Self) -> Self {
        self.record.stretches.extend(next.record.stretches);
        let others = next.record.inputs.into_iter().chain(next.record.outputs);
        let channels = self
            .record
            .inputs
            .iter_mut()
            .chain(&mut self.record.outputs);
        for (channel, other) in channels.zip(others) {
            channel.timing = channel.timing.joined(&other.timing);
        }
        self.reading.notes.extend(next.reading.notes);
        self
    }
}

/// Reads the named inputs and outputs of one source as a record, in one pass for all windows.
fn record(
    data: &DataArgs,
    inputs: &[String],
    outputs: &[String],
    windows: &[Options],
) -> Result<Taken> {
    let source = Source::open(data)?;
    let requests: Vec<Request> = [(inputs, Role::Input), (outputs, Role::Output)]
        .into_iter()
        .flat_map(|(names, role)| {
            names.iter().map(move |name| Request {
                name: name.clone(),
                role,
            })
        })
        .collect();
    let mut resamplers: Vec<Resampler> = windows
        .iter()
        .map(|options| Resampler::new(inputs, outputs, options.clone()))
        .collect();
    let bar = progress_bar(source.bytes(), data);
    let reading = source.read(
        &requests,
        &mut |signal, stamp, value| {
            // Every window takes every sample: none may be asked first and spare the others.
            let wanted = resamplers
                .iter_mut()
                .map(|it| it.take(signal, stamp, value));
            wanted.fold(false, |any, one| any | one)
        },
        &|bytes| bar.set_position(bytes),
    )?;
    bar.finish_and_clear();
    let records = resamplers.into_iter().map(Resampler::finish);
    let joined = records.reduce(|joined, next| {
        let (mut joined, next) = (joined?, next?);
        joined.stretches.extend(next.stretches);
        Ok(joined)
    });
    let record = joined
        .unwrap_or_else(|| Err("there is no window".to_owned()))
        .map_err(|reason| match &reading.notes[..] {
            [] => anyhow!(reason),
            notes => anyhow!("{reason} ({})", notes.join("; ")),
        })?;
    Ok(Taken { record, reading })
}

/// The making of a record, for people.
#[must_use]
pub fn account(record: &Record, reading: &Reading) -> String {
    let mut text = format!(
        "{:.6} Hz, {} samples in {} stretch{}, {:.3} s; stamps {}\n",
        1.0 / record.sample_time,
        record.samples(),
        record.stretches.len(),
        if record.stretches.len() == 1 {
            ""
        } else {
            "es"
        },
        record.duration(),
        reading.stamps
    );
    for (kind, channels) in [("input ", &record.inputs), ("output", &record.outputs)] {
        for channel in channels {
            text += &format!("{kind}  {}: {}\n", channel.name, channel_account(channel));
        }
    }
    for note in &reading.notes {
        text += &format!("note    {note}\n");
    }
    text
}

fn channel_account(channel: &Channel) -> String {
    let timing = &channel.timing;
    let mut text = format!(
        "{} samples at {:.3} Hz, jitter {:.3} ms, {}",
        timing.samples,
        timing.rate(),
        timing.jitter * 1e3,
        channel.method
    );
    if timing.gaps > 0 {
        text += &format!(
            "; {} gaps, the longest {:.3} s",
            timing.gaps, timing.longest
        );
    }
    if channel.held > 0.0 {
        text += &format!(
            "; a sample held for up to {:.3} s (--max-gap SECONDS makes gaps of pauses)",
            channel.held
        );
    }
    for (count, what) in [
        (timing.duplicates, "with a stamp that came before"),
        (timing.late, "too late to be put in order"),
        (timing.not_finite, "not finite"),
        (timing.absent, "messages without it"),
    ] {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}
