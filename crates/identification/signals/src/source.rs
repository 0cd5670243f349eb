//! Sources of samples: a bag, tables, a log of a vehicle, columns in memory.
//!
//! All sources stream: a sample is passed on as it is read, and not stored. Reading continues after unreadable parts; they are listed in
//! [`Reading::notes`].

use std::fmt::Debug;

use planesman_bag::BagReader;

use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Take};

/// A topic of a source and its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTopic {
    /// The topic's name; for a table the file.
    pub name: String,
    /// The type of the source's messages; empty for a table.
    pub type_name: &'static str,
    /// One request for each field, in the order of the message.
    pub requests: Vec<Request>,
}

/// An open source of samples.
pub trait Source: Debug {
    /// Names of the source's files, for display.
    fn name(&self) -> String;

    /// Number of bytes to be read.
    fn bytes(&self) -> u64 {
        0
    }

    /// The interval between samples, s, if it was given because the data has no time.
    fn sample_time(&self) -> Option<f64> {
        None
    }

    /// Whether the data has the time of its samples, or the interval between them was given.
    fn has_time(&self) -> bool {
        true
    }

    /// Assumes rows one second apart, if no time is known.
    fn count_rows(&mut self) {}

    /// The bag behind the source, which lists its topics.
    fn bag(&self) -> Option<&BagReader> {
        None
    }

    /// Topics of the source; empty for a bag.
    fn topics(&self) -> Vec<SourceTopic> {
        Vec::new()
    }

    /// The source's tables, if there are several and each has all of these signals: each table is then a separate experiment.
    fn experiments(&self, _signals: &[String]) -> Vec<Box<dyn Source>> {
        Vec::new()
    }

    /// Passes every sample of the signals to `take`; `progress` receives the number of bytes read.
    ///
    /// # Errors
    /// One line: a signal is missing, or none of the data can be read.
    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading>;
}

/// Samples of some signals of a source, read once into memory; records of these signals then need no second reading.
#[derive(Debug)]
pub struct KeptSource {
    source: Box<dyn Source>,
    requests: Vec<Request>,
    /// Number of the signal, stamp in ns, value or NaN, in the order of reading.
    samples: Vec<(usize, i64, f64)>,
    reading: Reading,
}

impl KeptSource {
    /// Reads the signals, at most `most` samples in total.
    ///
    /// # Errors
    /// Like [`Source::read`].
    pub fn new(source: Box<dyn Source>, requests: Vec<Request>, most: usize) -> Result<Self> {
        let mut samples = Vec::new();
        let mut take = |signal, stamp, value: Option<f64>| {
            samples.push((signal, stamp, value.unwrap_or(f64::NAN)));
            samples.len() < most
        };
        let reading = source.read(&requests, &mut take, &|_| ())?;
        Ok(Self {
            source,
            requests,
            samples,
            reading,
        })
    }
}

impl Source for KeptSource {
    fn name(&self) -> String {
        self.source.name()
    }

    fn sample_time(&self) -> Option<f64> {
        self.source.sample_time()
    }

    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        _progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let mut wanted = vec![None; self.requests.len()];
        for (signal, request) in requests.iter().enumerate() {
            let place = self.requests.iter().position(|it| it == request);
            let unread = || SourceError::Request(format!("'{}' was not read", request.name));
            wanted[place.ok_or_else(unread)?] = Some(signal);
        }
        for (place, stamp, value) in &self.samples {
            let value = Some(*value).filter(|it| !it.is_nan());
            if wanted[*place].is_some_and(|signal| !take(signal, *stamp, value)) {
                break;
            }
        }
        Ok(self.reading.clone())
    }
}
