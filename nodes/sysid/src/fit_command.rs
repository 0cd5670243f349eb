//! `sysid fit`: from a bag or a table to a model one can judge.

use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use clap::Parser;
use planesman_model_file::ModelFile;
use serde_json::{Value, json};

use crate::analysis::{Analysis, Options, analyse};
use crate::estimators::vehicle::{Heave, Vehicle};
use crate::estimators::{Knowledge, Method};
use crate::record::Record;
use crate::source::Reading;
use crate::structure::Start;
use crate::taken::{SignalArgs, Taken, account};

/// Find a model between two signals of any bag or table, with its uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid fit")]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// How to estimate
    #[arg(long, value_enum, default_value_t)]
    method: Method,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write the model: *.json or *.yaml
    #[arg(long, value_name = "FILE", value_parser = model_file)]
    model: Option<PathBuf>,
    /// Write a page: data, comparison, residual tests, poles and zeros, frequency response
    #[arg(long, value_name = "FILE", value_parser = file)]
    pub html: Option<PathBuf>,
}

/// What the model looks like.
#[derive(Clone, Debug, clap::Args)]
struct StructureArgs {
    /// The model's order, known poles not counted [default: searched, 1 to 4]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=20))]
    order: Option<u8>,
    /// Samples from input to first effect [default: searched with the order, 1 to 3; 1 with --order]
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=40))]
    delay: Option<u8>,
    /// Zeros known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    zeros_at_one: u8,
    /// Poles known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=4))]
    integrators: u8,
    /// The output has no offset
    #[arg(long)]
    no_offset: bool,
    /// The data begins at rest [default: in motion, which is estimated]
    #[arg(long)]
    at_rest: bool,
    /// Several stretches have only their poles in common
    #[arg(long)]
    own_numerators: bool,
}

/// What is known of the vehicle.
#[derive(Clone, Debug, clap::Args)]
pub struct VehicleArgs {
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
    pub vehicle: Option<String>,
    /// The standard deviation of what is known of heave, % of each
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = positive)]
    heave_doubt: f64,
    /// The vehicle's speed (m/s), for --vehicle and the model file
    #[arg(long, value_parser = above_zero)]
    pub speed: Option<f64>,
    /// The moment of inertia J, which K, B and M_theta follow with
    #[arg(long, value_parser = above_zero)]
    inertia: Option<f64>,
    /// For kalman: the noise's standard deviation, output unit [default: from second differences]
    #[arg(long, value_parser = above_zero)]
    noise: Option<f64>,
    /// For kalman: how far the sensor's bias drifts in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = positive)]
    bias_drift: f64,
    /// For kalman: how far disturbances move the output in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = positive)]
    disturbance: f64,
}

fn finite(text: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("'{text}' is no number"))?;
    value
        .is_finite()
        .then_some(value)
        .ok_or_else(|| format!("'{text}' is not finite"))
}

fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value >= 0.0 => Ok(value),
        _ => Err("a number that is not negative is expected".to_owned()),
    }
}

fn above_zero(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value > 0.0 => Ok(value),
        _ => Err("a number above 0 is expected".to_owned()),
    }
}

fn heave(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text.split(',').map(finite).collect::<Result<_, _>>()?;
    numbers
        .try_into()
        .map_err(|_| "four numbers are expected: NU,ZETA,ETA,EPSILON".to_owned())
}

impl FitArgs {
    /// The vehicle that heave is to be taken of, and its speed, m/s; `None` when none was named.
    #[must_use]
    pub fn named_vehicle(&self) -> Option<(&str, f64)> {
        Some((self.vehicle.vehicle.as_deref()?, self.vehicle.speed?))
    }

    /// What they stand for, with the heave of the vehicle that was named.
    fn options(&self, of_vehicle: Option<[f64; 4]>) -> Result<Options> {
        let (structure, vehicle) = (&self.structure, &self.vehicle);
        let told_of_structure = structure.order.is_some()
            || structure.delay.is_some()
            || structure.zeros_at_one + structure.integrators > 0
            || structure.own_numerators;
        let coefficients = vehicle.heave.or(of_vehicle);
        if self.method.is_of_the_vehicle() {
            if told_of_structure {
                bail!(
                    "--method {}: its equations have the order, delay and zeros that they have",
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
            },
            order: structure.order.map(usize::from),
            delay: structure.delay.map(usize::from),
            zeros_at_one: usize::from(structure.zeros_at_one),
            integrators: usize::from(structure.integrators),
            offset: !structure.no_offset,
            start: if structure.at_rest {
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

/// What `sysid fit` found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The record the model is of.
    pub record: Record,
    /// How the data was read.
    pub reading: Reading,
    /// The model and what there is to know of it.
    pub analysis: Analysis,
}

/// Reads the data and finds the model. `heave` is nu, zeta, eta and epsilon of the vehicle that was named.
///
/// # Errors
/// One line: options that do not go together, data that cannot be read, a record that determines no model.
pub fn fit(args: &FitArgs, heave: Option<[f64; 4]>) -> Result<Found> {
    let options = args.options(heave)?;
    let Taken { record, reading } = args.signals.record()?;
    let analysis = analyse(&record, &options).map_err(|reason| anyhow!(reason))?;
    Ok(Found {
        record,
        reading,
        analysis,
    })
}

/// A file that can be written when the work is done: its folder is there.
fn file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("there is no folder '{}'", folder.display()))
        }
        _ => Ok(path),
    }
}

fn model_file(text: &str) -> Result<PathBuf, String> {
    let path = file(text)?;
    ModelFile::takes_name(&path)?;
    Ok(path)
}

/// Prints what was found and writes the model file.
///
/// # Errors
/// One line: a model that is none to write, a file that cannot be written.
pub fn tell(args: &FitArgs, found: &Found) -> Result<()> {
    let text = if args.json {
        serde_json::to_string_pretty(&told(found)?)? + "\n"
    } else {
        let account = account(&found.record, &found.reading);
        format!("{account}\n{}", found.analysis.text())
    };
    planesman_node::print(text)?;
    if let Some(path) = &args.model {
        let file = found.analysis.file().map_err(|reason| anyhow!(reason))?;
        file.write(path)?;
        planesman_node::complain!("{}: the model", path.display());
    }
    Ok(())
}

/// Runs the command where there are neither vehicles nor pages.
///
/// # Errors
/// As [`fit`] and [`tell`]; when a vehicle is named or a page asked for.
pub fn run(args: &FitArgs) -> Result<()> {
    if args.html.is_some() {
        bail!("--html: pages are drawn by `planesman sysid fit`");
    }
    if args.vehicle.vehicle.is_some() {
        bail!("--vehicle: vehicles are known to `planesman sysid fit`; give --heave");
    }
    tell(args, &fit(args, None)?)
}

/// Everything but the record's numbers.
fn told(found: &Found) -> Result<Value> {
    let Found {
        record,
        reading,
        analysis,
    } = found;
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
        "model": analysis.file().map_err(|reason| anyhow!(reason))?,
        "parameters": physical,
        "candidates": analysis.candidates,
        "residuals": analysis.residuals,
        "record": {
            "sample_time": record.sample_time,
            "samples": record.samples(),
            "stretches": record.stretches.iter().map(|it| (it.start, it.len())).collect::<Vec<_>>(),
            "inputs": record.inputs,
            "outputs": record.outputs,
        },
        "reading": reading,
    }))
}
