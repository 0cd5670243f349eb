//! Signals as they lie in a bag, table or log: every sample with its stamp, on no grid.

use planesman_parallel::stop_point;
use planesman_signals::{Reading, Request, Take};

use crate::data::DataOptions;
use crate::error::FitError;

/// The signals of some data.
#[derive(Clone, Debug, Default)]
pub struct SamplesOptions {
    /// The data.
    pub data: DataOptions,
    /// Each signal: `TOPIC:FIELD`, or a column.
    pub signals: Vec<String>,
}

/// Hands every sample of the signals to `take`. Of a field that is a list the first element is prepared, unless one is named.
///
/// # Errors
/// A signal that is not there, or data of which nothing can be read.
pub fn samples(options: &SamplesOptions, take: &mut Take<'_>) -> Result<Reading, FitError> {
    if options.signals.is_empty() {
        return Err(FitError::NoSignal);
    }
    let requests: Vec<Request> = options.signals.iter().map(Request::output).collect();
    let reading = options
        .data
        .open()?
        .read(&requests, take, &|_| stop_point());
    reading.map_err(FitError::data)
}
