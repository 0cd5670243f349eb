//! Validates model files from any source on data and compares them.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use planesman_identification::validation::residuals::{Correlation, ResidualTests};
use planesman_identification::{Judgement, Reading, Uncertain};
use planesman_linear::{ComplexFunctions as _, unwrapped_phases};
use planesman_model_file::ModelFile;
use planesman_parallel::Progress;
use planesman_signals::PreparedRecord;

use crate::data::DataOptions;
use crate::error::FitError;
use crate::model_file;
use crate::options::{GridOptions, PreparationOptions, SignalOptions};
use crate::record::Expected;
use crate::rules::check_ahead;

/// Number of frequencies in a response.
const FREQUENCIES: usize = 200;

/// The options of [`compare`].
///
/// Each field is the option of the same name of `planesman sysid compare`; docs/sysid.md explains them.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// The models, each with its file's path or any other name.
    pub models: Vec<(PathBuf, ModelFile)>,
    /// The data.
    pub data: DataOptions,
    /// The input signal; `None` to use the models' input.
    pub input: Option<String>,
    /// The output signal; `None` to use the models' output.
    pub output: Option<String>,
    /// The grid; without a rate, the grid of the first model.
    pub grid: GridOptions,
    /// Preparation of the record.
    pub preparation: PreparationOptions,
    /// Prediction horizons in samples, 1 to 1000 each.
    pub ahead: Vec<usize>,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            models: Vec::new(),
            data: DataOptions::default(),
            input: None,
            output: None,
            grid: GridOptions::default(),
            preparation: PreparationOptions::default(),
            ahead: vec![1, 10],
        }
    }
}

/// Models validated on one record.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The record, and how it was prepared.
    pub prepared: PreparedRecord,
    /// The models, in the given order.
    pub models: Vec<Compared>,
}

/// A model and its judgement.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Name of the model in the tables.
    pub name: String,
    /// The method that estimated the model.
    pub method: String,
    /// The model's performance on the data.
    pub judgement: Judgement,
}

/// Reads the data and validates the models on it. `progress` receives the progress.
///
/// # Errors
/// If models have different signals, the data lacks a signal, or a model has another sampling interval.
pub fn compare(options: &CompareOptions, progress: &dyn Progress) -> Result<Comparison, FitError> {
    let models = &options.models;
    let (path, first) = models.first().ok_or(FitError::NoModel)?;
    check_ahead(&options.ahead)?;
    let signals = SignalOptions {
        input: signal(models, options.input.as_ref(), "input", |it| &it.input)?,
        output: signal(models, options.output.as_ref(), "output", |it| &it.output)?,
        grid: options.grid.clone(),
        preparation: options.preparation,
        ..SignalOptions::default()
    };
    signals.check()?;
    let prepared = options.read(&signals, path, first.sample_time, progress)?;
    let paths: Vec<PathBuf> = models.iter().map(|it| it.0.clone()).collect();
    let judged = |(path, file): &(PathBuf, ModelFile)| {
        let refused = |reason| FitError::Curve {
            model: path.clone(),
            reason,
        };
        let model = model_file::given(file).map_err(refused)?;
        let judgement = model.on(&prepared.resampled.record, &options.ahead);
        Ok(Compared {
            name: name(path, &paths),
            method: file.method.clone(),
            judgement: judgement.map_err(|source| FitError::Judgement {
                model: path.clone(),
                rate: 1.0 / file.sample_time,
                source,
            })?,
        })
    };
    let judged: Result<_, FitError> = models.iter().map(judged).collect();
    Ok(Comparison {
        models: judged?,
        prepared,
    })
}

impl CompareOptions {
    /// The signals, resampled to the grid of a model.
    pub(crate) fn read(
        &self,
        signals: &SignalOptions,
        model: &Path,
        sample_time: f64,
        progress: &dyn Progress,
    ) -> Result<PreparedRecord, FitError> {
        let read = |grid: GridOptions| {
            let grid = grid.at_rate(1.0 / sample_time);
            let record = signals.record(&self.data, &grid, Expected::ANY, false, progress);
            record.map_err(|source| FitError::Grid {
                model: model.to_owned(),
                sample_time,
                source: Box::new(source),
            })
        };
        let prepared = read(self.grid.clone())?;
        // A model of decimated data is of means.
        match self.grid.averaged_where_decimated(&prepared) {
            Some(averaged) => read(averaged),
            None => Ok(prepared),
        }
    }
}

/// The requested signal, or else the signal named in the models.
fn signal(
    models: &[(PathBuf, ModelFile)],
    asked: Option<&String>,
    option: &'static str,
    of: fn(&ModelFile) -> &String,
) -> Result<String, FitError> {
    let own = |(path, file): &(PathBuf, ModelFile)| (path.clone(), of(file).clone());
    let first = models.first().map(own).ok_or(FitError::NoModel)?;
    match (asked, models.iter().find(|(_, file)| *of(file) != first.1)) {
        (Some(name), _) => Ok(name.clone()),
        (None, None) => Ok(first.1),
        (None, Some(other)) => Err(FitError::Signals {
            option,
            first,
            other: own(other),
        }),
    }
}

/// The shortest unique name: the file's name without folder and ending, or its path if two are equal.
pub(crate) fn name(path: &Path, paths: &[PathBuf]) -> String {
    let same = |it: &&PathBuf| it.file_stem() == path.file_stem();
    match paths.iter().filter(same).count() {
        1 => path.file_stem().unwrap_or_default().display().to_string(),
        _ => path.display().to_string(),
    }
}

impl Compared {
    /// The model's numbers, with their standard errors.
    #[must_use]
    pub fn reading(&self) -> Reading<'_> {
        Reading::new(&self.judgement.estimate, self.judgement.longest)
    }

    /// Its delay, samples.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.judgement.estimate.layout.structure.delay
    }

    /// The poles in s, slowest first; of a conjugate pair only the pole with positive imaginary part.
    #[must_use]
    pub fn poles(&self) -> Vec<Uncertain> {
        let mut poles = self.reading().continuous_poles().unwrap_or_default();
        poles.retain(|pole| pole.value.im >= 0.0);
        poles.sort_by(|p, q| p.value.modulus().total_cmp(&q.value.modulus()));
        poles
    }

    /// The tests of the residual: the tested property and the correlations.
    #[must_use]
    pub fn tests(&self) -> Vec<(&'static str, Correlation)> {
        let tests = self.judgement.residuals.iter();
        tests.flat_map(ResidualTests::each).collect()
    }
}

/// A frequency response at one frequency.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// The frequency, rad/s.
    pub omega: f64,
    /// Output unit per input unit.
    pub value: Uncertain,
    /// The phase, unwrapped from the lowest frequency on, degrees.
    pub phase: f64,
}

impl Response {
    /// The magnitude plus `sigmas` standard deviations, dB.
    #[must_use]
    pub fn magnitude(&self, sigmas: f64) -> f64 {
        let size = self.value.value.modulus();
        let size = (size + sigmas * self.value.magnitude_deviation()).max(1e-3 * size);
        20.0 * libm::log10(size.max(1e-12))
    }
}

/// The response at frequencies from 1/3000 of the Nyquist frequency up to the Nyquist frequency. Frequencies are left out if the response is 0 there
/// or has no bound.
#[must_use]
pub fn frequency_response(reading: &Reading<'_>, sample_time: f64) -> Vec<Response> {
    let nyquist = PI / sample_time;
    let responses: Vec<(f64, Uncertain)> = (0..FREQUENCIES)
        .map(|i| nyquist * libm::pow(10f64, -3.5 * (1.0 - i as f64 / (FREQUENCIES - 1) as f64)))
        .filter_map(|omega| Some((omega, reading.response(omega)?)))
        .filter(|(_, it)| it.value.modulus() > 0.0)
        .collect();
    let phases = unwrapped_phases(responses.iter().map(|(_, it)| it.value));
    let each = responses.into_iter().zip(phases);
    each.map(|((omega, value), phase)| Response {
        omega,
        value,
        phase: phase.to_degrees(),
    })
    .collect()
}

/// The frequency response of each model; all phases begin within half a turn of the first model's.
#[must_use]
pub fn frequency_responses(models: &[Compared]) -> Vec<Vec<Response>> {
    let mut first: Option<f64> = None;
    models
        .iter()
        .map(|model| {
            let sample_time = model.judgement.estimate.sample_time;
            let mut responses = frequency_response(&model.reading(), sample_time);
            if let Some(begins) = responses.first().map(|it| it.phase) {
                let turns = ((begins - *first.get_or_insert(begins)) / 360.0).round();
                responses
                    .iter_mut()
                    .for_each(|it| it.phase -= 360.0 * turns);
            }
            responses
        })
        .collect()
}
