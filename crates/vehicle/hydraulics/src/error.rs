//! The errors of the actuator node's core.

use planesman_circuit::MOST_FORCE;

use crate::actuator_file::ActuatorFileError;
use crate::actuator_set::MOST_CYCLES_IN_FLIGHT;

/// A rejected input of the core; the core stays unchanged.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The actuator file is refused.
    #[error(transparent)]
    ActuatorFile(#[from] ActuatorFileError),
    /// The tick is not positive, ns.
    #[error("tick of {0} ns refused: it must be positive")]
    Tick(i64),
    /// The fault's group has no actuator.
    #[error("no actuator belongs to fault.group '{group}'; known: all, {groups}")]
    NoActuator {
        /// The group.
        group: &'static str,
        /// Names of the groups with an actuator.
        groups: String,
    },
    /// The fault's group has no digital hydraulic actuator.
    #[error("fault.*: fault.group '{0}' has no digital hydraulic actuator that could fail")]
    NothingToFail(&'static str),
    /// Wear or a fault is set for a circuit of on/off valves.
    #[error(
        "fault.*, leakage.scale and friction.stepping need an actuator of metered volumes; '{0}' is a circuit of on/off valves, which has leakage, friction and supply in its own file"
    )]
    SoundCircuit(String),
    /// Two-speed logic for an actuator with only one volume.
    #[error(
        "logic.mode is two-speed, but the actuator '{actuator}' of the {group} has no small_volume; auv_two_speed has one"
    )]
    NoSmallVolume {
        /// The actuator's name or file.
        actuator: String,
        /// The group of planes that the actuator moves.
        group: &'static str,
    },
    /// The latch is so slow that too many volumes are on their way.
    #[error(
        "fault.slow_latch '{slow_latch}' refused: a volume of the actuator '{actuator}' would arrive later than {MOST_CYCLES_IN_FLIGHT} valve cycles"
    )]
    SlowLatch {
        /// s
        slow_latch: f64,
        /// Actuator's name or file.
        actuator: String,
    },
    /// Groups, actuators or models were changed after the start.
    #[error("groups, actuators and models are fixed once the actuator has started")]
    Fixed,
    /// The force on the ram exceeds its limit.
    #[error("load force of {0} N refused: the limit is {MOST_FORCE} N to either side")]
    LoadForce(f64),
    /// The motion could not be solved or is not finite. The run has ended.
    #[error(
        "actuator '{actuator}' of the {group}, in the tick that begins at {time} s: {}",
        match .unsolved {
            Some(field) => format!("the search for the events of the motion does not end. The cause is {field}"),
            None => "the motion is not finite".to_owned(),
        }
    )]
    Motion {
        /// The actuator's name or file.
        actuator: String,
        /// The group of planes that the actuator moves.
        group: &'static str,
        /// Stamp of the tick, s.
        time: f64,
        /// Field that prevents the search for the motion's events from ending; `None` if a number is not finite.
        unsolved: Option<String>,
    },
    /// A number of a plane command is not finite.
    #[error("plane command refused: {0} is not finite")]
    Command(String),
}
