//! What environments are made of, checked.

use planesman_vehicle::six_dof::{FileError, Unphysical, Vehicle, load};
use serde::Deserialize;

use crate::actions::Actions;
use crate::task::Task;

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

/// Why environments were not made.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The vehicle was not taken.
    #[error(transparent)]
    Vehicle(#[from] FileError),
    /// No vehicle has such factors.
    #[error("randomise: {0}")]
    Randomise(#[from] Unphysical),
    /// An option breaks a rule.
    #[error("{entry}: {reason}")]
    Option {
        /// The option.
        entry: String,
        /// What was wrong, and what is expected.
        reason: String,
    },
}

impl Refused {
    pub(crate) fn option(entry: &str, reason: String) -> Self {
        let entry = entry.to_owned();
        Self::Option { entry, reason }
    }
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
    pub(crate) speed: f64,
    pub(crate) current: [f64; 2],
    pub(crate) randomise: Vec<(String, [f64; 2])>,
    pub(crate) step: f64,
    pub(crate) substeps: u32,
    /// Steps of an episode.
    pub(crate) steps: u32,
}

impl Setting {
    pub(crate) fn new(options: &Options) -> Result<Self, Refused> {
        let (task, name) = (options.task, options.vehicle.as_str());
        let vehicle = load(name)?;
        let known = Known::of(name);
        let moved = match &options.actions {
            Some(moved) => moved.clone(),
            None => known.actions(task),
        };
        let mut held = options.held.clone();
        let is_given = |name: &str| {
            moved.iter().any(|(other, _)| other == name)
                || options.held.iter().any(|(other, _)| other == name)
        };
        let own = known.held.iter().filter(|(name, _)| !is_given(name));
        held.extend(own.map(|(name, value)| ((*name).to_owned(), *value)));
        let actions = Actions::new(&vehicle, &moved, &held)?;
        let speed = options.speed.unwrap_or(known.speed);
        let current = options.current.unwrap_or(task.current(speed));
        let duration = options.duration.unwrap_or(task.duration());
        for (entry, value, expected) in [
            ("step", options.step, "above 0 s"),
            ("duration", duration, "above 0 s"),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Refused::option(
                    entry,
                    format!("{value} refused: {expected} is expected"),
                ));
            }
        }
        for (entry, [least, most]) in [("speed", [0.0, speed]), ("current", current)] {
            if !(0.0 <= least && least <= most && most <= FASTEST) {
                return Err(Refused::option(
                    entry,
                    format!("[{least}, {most}] refused: 0 to {FASTEST} m/s is expected"),
                ));
            }
        }
        let steps = duration / options.step;
        if !(0.5..=MOST_STEPS).contains(&steps) {
            return Err(Refused::option(
                "duration",
                format!(
                    "{steps} steps of {} s refused: 1 to {MOST_STEPS} are expected",
                    options.step
                ),
            ));
        }
        if !(1..=MOST_SUBSTEPS).contains(&options.substeps) {
            return Err(Refused::option(
                "substeps",
                format!(
                    "{} refused: 1 to {MOST_SUBSTEPS} are expected",
                    options.substeps
                ),
            ));
        }
        for (name, [least, most]) in &options.randomise {
            if !(0.0 < *least && least <= most && most.is_finite()) {
                return Err(Refused::option(
                    "randomise",
                    format!(
                        "{name} [{least}, {most}] refused: factors above 0 are expected, least and most"
                    ),
                ));
            }
        }
        for end in [0, 1] {
            vehicle.scaled(
                options
                    .randomise
                    .iter()
                    .map(|(name, range)| (name.as_str(), range[end])),
            )?;
        }
        Ok(Self {
            task,
            vehicle,
            sensors: options.sensors,
            actions,
            moved,
            speed,
            current,
            randomise: options.randomise.clone(),
            step: options.step,
            substeps: options.substeps,
            steps: steps.round() as u32,
        })
    }
}

/// What a built-in vehicle is flown with.
struct Known {
    /// Size of the angles of rudder and planes \[rad\], and of thrust \[N\], where it has it.
    fins: Option<f64>,
    thrust: Option<f64>,
    /// Forces \[N\] and moments \[N m\] of its axes.
    axes: &'static [(&'static str, f64)],
    held: &'static [(&'static str, f64)],
    /// \[m/s\]
    speed: f64,
}

impl Known {
    fn of(vehicle: &str) -> Self {
        let none = Self {
            fins: None,
            thrust: None,
            axes: &[],
            held: &[],
            speed: 0.0,
        };
        match vehicle {
            // 9 N balances its drag at 1.5 m/s.
            "lauv" => Self {
                fins: Some(0.3),
                thrust: Some(14.0),
                held: &[("thrust", 9.0)],
                speed: 1.5,
                ..none
            },
            // 13.6 degrees: Prestero 2001, Table A.5; its propeller always turns alike.
            "remus_100_6dof" | "remus_100_printed" => Self {
                fins: Some(0.237),
                speed: 1.5,
                ..none
            },
            // Beyond 15.5 N of surge the model tumbles (its file).
            "bluerov2_heavy" => Self {
                axes: &[
                    ("surge", 12.0),
                    ("sway", 12.0),
                    ("heave", 20.0),
                    ("yaw", 3.0),
                ],
                ..none
            },
            _ => none,
        }
    }

    /// What is moved in a task; nothing where the vehicle has no means for it.
    fn actions(&self, task: Task) -> Vec<(String, [f64; 2])> {
        let symmetric = |name: &str, size: f64| (name.to_owned(), [-size, size]);
        let axes = |names: &[&str]| -> Vec<_> {
            let chosen = self.axes.iter().filter(|(name, _)| names.contains(name));
            chosen.map(|(name, size)| symmetric(name, *size)).collect()
        };
        let fins = |names: &[&str]| -> Vec<_> {
            let size = self.fins.iter();
            size.flat_map(|size| names.iter().map(|name| symmetric(name, *size)))
                .collect()
        };
        let mut moved = match task {
            Task::Depth => axes(&["heave"]),
            Task::Heading => axes(&["yaw"]),
            Task::Docking | Task::Station => axes(&["surge", "sway", "heave", "yaw"]),
        };
        moved.extend(match (task, self.thrust) {
            (Task::Depth, _) => fins(&["stern_planes"]),
            (Task::Heading, _) => fins(&["rudder"]),
            (Task::Docking, _) => fins(&["rudder", "stern_planes"]),
            (Task::Station, Some(thrust)) => {
                let mut all = fins(&["rudder", "stern_planes"]);
                all.push(("thrust".to_owned(), [0.0, thrust]));
                all
            }
            // It cannot choose its speed.
            (Task::Station, None) => Vec::new(),
        });
        moved
    }
}
