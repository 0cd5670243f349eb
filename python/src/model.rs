//! Identification, model files, and a vehicle's transfer functions.

use std::path::{Path, PathBuf};

use clap::{CommandFactory as _, Parser};
use numpy::{Complex64, IntoPyArray, PyArray1, PyReadonlyArray1};
use planesman::sysid::fit::{self as command, FitArgs};
use planesman::sysid::model_file::given;
use planesman::sysid::simulated::Simulated;
use planesman::tf_command::{self, TfArgs};
use planesman_identification::Reading;
use planesman_linear::TransferFunction;
use planesman_model_file::ModelFile;
use pyo3::prelude::*;

use crate::error::{parsed, raised, released};

type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// The name by which a model that is in memory is refused.
const IN_MEMORY: &str = "model.json";

/// A model by the arguments of `planesman sysid fit`: its JSON, and of the longest run the first stamp, input, measured and
/// simulated output. With columns in memory they are the data.
#[pyfunction]
#[pyo3(signature = (args, columns=None))]
pub(crate) fn fit<'py>(
    py: Python<'py>,
    args: Vec<String>,
    columns: Option<Vec<(String, PyReadonlyArray1<'py, f64>)>>,
) -> PyResult<(String, i64, [Numbers<'py>; 3])> {
    let mut args: FitArgs = parsed(&args)?;
    if let Some(columns) = columns {
        let copied = columns
            .into_iter()
            .map(|(name, numbers)| (name, numbers.as_array().to_vec()));
        args = args.of_columns(copied.collect());
    }
    let (json, start, run) = released(py, || {
        let found = command::fit(&args)?;
        let record = &found.taken.resampled.record;
        let run = Simulated::of(&found.analysis, record)?;
        let (input, measured) = (run.input.to_vec(), run.measured.to_vec());
        let json = serde_json::to_string(&found.as_json()?)?;
        Ok((json, run.start, [input, measured, run.simulated]))
    })?;
    Ok((json, start, run.map(|it| it.into_pyarray(py))))
}

/// The options of `planesman sysid fit` by their names, with the values that are possible where there are few.
#[pyfunction]
pub(crate) fn fit_options() -> Vec<(String, Vec<String>)> {
    let command = FitArgs::command();
    let options = command.get_arguments().filter_map(|it| {
        let values = it.get_possible_values();
        let values = values.iter().map(|value| value.get_name().to_owned());
        Some((it.get_long()?.replace('-', "_"), values.collect()))
    });
    options.collect()
}

/// A model file, as JSON.
#[pyfunction]
pub(crate) fn read_model(path: PathBuf) -> PyResult<String> {
    let model = ModelFile::read(&path).map_err(|error| raised(error.into()))?;
    serde_json::to_string(&model).map_err(|error| raised(error.into()))
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

/// The frequency response of a model, given as JSON, at frequencies in rad/s: complex values, and the standard deviations of
/// magnitude and of phase (rad). NaN where it has no bound.
#[pyfunction]
pub(crate) fn response<'py>(
    py: Python<'py>,
    model: &str,
    omega: PyReadonlyArray1<'py, f64>,
) -> PyResult<(Bound<'py, PyArray1<Complex64>>, Numbers<'py>, Numbers<'py>)> {
    let omega = omega.as_array().to_vec();
    let (values, deviations) = released(py, || {
        let estimate = given(&parse(model)?).estimate(1)?;
        let reading = Reading::of(&estimate, 0);
        let at = |omega: &f64| match reading.response(*omega) {
            Some(it) => {
                let value = Complex64::new(it.value.re, it.value.im);
                (value, (it.magnitude_deviation(), it.phase_deviation()))
            }
            None => (Complex64::new(f64::NAN, f64::NAN), (f64::NAN, f64::NAN)),
        };
        Ok(omega.iter().map(at).unzip::<_, _, Vec<_>, Vec<_>>())
    })?;
    let (magnitude, phase): (Vec<f64>, Vec<f64>) = deviations.into_iter().unzip();
    Ok((
        values.into_pyarray(py),
        magnitude.into_pyarray(py),
        phase.into_pyarray(py),
    ))
}

#[derive(Parser)]
struct Tf {
    #[command(flatten)]
    args: TfArgs,
}

/// Numerator and denominator, from the highest power.
type Polynomials = (Vec<f64>, Vec<f64>);

/// A vehicle's transfer function by the arguments of `planesman tf`: heading and remarks, the model in s and that in z.
#[pyfunction]
pub(crate) fn transfer_function(
    args: Vec<String>,
) -> PyResult<(Vec<String>, Polynomials, Polynomials)> {
    let Tf { args } = parsed(&args)?;
    let models = tf_command::models(&args).map_err(raised)?;
    let of = |it: TransferFunction| (it.num, it.den);
    let mut about = vec![models.heading, models.sampling];
    about.extend(models.remarks);
    Ok((about, of(models.continuous), of(models.sampled)))
}
