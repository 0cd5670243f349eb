//! The options of environments, checked.

use planesman_vehicle::six_dof::{Vehicle, load};
use serde::Deserialize;

use crate::actions::Actions;
use crate::refused::Refused;
use crate::task::{Conditions, Task};

/// The options of environments.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// The task.
    pub task: Task,
    /// A built-in vehicle, or the path of a file.
    pub vehicle: String,
    /// Whether to observe sensor readings with noise and bias instead of the true quantities.
    pub sensors: bool,
    /// Inputs or axes, each with the value at -1 and at 1; `None` for the default of vehicle and task.
    pub actions: Option<Vec<(String, [f64; 2])>>,
    /// Constant inputs or axes; these override the vehicle's.
    pub held: Vec<(String, f64)>,
    /// Initial speed through the water \[m/s\]; `None` for the vehicle's default.
    pub speed: Option<f64>,
    /// Smallest and largest speed of the current \[m/s\]; `None` for the task's default.
    pub current: Option<[f64; 2]>,
    /// Names as in [`Vehicle::scaled`], each with its least and largest factor.
    pub randomise: Vec<(String, [f64; 2])>,
    /// Time between two actions \[s\].
    pub step: f64,
    /// Runge-Kutta steps between two actions.
    pub substeps: u32,
    /// Duration of an episode \[s\]; `None` for the task's default.
    pub duration: Option<f64>,
}

/// Maximum number of environment steps in an episode, and of Runge-Kutta steps in an environment step.
const MOST_STEPS: f64 = 1e6;
const MOST_SUBSTEPS: u32 = 1000;
/// Maximum of currents and speeds \[m/s\].
const FASTEST: f64 = 10.0;

/// Checked options.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) task: Task,
    pub(crate) vehicle: Vehicle,
    pub(crate) sensors: bool,
    pub(crate) actions: Actions,
    /// The name of each action, with the value at -1 and at 1.
    pub(crate) moved: Vec<(String, [f64; 2])>,
    pub(crate) conditions: Conditions,
    pub(crate) randomise: Vec<(String, [f64; 2])>,
    pub(crate) substeps: u32,
    /// Steps of an episode.
    pub(crate) steps: u32,
}

impl Setting {
    pub(crate) fn new(options: &Options) -> Result<Self, Refused> {
        let (task, name) = (options.task, options.vehicle.as_str());
        let vehicle = load(name)?;
        let own = || {
            defaults(name, task)
                .iter()
                .map(|(name, range)| ((*name).to_owned(), *range))
        };
        let moved = options.actions.clone().unwrap_or_else(|| own().collect());
        let mut held = options.held.clone();
        let names = moved
            .iter()
            .map(|it| &it.0)
            .chain(held.iter().map(|it| &it.0));
        if name == "lauv" && !names.into_iter().any(|name| name == "thrust") {
            held.push(("thrust".to_owned(), LAUV_THRUST));
        }
        let actions = Actions::new(&vehicle, &moved, &held)?;
        let cruises = matches!(name, "lauv" | "remus_100_6dof" | "remus_100_printed");
        let speed = options.speed.unwrap_or(if cruises { CRUISE } else { 0.0 });
        let current = options.current.unwrap_or(task.current(speed));
        let duration = options.duration.unwrap_or(task.duration());
        let (step, substeps, steps) = (options.step, options.substeps, duration / options.step);
        let speeds = |[least, most]: [f64; 2]| 0.0 <= least && least <= most && most <= FASTEST;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let rules = [
            ("step", step, positive(step), "a time above 0 s"),
            ("duration", duration, positive(duration), "a time above 0 s"),
            (
                "duration / step",
                steps,
                (0.5..=MOST_STEPS).contains(&steps),
                "1 to 1e6 steps",
            ),
            (
                "substeps",
                f64::from(substeps),
                (1..=MOST_SUBSTEPS).contains(&substeps),
                "1 to 1000",
            ),
            ("speed", speed, speeds([0.0, speed]), "0 to 10 m/s"),
            (
                "current",
                current[1],
                speeds(current),
                "the smallest and the largest value, 0 to 10 m/s",
            ),
        ];
        if let Some((entry, value, _, expected)) = rules.into_iter().find(|(_, _, holds, _)| !holds)
        {
            return Err(Refused::option(
                entry,
                format!("{value} refused: {expected} is expected"),
            ));
        }
        for (name, [least, most]) in &options.randomise {
            if !(0.0 < *least && least <= most && most.is_finite()) {
                let reason = format!(
                    "{name} [{least}, {most}] refused: give the least and the largest factor, both above 0"
                );
                return Err(Refused::option("randomise", reason));
            }
        }
        for end in [0, 1] {
            let factors = options.randomise.iter();
            vehicle.scaled(factors.map(|(name, range)| (name.as_str(), range[end])))?;
        }
        Ok(Self {
            task,
            vehicle,
            sensors: options.sensors,
            actions,
            moved,
            conditions: Conditions {
                speed,
                current,
                step,
            },
            randomise: options.randomise.clone(),
            substeps,
            steps: steps.round() as u32,
        })
    }
}

/// Initial speed of the vehicles with fins \[m/s\].
const CRUISE: f64 = 1.5;
/// Thrust that balances the drag of `lauv` at that speed \[N\].
const LAUV_THRUST: f64 = 9.0;

/// A moved input or axis, with the value at -1 and at 1: rad, N, N m.
type Moved = (&'static str, [f64; 2]);

const LAUV: [Moved; 3] = [
    ("rudder", [-0.3, 0.3]),
    ("stern_planes", [-0.3, 0.3]),
    ("thrust", [0.0, 14.0]),
];
/// 13.6 degrees: Prestero 2001.
const REMUS: [Moved; 2] = [
    ("rudder", [-0.237, 0.237]),
    ("stern_planes", [-0.237, 0.237]),
];
/// Beyond 15.5 N of surge the model tumbles (see its file).
const BLUEROV: [Moved; 4] = [
    ("surge", [-12.0, 12.0]),
    ("sway", [-12.0, 12.0]),
    ("heave", [-20.0, 20.0]),
    ("yaw", [-3.0, 3.0]),
];

/// The default actions of a task; empty if the vehicle is not known, or cannot do the task.
fn defaults(vehicle: &str, task: Task) -> &'static [Moved] {
    match (vehicle, task) {
        ("lauv", Task::Depth) => &LAUV[1..2],
        ("lauv", Task::Heading) => &LAUV[..1],
        ("lauv", Task::Docking) => &LAUV[..2],
        ("lauv", Task::Station) => &LAUV,
        ("remus_100_6dof" | "remus_100_printed", Task::Depth) => &REMUS[1..],
        ("remus_100_6dof" | "remus_100_printed", Task::Heading) => &REMUS[..1],
        ("remus_100_6dof" | "remus_100_printed", Task::Docking) => &REMUS,
        ("bluerov2_heavy", Task::Depth) => &BLUEROV[2..3],
        ("bluerov2_heavy", Task::Heading) => &BLUEROV[3..],
        ("bluerov2_heavy", Task::Docking | Task::Station) => &BLUEROV,
        _ => &[],
    }
}
