//! `planesman tune`: PI and PID gains for a model, judged over its uncertainty; of a model of the vehicle's pitch the gains of the dive
//! loops ([`dive`]).

mod dive;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, Parser};
use planesman_console::print_wrapped;
use planesman_fit::{FitOptions, fit};
use planesman_flight::sink::write_text;
use planesman_model_file::ModelFile;
use planesman_pages::tuning;
use planesman_tuning::{Kind, Method, TuneOptions, tune};
use planesman_units::Dimension;
use planesman_vehicle::identified;

use crate::arguments::{choice, output_file, quantity, within};
use crate::sysid::arguments::SignalArgs;

/// A model file stands for itself; data needs its signals.
fn of_model_or_data(argument: clap::Arg) -> clap::Arg {
    match argument.get_id().as_str() {
        "input" | "output" => argument.required(false).default_value("").hide_default_value(true),
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

/// The controller and how its gains are found.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Controller")]
struct ControllerArgs {
    /// How the gains are found [default: simc for a model that reduces to lags, integrators and dead time, else optimise]
    #[arg(long, value_parser = choice(&Method::ALL, Method::described))]
    method: Option<Method>,
    /// The kind of controller [default: pid where a second time constant is longer than the dead time, else pi]
    #[arg(long, value_parser = choice(&Kind::ALL, Kind::described))]
    controller: Option<Kind>,
    /// The controller's sample time (s, or with its unit: 50ms) [default: that of the model]
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-6, 1e6))]
    period: Option<f64>,
    /// Delay from a sample of the output to the command that answers it (s, or with its unit)
    #[arg(long, value_name = "TIME", default_value = "0", value_parser = quantity(Dimension::Time, 0.0, 1e6))]
    computing_delay: f64,
    /// For simc tau_c, for lambda lambda, for placement 1/wn (s) [default: the least that keeps the limits]
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-6, 1e9))]
    closed_loop_time: Option<f64>,
    /// For placement: damping ratio of the pair of poles
    #[arg(long, value_name = "ZETA", default_value_t = TuneOptions::default().damping_ratio, value_parser = within(0.1, 2.0))]
    damping_ratio: f64,
    /// For margins: the gain crossover (rad/s), at which the phase margin is that of --phase-margin
    #[arg(long, value_name = "RAD/S", value_parser = within(1e-9, 1e9))]
    crossover: Option<f64>,
}

/// What 95 % of the plants are to keep.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Limits, kept by 95 % of the plants that the model allows")]
struct LimitArgs {
    /// Least phase margin (deg)
    #[arg(long, value_name = "DEG", default_value_t = TuneOptions::default().phase_margin, value_parser = within(1.0, 89.0))]
    phase_margin: f64,
    /// Least gain margin, to either side (dB)
    #[arg(long, value_name = "DB", default_value_t = TuneOptions::default().gain_margin, value_parser = within(0.1, 60.0))]
    gain_margin: f64,
    /// Largest sensitivity peak Ms: 1.4 for a calm loop, 2 for a fast one
    #[arg(long, value_name = "PEAK", default_value_t = TuneOptions::default().ms, value_parser = within(1.05, 100.0))]
    ms: f64,
    /// Plants drawn from the model's covariance
    #[arg(long, value_name = "COUNT", default_value_t = 500, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    draws: u32,
    /// Seed of the draws
    #[arg(long, default_value_t = TuneOptions::default().seed)]
    seed: u32,
    /// Take the model even if its verdict is against it, or it has no covariance
    #[arg(long)]
    anyway: bool,
}

/// The steps that are simulated.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Simulated steps")]
struct TrialArgs {
    /// Step of the setpoint, in the output's unit
    #[arg(long, value_name = "SIZE", default_value_t = TuneOptions::default().step, value_parser = step, allow_hyphen_values = true)]
    step: f64,
    /// How far the input may go from where it stands, down and up, in its unit
    #[arg(long, value_name = "FROM..TO", value_parser = limit, allow_hyphen_values = true)]
    input_limit: Option<(f64, f64)>,
}

fn step(text: &str) -> Result<f64, String> {
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|it| it.is_finite() && *it != 0.0);
    value.ok_or_else(|| "a number other than 0 is expected".to_owned())
}

fn limit(text: &str) -> Result<(f64, f64), String> {
    let ends = text
        .split_once("..")
        .and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    let within = |(low, high): &(f64, f64)| {
        *low <= 0.0 && *high >= 0.0 && low < high && low.is_finite() && high.is_finite()
    };
    ends.filter(within)
        .ok_or_else(|| "FROM..TO about 0 is expected, as -5..10".to_owned())
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
        if let ([path], true) = (&data[..], input.is_empty() && output.is_empty()) {
            if ModelFile::takes_name(path).is_ok() {
                return Ok(ModelFile::read(path)?);
            }
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
        Ok(found.model_file()?)
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
        return dive::run(args, model);
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
