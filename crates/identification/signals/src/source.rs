//! What hands out samples: a bag, tables, a log of a vehicle, columns in memory.
//!
//! All stream: a sample is handed on as it is read and forgotten. What cannot be read does not
//! end the rest; it is listed in [`Reading::notes`].

use std::fmt::Debug;

use planesman_bag::BagReader;

use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Take};

/// A topic of a source and its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceTopic {
    /// Its name; a table's is its file.
    pub name: String,
    /// The kind of its messages; empty for a table.
    pub type_name: &'static str,
    /// One for each field, in the order in which a message has them.
    pub requests: Vec<Request>,
}

/// An open source of samples.
pub trait Source: Debug {
    /// Its files, for people.
    fn name(&self) -> String;

    /// Bytes to be read.
    fn bytes(&self) -> u64 {
        0
    }

    /// Seconds from sample to sample, where the data has no time and they were given.
    fn sample_time(&self) -> Option<f64> {
        None
    }

    /// Whether the data tells the time of its samples, or the interval between them was given.
    fn has_time(&self) -> bool {
        true
    }

    /// Sets rows a second apart, where nothing is known of their time.
    fn count_rows(&mut self) {}

    /// The bag that it reads; its topics are listed there.
    fn bag(&self) -> Option<&BagReader> {
        None
    }

    /// Its topics; empty for a bag.
    fn topics(&self) -> Vec<SourceTopic> {
        Vec::new()
    }

    /// Its tables, where it has several and each has all of these signals: each is then an experiment of its own.
    fn experiments(&self, _signals: &[String]) -> Vec<Box<dyn Source>> {
        Vec::new()
    }

    /// Hands every sample of the signals to `take`; `progress` is called with the bytes read.
    ///
    /// # Errors
    /// One line: a signal that is not there, or data of which nothing can be read.
    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading>;
}

/// Samples of some signals of a source in memory: read once, so that records of any of them are made without reading again.
#[derive(Debug)]
pub struct KeptSource {
    source: Box<dyn Source>,
    requests: Vec<Request>,
    /// Number of the signal, stamp in ns, value or NaN, in the order in which they were read.
    samples: Vec<(usize, i64, f64)>,
    reading: Reading,
}

impl KeptSource {
    /// Reads the signals, `most` samples of all together.
    ///
    /// # Errors
    /// As [`Source::read`].
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
