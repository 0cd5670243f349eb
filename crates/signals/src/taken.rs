//! A record from data: named signals of one source, resampled to one grid.

use anyhow::{Result, anyhow};

use crate::channel::Channel;
use crate::request::{Reading, Request, Role};
use crate::resample::{GridError, Options, Resampled, Resampler};
use crate::source::Source;

/// A record taken from data, and how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// The record, and how its signals came onto the grid.
    pub resampled: Resampled,
    /// How the data was read.
    pub reading: Reading,
}

impl Taken {
    /// The same, followed by runs from another source.
    #[must_use]
    pub fn followed_by(mut self, next: Self) -> Self {
        let (ours, theirs) = (&mut self.resampled, next.resampled);
        ours.record.stretches.extend(theirs.record.stretches);
        let channels = ours.inputs.iter_mut().chain(&mut ours.outputs);
        for (channel, other) in channels.zip(theirs.inputs.into_iter().chain(theirs.outputs)) {
            channel.timing = channel.timing.joined(&other.timing);
        }
        self.reading.notes.extend(next.reading.notes);
        self
    }

    /// How the record was made, as text.
    #[must_use]
    pub fn account(&self) -> String {
        let Resampled {
            record,
            inputs,
            outputs,
        } = &self.resampled;
        let mut text = format!(
            "{:.6} Hz, {} samples in {} segment{}, {:.3} s; stamps {}\n",
            1.0 / record.sample_time,
            record.samples(),
            record.stretches.len(),
            if record.stretches.len() == 1 { "" } else { "s" },
            record.duration(),
            self.reading.stamps
        );
        for (kind, channels) in [("input ", inputs), ("output", outputs)] {
            for channel in channels {
                text += &format!("{kind}  {}: {}\n", channel.name, channel_account(channel));
            }
        }
        for note in &self.reading.notes {
            text += &format!("note    {note}\n");
        }
        text
    }
}

/// Reads the named inputs and outputs of one source as a record, in one pass for all windows; `progress` is called with
/// the bytes read.
///
/// # Errors
/// One line: a signal that is not there, data of which nothing can be read, signals without an instant in common.
pub fn take(
    source: &Source,
    inputs: &[String],
    outputs: &[String],
    windows: &[Options],
    progress: &dyn Fn(u64),
) -> Result<Taken> {
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
    let reading = source.read(
        &requests,
        &mut |signal, stamp, value| {
            // Every window takes every sample: none may be asked first and spare the others.
            let wanted = resamplers
                .iter_mut()
                .map(|it| it.take(signal, stamp, value));
            wanted.fold(false, |any, one| any | one)
        },
        progress,
    )?;
    let records = resamplers.into_iter().map(Resampler::finish);
    let joined = records.reduce(|joined, next| {
        let (mut joined, next) = (joined?, next?);
        joined.record.stretches.extend(next.record.stretches);
        Ok(joined)
    });
    let resampled = joined
        .unwrap_or(Err(GridError::NoWindow))
        .map_err(|reason| match &reading.notes[..] {
            [] => anyhow!(reason),
            notes => anyhow!("{reason} ({})", notes.join("; ")),
        })?;
    Ok(Taken { resampled, reading })
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
            "; a sample held for up to {:.3} s (--max-gap SECONDS limits it)",
            channel.held
        );
    }
    for (count, what) in [
        (timing.duplicates, "with a repeated stamp"),
        (timing.late, "too late for their place in order"),
        (timing.not_finite, "not finite"),
        (timing.absent, "without a value"),
    ] {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}
