//! The errors of the controller.

use crate::fault::Fault;
use crate::gains::FileError;
use crate::limits::LimitError;

/// A rejected input of the controller; nothing changes then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Parameters that are each in range but do not go together, by name.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
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
    /// A manoeuvre that cannot be flown.
    #[error(transparent)]
    Manoeuvre(#[from] ManoeuvreError),
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

/// Parameters that are each in range but do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// A limit of zero.
    #[error("parameter '{0}': {1}")]
    Limit(&'static str, LimitError),
    /// Back-calculation without a tracking time constant.
    #[error(
        "parameters 'anti_windup.*': a tracking time of {0} s refused: back-calculation needs a positive one"
    )]
    TrackingTime(f64),
    /// A model file whose model is not used.
    #[error("parameter 'gains.file': {0}")]
    GainsFile(FileError),
    /// Depths over times and over distances.
    #[error(
        "parameters 'schedule.times', 'schedule.distances': refused: a schedule is over time or over distance, not both"
    )]
    TwoSchedules,
    /// A schedule that makes no sense.
    #[error("parameters 'schedule.{list}', 'schedule.depths': {reason}")]
    Schedule {
        /// `times` or `distances`.
        list: &'static str,
        /// Why not.
        reason: ScheduleError,
    },
    /// No depth between the bounds.
    #[error("parameters 'depth.min', 'depth.max': {min} m refused: it lies below {max} m")]
    DepthBounds {
        /// The least depth, m.
        min: f64,
        /// The largest depth, m.
        max: f64,
    },
    /// A depth that could not be held.
    #[error(
        "parameter '{name}': {depth} m refused: only depths from depth.min ({min} m) to depth.max ({max} m) are held"
    )]
    Depth {
        /// The parameter.
        name: &'static str,
        /// Its depth, m.
        depth: f64,
        /// The least depth, m.
        min: f64,
        /// The largest depth, m.
        max: f64,
    },
    /// An envelope narrower than what the loops are allowed.
    #[error("parameter '{name}': {value} refused: at most {other}, {bound}")]
    Envelope {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The parameter that bounds it.
        other: &'static str,
        /// The value of that.
        bound: f64,
    },
    /// A test signal beyond the plane limit.
    #[error(
        "parameter 'identification.amplitude': {amplitude} rad refused: planes.limit ({limit} rad) would clip the signal"
    )]
    Clipped {
        /// The amplitude, rad.
        amplitude: f64,
        /// The plane limit, rad.
        limit: f64,
    },
    /// A vehicle that cannot hover.
    #[error("parameter 'hover.vehicle': {0}")]
    Hover(String),
    /// Mode hover without a vehicle to hover.
    #[error(
        "parameter 'mode': hover refused: 'hover.vehicle' names no vehicle with thrusters (bluerov2_heavy is one)"
    )]
    NothingHovers,
    /// Way-points of two lengths.
    #[error(
        "parameters 'waypoints.x', 'waypoints.y': {x} and {y} values refused: each way-point has both"
    )]
    WayPoints {
        /// Of `x`.
        x: usize,
        /// Of `y`.
        y: usize,
    },
    /// A test signal that cannot be timed.
    #[error("parameters 'identification.*': {0}")]
    TestSignal(ManoeuvreError),
}

/// Why depths over time or distance make no schedule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// Lists of different lengths.
    #[error("schedule refused: {beginnings} {what}s but {depths} depths")]
    Lengths {
        /// `time` or `distance`.
        what: &'static str,
        /// How many of them.
        beginnings: usize,
        /// How many depths.
        depths: usize,
    },
    /// A number that is none.
    #[error("schedule refused: {0} is not finite")]
    NotFinite(f64),
    /// A depth before the run.
    #[error("schedule refused: the {what} {beginning} {unit} is negative")]
    Negative {
        /// `time` or `distance`.
        what: &'static str,
        /// Its value.
        beginning: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// Entries out of order.
    #[error(
        "schedule refused: its {what}s must increase, {before} {unit} is followed by {after} {unit}"
    )]
    Order {
        /// `time` or `distance`.
        what: &'static str,
        /// Its unit.
        unit: &'static str,
        /// An entry.
        before: f64,
        /// The next one.
        after: f64,
    },
    /// Times that are one, in whole nanoseconds.
    #[error("schedule refused: its times must increase by a nanosecond at least, at {0} s")]
    SameTime(f64),
}

/// Why a manoeuvre or a test signal cannot be flown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ManoeuvreError {
    /// No manoeuvre of this name.
    #[error("manoeuvre '{name}' refused: it must be one of {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// A number that is none.
    #[error("{0} {1} refused: it must be finite")]
    NotFinite(&'static str, f64),
    /// A time before the run.
    #[error("{0} {1} s refused: it must not be negative")]
    Negative(&'static str, f64),
    /// A signal without its period, s.
    #[error("period {0} s refused: this test signal needs a positive one")]
    Period(f64),
    /// A chirp without its last period or without an end.
    #[error(
        "period_end {period_end} s, duration {duration} s refused: a chirp needs both positive"
    )]
    Chirp {
        /// The last period, s.
        period_end: f64,
        /// The duration, s.
        duration: f64,
    },
    /// An amplitude beyond the plane limit, both rad.
    #[error("amplitude {0} rad refused: planes.limit ({1} rad) would clip it")]
    Clipped(f64, f64),
    /// A duration out of range, s.
    #[error("duration {0} s refused: 0 to 1e6 s")]
    Duration(f64),
    /// A signal that does not end of itself.
    #[error("duration 0 s refused: a {0} needs one to end")]
    Endless(String),
}
