//! Gains of the depth and pitch loops for an identified vehicle, and flights of vehicles drawn from the model's covariance.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use planesman_console::{Format, Outcome, Table, called, file_line};
use planesman_flight::scenario::Scenario;
use planesman_flight::sink::write_text;
use planesman_flight::sweep::Sweep;
use planesman_flight::sweep::outcomes::Outcomes;
use planesman_model_file::ModelFile;
use planesman_show::design::{
    ACTUATOR, DiveGains, DiveTask, Subject, described, gains_text, speed_text,
};
use planesman_show::pages::review::{Gains, drawn_text, of_dive, worst};
use planesman_tuning::{Distribution, MISSED, drawn};
use planesman_vehicle::vehicle_file;
use serde_json::json;

use super::arguments::{ControllerArgs, LimitArgs, TrialArgs};
use crate::arguments::{make_way_for_folder, output_file, speed, within};

/// Maximum number of vehicles drawn.
const MOST_DRAWS: usize = 100;
/// Number of vehicles flown.
const FLOWN: usize = 40;
/// Longest duration of a step response and of a flight, s.
const DURATION: f64 = 120.0;

/// Options for a model from plane_motion:dive_planes to state:pitch or state:pitch_rate.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Depth and pitch gains, for a model of the vehicle's pitch")]
pub(super) struct DiveArgs {
    /// The vehicle's speed in the record (m/s, or with its unit: 1ft/s); a model file contains it
    #[arg(long, value_parser = speed(1e-3, 100.0))]
    pub(super) speed: Option<f64>,
    /// Base vehicle: supplies everything except the pitch dynamics
    #[arg(long, value_name = "VEHICLE", default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Actuator of the planes: ideal, first_order, or a built-in actuator or actuator file
    #[arg(long, default_value = ACTUATOR)]
    actuator: String,
    /// Maximum overshoot of a depth step (%)
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, value_parser = within(0.0, 100.0))]
    overshoot: f64,
}

/// Files to write for the gains.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Depth and pitch gains, for a model of the vehicle's pitch")]
pub(super) struct DiveFileArgs {
    /// Write the gains as a parameter file of depth_controller, *.yaml
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    gains: Option<PathBuf>,
    /// Fly a depth step with the gains for every drawn vehicle, at most 40, as planesman sweep does; writes model files, scenario and results
    /// into this new folder
    #[arg(long, value_name = "FOLDER")]
    fly: Option<PathBuf>,
}

impl DiveArgs {
    /// The design task of a model: speed, base vehicle, actuator and limits.
    pub(super) fn task(
        &self,
        model: ModelFile,
        controller: &ControllerArgs,
        limits: &LimitArgs,
        trial: &TrialArgs,
    ) -> DiveTask {
        let mut subject = Subject {
            actuator: self.actuator.clone(),
            computing_delay: controller.computing_delay,
            ..Subject::default()
        };
        if let Some(period) = controller.period {
            subject.rate = 1.0 / period;
        }
        DiveTask {
            base: self.base.clone(),
            subject,
            phase_margin: limits.phase_margin.to_radians(),
            gain_margin: libm::pow(10_f64, limits.gain_margin / 20.0),
            sensitivity: limits.ms,
            overshoot: self.overshoot,
            step: trial.step.abs(),
            duration: DURATION,
            draws: drawn(&model, (limits.draws as usize).min(MOST_DRAWS), limits.seed),
            model,
        }
    }
}

impl DiveFileArgs {
    /// Prints the gains, writes the requested files, and flies the vehicles.
    pub(super) fn write(
        &self,
        task: &DiveTask,
        found: &DiveGains,
        json: bool,
        verbose: bool,
    ) -> Result<()> {
        if let Some(path) = &self.gains {
            write_text(path, found.parameter_file())?;
        }
        if json {
            planesman_console::print(serde_json::to_string_pretty(&as_json(task, found))? + "\n")?;
            if let Some(path) = &self.gains {
                planesman_console::err!("{}", file_line("Gains", path));
            }
        } else {
            let mut outcome = outcome(task, found, verbose);
            outcome = match &self.gains {
                Some(path) => outcome.file("Gains", path),
                None => outcome.next(
                    format!("{} --gains gains.yaml", called()),
                    "for ros2 param load",
                ),
            };
            outcome.print()?;
        }
        if let Some(folder) = &self.fly {
            fly(folder, task, found)?;
        }
        Ok(())
    }
}

/// The gains in the form of a review.
///
/// # Errors
/// Same as [`DiveTask::depths`].
pub(crate) fn review(task: &DiveTask, found: &DiveGains, seed: u32) -> Result<Gains<'static>> {
    let [margins, steps] = [0..3, 3..5].map(|of| table(&rows(found)[of]));
    let phase = found.phase();
    let kept = match found.draws.len() {
        0 => "limits kept by the model, which is assumed to be exact".to_owned(),
        n => format!("limits kept by 95 % of {n} vehicles drawn from the model's covariance"),
    };
    Ok(Gains {
        keeps_limits: true,
        sentences: vec![
            kept,
            worst(
                [phase.clone(), found.gain(), found.sensitivity()],
                found.draws.len(),
            ),
        ],
        lines: vec![
            ("depth_controller", gains_text(&found.gains)),
            (
                "loop",
                format!(
                    "{} at {}, actuator {}, {} Hz",
                    task.base,
                    speed_text(found.speed),
                    task.subject.actuator,
                    task.subject.rate
                ),
            ),
            ("limits", limits(task)),
        ],
        crossover: None,
        plants: drawn_text(found.draws.len(), seed),
        margins,
        steps,
        causes: None,
        plots: of_dive(&phase, task.phase_margin, &task.depths(found)?),
    })
}

/// The limits as text.
fn limits(task: &DiveTask) -> String {
    format!(
        "phase margin {:.1} deg, gain margin {:.1} dB, sensitivity peak Ms {:.2}",
        task.phase_margin.to_degrees(),
        20.0 * libm::log10(task.gain_margin),
        task.sensitivity
    )
}

fn cell(value: f64, decimals: usize) -> String {
    match value.is_finite() {
        true => format!("{value:.decimals$}"),
        false => "-".to_owned(),
    }
}

/// Rows of the table: name, distribution, whether the worst value is the largest, and number of decimals.
fn rows(found: &DiveGains) -> [(&'static str, Distribution, bool, usize); 5] {
    [
        ("phase margin, deg", found.phase(), false, 1),
        ("gain margin, dB", found.gain(), false, 1),
        ("sensitivity peak Ms", found.sensitivity(), true, 2),
        ("overshoot, %", found.overshoot(), true, 2),
        ("settling time (5 %), s", found.settling(), true, 2),
    ]
}

fn table(rows: &[(&'static str, Distribution, bool, usize)]) -> Table {
    let mut table = Table::of(["", "model", "worst of 95 %", "median"]);
    for (name, spread, is_peak, decimals) in rows {
        let share = if *is_peak { 1.0 - MISSED } else { MISSED };
        table.row([
            (*name).to_owned(),
            cell(spread.model, *decimals),
            cell(spread.quantile(share), *decimals),
            cell(spread.quantile(0.5), *decimals),
        ]);
    }
    table
}

/// The gains, their margins over the drawn vehicles, and the next commands.
fn outcome(task: &DiveTask, found: &DiveGains, verbose: bool) -> Outcome {
    let kept = match found.draws.len() {
        0 => "The model has no covariance and is assumed to be exact.".to_owned(),
        n => format!("95 % of {n} vehicles drawn from the model's covariance keep all limits."),
    };
    let set = found
        .parameters()
        .map(|(name, value)| format!(" --set depth_controller.{name}={value:.4}"));
    let mut outcome = Outcome::new(format!(
        "Gains at {}: {}\n{kept}",
        speed_text(found.speed),
        gains_text(&found.gains)
    ))
    .numbers(table(&rows(found)).text(Format::Table));
    if let Some((reason, count)) = &found.left_out {
        outcome = outcome.numbers(format!(
            "\n{count} more draws were left out, because such vehicles are physically impossible: {reason}"
        ));
    }
    if verbose {
        outcome = outcome.numbers(format!(
            "\n{} to {} on {}, actuator {}, {} Hz\n{}",
            task.model.input,
            task.model.output,
            task.base,
            task.subject.actuator,
            task.subject.rate,
            described(&found.model)
        ));
    }
    outcome.next(
        format!("planesman sim dive{}", set.concat()),
        "fly with these gains",
    )
}

pub(crate) fn as_json(task: &DiveTask, found: &DiveGains) -> serde_json::Value {
    let spread = |of: &Distribution| {
        let finite = |value: f64| Some(value).filter(|it| it.is_finite());
        json!({
            "model": finite(of.model),
            "q05": finite(of.quantile(MISSED)),
            "q50": finite(of.quantile(0.5)),
            "q95": finite(of.quantile(1.0 - MISSED)),
        })
    };
    let gains = found
        .parameters()
        .map(|(name, value)| (name.to_owned(), json!(value)));
    json!({
        "input": task.model.input,
        "output": task.model.output,
        "speed": found.speed,
        "depth_controller": serde_json::Map::from_iter(gains),
        "draws": found.draws.len(),
        "left_out": found.left_out.as_ref().map_or(0, |it| it.1),
        "phase_margin": spread(&found.phase()),
        "gain_margin": spread(&found.gain()),
        "ms": spread(&found.sensitivity()),
        "overshoot": spread(&found.overshoot()),
        "settling_time": spread(&found.settling()),
    })
}

/// The files in the folder of [`fly`]; the folder is recognised by the first one.
const OWN: [&str; 5] = [
    "scenario.yaml",
    "model_*.yaml",
    "sweep/sweep.yaml",
    "sweep/cases.csv",
    "sweep/cases.parquet",
];

/// Flies a depth step with the model's vehicle and with the drawn vehicles; each is a model file in the folder.
fn fly(folder: &Path, task: &DiveTask, found: &DiveGains) -> Result<()> {
    make_way_for_folder(folder, &OWN)?;
    std::fs::create_dir(folder).with_context(|| format!("'{}'", folder.display()))?;
    let own = std::iter::once(&task.model);
    let mut vehicles = Vec::new();
    for (number, file) in own.chain(task.draws.iter().take(FLOWN)).enumerate() {
        // A drawn model that is no vehicle's was left out of the margins too.
        let base = vehicle_file::load(&task.base)?;
        if planesman_vehicle::identified::vehicle(&base, file).is_err() {
            continue;
        }
        let path = folder.join(format!("model_{number:03}.yaml"));
        file.write(&path)?;
        vehicles.push(path.canonicalize()?.display().to_string());
    }
    let scenario = scenario(task, found, &vehicles[0]);
    write_text(&folder.join("scenario.yaml"), &scenario)?;
    let vary = format!("plant_sim.vehicle={}", vehicles.join(","));
    let sweep = Sweep::new(Scenario::parse(&scenario)?, &[vary], None, 1)?;
    let results = folder.join("sweep");
    sweep.define(&results, None)?;
    let jobs = std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let flown = sweep.fly(&results, None, jobs, &())?;
    let outcomes = Outcomes::read(&results, None, sweep.space())?;
    let each = || outcomes.combinations.values();
    let settled: Vec<f64> = each().filter_map(|it| it.settling.value()).collect();
    let travel: Vec<f64> = each().filter_map(|it| it.travel.value()).collect();
    let settling = Distribution::new(
        settled.first().copied().unwrap_or(f64::INFINITY),
        settled.iter().copied(),
    );
    let travel = Distribution::new(
        travel.first().copied().unwrap_or(f64::INFINITY),
        travel.iter().map(|it| it.to_degrees()),
    );
    let unsettled: u32 = each().map(|it| it.unsettled).sum();
    planesman_console::err!(
        "Flown: {}\n{} vehicles flown, {} broke off, {unsettled} did not settle; settling time (5 %) {} s at the median, {} s at 95 %; planes moved {} deg at the \
         median, {} deg at 95 %",
        flown.file.display(),
        outcomes.cases,
        outcomes.failed,
        cell(settling.quantile(0.5), 2),
        cell(settling.quantile(1.0 - MISSED), 2),
        cell(travel.quantile(0.5), 1),
        cell(travel.quantile(1.0 - MISSED), 1)
    );
    Ok(())
}

/// Scenario of a depth step with the gains, without a test signal.
fn scenario(task: &DiveTask, found: &DiveGains, vehicle: &str) -> String {
    let gains: String = found
        .parameters()
        .iter()
        .map(|(name, value)| format!("    {name}: {value:?}\n"))
        .collect();
    let model = match task.subject.actuator.as_str() {
        "ideal" | "first_order" => format!("    model: {}\n", task.subject.actuator),
        name => format!("    actuator: {name:?}\n"),
    };
    format!(
        "description: A depth step with the gains of planesman tune\nduration: {DURATION:?}\ntick: {:?}\nparameters:\n  plant_sim:\n    vehicle: {vehicle:?}\n    \
         vehicle_base: {:?}\n    speed: {:?}\n  depth_controller:\n    mode: depth\n    depth_setpoint: {:?}\n{gains}    identification:\n      signal: none\n  \
         dha_actuator:\n{model}",
        1.0 / task.subject.rate,
        task.base,
        found.speed,
        task.step
    )
}
