//! The timing of a signal's samples, and the method of resampling.

use std::fmt;

use planesman_text::{number, option, setting};
use serde::Serialize;

use crate::mixture::Mixture;
use crate::unwrap::{Unwrap, Unwrapper};

/// The share of samples with a stamp that came before that is refused. Messages that are recorded twice are half of all.
const MOSTLY_REPEATED: f64 = 0.8;

/// The share of samples in wrong order that is refused.
const MOSTLY_LATE: f64 = 0.5;

/// One signal of a record, and how it came onto the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// The signal, as it was asked for: `TOPIC:FIELD`, or a CSV column.
    pub name: String,
    /// How its samples were put on the grid.
    pub method: Method,
    /// How its samples lay in time before.
    pub timing: Timing,
    /// The longest time for which a sample of an input was held, s; 0 if that was neither beyond five of its median intervals (or two and
    /// a half of the grid) nor beyond a hundred of the grid.
    pub held: f64,
    /// What was done to its samples before.
    pub changes: Vec<Change>,
    /// What speaks for two things in turns, if something does.
    pub mixture: Option<Mixture>,
}

/// What is done to the samples of a signal before they go onto a grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// They came in bursts, and are spread evenly over the time that they stand for.
    Spread {
        /// Samples of a burst, on the mean.
        samples: f64,
        /// From burst to burst, s.
        period: f64,
        /// Those of a burst have one stamp, as of a clock of whole seconds; else they were received at once.
        share_a_stamp: bool,
    },
    /// Their stamps are in steps nearly as long as the time between samples, and are spread evenly within them.
    Rounded {
        /// s
        step: f64,
    },
    /// A slow sensor's samples are repeated until the next: repeats are left out.
    RepeatsLeftOut {
        /// Rows for each sample of the sensor, on the mean.
        rows: f64,
    },
    /// An angle or counter that wraps is unwrapped.
    Unwrapped {
        /// Its period.
        period: f64,
        /// How often it wrapped.
        wraps: u64,
    },
}

impl Change {
    /// What an unwrapper has done, if its values wrapped.
    pub(crate) fn of(unwrapper: &Unwrapper) -> Option<Self> {
        let wraps = unwrapper.wraps;
        let change = |period| Self::Unwrapped { period, wraps };
        unwrapper.period.map(change)
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Spread {
                samples,
                period,
                share_a_stamp,
            } => {
                let how = if share_a_stamp {
                    "share a stamp"
                } else {
                    "come at once"
                };
                write!(
                    f,
                    "{samples:.1} samples {how} every {period:.3} s, spread evenly over that time"
                )
            }
            Self::Rounded { step } => {
                write!(
                    f,
                    "stamps in steps of {step:.6} s, spread evenly within them"
                )
            }
            Self::RepeatsLeftOut { rows } => write!(
                f,
                "a new value every {} rows only: repeats are left out",
                (10.0 * rows).round() / 10.0
            ),
            Self::Unwrapped { period, wraps } => write!(
                f,
                "wraps {wraps} times: unwrapped by {} ({} takes it as it is)",
                Unwrap::Period(period),
                setting("unwrap", "no")
            ),
        }
    }
}

planesman_text::choices! {
    /// How samples between the grid's instants become one number for each instant.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Method {
        #[default]
        Mean = "mean": "Mean over the interval that starts at the grid point, each sample held until the next; for commands",
        Foh = "foh": "Mean over the interval that starts at the grid point, straight lines between the samples (first-order hold); for a measured motion",
        Linear = "linear": "Linear interpolation between the samples before and after the grid point; for measurements",
        Hold = "hold": "Latest sample at or before the grid point",
        Centred = "centred": "Mean of the samples nearest to the grid point; for measurements much faster than the grid",
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean over the interval",
            Self::Foh => "mean over the interval of straight lines",
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

    /// Why the stamps of a signal, topic or table of so many samples tell no times, with what helps.
    #[must_use]
    pub fn refusal(&self, all: u64) -> Option<String> {
        if self.duplicates as f64 > MOSTLY_REPEATED * all as f64 {
            return Some(format!(
                "{} of {all} samples have the stamp of another, so their times are not known: name the interval between \
                 the rows of a table ({}) or another column ({}), and of a bag the recorder's time ({})",
                self.duplicates,
                setting("sample_time", "SECONDS"),
                option("time"),
                setting("stamp", "log")
            ));
        }
        (self.late as f64 > MOSTLY_LATE * all as f64).then(|| {
            format!(
                "{} of {all} samples are stamped before those in front of them: sort them by time, or name another \
                 time: {} of a table, {} of a bag",
                self.late,
                setting("time", "COLUMN"),
                setting("stamp", "log")
            )
        })
    }

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

/// A rate to three decimals, a slow one to its digits.
#[must_use]
pub fn hertz(rate: f64) -> String {
    match rate < 1.0 {
        true => number(rate),
        false => format!("{rate:.3}"),
    }
}
