//! What environments are made of, checked.

use planesman_vehicle::six_dof::{Vehicle, load};
use serde::Deserialize;

use crate::actions::Actions;
use crate::refused::Refused;
use crate::task::{Conditions, Task};

/// What environments are made of.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// The task.
    pub task: Task,
    /// A built-in vehicle, or the path of a file.
    pub vehicle: String,
    /// Sensors with noise and bias are observed, not the truth.
    pub sensors: bool,
    /// Inputs or axes, each with the value at -1 and at 1; those of the vehicle and task if there is none.
    pub actions: Option<Vec<(String, [f64; 2])>>,
    /// Inputs or axes that are held; over those of the vehicle.
    pub held: Vec<(String, f64)>,
    /// Through the water, as an episode begins \[m/s\]; that of the vehicle if there is none.
    pub speed: Option<f64>,
    /// Least and most speed of the current \[m/s\]; those of the task if there is none.
    pub current: Option<[f64; 2]>,
    /// Names as of [`Vehicle::scaled`], each with the least and the most factor.
    pub randomise: Vec<(String, [f64; 2])>,
    /// Time between two actions \[s\].
    pub step: f64,
    /// Steps of the Runge-Kutta method in it.
    pub substeps: u32,
    /// Of an episode \[s\]; that of the task if there is none.
    pub duration: Option<f64>,
}

/// Most environment steps of an episode, and Runge-Kutta steps of an environment step.
const MOST_STEPS: f64 = 1e6;
const MOST_SUBSTEPS: u32 = 1000;
/// Currents and speeds beyond are no vehicle's \[m/s\].
const FASTEST: f64 = 10.0;

/// Options that were checked.
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
                "least and most, of 0 to 10 m/s",
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
                    "{name} [{least}, {most}] refused: least and most factor are expected, above 0"
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

/// Begins at \[m/s\], of the vehicles with fins.
const CRUISE: f64 = 1.5;
/// Balances the drag of `lauv` at that speed \[N\].
const LAUV_THRUST: f64 = 9.0;

/// An input or axis that is moved, with the value at -1 and at 1: rad, N, N m.
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
/// Beyond 15.5 N of surge the model tumbles (its file).
const BLUEROV: [Moved; 4] = [
    ("surge", [-12.0, 12.0]),
    ("sway", [-12.0, 12.0]),
    ("heave", [-20.0, 20.0]),
    ("yaw", [-3.0, 3.0]),
];

/// What is moved in a task; nothing where a vehicle is not known, or has no means for it.
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
