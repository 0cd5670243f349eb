//! `planesman sysid fit`: a model with uncertainty, tests and a verdict, from a bag or a CSV file.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use planesman_console::progress::ProgressBar;
use planesman_identification::analysis::{Analysis, Options, analyse, analyse_validated};
use planesman_identification::estimators::recursive::{Forgetting, Options as Recursion};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{Knowledge, Method};
use planesman_identification::selection::Candidate;
use planesman_identification::{IdentificationError, Start};
use planesman_model_file::ModelFile;
use planesman_signals::Taken;
use planesman_vehicle::{pitch, vehicle_file};
use serde_json::{Value, json};

use super::arguments::{Columns, SignalArgs, Validation, validation};
use super::trial::{self, Trial};
use super::{compare_page, model_file, page};
use crate::arguments::{choice_also_known, output_file, speed, within};
use planesman_console::print_wrapped;
use planesman_console::progress::{bar, spinner};
use planesman_flight::sink::write_text;

type IdentificationResult = Result<Analysis, IdentificationError>;

/// The largest order of a model with poles.
const MOST: usize = 20;

/// The options that `-h` shows; `--help` shows all.
const SHORT: [&str; 15] = [
    "data",
    "input",
    "output",
    "reference",
    "rate",
    "window",
    "validation",
    "sample_time",
    "method",
    "order",
    "delay",
    "speed",
    "json",
    "model",
    "html",
];

fn in_short(argument: clap::Arg) -> clap::Arg {
    let is_shown = SHORT.contains(&argument.get_id().as_str());
    argument.hide_short_help(!is_shown)
}

/// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "sysid fit",
    mut_args = in_short,
    override_usage = "planesman sysid fit [OPTIONS] -i <SIGNAL> -o <SIGNAL> <DATA>..."
)]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// Data to judge the model on, of which nothing is fitted: a file or folder with the same signals, or a window of the data as in
    /// --window, which is then left out of the fit [default: a model of the first seven tenths is judged on the rest]
    #[arg(long, value_name = "DATA|FROM..TO", value_parser = validation, allow_hyphen_values = true, help_heading = "Data")]
    validation: Option<Validation>,
    /// The estimator
    #[arg(long, value_parser = choice_also_known(&Asked::ALL, Asked::described, also_known),
        default_value = Method::default().name(), help_heading = "Model")]
    method: Asked,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    vehicle: VehicleArgs,
    #[command(flatten)]
    recursion: RecursionArgs,
    /// 95 % intervals of poles and gain by a bootstrap as well: fit so many records simulated with the model and its residuals
    #[arg(long, value_name = "RECORDS", value_parser = clap::value_parser!(u32).range(100..=100_000), help_heading = "Model")]
    bootstrap: Option<u32>,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Write the model: *.json or *.yaml
    #[arg(long, value_name = "FILE", value_parser = model_path, help_heading = "Output")]
    model: Option<PathBuf>,
    /// Write an HTML page: data, comparison, residual tests, poles and zeros, frequency response
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

/// The method that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// One.
    One(Method),
    /// Each of them, beside the others.
    All,
}

impl Asked {
    /// Every method, and all of them.
    const ALL: [Self; Method::ALL.len() + 1] = {
        let mut all = [Self::All; Method::ALL.len() + 1];
        let mut i = 0;
        while i < Method::ALL.len() {
            all[i] = Self::One(Method::ALL[i]);
            i += 1;
        }
        all
    };

    /// Its name and its help line.
    fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::One(method) => method.described(),
            Self::All => (
                "all",
                "Every method beside the others; the one that simulates held-out data best is printed and written",
            ),
        }
    }
}

/// The model's structure.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Model")]
struct StructureArgs {
    /// Order of the model (of its denominator), known poles not counted; for fir the number of coefficients [default:
    /// searched, 1 to 10; 1 to 4 for a method that is named; up to 64 for fir]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=64), visible_alias = "denominator-order")]
    order: Option<u8>,
    /// Coefficients of the numerator, known zeros not counted [default: as many as the order]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=40), requires = "order")]
    numerator: Option<u8>,
    /// Delay in samples from the input to its first effect, 0 where the output is measured after the input of the same
    /// sample [default: searched, 0 to 20; for a method that is named 1 to 3, 1 with --order]
    #[arg(long, value_parser = clap::value_parser!(u8).range(0..=40))]
    delay: Option<u8>,
    /// Number of zeros known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    zeros_at_one: u8,
    /// Number of poles known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    integrators: u8,
    /// The output has no offset
    #[arg(long)]
    no_offset: bool,
    /// The data begins at rest [default: the initial state is estimated]
    #[arg(long)]
    at_rest: bool,
    /// Input and output are zero before each segment (the thesis' start): zeros are put in front of it
    #[arg(long, requires = "order")]
    prewindow: bool,
    /// Each segment has its own numerator; only the poles are common
    #[arg(long)]
    own_numerators: bool,
}

impl StructureArgs {
    /// Zeros that go in front of each segment, as many as a row of the difference equation looks back.
    fn zeros_in_front(&self) -> usize {
        let order = self.order.filter(|_| self.prewindow).map_or(0, usize::from);
        match order {
            0 => 0,
            order => {
                let numerator = self.numerator.map_or(order, usize::from);
                let inputs = usize::from(self.delay.unwrap_or(1))
                    + numerator
                    + usize::from(self.zeros_at_one);
                inputs
                    .saturating_sub(1)
                    .max(order + usize::from(self.integrators))
            }
        }
    }
}

/// Known values of the vehicle.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Vehicle")]
struct VehicleArgs {
    /// For vehicle and kalman, q_dot = K/J u - B/J q - M_theta/J theta + NU w, w_dot = EPSILON u + ETA q - ZETA w:
    /// NU,ZETA,ETA,EPSILON, with w in the output's unit times m [default: no heave]
    #[arg(long, value_name = "NU,ZETA,ETA,EPSILON", value_parser = heave, allow_hyphen_values = true)]
    heave: Option<[f64; 4]>,
    /// The same from a built-in vehicle or a vehicle file, at --speed: for planes in rad, a rate in rad/s
    #[arg(
        long,
        value_name = "NAME|FILE",
        conflicts_with = "heave",
        requires = "speed"
    )]
    vehicle: Option<String>,
    /// Standard deviation of the heave coefficients, in % of each
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = positive)]
    heave_doubt: f64,
    /// The vehicle's speed (m/s, or with its unit: 1ft/s), for --vehicle and the model file
    #[arg(long, value_parser = speed(1e-3, 100.0))]
    speed: Option<f64>,
    /// Moment of inertia J; K, B and M_theta are printed with it
    #[arg(long, value_parser = above_zero)]
    inertia: Option<f64>,
    /// For kalman: standard deviation of the noise, output unit [default: from second differences]
    #[arg(long, value_parser = above_zero)]
    noise: Option<f64>,
    /// For kalman: standard deviation of the sensor's bias drift in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = positive)]
    bias_drift: f64,
    /// For kalman: standard deviation of the output's change by disturbances in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = positive)]
    disturbance: f64,
}

/// How the recursive methods learn.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Recursive methods")]
struct RecursionArgs {
    /// For recursive methods: forgetting factor per sample (1: none; 0.98: a memory of about 50 samples) [default: 1]
    #[arg(long, value_name = "LAMBDA", value_parser = within(1e-3, 1.0))]
    forgetting: Option<f64>,
    /// For recursive methods: initial covariance of each parameter [default: 1e8]
    #[arg(long, value_name = "P0", value_parser = above_zero)]
    initial_covariance: Option<f64>,
}

impl RecursionArgs {
    /// The options they stand for.
    ///
    /// # Errors
    /// A sentence, when one is given for a method that is not recursive.
    fn options(&self, asked: Asked) -> Result<Recursion> {
        let given = self.forgetting.or(self.initial_covariance);
        match asked {
            Asked::One(method) if given.is_some() && !is_recursive(method) => bail!(
                "--forgetting and --initial-covariance are for the recursive methods, as --method \
                 recursive_least_squares; {} uses all samples at once",
                method.name()
            ),
            _ => {}
        }
        let defaults = Recursion::default();
        Ok(Recursion {
            forgetting: self
                .forgetting
                .map_or(defaults.forgetting, Forgetting::Constant),
            initial_covariance: self
                .initial_covariance
                .unwrap_or(defaults.initial_covariance),
            ..defaults
        })
    }
}

/// Whether a method learns a sample at a time, by forgetting factor and covariance.
fn is_recursive(method: Method) -> bool {
    matches!(
        method,
        Method::RecursiveLeastSquares
            | Method::ExtendedLeastSquares
            | Method::RecursivePredictionError
            | Method::RecursiveOutputError
    )
}

/// The names by which a method is known elsewhere.
fn also_known(asked: Asked) -> &'static [&'static str] {
    let Asked::One(method) = asked else {
        return &[];
    };
    match method {
        Method::OutputError => &["oe"],
        Method::BoxJenkins => &["bj"],
        Method::Instruments => &["iv"],
        Method::LeastSquares => &["arx"],
        Method::N4sid => &["subspace"],
        Method::RecursiveLeastSquares => &["rls", "rarx"],
        Method::ExtendedLeastSquares => &["els"],
        Method::RecursivePredictionError => &["rpem", "rml"],
        Method::RecursiveOutputError => &["roe"],
        _ => &[],
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("'{text}' is not a number"))?;
    value
        .is_finite()
        .then_some(value)
        .ok_or_else(|| format!("'{text}' is not finite"))
}

fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value >= 0.0 => Ok(value),
        _ => Err("expected a number of 0 or more".to_owned()),
    }
}

fn above_zero(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value > 0.0 => Ok(value),
        _ => Err("expected a number above 0".to_owned()),
    }
}

fn heave(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text.split(',').map(finite).collect::<Result<_, _>>()?;
    numbers
        .try_into()
        .map_err(|_| "expected four numbers: NU,ZETA,ETA,EPSILON".to_owned())
}

impl FitArgs {
    /// The same with columns in memory in place of the data, which is then not opened.
    #[must_use]
    pub fn of_columns(self, columns: Columns) -> Self {
        Self {
            signals: self.signals.of_columns(columns),
            ..self
        }
    }

    /// The options of the analysis by a method.
    fn options(&self, method: Method) -> Result<Options> {
        let (structure, vehicle) = (&self.structure, &self.vehicle);
        let of_vehicle = match (&vehicle.vehicle, vehicle.speed) {
            (Some(name), Some(speed)) => Some(heave_of(name, speed)?),
            _ => None,
        };
        let has_structure = structure.order.is_some()
            || structure.numerator.is_some()
            || structure.delay.is_some()
            || structure.zeros_at_one + structure.integrators > 0
            || structure.own_numerators;
        let coefficients = vehicle.heave.or(of_vehicle);
        if method.is_of_the_vehicle() {
            if has_structure {
                bail!(
                    "--method {}: order, delay and zeros are given by the vehicle's equations",
                    method.name()
                );
            }
        } else if coefficients.is_some() && self.method != Asked::All {
            bail!("--heave and --vehicle are for --method vehicle and kalman");
        }
        let is_fir = method == Method::Fir;
        let order = structure.order.map(usize::from);
        if is_fir && structure.numerator.is_some() && self.method != Asked::All {
            bail!("--method fir has no denominator: --order is the number of its coefficients");
        }
        if order.is_some_and(|order| order > MOST) && !is_fir {
            bail!("--order: {MOST} at most, but for --method fir");
        }
        let heave = coefficients.map(|[to_pitch, damping, from_rate, from_input]| Heave {
            to_pitch,
            damping,
            from_rate,
            from_input,
            doubt: vehicle.heave_doubt / 100.0,
        });
        Ok(Options {
            method,
            knowledge: Knowledge {
                vehicle: Vehicle { heave },
                noise: vehicle.noise,
                bias_drift: vehicle.bias_drift,
                disturbance: vehicle.disturbance,
                // Beside other methods the criterion chooses: an order is none of coefficients.
                length: order.filter(|_| is_fir && self.method != Asked::All),
                recursion: self.recursion.options(self.method)?,
            },
            order: order.filter(|_| !is_fir),
            numerator: structure.numerator.map(usize::from).filter(|_| !is_fir),
            delay: structure.delay.map(usize::from),
            zeros_at_one: usize::from(structure.zeros_at_one),
            integrators: usize::from(structure.integrators),
            offset: !structure.no_offset,
            start: if structure.at_rest || structure.prewindow {
                Start::Rest
            } else {
                Start::Motion
            },
            own_numerators: structure.own_numerators,
            inertia: vehicle.inertia,
            speed: vehicle.speed,
            bootstrap: self.bootstrap.map(|it| it as usize),
        })
    }
}

/// A model and its record.
#[derive(Clone, Debug)]
pub struct Found {
    /// The record, and how it was made.
    pub taken: Taken,
    /// The record it was judged on, where one was given.
    pub validation: Option<Taken>,
    /// The model with its uncertainty, tests and verdict.
    pub analysis: Analysis,
    /// All methods that were tried, where all were asked for.
    pub tried: Vec<Trial>,
}

impl Found {
    /// Everything but the record's numbers, as `--json` prints it.
    ///
    /// # Errors
    /// As [`Found::model_file`].
    pub fn as_json(&self) -> Result<Value> {
        as_json(self)
    }

    /// The model as a file that other programs load.
    ///
    /// # Errors
    /// When poles or zeros cannot be found.
    pub fn model_file(&self) -> Result<ModelFile> {
        Ok(ModelFile {
            preparation: self.taken.steps.iter().map(|it| it.text.clone()).collect(),
            ..model_file::of(&self.analysis)?
        })
    }
}

/// Reads the data and identifies the model.
///
/// # Errors
/// One line: options that do not go together, a vehicle that is refused, data that cannot be read, a record that
/// determines no model.
pub fn fit(args: &FitArgs) -> Result<Found> {
    // Refused before anything is read.
    let options = match args.method {
        Asked::One(method) => vec![args.options(method)?],
        Asked::All => Vec::new(),
    };
    let (taken, validation) = args.read()?;
    let record = &taken.resampled.record;
    let of = |options: &Options| match &validation {
        None => analyse(record, options),
        Some(validation) => analyse_validated(record, options, &validation.resampled.record),
    };
    let (analysis, tried) = match options.first() {
        Some(options) => {
            let working = args.progress(|| spinner("models"));
            let analysis = of(options);
            working.finish_and_clear();
            (analysis?, Vec::new())
        }
        None => {
            let tried = args.try_all(&of);
            let best = trial::best(&tried).context("no method finds a model")?;
            (best.clone(), tried)
        }
    };
    Ok(Found {
        taken,
        validation,
        analysis,
        tried,
    })
}

impl FitArgs {
    /// The record to fit, and the one to judge the model on.
    fn read(&self) -> Result<(Taken, Option<Taken>)> {
        let zeros = self.structure.zeros_in_front();
        let ways = match self.validation {
            Some(Validation::Window(from, to)) => self.signals.outside((from, to))?,
            _ => vec![self.signals.clone()],
        };
        // A named method is given the data as it is.
        let decimate = matches!(self.method, Asked::All | Asked::One(Method::Automatic));
        let mut found = ways.iter().map(|way| way.record(zeros, decimate));
        let first = found.next().context("no data")?;
        let taken = match first {
            Ok(taken) => taken,
            Err(reason) => found.find_map(Result::ok).ok_or(reason)?,
        };
        let validation = self.validation.as_ref().map(|given| {
            let record = self.signals.validation(given, &taken).record(0, false);
            record.context("the validation data")
        });
        Ok((taken, validation.transpose()?))
    }

    /// Progress of long work, unless it is not wanted.
    fn progress(&self, shown: impl FnOnce() -> ProgressBar) -> ProgressBar {
        match self.signals.is_quiet() {
            true => ProgressBar::hidden(),
            false => shown(),
        }
    }

    /// Every method; those for a vehicle's equations only with what is known of the vehicle.
    fn try_all(&self, analyse: &dyn Fn(&Options) -> IdentificationResult) -> Vec<Trial> {
        let of_vehicle = self.vehicle.heave.is_some() || self.vehicle.vehicle.is_some();
        let working = self.progress(|| bar("methods", Method::ALL.len()));
        let methods = Method::ALL.into_iter();
        let wanted = methods.filter(|method| of_vehicle || !method.is_of_the_vehicle());
        let tried = wanted.map(|method| {
            let start = Instant::now();
            let outcome = self
                .options(method)
                .map_err(|reason| format!("{reason:#}"))
                .and_then(|options| analyse(&options).map_err(|reason| reason.to_string()));
            working.inc(1);
            Trial {
                method,
                outcome,
                seconds: start.elapsed().as_secs_f64(),
            }
        });
        let tried = tried.collect();
        working.finish_and_clear();
        tried
    }
}

/// nu, zeta, eta and epsilon of a vehicle about level flight: pitch acceleration per heave, 1/(m s); damping of
/// heave, 1/s; heave acceleration per pitch rate, m/s, and per plane angle, m/s^2 per rad.
fn heave_of(vehicle: &str, speed: f64) -> Result<[f64; 4]> {
    let vehicle = vehicle_file::load(vehicle).map_err(|reason| anyhow!("{reason}"))?;
    let [_, _, _, heave @ ..] = pitch::coefficients(&vehicle.derivatives(speed))
        .with_context(|| format!("vehicle '{}' at {speed} m/s", vehicle.name))?;
    Ok(heave)
}

fn model_path(text: &str) -> Result<PathBuf, String> {
    let path = output_file(text)?;
    ModelFile::takes_name(&path).map_err(|refusal| refusal.to_string())?;
    Ok(path)
}

/// Runs the command: prints the model, writes the model file and the page.
///
/// # Errors
/// As [`fit`]; a model that cannot be written, a file or page that cannot be written.
pub fn run(args: &FitArgs) -> Result<()> {
    let found = fit(args)?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(found.taken.account())?;
        if let Some(validation) = &found.validation {
            print_wrapped(format!("validation data\n{}", validation.account()))?;
        }
        if !found.tried.is_empty() {
            planesman_console::print(format!("\n{}", trial::table(&found.tried)?))?;
            print_wrapped(trial::notes(&found.tried))?;
        }
        print_wrapped(format!("\n{}", found.analysis.text()))?;
    }
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_console::err!("{}: the model", path.display());
    }
    if let Some(path) = &args.html {
        let page = match &found.tried[..] {
            [] => {
                let (analysis, taken) = (&found.analysis, &found.taken);
                let columns = [&analysis.input, &analysis.output];
                let columns = columns.map(|it| taken.reading.column(it));
                page::page(analysis, &taken.resampled.record, columns)?
            }
            tried => {
                let taken = found.validation.as_ref().unwrap_or(&found.taken);
                compare_page::page(&trial::compared(tried, taken)?, taken)
            }
        };
        write_text(path, page)?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

/// A candidate of the default method and its fit by cross-validation, %.
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

/// Everything but the record's numbers.
fn as_json(found: &Found) -> Result<Value> {
    let Found {
        taken,
        validation,
        analysis,
        tried,
    } = found;
    let record = &taken.resampled.record;
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
    Ok(json!({
        "model": found.model_file()?,
        "parameters": physical,
        "candidates": analysis.candidates,
        "selected": analysis.selected.iter().map(selected).collect::<Vec<_>>(),
        "attainable_fit": analysis.attainable_fit,
        "predicted_fit": analysis.predicted_fit,
        "share_of_input": analysis.share,
        "delay": analysis.lag.map(|it| json!({"best": it.best, "interval": it.interval})),
        "bootstrap": analysis.bootstrap,
        "residuals": analysis.residuals,
        "record": {
            "sample_time": record.sample_time,
            "samples": record.samples(),
            "segments": record.segments.iter().map(|it| (it.start, it.len())).collect::<Vec<_>>(),
            "inputs": taken.resampled.inputs,
            "outputs": taken.resampled.outputs,
        },
        "reading": taken.reading,
        "preparation": taken.steps,
        "validation": validation.as_ref().map(|it| json!({
            "samples": it.resampled.record.samples(),
            "reading": it.reading,
            "preparation": it.steps,
        })),
        "methods": tried.iter().map(Trial::as_json).collect::<Vec<_>>(),
    }))
}

#[cfg(test)]
mod tests {
    use planesman_units::{FOOT, INCH};

    use super::*;

    #[test]
    fn heave_of_the_thesis_vehicle_is_that_of_its_coefficients() {
        // Brunner 1988, Table 1 (p. 41): Z'w -1.295, Z'q + m' 0.196, Z'delta 0.095, M'w 0.088, m' - Z'w_dot 1.046,
        // I'y 0.072 with M'q_dot; 28 in long.
        let (speed, length) = (2.1 * FOOT, 28.0 * INCH);
        let rate = speed / length;
        let expected = [
            0.088 / 0.072 * rate / length,
            1.295 / 1.046 * rate,
            0.196 / 1.046 * rate * length,
            0.095 / 1.046 * rate * speed,
        ];
        let found = heave_of("brunner", speed).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    }
}
