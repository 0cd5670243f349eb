//! Signals as recorded in a bag, table or log: every sample with its stamp, not resampled.

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

/// Passes every sample of the signals to `take`. For a field that is a list, the first element is prepared unless one is named.
///
/// # Errors
/// If a signal is missing, or none of the data can be read.
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
