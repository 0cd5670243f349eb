//! `planesman sysid fit`: a model with uncertainty, tests and a verdict, from a bag or a CSV file.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Parser;
use planesman_console::print_wrapped;
use planesman_equations::EquationsFile;
use planesman_fit::rules::{self, ABOVE_ZERO, NOT_NEGATIVE};
use planesman_fit::{
    FitError, FitOptions, KnownVehicle, MethodChoice, RecursionOptions, StructureOptions,
    Validation, VehicleOptions, compared, fit, fit_continuous, fit_equations, fit_several,
};
use planesman_identification::analysis::CurveChoice;
use planesman_identification::estimators::{Form, Method};
use planesman_model_file::ModelFile;

use super::arguments::{SignalArgs, by, together};
use crate::arguments::{choice, choice_also_known, output_file, speed, within};
use planesman_flight::sink::write_text;
use planesman_show::pages::tables::{notes, tried};
use planesman_vehicle::heave::{HeaveError, heave_of};

/// The options that `-h` shows; `--help` shows all.
const SHORT: [&str; 17] = [
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
    "equations",
    "continuous",
    "speed",
    "json",
    "model",
    "html",
];

fn shown_and_together(argument: clap::Arg) -> clap::Arg {
    let is_shown = SHORT.contains(&argument.get_id().as_str());
    let argument = match argument.get_id().as_str() {
        // Equations name their signals themselves.
        "input" | "output" => argument
            .required(false)
            .required_unless_present("equations"),
        _ => argument,
    };
    together(argument).hide_short_help(!is_shown)
}

/// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "sysid fit",
    mut_args = shown_and_together,
    override_usage = "planesman sysid fit [OPTIONS] -i <SIGNAL> -o <SIGNAL> <DATA>..."
)]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// Data to judge the model on, of which nothing is fitted: a file or folder with the same signals, or a window of the data as in
    /// --window, which is then left out of the fit [default: a model of the first seven tenths is judged on the rest]
    #[arg(long, value_name = "DATA|FROM..TO", value_parser = |text: &str| text.parse::<Validation>(), allow_hyphen_values = true, help_heading = "Data")]
    validation: Option<Validation>,
    /// The estimator
    #[arg(long, value_parser = choice_also_known(&MethodChoice::ALL, MethodChoice::described, MethodChoice::also_known),
        default_value = Method::default().name(), help_heading = "Model")]
    method: MethodChoice,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    vehicle: VehicleArgs,
    #[command(flatten)]
    recursion: RecursionArgs,
    /// State equations of one's own, with unknown parameters: a file of equations, fitted at the stamps themselves. -i NAME=SIGNAL and
    /// -o NAME=SIGNAL name the signals of its inputs and outputs; what is not named is called as in the file
    #[arg(long, value_name = "FILE", help_heading = "Model")]
    equations: Option<PathBuf>,
    /// A transfer function in s with dead time, fitted at the stamps themselves, however uneven: --order and --numerator are those of s,
    /// --delay 0 is none of a dead time
    #[arg(long, conflicts_with = "equations", help_heading = "Model")]
    continuous: bool,
    /// 95 % intervals of poles and gain by a bootstrap as well: fit so many records simulated with the model and its residuals
    #[arg(long, value_name = "RECORDS", value_parser = clap::value_parser!(u32).range(rules::BOOTSTRAP), help_heading = "Model")]
    bootstrap: Option<u32>,
    /// Static curve in front of the dynamics (Hammerstein) or behind them (Wiener)
    #[arg(long, value_parser = choice(&CurveChoice::ALL, CurveChoice::described), default_value = CurveChoice::default().described().0,
        help_heading = "Model")]
    curve: CurveChoice,
    /// Write the frequency response of --method frf: *.csv
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    response: Option<PathBuf>,
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

/// The model's structure.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Model")]
struct StructureArgs {
    /// Order of the model (of its denominator), known poles not counted, 0 for a static gain; for fir the number of coefficients
    /// [default: searched, 1 to 10; 1 to 4 for a method that is named; up to 64 for fir]
    #[arg(long, value_parser = clap::value_parser!(u8).range(rules::ORDER), visible_alias = "denominator-order")]
    order: Option<u8>,
    /// Form of a process model, for --method process [default: chosen by the Bayesian criterion]
    #[arg(long, value_name = "FORM", value_parser = choice(&Form::ALL, Form::described))]
    process: Option<Form>,
    /// For --method frf: the least coherence of input and output in the band that the model is fitted in [default: 0.6]
    #[arg(long, value_name = "SHARE", value_parser = by(rules::COHERENCE))]
    coherence: Option<f64>,
    /// Coefficients of the numerator, known zeros not counted [default: as many as the order]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(rules::NUMERATOR))]
    numerator: Option<u8>,
    /// Delay in samples from the input to its first effect, 0 where the output is measured after the input of the same
    /// sample [default: searched, 0 to 1000; for a method that is named 1 to 3, 1 with --order]
    #[arg(long, value_parser = clap::value_parser!(u16).range(rules::DELAY))]
    delay: Option<u16>,
    /// Number of zeros known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(rules::AT_ONE))]
    zeros_at_one: u8,
    /// Number of poles known to be at z = 1
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(rules::AT_ONE))]
    integrators: u8,
    /// The output has no offset
    #[arg(long)]
    no_offset: bool,
    /// The data begins at rest [default: the initial state is estimated]
    #[arg(long)]
    at_rest: bool,
    /// Input and output are zero before each segment (the thesis' start): zeros are put in front of it
    #[arg(long)]
    prewindow: bool,
    /// Each segment has its own numerator; only the poles are common
    #[arg(long)]
    own_numerators: bool,
}

/// Known values of the vehicle.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Vehicle")]
struct VehicleArgs {
    /// For vehicle and kalman, q_dot = K/J u - B/J q - M_theta/J theta + NU w, w_dot = EPSILON u + ETA q - ZETA w:
    /// NU,ZETA,ETA,EPSILON, with w in the output's unit times m [default: no heave]
    #[arg(long, value_name = "NU,ZETA,ETA,EPSILON", value_parser = rules::heave, allow_hyphen_values = true)]
    heave: Option<[f64; 4]>,
    /// The same from a built-in vehicle or a vehicle file, at --speed: for planes in rad, a rate in rad/s
    #[arg(long, value_name = "NAME|FILE")]
    vehicle: Option<String>,
    /// Standard deviation of the heave coefficients, in % of each
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = by(NOT_NEGATIVE))]
    heave_doubt: f64,
    /// The vehicle's speed (m/s, or with its unit: 1ft/s), for --vehicle and the model file
    #[arg(long, value_parser = speed(rules::SPEED.least, rules::SPEED.most))]
    speed: Option<f64>,
    /// Moment of inertia J; K, B and M_theta are printed with it
    #[arg(long, value_parser = by(ABOVE_ZERO))]
    inertia: Option<f64>,
    /// For kalman: standard deviation of the noise, output unit [default: from second differences]
    #[arg(long, value_parser = by(ABOVE_ZERO))]
    noise: Option<f64>,
    /// For kalman: standard deviation of the sensor's bias drift in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = by(NOT_NEGATIVE))]
    bias_drift: f64,
    /// For kalman: standard deviation of the output's change by disturbances in one second, output unit
    #[arg(long, default_value_t = 0.0, value_parser = by(NOT_NEGATIVE))]
    disturbance: f64,
}

/// How the recursive methods learn.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Recursive methods")]
struct RecursionArgs {
    /// For recursive methods: forgetting factor per sample (1: none; 0.98: a memory of about 50 samples) [default: 1]
    #[arg(long, value_name = "LAMBDA", value_parser = within(rules::FORGETTING.least, rules::FORGETTING.most))]
    forgetting: Option<f64>,
    /// For recursive methods: initial covariance of each parameter [default: 1e8]
    #[arg(long, value_name = "P0", value_parser = by(ABOVE_ZERO))]
    initial_covariance: Option<f64>,
}

impl TryFrom<&FitArgs> for FitOptions {
    type Error = HeaveError;

    fn try_from(args: &FitArgs) -> Result<Self, HeaveError> {
        let (structure, vehicle) = (&args.structure, &args.vehicle);
        let known = vehicle.vehicle.as_ref().map(|name| {
            let heave = vehicle.speed.map(|speed| heave_of(name, speed));
            Ok::<_, HeaveError>(KnownVehicle {
                heave: heave.transpose()?,
            })
        });
        Ok(Self {
            signals: (&args.signals).into(),
            validation: args.validation.clone(),
            method: args.method,
            structure: StructureOptions {
                order: structure.order.map(usize::from),
                process: structure.process,
                coherence: structure.coherence,
                numerator: structure.numerator.map(usize::from),
                delay: structure.delay.map(usize::from),
                zeros_at_one: usize::from(structure.zeros_at_one),
                integrators: usize::from(structure.integrators),
                no_offset: structure.no_offset,
                at_rest: structure.at_rest,
                prewindow: structure.prewindow,
                own_numerators: structure.own_numerators,
            },
            vehicle: VehicleOptions {
                heave: vehicle.heave,
                vehicle: known.transpose()?,
                heave_doubt: vehicle.heave_doubt,
                speed: vehicle.speed,
                inertia: vehicle.inertia,
                noise: vehicle.noise,
                bias_drift: vehicle.bias_drift,
                disturbance: vehicle.disturbance,
            },
            recursion: RecursionOptions {
                forgetting: args.recursion.forgetting,
                initial_covariance: args.recursion.initial_covariance,
            },
            bootstrap: args.bootstrap.map(|it| it as usize),
            curve: args.curve,
        })
    }
}

impl FitArgs {
    /// What is next once the model is written, if it is.
    fn once_written(&self) -> Option<String> {
        let path = self.model.as_ref()?.display();
        Some(format!(
            "judge it on other data: planesman sysid compare {path} DATA"
        ))
    }
}

fn model_path(text: &str) -> Result<PathBuf, String> {
    let path = output_file(text)?;
    ModelFile::takes_name(&path).map_err(|refusal| refusal.to_string())?;
    Ok(path)
}

/// Runs the command: prints the model, writes the model file and the page.
///
/// # Errors
/// As [`planesman_fit::fit`]; a model that cannot be written, a file or page that cannot be written.
pub fn run(args: &FitArgs) -> Result<()> {
    let options = FitOptions::try_from(args)?;
    let measures_response = args.method == MethodChoice::One(Method::Frf);
    if args.response.is_some() && (args.equations.is_some() || !measures_response) {
        return Err(FitError::NoResponse.into());
    }
    if let Some(path) = &args.equations {
        return run_equations(args, &options, path);
    }
    if args.continuous {
        return run_continuous(args, &options);
    }
    if options.signals.are_several() {
        return run_several(args, &options);
    }
    let found = fit(&options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(found.prepared.description())?;
        if let Some(validation) = &found.validation {
            print_wrapped(format!("validation data\n{}", validation.description()))?;
        }
        if !found.tried.is_empty() {
            planesman_console::print(format!("\n{}", tried(&found.tried)))?;
            print_wrapped(notes(&found.tried))?;
        }
        let text = found
            .analysis
            .text_once_written(args.once_written().as_deref());
        print_wrapped(format!("\n{text}"))?;
    }
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_console::err!("{}: the model", path.display());
    }
    if let Some(path) = &args.response {
        write_text(path, found.response()?)?;
        planesman_console::err!("{}: the frequency response", path.display());
    }
    if let Some(path) = &args.html {
        let page = match &found.tried[..] {
            [] => {
                let (analysis, prepared) = (&found.analysis, &found.prepared);
                let columns = [&analysis.input, &analysis.output];
                let columns = columns.map(|it| prepared.reading.column(it));
                planesman_show::pages::fit::page(analysis, &prepared.resampled.record, columns)?
            }
            tried => {
                let prepared = found.validation.as_ref().unwrap_or(&found.prepared);
                planesman_show::pages::compare::page(&compared(tried, prepared)?, prepared)
            }
        };
        write_text(path, page)?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

/// The same of equations of one's own.
fn run_equations(args: &FitArgs, options: &FitOptions, path: &Path) -> Result<()> {
    let file = EquationsFile::read(path)?;
    let found = fit_equations(options, file, &*args.signals.data.progress());
    let found = found.with_context(|| path.display().to_string())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(planesman_show::pages::equations::text(&found))?;
    }
    if let Some(path) = &args.model {
        found.file().write(path)?;
        planesman_console::err!("{}: the equations", path.display());
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::equations::page(&found))?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

/// The same of a transfer function in s.
fn run_continuous(args: &FitArgs, options: &FitOptions) -> Result<()> {
    if args.response.is_some() {
        return Err(FitError::NoResponse.into());
    }
    if args.model.is_some() {
        return Err(FitError::NoSampledModel.into());
    }
    let found = fit_continuous(options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(planesman_show::pages::continuous::text(&found))?;
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::continuous::page(&found))?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

/// The same of several inputs or outputs.
fn run_several(args: &FitArgs, options: &FitOptions) -> Result<()> {
    let found = fit_several(options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(found.prepared.description())?;
        if let Some(validation) = &found.validation {
            print_wrapped(format!("validation data\n{}", validation.description()))?;
        }
        let text = found.text_once_written(args.once_written().as_deref());
        print_wrapped(format!("\n{text}"))?;
    }
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_console::err!("{}: the model", path.display());
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::several::page(&found))?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use clap::CommandFactory as _;

    use super::FitArgs;

    #[test]
    fn the_command_line_has_the_options_of_the_library() {
        let command = FitArgs::command();
        let own = [
            "continuous",
            "equations",
            "json",
            "model",
            "response",
            "html",
            "quiet",
            "help",
        ];
        let here: BTreeMap<String, Vec<String>> = (command.get_arguments())
            .filter_map(|it| {
                let values = it.get_possible_values();
                let values = values.iter().map(|value| value.get_name().to_owned());
                let takes_one = it.get_action().takes_values();
                let values = values.filter(|_| takes_one).collect();
                Some((it.get_long()?.replace('-', "_"), values))
            })
            .filter(|(name, _)| !own.contains(&name.as_str()))
            .collect();
        let there = planesman_fit::options().into_iter();
        let there = there.map(|(name, words)| {
            let words = words.into_iter().map(str::to_owned).collect();
            (name.to_owned(), words)
        });
        assert_eq!(here, there.collect());
    }
}
