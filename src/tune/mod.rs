//! `planesman tune`: PI and PID gains for a model, judged over its uncertainty; of a model of the vehicle's pitch the gains of the dive
//! loops (`dive`).

mod arguments;
mod dive;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Parser;
use planesman_console::print_wrapped;
use planesman_fit::{FitOptions, MethodChoice, fit};
use planesman_flight::sink::write_text;
use planesman_identification::estimators::Method as Estimator;
use planesman_model_file::ModelFile;
use planesman_pages::tuning;
use planesman_tuning::{TuneOptions, tune};
use planesman_vehicle::identified;

use self::arguments::{ControllerArgs, LimitArgs, TrialArgs};
use crate::arguments::output_file;
use crate::sysid::arguments::SignalArgs;

/// By how much the held-out fit of a process model, %, may lie below that of the default for it to be taken.
const AS_GOOD: f64 = 1.0;

/// A model file stands for itself; data needs its signals.
fn of_model_or_data(argument: clap::Arg) -> clap::Arg {
    match argument.get_id().as_str() {
        "input" | "output" => argument.required(false),
        "data" => argument.help(
            "A model file of planesman sysid fit --model, or the data of a model that is then identified first, as by planesman sysid fit: a bag, tables or logs with -i and -o",
        ),
        _ => argument,
    }
}

/// Find PI or PID gains for a model, with their margins over the model's uncertainty.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "tune",
    mut_args = of_model_or_data,
    override_usage = "planesman tune [OPTIONS] <MODEL>\n       planesman tune [OPTIONS] -i <SIGNAL> -o <SIGNAL> <DATA>..."
)]
pub struct TuneArgs {
    #[command(flatten)]
    signals: SignalArgs,
    #[command(flatten)]
    controller: ControllerArgs,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    trial: TrialArgs,
    #[command(flatten)]
    dive: dive::DiveArgs,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Write an HTML page: responses, Bode and Nyquist plot, each with the band of the plants that the model allows
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

impl From<&TuneArgs> for TuneOptions {
    fn from(args: &TuneArgs) -> Self {
        let TuneArgs {
            controller,
            limits,
            trial,
            ..
        } = args;
        Self {
            method: controller.method,
            controller: controller.controller,
            period: controller.period,
            computing_delay: controller.computing_delay,
            phase_margin: limits.phase_margin,
            gain_margin: limits.gain_margin,
            ms: limits.ms,
            crossover: controller.crossover,
            closed_loop_time: controller.closed_loop_time,
            damping_ratio: controller.damping_ratio,
            draws: limits.draws as usize,
            seed: limits.seed,
            step: trial.step,
            input_limit: trial.input_limit,
            anyway: limits.anyway,
        }
    }
}

impl TuneArgs {
    /// The model of the file, or of the data.
    fn model(&self) -> Result<ModelFile> {
        let data = &self.signals.data.data;
        let (input, output) = (&self.signals.input, &self.signals.output);
        if let ([path], true) = (&data[..], input.is_empty() && output.is_empty())
            && ModelFile::takes_name(path).is_ok()
        {
            return Ok(ModelFile::read(path)?);
        }
        if input.len() > 1 || output.len() > 1 {
            bail!(
                "a controller of one input and one output is tuned: name one --input and one --output"
            );
        }
        if input.is_empty() || output.is_empty() {
            bail!(
                "data needs the signals of a model, --input and --output (planesman sysid topics {} lists them); a model file is *.yaml or *.json",
                data.first()
                    .map_or_else(String::new, |it| it.display().to_string())
            );
        }
        let mut options = FitOptions {
            signals: (&self.signals).into(),
            ..FitOptions::default()
        };
        options.vehicle.speed = self.dive.speed;
        let found = fit(&options, &*self.signals.data.progress())?;
        if found.analysis.estimate.process.is_some() || self.dive.speed.is_some() {
            return Ok(found.model_file()?);
        }
        // Gain, time constants and dead time have intervals of their own, which those of a larger model's modes are not.
        options.method = MethodChoice::One(Estimator::Process);
        let process = fit(&options, &());
        let as_good = process.ok().filter(|it| {
            let [own, default] =
                [it, &found].map(|it| it.analysis.held_out_fit.or(it.analysis.fit));
            own.zip(default)
                .is_some_and(|(own, default)| own > default - AS_GOOD)
        });
        Ok(as_good.as_ref().unwrap_or(&found).model_file()?)
    }
}

/// Runs the command: prints the gains, writes the page.
///
/// # Errors
/// As [`planesman_fit::fit`], [`tune()`] and [`planesman_design::DiveTask::gains`]; a page that cannot be written.
pub fn run(args: &TuneArgs) -> Result<()> {
    let model = args.model()?;
    let asked = args.controller.method.is_some() || args.controller.controller.is_some();
    if identified::is_of_pitch(&model) && !asked {
        let TuneArgs {
            controller,
            limits,
            trial,
            dive,
            json,
            ..
        } = args;
        return dive.run(model, controller, limits, trial, *json);
    }
    let found = tune(&model, &args.into())?;
    if args.json {
        planesman_console::print(serde_json::to_string_pretty(&found.as_json())? + "\n")?;
    } else {
        print_wrapped(tuning::text(&found))?;
    }
    if let Some(path) = &args.html {
        write_text(path, tuning::page(&found))?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}
