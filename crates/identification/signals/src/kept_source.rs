//! Samples of some signals of a source, read once, so that records of any of them are made without reading again.

use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Take};
use crate::source::Source;

/// Samples of a source in memory.
#[derive(Debug)]
pub struct KeptSource {
    pub(crate) source: Source,
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
    pub fn new(source: Source, requests: Vec<Request>, most: usize) -> Result<Self> {
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

    /// Hands the samples of the signals to `take`.
    pub(crate) fn read(&self, requests: &[Request], take: &mut Take<'_>) -> Result<Reading> {
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
