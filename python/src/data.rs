//! Signals and fields of a bag, table or log.

use std::collections::HashMap;
use std::path::PathBuf;

use planesman_fit::{SamplesOptions, Sources, survey};
use pyo3::prelude::*;

use crate::array::array;
use crate::error::{raised, released};
use crate::options::{Keyword, Keywords};

/// Stamps \[ns\] and values of a signal.
type Pair<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Reads every sample of the signals. Each signal has stamps (int64, ns) and numbers (float64, NaN for a missing number), in the
/// order of the data. Also returns notes on unreadable data.
#[pyfunction]
pub(crate) fn samples(
    py: Python<'_>,
    data: Vec<PathBuf>,
    signals: Vec<String>,
    options: HashMap<String, Keyword>,
) -> PyResult<(Vec<Pair<'_>>, Vec<String>)> {
    let data = Keywords(options).only_data(Sources::Files(data));
    let data = data.map_err(raised)?;
    let mut read = vec![(Vec::new(), Vec::new()); signals.len()];
    let options = SamplesOptions { data, signals };
    let (read, notes) = released(py, || {
        let reading = planesman_fit::samples(&options, &mut |signal, stamp, value| {
            let (stamps, values): &mut (Vec<i64>, Vec<f64>) = &mut read[signal];
            stamps.push(stamp);
            values.push(value.unwrap_or(f64::NAN));
            true
        });
        let notes = reading?.notes;
        Ok((read, notes))
    })?;
    let arrays = read
        .into_iter()
        .map(|(stamps, values)| Ok((array(py, stamps)?, array(py, values)?)));
    Ok((arrays.collect::<PyResult<_>>()?, notes))
}

/// Whether a file is a bag, a table or a log, judged by the ending of its name.
#[pyfunction]
pub(crate) fn is_data(path: PathBuf) -> bool {
    planesman_fit::is_data(&path)
}

/// Lists every numeric field of the topics whose name contains `topic`, with rate, gaps and range, as JSON.
#[pyfunction]
pub(crate) fn fields(
    py: Python<'_>,
    data: Vec<PathBuf>,
    topic: Option<&str>,
    options: HashMap<String, Keyword>,
) -> PyResult<String> {
    let data = Keywords(options).only_data(Sources::Files(data));
    let data = data.map_err(raised)?;
    let survey = released(py, || Ok(survey(&data, topic, &())?))?;
    serde_json::to_string(&survey).map_err(raised)
}
