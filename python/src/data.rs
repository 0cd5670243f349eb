//! Signals and fields of a bag, table or log.

use std::ffi::OsString;

use planesman::sysid::samples::{self as command, SamplesArgs};
use planesman::sysid::topics::{self, TopicsArgs};
use pyo3::prelude::*;

use crate::array::array;
use crate::error::{parsed, raised, released};
use crate::words::in_python;

/// Stamps, ns, and numbers.
type Pair<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Every sample of the signals: stamps (int64, ns) and numbers (float64, NaN where there is none) of each, in the order of the
/// data, and notes on what could not be read.
#[pyfunction]
pub(crate) fn samples(
    py: Python<'_>,
    args: Vec<OsString>,
) -> PyResult<(Vec<Pair<'_>>, Vec<String>)> {
    let args: SamplesArgs = parsed(&args)?;
    let (signals, notes) = released(py, || {
        let mut signals = vec![(Vec::new(), Vec::new()); args.signals().len()];
        let reading = command::read(&args, &mut |signal, stamp, value| {
            let (stamps, values): &mut (Vec<i64>, Vec<f64>) = &mut signals[signal];
            stamps.push(stamp);
            values.push(value.unwrap_or(f64::NAN));
            true
        });
        Ok((signals, reading?.notes))
    })?;
    let notes = notes.iter().map(|note| in_python(note)).collect();
    let arrays = signals
        .into_iter()
        .map(|(stamps, values)| Ok((array(py, stamps)?, array(py, values)?)));
    Ok((arrays.collect::<PyResult<_>>()?, notes))
}

/// Every numeric field, with rate, gaps and range, as JSON.
#[pyfunction]
pub(crate) fn fields(py: Python<'_>, args: Vec<OsString>) -> PyResult<String> {
    let args: TopicsArgs = parsed(&args)?;
    let survey = released(py, || topics::survey(&args))?;
    serde_json::to_string(&survey).map_err(raised)
}
