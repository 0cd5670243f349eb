//! Identification, model files, and transfer functions of vehicles.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use planesman_fit::declaration::OptionGroup as _;
use planesman_fit::model_file::given;
use planesman_fit::{EquationsFile, FitOptions, Sources};
use planesman_identification::{Reading, Uncertain};
use planesman_linear::TransferFunction;
use planesman_model_file::ModelFile;
use planesman_vehicle::{transfer, vehicle_file};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::array::{array, numbers};
use crate::error::{Watch, raised, released, watched};
use crate::options::{Keyword, Keywords};

/// The file name that errors give a model in memory.
const IN_MEMORY: &str = "model.json";

/// Fits a model by the options of `planesman sysid fit`. Returns its JSON and, for the longest run, the first stamp, the input, the
/// measured and the simulated output. `columns`: data in memory, float64 as bytes. `progress` is called repeatedly.
#[pyfunction]
#[pyo3(signature = (data, options, columns=None, progress=None))]
pub(crate) fn fit<'py>(
    py: Python<'py>,
    data: Vec<PathBuf>,
    options: HashMap<String, Keyword>,
    columns: Option<Vec<(String, PyBackedBytes)>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, i64, Vec<Bound<'py, PyAny>>)> {
    let options = Keywords(options)
        .fit(sources(data, columns))
        .map_err(raised)?;
    let watch = Watch::new(progress);
    let (json, start, run) = watched(py, &watch, || {
        let found = planesman_fit::fit(&options, &())?;
        let run = found.simulated()?;
        let (input, measured) = (run.input.to_vec(), run.measured.to_vec());
        let json = serde_json::to_string(&found.as_json()?)?;
        Ok((json, run.start, [input, measured, run.simulated]))
    })?;
    let run = run.into_iter().map(|it| array(py, it));
    Ok((json, start, run.collect::<PyResult<_>>()?))
}

/// Fits models with several inputs or outputs by the options of `planesman sysid fit`; returns their JSON.
#[pyfunction]
#[pyo3(signature = (data, options, columns=None, progress=None))]
pub(crate) fn fit_several(
    py: Python<'_>,
    data: Vec<PathBuf>,
    options: HashMap<String, Keyword>,
    columns: Option<Vec<(String, PyBackedBytes)>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let options = Keywords(options)
        .fit(sources(data, columns))
        .map_err(raised)?;
    let watch = Watch::new(progress);
    watched(py, &watch, || {
        let found = planesman_fit::fit_several(&options, &())?;
        Ok(serde_json::to_string(&found.as_json()?)?)
    })
}

/// Fits user-written state equations by the options of `planesman sysid fit --equations`; returns their JSON.
#[pyfunction]
#[pyo3(signature = (data, equations, options, columns=None, progress=None))]
pub(crate) fn fit_equations(
    py: Python<'_>,
    data: Vec<PathBuf>,
    equations: PathBuf,
    options: HashMap<String, Keyword>,
    columns: Option<Vec<(String, PyBackedBytes)>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let options = Keywords(options)
        .fit(sources(data, columns))
        .map_err(raised)?;
    let watch = Watch::new(progress);
    watched(py, &watch, || {
        let file = EquationsFile::read(&equations)?;
        let found = planesman_fit::fit_equations(&options, file, &())?;
        Ok(serde_json::to_string(&found.as_json()?)?)
    })
}

/// The data source: files, or columns in memory.
fn sources(data: Vec<PathBuf>, columns: Option<Vec<(String, PyBackedBytes)>>) -> Sources {
    match columns {
        None => Sources::Files(data),
        Some(columns) => {
            let columns = columns.into_iter();
            Sources::Columns(columns.map(|(name, it)| (name, numbers(&it))).collect())
        }
    }
}

/// The names of a fit's options; for an option with few allowed words, these words too.
#[pyfunction]
pub(crate) fn fit_options() -> Vec<(&'static str, Vec<&'static str>)> {
    let options = FitOptions::declarations().into_iter();
    let words = options.map(|it| (it.name, it.kind().words));
    let names = words.map(|(name, words)| (name, words.iter().map(|it| it.name).collect()));
    names.collect()
}

/// Reads a model file and returns its JSON.
#[pyfunction]
pub(crate) fn read_model(path: PathBuf) -> PyResult<String> {
    let model = ModelFile::read(&path).map_err(raised)?;
    serde_json::to_string(&model).map_err(raised)
}

/// Writes a model, given as JSON, to a `*.json` or `*.yaml` file.
#[pyfunction]
pub(crate) fn write_model(model: &str, path: PathBuf) -> PyResult<()> {
    let written = parse(model).and_then(|model| Ok(model.write(&path)?));
    written.map_err(raised)
}

fn parse(model: &str) -> anyhow::Result<ModelFile> {
    Ok(ModelFile::parse(Path::new(IN_MEMORY), model)?)
}

/// The frequency response of a model, given as JSON, at frequencies in rad/s (float64 as bytes). Returns complex values and the
/// standard deviations of magnitude and phase \[rad\]; all are NaN where the response is infinite.
#[pyfunction]
pub(crate) fn response<'py>(
    py: Python<'py>,
    model: &str,
    omega: PyBackedBytes,
) -> PyResult<[Bound<'py, PyAny>; 3]> {
    let (mut values, mut magnitudes, mut phases) = (Vec::new(), Vec::new(), Vec::new());
    released(py, || {
        let estimate = given(&parse(model)?)?.estimate(1)?;
        let reading = Reading::new(&estimate, 0);
        for omega in numbers(&omega) {
            let found = reading.response(omega);
            let or_nan = |of: &dyn Fn(&Uncertain) -> f64| found.as_ref().map_or(f64::NAN, of);
            values.push([or_nan(&|it| it.value.re), or_nan(&|it| it.value.im)]);
            magnitudes.push(or_nan(&Uncertain::magnitude_deviation));
            phases.push(or_nan(&Uncertain::phase_deviation));
        }
        Ok(())
    })?;
    Ok([
        array(py, values)?,
        array(py, magnitudes)?,
        array(py, phases)?,
    ])
}

/// Coefficients of numerator and denominator, highest power first.
type Polynomials = (Vec<f64>, Vec<f64>);

/// A vehicle's transfer function: heading, remarks, the model in s and the model in z.
#[pyfunction]
pub(crate) fn transfer_function(
    vehicle: &str,
    options: HashMap<String, Keyword>,
) -> PyResult<(Vec<String>, Polynomials, Polynomials)> {
    let found = Keywords(options).transfer().and_then(|asked| {
        let vehicle = vehicle_file::load_on(vehicle, &asked.base)?;
        let signals = (asked.input, asked.output);
        Ok(transfer::models(
            &vehicle,
            signals,
            asked.speed,
            asked.rate,
        )?)
    });
    let models = found.map_err(raised)?;
    let of = |it: TransferFunction| (it.num, it.den);
    let mut about = vec![models.heading, models.sampling];
    about.extend(models.remarks);
    Ok((about, of(models.continuous), of(models.sampled)))
}
