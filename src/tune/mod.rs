//! `planesman tune`: PI and PID gains for a model, with their margins over its uncertainty; for a model of the vehicle's pitch, the gains of
//! the depth and pitch loops (`dive`).

mod arguments;
mod dive;
mod gains;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Parser;
use planesman_console::{called, file_line};
use planesman_fit::{FitData, FitError, FitOptions, FitResult, MethodChoice};
use planesman_flight::sink::write_text;
use planesman_identification::estimators::Method as Estimator;
use planesman_model_file::ModelFile;
use planesman_parallel::Progress;
use planesman_show::pages::tuning;

use self::dive::DiveFileArgs;
pub(crate) use self::dive::{as_json as json_of_dive, review as review_of_dive};
pub(crate) use self::gains::{GainArgs, Gains};
use crate::arguments::page_file;
use crate::sysid::arguments::SignalArgs;

/// Largest ratio of a process model's held-out error to the default model's at which the process model is preferred.
const AS_GOOD: f64 = 1.02;

/// A model file needs no signals; data does.
fn of_model_or_data(argument: clap::Arg) -> clap::Arg {
    match argument.get_id().as_str() {
        "input" | "output" => argument.required(false),
        "data" => argument.help(
            "A model file of planesman sysid fit --model; or data (a bag, tables or logs, with -i and -o), from which a model is identified first",
        ),
        _ => argument,
    }
}

/// Find PI or PID gains for a model, and their margins for the model's uncertainty.
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
    gains: GainArgs,
    #[command(flatten)]
    files: DiveFileArgs,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Also print the model, the method, and the cause that limits the margins
    #[arg(long, help_heading = "Output")]
    verbose: bool,
    /// Write an HTML page: responses, Bode and Nyquist plots, each with the band of the plants drawn from its covariance
    #[arg(long, value_name = "FILE", value_parser = page_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

/// The model to tune for: the default, or a process model whose held-out error is at most 2 % larger. A process model gives intervals of its gain,
/// time constants and dead time; a larger model gives no intervals for its modes.
///
/// # Errors
/// Like [`FitData::fit`] of the default model.
pub(crate) fn model_for_gains(
    data: &FitData,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<FitResult, FitError> {
    let found = data.fit(options, progress)?;
    if found.analysis.estimate.process.is_some() || options.vehicle.speed.is_some() {
        return Ok(found);
    }
    let options = FitOptions {
        method: MethodChoice::One(Estimator::Process),
        ..options.clone()
    };
    let held_out = |it: &FitResult| it.analysis.held_out.fit.or(it.analysis.fit);
    let as_good = data.fit(&options, &()).ok().filter(|it| {
        let fits = held_out(it).zip(held_out(&found));
        fits.is_some_and(|(own, default)| 100.0 - own <= AS_GOOD * (100.0 - default))
    });
    Ok(as_good.unwrap_or(found))
}

impl TuneArgs {
    /// The model from the file, or identified from the data.
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
                "tune needs a controller with one input and one output. Name one --input and one --output"
            );
        }
        if input.is_empty() || output.is_empty() {
            bail!(
                "to identify a model from data, name the signals with --input and --output (planesman sysid topics {} lists them). A model file has the ending .yaml or .json",
                data.first()
                    .map_or_else(String::new, |it| it.display().to_string())
            );
        }
        let mut options = FitOptions {
            signals: self.signals.options(),
            ..FitOptions::default()
        };
        options.vehicle.speed = self.gains.speed();
        let progress = self.signals.data.progress();
        let data = FitData::read(&options, &*progress)?;
        Ok(model_for_gains(&data, &options, &*progress)?.model_file()?)
    }
}

/// Prints the gains and writes the page.
///
/// # Errors
/// Like [`planesman_fit::fit`], [`planesman_tuning::tune`] and [`planesman_show::design::DiveTask::gains`]; a page that cannot be written.
pub fn run(args: &TuneArgs) -> Result<()> {
    let found = match args.gains.gains(args.model()?)? {
        Gains::Dive(task, found) => {
            return args.files.write(&task, &found, args.json, args.verbose);
        }
        Gains::Controller(found) => found,
    };
    if let Some(path) = &args.html {
        write_text(path, tuning::page(&found))?;
    }
    if args.json {
        planesman_console::print(serde_json::to_string_pretty(&found.as_json())? + "\n")?;
        if let Some(path) = &args.html {
            planesman_console::err!("{}", file_line("Page", path));
        }
        return Ok(());
    }
    let outcome = tuning::outcome(&found, args.verbose);
    Ok(match &args.html {
        Some(path) => outcome.file("Page", path),
        None => outcome.next(
            format!("{} --html tune.html", called()),
            "responses, Bode and Nyquist plot for all these plants",
        ),
    }
    .print()?)
}
