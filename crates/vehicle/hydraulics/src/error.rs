//! The errors of the actuator node's core.

use planesman_circuit::MOST_FORCE;

use crate::actuator_file::ActuatorFileError;
use crate::actuator_set::MOST_CYCLES_IN_FLIGHT;

/// A rejected input of the core; nothing changes then.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An actuator file.
    #[error(transparent)]
    ActuatorFile(#[from] ActuatorFileError),
    /// A tick that is not positive, ns.
    #[error("tick of {0} ns refused: it must be positive")]
    Tick(i64),
    /// A fault of a group that has no actuator.
    #[error("fault.group '{group}' has no actuator; all, {groups} have")]
    NoActuator {
        /// The group.
        group: &'static str,
        /// Those that have one.
        groups: String,
    },
    /// A fault where no digital hydraulic actuator is.
    #[error("fault.*: in fault.group '{0}' there is no digital hydraulic actuator that could fail")]
    NothingToFail(&'static str),
    /// Wear or a fault of a circuit of on/off valves.
    #[error(
        "fault.*, leakage.scale and friction.stepping are those of an actuator of metered volumes; '{0}' is a circuit of on/off valves, whose leakage, friction and supply are in its file"
    )]
    SoundCircuit(String),
    /// Two-speed logic on an actuator of one volume.
    #[error(
        "logic.mode is two-speed, but the actuator '{actuator}' of the {group} has no small_volume; auv_two_speed has one"
    )]
    NoSmallVolume {
        /// The actuator's name or file.
        actuator: String,
        /// The group that it moves.
        group: &'static str,
    },
    /// A latch so slow that more volumes are on their way than are kept.
    #[error(
        "fault.slow_latch '{slow_latch}' refused: a volume of the actuator '{actuator}' would arrive later than {MOST_CYCLES_IN_FLIGHT} valve cycles"
    )]
    SlowLatch {
        /// s
        slow_latch: f64,
        /// The actuator's name or file.
        actuator: String,
    },
    /// Other groups, actuators or models after the start.
    #[error("groups, actuators and models are fixed once the actuator has started")]
    Fixed,
    /// A force on the ram beyond what is taken.
    #[error("load force of {0} N refused: at most {MOST_FORCE} N to either side are taken")]
    LoadForce(f64),
    /// A motion that could not be solved, or is not finite. The run is over.
    #[error(
        "actuator '{actuator}' of the {group}, in the tick from {time} s on: {}",
        match .unsolved {
            Some(field) => format!("the search for the events of its motion does not end, by {field}"),
            None => "its motion is not finite".to_owned(),
        }
    )]
    Motion {
        /// The actuator's name or file.
        actuator: String,
        /// The group that it moves.
        group: &'static str,
        /// The tick's stamp, s.
        time: f64,
        /// The field by which the motion's events cannot be found; else a number is not finite.
        unsolved: Option<String>,
    },
    /// A number of a plane command is not finite.
    #[error("plane command refused: {0} is not finite")]
    Command(String),
}
