//! Fits a model to data, with uncertainty, tests and a verdict.

use planesman_text::setting;
use std::time::Instant;

use planesman_identification::IdentificationError;
use planesman_identification::analysis::{
    Analysis, Options, Reason, Verdict, analyse, analyse_validated,
};
use planesman_identification::estimators::Method;
use planesman_identification::selection::Candidate;
use planesman_identification::static_curve::Side;
use planesman_model_file::ModelFile;
use planesman_parallel::Progress;
use planesman_signals::{Channel, PreparedRecord, Reading};
use serde_json::{Value, json};

use crate::error::FitError;
use crate::model_file;
use crate::options::{FitOptions, MethodChoice, Validation};
use crate::record::Expected;
use crate::response;
use crate::simulated::Simulated;
use crate::trial::{Trial, ranked};

/// An input with this many samples per grid interval moves between the grid points. The record does not contain these times, so the delay is known to one
/// sample at best.
const FASTER: f64 = 1.5;

/// A model and its record.
#[derive(Debug)]
pub struct FitResult {
    /// The record, and how it was prepared.
    pub prepared: PreparedRecord,
    /// The validation record, if one was given.
    pub validation: Option<PreparedRecord>,
    /// The model with its uncertainty, tests and verdict.
    pub analysis: Analysis,
    /// All tried methods, if all were requested.
    pub tried: Vec<Trial>,
}

/// The data of a fit, read once to fit several models.
#[derive(Clone, Debug)]
pub struct FitData {
    /// The record, and how it was prepared.
    pub prepared: PreparedRecord,
    /// The validation record, if one was given.
    pub validation: Option<PreparedRecord>,
}

/// Reads the data and identifies the model. `progress` receives the progress.
///
/// # Errors
/// If options conflict, the vehicle is invalid, the data cannot be read, or the record does not determine a model.
pub fn fit(options: &FitOptions, progress: &dyn Progress) -> Result<FitResult, FitError> {
    let data = FitData::read(options, progress)?;
    let (analysis, tried) = data.analysed(options, progress)?;
    data.result(options, analysis, tried)
}

impl FitData {
    /// Reads the data.
    ///
    /// # Errors
    /// If options conflict, the vehicle is invalid, or the data cannot be read.
    pub fn read(options: &FitOptions, progress: &dyn Progress) -> Result<Self, FitError> {
        // Refused before anything is read.
        options.check()?;
        if options.signals.are_several() {
            return Err(FitError::Several);
        }
        if let MethodChoice::One(method) = options.method {
            options.analysis(method)?;
        }
        let (prepared, validation) = options.read(progress)?;
        Ok(Self {
            prepared,
            validation,
        })
    }

    /// Fits a model by the requested method.
    ///
    /// # Errors
    /// If options conflict, or the record does not determine a model.
    pub fn fit(
        &self,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<FitResult, FitError> {
        let (analysis, tried) = self.analysed(options, progress)?;
        self.clone().result(options, analysis, tried)
    }

    fn analysed(
        &self,
        options: &FitOptions,
        progress: &dyn Progress,
    ) -> Result<(Analysis, Vec<Trial>), FitError> {
        let record = &self.prepared.resampled.record;
        let analyse = |options: &Options| match &self.validation {
            None => analyse(record, options),
            Some(validation) => analyse_validated(record, options, &validation.resampled.record),
        };
        match options.method {
            MethodChoice::One(method) => {
                let options = options.analysis(method)?;
                progress.begin("models", 0, 0);
                let analysis = analyse(&options);
                progress.end();
                Ok((analysis?, Vec::new()))
            }
            MethodChoice::All => {
                let tried = options.try_all(&analyse, progress);
                let best = ranked(&tried).first().and_then(|it| it.found().cloned());
                Ok((best.ok_or(FitError::NoMethod)?, tried))
            }
        }
    }

    fn result(
        self,
        options: &FitOptions,
        analysis: Analysis,
        tried: Vec<Trial>,
    ) -> Result<FitResult, FitError> {
        let mut result = FitResult {
            prepared: self.prepared,
            validation: self.validation,
            analysis,
            tried,
        };
        if result.analysis.search.lines.is_some()
            && let Some(means) = options.signals.means_of_motion()?
        {
            let told = format!(
                "the signal {means} contains the mean over each interval, which needs no assumption: {}",
                setting("input", &means)
            );
            result.analysis.reasons.insert(0, Reason::Data(told));
        }
        result.judge_clock();
        Ok(result)
    }
}

impl FitOptions {
    /// The record to fit, and the validation record.
    pub(crate) fn read(
        &self,
        progress: &dyn Progress,
    ) -> Result<(PreparedRecord, Option<PreparedRecord>), FitError> {
        let signals = &self.signals;
        let ways = match self.validation {
            Some(Validation::Window(from, to)) => signals.grid.outside((from, to))?,
            _ => vec![signals.grid.clone()],
        };
        let expected = Expected {
            prewindow: self.structure.zeros_in_front(),
            at_rest: self.structure.at_rest,
            is_static: self.structure.order == Some(0),
            is_simulated: false,
        };
        // A named method is given the data as it is.
        let automatic = MethodChoice::One(Method::Automatic);
        let decimate = [MethodChoice::All, automatic].contains(&self.method);
        let record = |grid| signals.record(&signals.data, grid, expected, decimate, progress);
        let mut found = ways.iter().map(record);
        let prepared = match found.next().ok_or(FitError::NoData)? {
            Ok(prepared) => prepared,
            Err(reason) => found.find_map(Result::ok).ok_or(reason)?,
        };
        let validation = self.validation.as_ref();
        let validation = validation.map(|given| signals.validation(given, &prepared, progress));
        Ok((prepared, validation.transpose()?))
    }

    /// Every method.
    fn try_all(
        &self,
        analyse: &dyn Fn(&Options) -> Result<Analysis, IdentificationError>,
        progress: &dyn Progress,
    ) -> Vec<Trial> {
        let methods = self.tried();
        progress.begin("methods", methods.len() as u64, 0);
        let tried = methods.into_iter().map(|method| {
            let start = Instant::now();
            let options = self.analysis(method);
            let outcome = options.and_then(|options| Ok(analyse(&options)?));
            progress.step();
            Trial {
                method,
                outcome,
                seconds: start.elapsed().as_secs_f64(),
            }
        });
        let tried = tried.collect();
        progress.end();
        tried
    }
}

impl FitResult {
    /// Adds findings about the clock to the verdict.
    fn judge_clock(&mut self) {
        let readings = std::iter::once(&self.prepared).chain(&self.validation);
        let readings: Vec<_> = readings.map(|it| &it.reading).collect();
        self.analysis.reasons.splice(0..0, data_warnings(&readings));
        self.analysis.verdict = downgrade_verdict(&readings, self.analysis.verdict);
        let resampled = &self.prepared.resampled;
        let rate = 1.0 / resampled.record.sample_time;
        let is_faster = |it: &Channel| it.timing.rate() > FASTER * rate;
        if resampled.inputs.first().is_some_and(is_faster)
            && let Some(lag) = &mut self.analysis.lag
        {
            lag.interval = (lag.interval.0 - 1, lag.interval.1 + 1);
        }
    }

    /// The output of `--json`, without the information on the record.
    ///
    /// # Errors
    /// Same as [`FitResult::model_file`].
    pub fn as_json(&self) -> Result<Value, FitError> {
        let Self {
            prepared,
            validation,
            analysis,
            tried,
        } = self;
        let sample_time = prepared.resampled.record.sample_time;
        let named = |(name, value, deviation): (&str, f64, f64)| json!({"name": name, "value": value, "deviation": deviation});
        let physical: Vec<Value> = analysis
            .physical()
            .iter()
            .flat_map(|it| {
                let by_inertia = analysis
                    .options
                    .inertia
                    .map(|inertia| it.with_inertia(inertia));
                it.named()
                    .into_iter()
                    .chain(by_inertia.into_iter().flatten())
            })
            .map(named)
            .collect();
        let process = analysis.estimate.process.as_ref();
        let of_process = process.into_iter().flat_map(|it| it.named());
        let of_process =
            of_process.map(|(name, _, value, deviation)| named((name, value, deviation)));
        let of_frequency = analysis.estimate.frequency.iter();
        let of_frequency = of_frequency.flat_map(|it| {
            let named = it.named();
            named.map(|(name, value, deviation)| json!({"name": name, "value": value, "deviation": deviation}))
        });
        let parameters = physical.into_iter().chain(of_process).chain(of_frequency);
        let parameters: Vec<Value> = parameters.collect();
        let processes = analysis.search.processes.iter().map(|it| {
            json!({"form": it.form.name(), "at_rest": it.is_at_rest, "sought": it.parameters, "bic": it.bic})
        });
        let found = json!({
            "model": self.model_file()?,
            "parameters": parameters,
            "curve": analysis.curved.as_ref().map(|it| json!({
                "side": match it.side { Side::Input => "input", Side::Output => "output" },
                "kind": it.fitted.curve.name(),
                "parameters": it.fitted.named().map(|(name, value, deviation)| json!({"name": name, "value": value, "deviation": deviation})).collect::<Vec<_>>(),
                "linear_fit": it.linear_fit,
            })),
            "processes": processes.collect::<Vec<_>>(),
            "process_fit": analysis.search.process_fit,
            "frequency": analysis.estimate.frequency.as_ref().map(|it| response::as_json(it, sample_time)),
            "candidates": analysis.search.candidates,
            "selected": analysis.search.selected.iter().map(selected).collect::<Vec<_>>(),
            "attainable_fit": analysis.held_out.attainable,
            "offsets": (0..analysis.segments.len()).map(|run| analysis.estimate.offset(run)).collect::<Vec<_>>(),
            "predicted_fit": analysis.predicted_fit,
            "share_of_input": analysis.input_part.map(|it| it.share),
            "f_of_input": analysis.input_part.map(|it| it.f),
            "integrator_gain": analysis.reading().integrator_gain().map(|(gain, _)| [gain.value.re, gain.real_deviation()]),
            "delay": analysis.lag.map(|it| json!({"best": it.best, "interval": it.interval})),
            "bootstrap": analysis.bootstrap,
            "residuals": analysis.residuals,
            "methods": tried.iter().map(Trial::as_json).collect::<Vec<_>>(),
        });
        Ok(with_data(found, prepared, validation.as_ref()))
    }

    /// The model as a file that other programs load.
    ///
    /// # Errors
    /// If poles or zeros cannot be computed.
    pub fn model_file(&self) -> Result<ModelFile, FitError> {
        Ok(ModelFile {
            preparation: self
                .prepared
                .steps
                .iter()
                .map(|it| it.text.clone())
                .collect(),
            ..model_file::from_analysis(&self.analysis)?
        })
    }

    /// The frequency response as CSV text, if the method has one.
    ///
    /// # Errors
    /// [`FitError::NoResponse`]: another method.
    pub fn response(&self) -> Result<String, FitError> {
        let fit = self.analysis.estimate.frequency.as_ref();
        let fit = fit.ok_or(FitError::NoResponse)?;
        Ok(response::table(fit, self.analysis.estimate.sample_time))
    }

    /// The longest run, measured and simulated.
    ///
    /// # Errors
    /// Never for a result of [`fit`].
    pub fn simulated(&self) -> Result<Simulated<'_>, FitError> {
        Ok(Simulated::new(
            &self.analysis,
            &self.prepared.resampled.record,
        )?)
    }
}

/// The findings together with the data, as JSON.
pub(crate) fn with_data(
    mut found: Value,
    prepared: &PreparedRecord,
    validation: Option<&PreparedRecord>,
) -> Value {
    let resampled = &prepared.resampled;
    let record = &resampled.record;
    found["record"] = json!({
        "sample_time": record.sample_time,
        "samples": record.samples(),
        "segments": record.segments.iter().map(|it| (it.start, it.len())).collect::<Vec<_>>(),
        "inputs": resampled.inputs,
        "outputs": resampled.outputs,
    });
    found["reading"] = json!(prepared.reading);
    found["preparation"] = json!(prepared.steps);
    found["validation"] = json!(validation.map(|it| json!({
        "samples": it.resampled.record.samples(),
        "reading": it.reading,
        "preparation": it.steps,
    })));
    found
}

/// Findings about the clock, and about signals that alternate between two sources.
pub(crate) fn data_warnings(readings: &[&Reading]) -> Vec<Reason> {
    // A window for validation is read from the same data, and says the same.
    let mut told: Vec<Reason> = Vec::new();
    for sentence in readings
        .iter()
        .flat_map(|it| it.clock.iter().chain(&it.mixed))
    {
        let reason = Reason::Data(sentence.clone());
        if !told.contains(&reason) {
            told.push(reason);
        }
    }
    told
}

/// Downgrades a verdict if the findings cast doubt on the data.
pub(crate) fn downgrade_verdict(readings: &[&Reading], verdict: Verdict) -> Verdict {
    let is_none = matches!(
        verdict,
        Verdict::NoEffect
            | Verdict::Undetermined
            | Verdict::Inseparable
            | Verdict::Unusable
            | Verdict::NotLinear { usable: false }
            | Verdict::Disturbed { usable: false }
    );
    if is_none {
        verdict
    } else if readings.iter().any(|it| !it.mixed.is_empty()) {
        Verdict::Mixed
    } else if readings.iter().any(|it| it.is_time_doubtful) {
        Verdict::TimeDoubtful
    } else {
        verdict
    }
}

/// A candidate of the default method with its cross-validated fit, %.
fn selected(of: &Candidate) -> Value {
    json!({
        "kind": of.kind.name(),
        "order": of.order(),
        "integrators": of.integrators(),
        "delay": of.structure.delay,
        "parameters": of.parameters(),
        "fit": of.fit(),
    })
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::sync::Mutex;

    use planesman_parallel::{Stop, until_stopped};

    use super::*;
    use crate::data::DataOptions;
    use crate::samples::{SamplesOptions, samples};
    use crate::survey::survey;

    const SAMPLE_TIME: f64 = 0.1;

    /// y = 0.9 y before + 0.2 u before, u a square wave and a sine.
    fn columns() -> Vec<(String, Vec<f64>)> {
        let square = |k: u32| f64::from(u8::from((k / 15).is_multiple_of(2)));
        let u: Vec<f64> = (0..400)
            .map(|k| square(k) + 0.1 * libm::sin(f64::from(k)))
            .collect();
        let mut y = vec![0.0];
        for k in 1..u.len() {
            y.push(0.9 * y[k - 1] + 0.2 * u[k - 1]);
        }
        vec![("u".to_owned(), u), ("y".to_owned(), y)]
    }

    fn options(data: DataOptions) -> FitOptions {
        let mut options = FitOptions::default();
        options.signals.data = data;
        options.signals.data.sample_time = Some(SAMPLE_TIME);
        options.signals.input = "u".to_owned();
        options.signals.output = "y".to_owned();
        options.structure.order = Some(1);
        options
    }

    #[test]
    fn columns_and_a_table_of_them_are_one_record_and_the_model_is_what_made_them() {
        let columns = columns();
        let mut text = String::from("u,y");
        for (u, y) in columns[0].1.iter().zip(&columns[1].1) {
            let _ = write!(text, "\n{u},{y}");
        }
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("a.csv");
        std::fs::write(&table, text).unwrap();
        let sources = [
            DataOptions::columns(columns.clone()),
            DataOptions::files([table]),
        ];
        let found = sources.map(|data| {
            let options = options(data);
            let data = &options.signals.data;
            let mut values = Vec::new();
            let signals = vec!["y".to_owned()];
            let of = SamplesOptions {
                data: data.clone(),
                signals,
            };
            samples(&of, &mut |_, _, value| {
                values.extend(value);
                true
            })
            .unwrap();
            assert_eq!(values, columns[1].1);
            let fields = survey(data, None, &()).unwrap().topics.remove(0).fields;
            assert_eq!(
                fields.iter().map(|it| it.count).collect::<Vec<_>>(),
                [400, 400]
            );
            let found = fit(&options, &()).unwrap();
            let model = found.analysis.model();
            assert!(
                (model.a[0] + 0.9).abs() < 1e-6 && (model.b[0] - 0.2).abs() < 1e-6,
                "{model:?}"
            );
            found
        });
        let [columns, table] = found.map(|it| it.prepared.resampled.record.segments);
        assert_eq!(columns, table);
    }

    #[test]
    fn a_frequency_response_is_fitted_written_and_refused_without_a_band() {
        // y = 0.9 y before + 0.2 u before: 2.107/(s + 1.054) behind a hold.
        let u: Vec<f64> = (0..1500)
            .map(|k| libm::sin(0.3 * libm::exp(f64::from(k) * 0.003) / 0.03))
            .collect();
        let hum = |k: usize| 0.02 * libm::sin(0.7 * (k * k) as f64);
        let mut y = vec![0.0];
        for k in 1..u.len() {
            y.push(0.9 * y[k - 1] + 0.2 * u[k - 1]);
        }
        let y: Vec<f64> = y.iter().enumerate().map(|(k, y)| y + hum(k)).collect();
        let of = |y: Vec<f64>| {
            let columns = vec![("u".to_owned(), u.clone()), ("y".to_owned(), y)];
            let mut options = options(DataOptions::columns(columns));
            options.method = MethodChoice::One(Method::Frf);
            options.structure.order = None;
            fit(&options, &())
        };
        let found = of(y).unwrap();
        let table = found.response().unwrap();
        let rows = table.lines().count() - 1;
        assert!(table.starts_with("omega_rad_s,frequency_hz,magnitude_db"));
        let json = found.as_json().unwrap();
        assert_eq!(json["frequency"]["omega"].as_array().unwrap().len(), rows);
        let file = found.model_file().unwrap();
        assert_eq!(file.method, "frf");
        let continuous = file.continuous.unwrap();
        assert_eq!(continuous.den.len(), 2, "{continuous:?}");
        assert!((continuous.den[1] - 1.0536).abs() < 0.05, "{continuous:?}");
        assert!(
            (continuous.num.last().unwrap() - 2.1072).abs() < 0.1,
            "{continuous:?}"
        );
        assert!(continuous.delay < 0.02, "{continuous:?}");
        let text = found.analysis.text();
        assert!(text.contains("the coherence is 0.6 or more from"), "{text}");
        let alone = (0..u.len()).map(hum).collect();
        let refusal = of(alone).unwrap_err().to_string();
        assert!(refusal.contains("coherence 0.4"), "{refusal}");
        let other = fit(&options(DataOptions::columns(columns())), &()).unwrap();
        assert!(matches!(other.response(), Err(FitError::NoResponse)));
    }

    #[derive(Default)]
    struct CollectedNotes(Mutex<Vec<String>>);

    impl CollectedNotes {
        fn note(&self, what: String) {
            self.0.lock().unwrap().push(what);
        }
    }

    impl Progress for CollectedNotes {
        fn begin(&self, what: &'static str, steps: u64, done: u64) {
            self.note(format!("{what} {done}/{steps}"));
        }
        fn step(&self) {
            self.note("step".to_owned());
        }
        fn end(&self) {
            self.note("end".to_owned());
        }
    }

    #[test]
    fn progress_is_told_of_each_method_and_a_fit_ends_when_it_is_asked_to() {
        let mut options = options(DataOptions::columns(columns()));
        let told = CollectedNotes::default();
        fit(&options, &told).unwrap();
        assert_eq!(*told.0.lock().unwrap(), ["end", "models 0/0", "end"]);
        options.method = MethodChoice::All;
        let told = CollectedNotes::default();
        let found = fit(&options, &told).unwrap();
        let told = told.0.into_inner().unwrap();
        let steps = told.iter().filter(|it| *it == "step").count();
        assert_eq!(steps, found.tried.len());
        assert!(told.contains(&format!("methods 0/{steps}")), "{told:?}");
        let stop = Stop::default();
        stop.ask();
        assert!(until_stopped(&stop, || fit(&options, &())).is_none());
    }
}
