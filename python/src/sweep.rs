//! The cases of a sweep, simulated part by part.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use planesman_flight::scenario::Scenario;
use planesman_flight::sweep::{self, Case, Kind, Part};
use planesman_identification::{on_all_cores, stop_point};
use pyo3::prelude::*;

use crate::array::array;
use crate::error::{Watch, raised, released, watched};

/// The cases of a scenario with the given `--vary`, `--samples` and `--seeds`.
#[pyclass(frozen, module = "planesman._native")]
pub(crate) struct Sweep(sweep::Sweep);

#[pymethods]
impl Sweep {
    #[new]
    fn new(scenario: &str, vary: Vec<String>, samples: Option<u32>, seeds: u32) -> PyResult<Self> {
        let sweep = Scenario::parse(scenario)
            .and_then(|scenario| sweep::Sweep::new(scenario, &vary, samples, seeds));
        Ok(Self(sweep.map_err(raised)?))
    }

    /// Checks every combination as the nodes do at their start.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        released(py, || Ok(self.0.check(&())?))
    }

    /// The number of combinations of values; each is simulated with every seed.
    fn combinations(&self) -> u64 {
        self.0.combinations()
    }

    /// The number of cases in part `part` of `of` parts.
    fn cases(&self, part: u64, of: u64) -> u64 {
        self.0.cases(Part { part, of })
    }

    /// Creates the folder of `parts` parts, with a description of the sweep.
    fn define(&self, folder: PathBuf, parts: u64) -> PyResult<()> {
        self.0.define(&folder, Some(parts)).map_err(raised)
    }

    /// Simulates part `part` of `of` parts. Returns the columns by name, with one row per case: numbers as float64 (NaN if missing),
    /// `case` and `seed` as int64, words as a list. `progress` is called repeatedly with the number of completed cases.
    #[pyo3(signature = (part, of, all_cores, progress=None))]
    fn fly<'py>(
        &self,
        py: Python<'py>,
        part: u64,
        of: u64,
        all_cores: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let part = Part { part, of };
        let watch = Watch::new(progress);
        let cases = watched(py, &watch, || {
            let places: Vec<u64> = (0..self.0.cases(part)).collect();
            let case = |place: &u64| {
                stop_point();
                let case = self.0.case(part, *place);
                watch.done.fetch_add(1, Ordering::Relaxed);
                case
            };
            let flown: planesman_flight::Result<Vec<_>> = match all_cores {
                true => on_all_cores(&places, case).into_iter().collect(),
                false => places.iter().map(case).collect(),
            };
            Ok(flown?)
        })?;
        columns(py, self.0.columns(), &cases)
    }
}

/// The cases column by column: number, values, seed, numbers, error.
fn columns<'py>(
    py: Python<'py>,
    names: Vec<(String, Kind)>,
    cases: &[Case],
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let axes = cases.first().map_or(0, |case| case.values.len());
    let whole = |of: &dyn Fn(&Case) -> i64| {
        let numbers: Vec<i64> = cases.iter().map(of).collect();
        array(py, numbers)
    };
    let number = |of: &dyn Fn(&Case) -> f64| {
        let numbers: Vec<f64> = cases.iter().map(of).collect();
        array(py, numbers)
    };
    let text = |of: &dyn Fn(&Case) -> &str| {
        let words: Vec<&str> = cases.iter().map(of).collect();
        words.into_pyobject(py)
    };
    let last = names.len() - 1;
    let column = |(place, (name, kind)): (usize, (String, Kind))| {
        let column = match (place, kind) {
            (0, _) => whole(&|it| it.number as i64)?,
            (place, Kind::Text) if place == last => text(&|it| &it.error)?,
            (place, Kind::Text) => text(&|it| &it.values[place - 1])?,
            (place, Kind::Number) if place <= axes => {
                number(&|it| it.values[place - 1].parse().unwrap_or(f64::NAN))?
            }
            (_, Kind::Whole) => whole(&|it| i64::from(it.seed))?,
            (place, Kind::Number) => {
                number(&|it| it.numbers[place - axes - 2].unwrap_or(f64::NAN))?
            }
        };
        Ok((name, column))
    };
    names.into_iter().enumerate().map(column).collect()
}
