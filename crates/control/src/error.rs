//! The errors of the controller.

use crate::fault::Fault;
use crate::limits::LimitError;

/// A rejected input of the controller; nothing changes then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Parameters that are each in range but do not go together, by name.
    #[error("{0}")]
    Parameters(String),
    /// A number of the vehicle's state is not finite.
    #[error("state refused: {0} is not finite")]
    State(String),
    /// A setpoint that the parameter of its name would not take.
    #[error("{0} setpoint {1}")]
    Setpoint(&'static str, String),
    /// No manoeuvre while the controller is off.
    #[error("refused: the controller is switched off (mode off)")]
    SwitchedOff,
    /// No manoeuvre in a fault.
    #[error("refused: a fault stands: {}", .0.text())]
    FaultStands(Fault),
    /// A manoeuvre that cannot be flown: the value and the rule it breaks.
    #[error("{0}")]
    Manoeuvre(String),
    /// A manoeuvre ended before its time.
    #[error("broken off: {0}")]
    BrokenOff(String),
    /// There is no fault to reset.
    #[error("there is no fault")]
    NoFault,
    /// The vehicle is still outside its envelope.
    #[error("the vehicle is still {}", .0.text())]
    StillFaulty(Fault),
    /// The vehicle's state is still silent.
    #[error("there is still no vehicle state")]
    StillSilent,
    /// A limit that is not positive.
    #[error(transparent)]
    Limit(#[from] LimitError),
}
