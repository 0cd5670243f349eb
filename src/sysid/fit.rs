//! `planesman sysid fit`: a model with uncertainty, tests and a verdict, from a bag or a CSV file.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use planesman_identification::Start;
use planesman_identification::analysis::{Analysis, Options, analyse};
use planesman_identification::estimators::recursive::{Forgetting, Options as Recursion};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{Knowledge, Method};
use planesman_identification::selection::Candidate;
use planesman_model_file::ModelFile;
use planesman_signals::Taken;
use planesman_vehicle::{pitch, vehicle_file};
use serde_json::{Value, json};

use super::arguments::{SignalArgs, choice_also_known};
use super::{model_file, page};
use crate::arguments::{output_file, speed, within};
use crate::progress::spinner;
use crate::table::wrapped;

/// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid fit")]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// The estimator
    #[arg(long, value_parser = choice_also_known(&Method::ALL, Method::described, also_known),
        default_value = Method::default().name())]
    method: Method,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    vehicle: VehicleArgs,
    #[command(flatten)]
    recursion: RecursionArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write the model: *.json or *.yaml
    #[arg(long, value_name = "FILE", value_parser = model_path)]
    model: Option<PathBuf>,
    /// Write an HTML page: data, comparison, residual tests, poles and zeros, frequency response
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
}

/// The model's structure.
#[derive(Clone, Debug, clap::Args)]
struct StructureArgs {
    /// Order of the model (of its denominator), known poles not counted [default: searched, 1 to 10; 1 to 4 for a method that is named]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=20), visible_alias = "denominator-order")]
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
    fn options(&self, method: Method) -> Result<Recursion> {
        let given = self.forgetting.or(self.initial_covariance);
        if given.is_some() && !is_recursive(method) {
            bail!(
                "--forgetting and --initial-covariance are for the recursive methods, as --method \
                 recursive_least_squares; {} uses all samples at once",
                method.name()
            );
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
fn also_known(method: Method) -> &'static [&'static str] {
    match method {
        Method::OutputError => &["oe"],
        Method::BoxJenkins => &["bj"],
        Method::Instruments => &["iv"],
        Method::LeastSquares => &["arx"],
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
    /// The options of the analysis.
    fn options(&self) -> Result<Options> {
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
        if self.method.is_of_the_vehicle() {
            if has_structure {
                bail!(
                    "--method {}: order, delay and zeros are given by the vehicle's equations",
                    self.method.name()
                );
            }
        } else if coefficients.is_some() {
            bail!("--heave and --vehicle are for --method vehicle and kalman");
        }
        let heave = coefficients.map(|[to_pitch, damping, from_rate, from_input]| Heave {
            to_pitch,
            damping,
            from_rate,
            from_input,
            doubt: vehicle.heave_doubt / 100.0,
        });
        Ok(Options {
            method: self.method,
            knowledge: Knowledge {
                vehicle: Vehicle { heave },
                noise: vehicle.noise,
                bias_drift: vehicle.bias_drift,
                disturbance: vehicle.disturbance,
                recursion: self.recursion.options(self.method)?,
            },
            order: structure.order.map(usize::from),
            numerator: structure.numerator.map(usize::from),
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
        })
    }
}

/// A model and its record.
#[derive(Clone, Debug)]
pub struct Found {
    /// The record, and how it was made.
    pub taken: Taken,
    /// The model with its uncertainty, tests and verdict.
    pub analysis: Analysis,
}

impl Found {
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
    let options = args.options()?;
    let decimate = args.method == Method::Automatic;
    let taken = args
        .signals
        .record(args.structure.zeros_in_front(), decimate)?;
    let working = spinner("models");
    let analysis = analyse(&taken.resampled.record, &options);
    working.finish_and_clear();
    let analysis = analysis?;
    Ok(Found { taken, analysis })
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
    let text = if args.json {
        serde_json::to_string_pretty(&as_json(&found)?)? + "\n"
    } else {
        wrapped(&format!(
            "{}\n{}",
            found.taken.account(),
            found.analysis.text()
        ))
    };
    planesman_node::print(text)?;
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_node::complain!("{}: the model", path.display());
    }
    if let Some(path) = &args.html {
        let page = page::page(&found.analysis, &found.taken.resampled.record)?;
        std::fs::write(path, page).with_context(|| format!("{}", path.display()))?;
        planesman_node::complain!("{}: the page", path.display());
    }
    Ok(())
}

/// A candidate of the default method and its fit by cross-validation, %.
fn selected(of: &Candidate) -> Value {
    json!({
        "kind": of.kind.name(),
        "order": of.structure.poles,
        "delay": of.structure.delay,
        "parameters": of.parameters(),
        "fit": of.fit(),
    })
}

/// Everything but the record's numbers.
fn as_json(found: &Found) -> Result<Value> {
    let Found { taken, analysis } = found;
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
