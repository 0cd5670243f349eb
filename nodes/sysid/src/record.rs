//! A record: inputs and outputs on one uniform grid of instants, as every estimator takes them.
//!
//! Where it comes from (a bag, a CSV file, topics that are live) is no longer visible here;
//! how it was put on the grid is told beside the numbers ([`Channel`]).
//!
//! A record is a list of *stretches*, each without a gap. Between two stretches something was
//! missing, or a new run began: an estimator starts its history anew with each, and the
//! parameters are common to all. Several runs of one vehicle make one record in the same way.
//!
//! Within a stretch the output is known at the instants `t_k = start + k * sample_time`, and
//! `inputs[..][k]` acts over the interval from t_k to t_(k+1).

use std::fmt;

use serde::Serialize;

/// Inputs and outputs on one uniform grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Record {
    /// The interval between instants, s.
    pub sample_time: f64,
    /// What drives, in the order of each stretch's `inputs`.
    pub inputs: Vec<Channel>,
    /// What responds, in the order of each stretch's `outputs`.
    pub outputs: Vec<Channel>,
    /// The numbers, in the order of time.
    pub stretches: Vec<Stretch>,
}

/// Numbers without a gap.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stretch {
    /// The first instant, ns on the data's own clock.
    pub start: i64,
    /// `inputs[i][k]`: input i over the interval that begins at instant k. All as long as the outputs.
    pub inputs: Vec<Vec<f64>>,
    /// `outputs[i][k]`: output i at instant k.
    pub outputs: Vec<Vec<f64>>,
}

/// One signal of a record, and how it came onto the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// The signal, as it was asked for: `TOPIC:FIELD`, or a CSV column.
    pub name: String,
    /// How its samples were put on the grid.
    pub method: Method,
    /// What its samples were like before.
    pub timing: Timing,
    /// The longest time for which a sample of an input was held, s; 0 if that was neither beyond five of its median intervals (or two and
    /// a half of the grid) nor beyond a hundred of the grid.
    pub held: f64,
}

/// How samples between the grid's instants become one number for each instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The mean over the interval that begins at the instant, each sample held until the next: for commands.
    #[default]
    Mean,
    /// On the straight line between the samples before and after the instant: for measurements.
    Linear,
    /// The latest sample at or before the instant.
    Hold,
    /// The mean of the samples nearer to this instant than to any other: for measurements much faster than the grid.
    Centred,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean over the interval",
            Self::Linear => "linear interpolation",
            Self::Hold => "latest held",
            Self::Centred => "mean about the instant",
        })
    }
}

/// The samples of one signal, or the messages of one topic, as they lay in time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Samples taken.
    pub samples: u64,
    /// The first and the last stamp, ns; `None` without samples.
    pub span: Option<(i64, i64)>,
    /// The median interval between neighbours, s; 0 with fewer than two samples.
    pub interval: f64,
    /// Half the range that holds nine of ten intervals, s: what is left when gaps are set aside.
    pub jitter: f64,
    /// Intervals of more than one and a half medians.
    pub gaps: u64,
    /// The longest interval, s.
    pub longest: f64,
    /// Samples whose stamp had come before; the later one counts.
    pub duplicates: u64,
    /// Samples older than one before them, by more than could be put in order; left out.
    pub late: u64,
    /// Samples that are NaN, infinite or beyond reason; left out.
    pub not_finite: u64,
    /// Messages without the element asked for, as a list that is too short; left out.
    pub absent: u64,
}

impl Timing {
    /// Samples per second, by the median interval; 0 with fewer than two samples.
    #[must_use]
    pub fn rate(&self) -> f64 {
        if self.interval > 0.0 {
            1.0 / self.interval
        } else {
            0.0
        }
    }
}

impl Timing {
    /// Of these samples and others, from elsewhere: counts together, the worse of either.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            span: self.span,
            interval: self.interval.max(other.interval),
            jitter: self.jitter.max(other.jitter),
            gaps: self.gaps + other.gaps,
            longest: self.longest.max(other.longest),
            duplicates: self.duplicates + other.duplicates,
            late: self.late + other.late,
            not_finite: self.not_finite + other.not_finite,
            absent: self.absent + other.absent,
        }
    }
}

impl Channel {
    /// A signal that was on the grid to begin with.
    #[must_use]
    pub fn on_grid(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            method: Method::Hold,
            timing: Timing::default(),
            held: 0.0,
        }
    }
}

impl Stretch {
    /// The number of instants.
    #[must_use]
    pub fn len(&self) -> usize {
        self.outputs.first().map_or(0, Vec::len)
    }

    /// Whether there is no instant.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Record {
    /// A record of one stretch that begins at time 0, from numbers that are on the grid.
    ///
    /// # Errors
    /// A sentence, when a name and its numbers do not pair, signals differ in length, or the
    /// sampling interval is not a positive number.
    pub fn of_run(
        sample_time: f64,
        inputs: Vec<(&str, Vec<f64>)>,
        outputs: Vec<(&str, Vec<f64>)>,
    ) -> Result<Self, String> {
        let [inputs, outputs] = [inputs, outputs].map(|signals| {
            let (names, numbers): (Vec<_>, Vec<_>) = signals.into_iter().unzip();
            let channels: Vec<_> = names.into_iter().map(Channel::on_grid).collect();
            (channels, numbers)
        });
        let record = Self {
            sample_time,
            inputs: inputs.0,
            outputs: outputs.0,
            stretches: vec![Stretch {
                start: 0,
                inputs: inputs.1,
                outputs: outputs.1,
            }],
        };
        record.check()?;
        Ok(record)
    }

    /// Whether the record is what it should be: a positive sampling interval, at least one output, and in every
    /// stretch as many lists as signals, all of one length, all finite.
    ///
    /// # Errors
    /// A sentence that says what is wrong.
    pub fn check(&self) -> Result<(), String> {
        if !(self.sample_time > 0.0 && self.sample_time.is_finite()) {
            return Err(format!("{} s is no sampling interval", self.sample_time));
        }
        if self.outputs.is_empty() {
            return Err("a record needs an output".to_owned());
        }
        for (number, stretch) in self.stretches.iter().enumerate() {
            let sides = [
                (&self.inputs, &stretch.inputs),
                (&self.outputs, &stretch.outputs),
            ];
            for (channels, lists) in sides {
                if channels.len() != lists.len() {
                    return Err(format!(
                        "stretch {number} has {} lists for {} signals",
                        lists.len(),
                        channels.len()
                    ));
                }
                for (channel, list) in channels.iter().zip(lists) {
                    if list.len() != stretch.len() {
                        return Err(format!(
                            "stretch {number}: {} has {} samples, the first output {}",
                            channel.name,
                            list.len(),
                            stretch.len()
                        ));
                    }
                    if let Some(k) = list.iter().position(|value| !value.is_finite()) {
                        return Err(format!(
                            "stretch {number}: {} is not finite at sample {k}",
                            channel.name
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// The number of instants in all stretches.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.stretches.iter().map(Stretch::len).sum()
    }

    /// How long the stretches are together, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples() as f64 * self.sample_time
    }

    /// The stretch with the most instants, the earliest of several.
    #[must_use]
    pub fn longest(&self) -> Option<&Stretch> {
        self.stretches
            .iter()
            .rev()
            .max_by_key(|stretch| stretch.len())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_run_is_a_record_of_one_stretch() {
        let record = Record::of_run(
            0.5,
            vec![("u", vec![1.0, 2.0])],
            vec![("y", vec![0.0, 3.0])],
        )
        .unwrap();
        assert_eq!((record.samples(), record.duration()), (2, 1.0));
        assert_eq!(record.longest().unwrap().outputs[0][1], 3.0);
        assert_eq!(record.inputs[0].name, "u");
    }

    #[test]
    fn what_does_not_fit_together_is_refused_with_the_signals_name() {
        let u = || vec![("u", vec![1.0, 2.0])];
        for (sample_time, y, reason) in [
            (0.0, vec![("y", vec![0.0, 3.0])], "sampling interval"),
            (f64::NAN, vec![("y", vec![0.0, 3.0])], "sampling interval"),
            (0.5, vec![], "needs an output"),
            (0.5, vec![("y", vec![0.0])], "u has 2 samples"),
            (
                0.5,
                vec![("y", vec![0.0, f64::NAN])],
                "y is not finite at sample 1",
            ),
        ] {
            let refusal = Record::of_run(sample_time, u(), y).unwrap_err();
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
