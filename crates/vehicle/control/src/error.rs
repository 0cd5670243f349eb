//! The errors of the controller.

use crate::fault::Fault;
use crate::gains::FileError;
use crate::limits::LimitError;

/// A rejected input of the controller; then nothing changes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Parameters that are each in range but conflict, by name.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// A number of the vehicle's state is not finite.
    #[error("state refused: {0} is not finite")]
    State(String),
    /// A setpoint outside the range of the parameter with its name.
    #[error("{0} setpoint {1}")]
    Setpoint(&'static str, String),
    /// A manoeuvre was requested while the controller is off.
    #[error("refused: the controller is switched off (mode off)")]
    SwitchedOff,
    /// A manoeuvre was requested while a fault is latched.
    #[error("refused, because a fault is latched: {}. Reset the fault first", .0.text())]
    FaultStands(Fault),
    /// A manoeuvre that cannot be flown.
    #[error(transparent)]
    Manoeuvre(#[from] ManoeuvreError),
    /// A manoeuvre that was aborted.
    #[error("broken off: {0}")]
    BrokenOff(String),
    /// There is no fault to reset.
    #[error("there is no fault")]
    NoFault,
    /// The vehicle is still outside its envelope.
    #[error("the vehicle is still {}", .0.text())]
    StillFaulty(Fault),
    /// The vehicle's state is still missing.
    #[error("no vehicle state has been received yet")]
    StillSilent,
    /// A limit that is not positive.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

/// Parameters that are each in range but conflict.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// A limit of zero.
    #[error("parameter '{0}': {1}")]
    Limit(&'static str, LimitError),
    /// Back-calculation has no tracking time constant.
    #[error(
        "parameters 'anti_windup.*': a tracking time of {0} s refused: back-calculation needs a positive one"
    )]
    TrackingTime(f64),
    /// A model file whose model cannot be used.
    #[error("parameter 'gains.file': {0}")]
    GainsFile(FileError),
    /// Depths are given over both times and distances.
    #[error(
        "parameters 'schedule.times', 'schedule.distances': refused: a schedule must be over time \
         or over distance, not both"
    )]
    TwoSchedules,
    /// An invalid schedule.
    #[error("parameters 'schedule.{list}', 'schedule.depths': {reason}")]
    Schedule {
        /// `times` or `distances`.
        list: &'static str,
        /// The reason.
        reason: ScheduleError,
    },
    /// No depth lies between the bounds.
    #[error(
        "parameters 'depth.min', 'depth.max': {min} m refused: depth.min must not be above depth.max, {max} m"
    )]
    DepthBounds {
        /// The smallest depth, m.
        min: f64,
        /// The largest depth, m.
        max: f64,
    },
    /// A depth outside the bounds.
    #[error(
        "parameter '{name}': {depth} m refused: it must be from depth.min ({min} m) to depth.max \
         ({max} m)"
    )]
    Depth {
        /// The parameter.
        name: &'static str,
        /// Its depth, m.
        depth: f64,
        /// The smallest depth, m.
        min: f64,
        /// The largest depth, m.
        max: f64,
    },
    /// An envelope narrower than the range allowed for the loops.
    #[error("parameter '{name}': {value} refused: it must be at most {other}, which is {bound}")]
    Envelope {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The parameter that bounds the envelope.
        other: &'static str,
        /// That parameter's value.
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
    /// A vehicle without the thrusters that hovering needs.
    #[error("parameter 'hover.vehicle': {0}")]
    Hover(String),
    /// Mode hover was requested without a vehicle.
    #[error(
        "parameter 'mode': hover refused: set 'hover.vehicle' to a vehicle with thrusters (for \
         example bluerov2_heavy)"
    )]
    NothingHovers,
    /// Lists of way-points with different lengths.
    #[error(
        "parameters 'waypoints.x', 'waypoints.y': {x} and {y} values refused: each way-point \
         needs both"
    )]
    WayPoints {
        /// Of `x`.
        x: usize,
        /// Of `y`.
        y: usize,
    },
    /// A test signal with invalid times.
    #[error("parameters 'identification.*': {0}")]
    TestSignal(ManoeuvreError),
}

/// The reason why depths over time or distance do not form a schedule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// Lists of different lengths.
    #[error("schedule refused: it has {beginnings} {what}s but {depths} depths")]
    Lengths {
        /// `time` or `distance`.
        what: &'static str,
        /// Their number.
        beginnings: usize,
        /// How many depths.
        depths: usize,
    },
    /// A number that is not finite.
    #[error("schedule refused: {0} is not finite")]
    NotFinite(f64),
    /// An entry before the beginning of the run.
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
        "schedule refused: each {what} must be larger than the previous one, but {before} {unit} is followed by {after} {unit}"
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
    /// Times that are equal in whole nanoseconds.
    #[error("schedule refused: successive times must differ by at least a nanosecond, at {0} s")]
    SameTime(f64),
}

/// The reason why a manoeuvre or a test signal cannot be flown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ManoeuvreError {
    /// No manoeuvre has this name.
    #[error("manoeuvre '{name}' refused: the name must be one of {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The known names.
        known: String,
    },
    /// A number that is not finite.
    #[error("{0} {1} refused: it must be finite")]
    NotFinite(&'static str, f64),
    /// A negative time.
    #[error("{0} {1} s refused: it must not be negative")]
    Negative(&'static str, f64),
    /// The signal needs a positive period, s.
    #[error("period {0} s refused: this test signal needs a positive one")]
    Period(f64),
    /// The chirp has no last period or no end.
    #[error(
        "period_end {period_end} s, duration {duration} s refused: a chirp needs a positive value for both"
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
    #[error("duration {0} s refused: it must be from 0 to 1e6 s")]
    Duration(f64),
    /// A signal that does not end by itself.
    #[error("duration 0 s refused: without a duration, a {0} would never end")]
    Endless(String),
}
