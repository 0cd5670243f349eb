//! A request for signals of a bag or table, and the notes from reading it.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use crate::error::{Result, SourceError};
use crate::time_unit::{JudgedUnit, Known, TimeUnit};
use planesman_text::{number, option};
use serde::Serialize;

/// Plausible rates of a log, Hz; above the upper one, seconds may really be milliseconds.
const PLAUSIBLE: RangeInclusive<f64> = 1e-3..=2e4;
const SLOW: f64 = 0.1;

/// Rates that suggest another unit, Hz.
const USUAL: RangeInclusive<f64> = 0.5..=1e4;

planesman_text::choices! {
    /// The clock whose stamps are used.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Clock {
        Header = "header": "Stamp in the header of the message",
        Log = "log": "Time when the recorder received the message",
    }
}

/// The role of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Input: a list is its time history over the next interval, and gives its mean.
    Input,
    /// Output: a list gives its first element.
    Output,
}

/// A requested signal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// `TOPIC:FIELD` in a bag, a column's name in a table.
    pub name: String,
    /// Its role.
    pub role: Role,
}

impl Request {
    /// An output of that name.
    #[must_use]
    pub fn output(name: impl Into<String>) -> Self {
        let (name, role) = (name.into(), Role::Output);
        Self { name, role }
    }
}

/// Checks that no signal is both an input and an output: the model would be 1. `found` has the place of each request.
///
/// # Errors
/// A sentence with the signal's name.
pub(crate) fn distinct<T: PartialEq>(requests: &[Request], found: &[T]) -> Result<()> {
    let all = || requests.iter().zip(found);
    for (input, of_input) in all().filter(|(it, _)| it.role == Role::Input) {
        let is_the_same =
            |(it, found): (&Request, &T)| it.role == Role::Output && found == of_input;
        if all().any(is_the_same) {
            return Err(SourceError::Request(format!(
                "'{}' is named both as input and as output; name two different signals",
                input.name
            )));
        }
    }
    Ok(())
}

/// Notes of reading.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reading {
    /// The kind of stamps used, for people.
    pub stamps: String,
    /// Everything that could not be read, with the reason.
    pub notes: Vec<String>,
    /// Findings about the clock that affect a model: where it goes back, or seems to have another unit.
    pub clock: Vec<String>,
    /// Signals that seem to mix two sources.
    pub mixed: Vec<String>,
    /// Whether all times may be wrong.
    pub is_time_doubtful: bool,
    /// The unit of the times, and how it is known.
    #[serde(skip)]
    pub(crate) unit: JudgedUnit,
    /// The median delay from a message's stamp to its reception by the recorder, s, by topic.
    pub latencies: BTreeMap<String, f64>,
    /// The full column name of each signal that was requested without its unit.
    #[serde(skip)]
    pub columns: BTreeMap<String, String>,
}

impl Reading {
    /// Questions an assumed unit of time, by the rate that it gives, Hz.
    pub fn question_unit(&mut self, rate: f64) {
        let (how, is_doubtful) = match self.unit.known {
            Known::Likely(how) => (how, true),
            Known::Assumed if !PLAUSIBLE.contains(&rate) => ("", true),
            Known::Assumed if rate <= SLOW => ("", false),
            _ => return,
        };
        let how = match how {
            "" => String::new(),
            how => format!(", {how},"),
        };
        let unit = self.unit.unit;
        let others = [TimeUnit::S, TimeUnit::Ms, TimeUnit::Us, TimeUnit::Ns].into_iter();
        let others = others.filter(|it| *it != unit).filter_map(|it| {
            let rate = rate * unit.nanoseconds() as f64 / it.nanoseconds() as f64;
            USUAL
                .contains(&rate)
                .then(|| format!(", in {} {} Hz", it.name(), number(rate)))
        });
        let told = format!(
            "the unit of the times is not given: in {}{how} the rate is {} Hz{} ({} sets the unit)",
            unit.name(),
            number(rate),
            others.collect::<String>(),
            option("time_unit")
        );
        match is_doubtful {
            true => self.clock.push(told),
            false => self.notes.push(told),
        }
        self.is_time_doubtful |= is_doubtful;
    }

    /// The signal's name with the unit, if its column's name has one.
    #[must_use]
    pub fn column<'a>(&'a self, signal: &'a str) -> &'a str {
        self.columns.get(signal).map_or(signal, String::as_str)
    }
}

/// The interval of progress reports, in rows or messages.
pub(crate) const PROGRESS_INTERVAL: u64 = 4096;

/// The place of each request; input and output must have different places, otherwise the model would be 1.
///
/// # Errors
/// Errors of `find`, or a sentence with the signal's name.
pub(crate) fn places<T: PartialEq>(
    requests: &[Request],
    find: impl Fn(&Request) -> Result<T>,
) -> Result<Vec<T>> {
    let found = requests.iter().map(find).collect::<Result<Vec<_>>>()?;
    distinct(requests, &found)?;
    Ok(found)
}

/// Receives samples: the signal's number, its stamp in ns, its value if it has one. Returns whether more samples are needed.
pub type Take<'a> = dyn FnMut(usize, i64, Option<f64>) -> bool + 'a;
