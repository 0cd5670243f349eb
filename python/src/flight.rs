//! Scenarios, and their flight in this process.

use std::path::{Path, PathBuf};

use planesman_flight::compose::Loop;
use planesman_flight::scenario::Scenario;
use planesman_flight::sink::{COLUMNS, McapSink};
use pyo3::prelude::*;

use crate::array::array;
use crate::error::{raised, released};

/// A column of the table of a flight.
type Column<'py> = (&'static str, Bound<'py, PyAny>);

/// The text of a scenario with these changes, checked as the nodes would. `given` is a name, a path, or the text itself.
#[pyfunction]
pub(crate) fn scenario(
    given: &str,
    is_text: bool,
    changes: Vec<String>,
    duration: Option<f64>,
    tick: Option<f64>,
    seed: Option<u32>,
) -> PyResult<String> {
    let loaded = match is_text {
        true => Scenario::parse_with(given, Path::new(""), &changes, "scenario"),
        false => Scenario::load_with(given, &changes),
    };
    let timed = loaded.and_then(|it| it.timed(duration, tick, seed));
    Ok(timed.map_err(raised)?.to_yaml())
}

/// Flies a scenario: each column of the table of a flight, `NAME [UNIT]`, a number a tick. With `bag` every message too, in
/// one MCAP file.
#[pyfunction]
pub(crate) fn fly<'py>(
    py: Python<'py>,
    scenario: &str,
    bag: Option<PathBuf>,
    namespace: &str,
) -> PyResult<Vec<Column<'py>>> {
    let columns = released(py, || {
        let scenario = Scenario::parse(scenario)?;
        let ticks = scenario.ticks() as usize;
        let mut columns = vec![Vec::with_capacity(ticks); COLUMNS.len()];
        let mut sink = bag
            .map(|path| McapSink::create(&path, namespace))
            .transpose()?;
        for tick in Loop::new(&scenario)? {
            let tick = tick?;
            for (column, (_, of)) in columns.iter_mut().zip(COLUMNS) {
                column.push(of(&tick));
            }
            if let Some(sink) = &mut sink {
                tick.put_into(sink)?;
            }
        }
        sink.map(McapSink::finish).transpose()?;
        Ok(columns)
    })?;
    let named = COLUMNS.iter().zip(columns);
    named
        .map(|((name, _), numbers)| Ok((*name, array(py, numbers)?)))
        .collect()
}
