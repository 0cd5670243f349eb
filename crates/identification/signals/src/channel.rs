//! The timing of a signal's samples, and the method of resampling.

use std::fmt;

use planesman_text::{number, option, setting};
use serde::Serialize;

use crate::mixture::Mixture;
use crate::unwrap::{Unwrap, Unwrapper};

/// A signal is refused if at least this share of its stamps is repeated. If every message is recorded twice, half of the messages are repeats.
const MOSTLY_REPEATED: f64 = 0.8;

/// A signal is refused if at least this share of its samples is out of order.
const MOSTLY_LATE: f64 = 0.5;

/// One signal of a record, and the way it was resampled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// The requested name: `TOPIC:FIELD`, or a CSV column.
    pub name: String,
    /// Method by which the samples were resampled to the grid.
    pub method: Method,
    /// Timing of the samples before resampling.
    pub timing: Timing,
    /// The longest time for which a sample of an input was held, s. Zero if this was not beyond five of its median intervals (or two and a
    /// half of the grid) nor beyond a hundred of the grid.
    pub held: f64,
    /// Changes made to the samples before resampling.
    pub changes: Vec<Change>,
    /// Evidence that two sources alternate in the signal; `None` if there is no evidence.
    pub mixture: Option<Mixture>,
}

/// A change to the samples of a signal before resampling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// The samples came in bursts, and are spread evenly over the time they represent.
    Spread {
        /// Mean number of samples in a burst.
        samples: f64,
        /// The time from burst to burst, s.
        period: f64,
        /// Whether the samples of a burst share one stamp (a clock of whole seconds); otherwise they were received at once.
        share_a_stamp: bool,
    },
    /// The stamps' resolution is nearly as long as the time between samples; they are spread evenly within it.
    Rounded {
        /// s
        step: f64,
    },
    /// Each sample of a slow sensor is repeated until the next: repeats are left out.
    RepeatsLeftOut {
        /// Mean number of rows for each sample of the sensor.
        rows: f64,
    },
    /// An angle or counter that wraps is unwrapped.
    Unwrapped {
        /// Its period.
        period: f64,
        /// Number of wraps.
        wraps: u64,
    },
}

impl Change {
    /// The change made by an unwrapper, if its values wrapped.
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
                    "{samples:.1} samples {how} every {period:.3} s, so they are spread evenly over that time"
                )
            }
            Self::Rounded { step } => {
                write!(
                    f,
                    "stamps are rounded to steps of {step:.6} s; samples with one stamp are spread evenly over the step"
                )
            }
            Self::RepeatsLeftOut { rows } => write!(
                f,
                "the value is new only every {} rows, so repeated values are left out",
                (10.0 * rows).round() / 10.0
            ),
            Self::Unwrapped { period, wraps } => write!(
                f,
                "wraps around {wraps} times, so it is unwrapped with the period {} ({} uses the signal as recorded)",
                Unwrap::Period(period),
                setting("unwrap", "no")
            ),
        }
    }
}

planesman_text::choices! {
    /// Method by which samples between the grid's instants become one number for each instant.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Method {
        #[default]
        Mean = "mean": "Mean over the interval that starts at the grid point, each sample held until the next; suitable for commands",
        Foh = "foh": "Mean over the interval that starts at the grid point, straight lines between the samples (first-order hold); suitable for a measured motion",
        Linear = "linear": "Linear interpolation between the samples before and after the grid point; suitable for measurements",
        Hold = "hold": "Latest sample at or before the grid point",
        Centred = "centred": "Mean of the samples nearest to the grid point; suitable for measurements much faster than the grid",
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean over the interval",
            Self::Foh => "mean over the interval, linear between samples",
            Self::Linear => "linear interpolation",
            Self::Hold => "latest held",
            Self::Centred => "mean about the instant",
        })
    }
}

/// Timing of the samples of one signal, or of the messages of one topic.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Samples taken.
    pub samples: u64,
    /// The first and the last stamp, ns; `None` without samples.
    pub span: Option<(i64, i64)>,
    /// The median interval between neighbours, s; 0 with fewer than two samples.
    pub interval: f64,
    /// Half the range of the middle nine tenths of the intervals, s, so that gaps do not count.
    pub jitter: f64,
    /// Number of intervals above one and a half medians.
    pub gaps: u64,
    /// The longest interval, s.
    pub longest: f64,
    /// Samples whose stamp occurred before; the later one counts.
    pub duplicates: u64,
    /// Samples older than an earlier one by more than can be sorted; left out.
    pub late: u64,
    /// Samples that are NaN, infinite or implausibly large; left out.
    pub not_finite: u64,
    /// Messages without the requested element, for example with a list that is too short; left out.
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

    /// The reason why the stamps of a signal, topic or table with this many samples give no times, with the remedy.
    #[must_use]
    pub fn refusal(&self, all: u64) -> Option<String> {
        if self.duplicates as f64 > MOSTLY_REPEATED * all as f64 {
            return Some(format!(
                "{} of {all} samples have the same stamp as another sample, so their times are not known. Give the interval between the rows of a table ({}) or another column ({}); for a bag, use the recorder's time ({})",
                self.duplicates,
                setting("sample_time", "SECONDS"),
                option("time"),
                setting("stamp", "log")
            ));
        }
        (self.late as f64 > MOSTLY_LATE * all as f64).then(|| {
            format!(
                "{} of {all} samples have earlier stamps than samples before them. Sort the samples by time, or choose another time ({} for a table, {} for a bag)",
                self.late,
                setting("time", "COLUMN"),
                setting("stamp", "log")
            )
        })
    }

    /// Combines this timing with another: counts are added, the worse of the other values is kept.
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

/// A rate with three decimals, or all significant digits if it is slow.
#[must_use]
pub fn hertz(rate: f64) -> String {
    match rate < 1.0 {
        true => number(rate),
        false => format!("{rate:.3}"),
    }
}
