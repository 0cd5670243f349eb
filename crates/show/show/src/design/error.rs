//! Why there is no analysis.

use planesman_hydraulics::actuator_file::ActuatorFileError;
use planesman_text::{option, setting};
use planesman_vehicle::vehicle_file::VehicleError;

/// A result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why there is no analysis.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A vehicle that is refused.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// An actuator that is refused.
    #[error(transparent)]
    Actuator(#[from] ActuatorFileError),
    /// An actuator without a slew response to analyse.
    #[error("actuator '{0}' does not follow a step of its command")]
    NoStep(String),
    /// A command that moves the planes over more ticks than are analysed.
    #[error(
        "the planes follow a command within {needed:.0} ticks, and at most {most} are analysed: choose a lower {} or {}",
        option("rate"),
        option("computing_delay")
    )]
    Ticks {
        /// Over so many.
        needed: f64,
        /// At most.
        most: f64,
    },
    /// A model that is no vehicle's.
    #[error("{0}")]
    Model(String),
    /// Limits that no gains keep over a model's uncertainty.
    #[error(
        "no gains of the dive loops keep a phase margin of {phase_margin:.0} deg, a gain margin of {gain_margin:.1} dB and a sensitivity peak of \
         {sensitivity:.2} in 95 % of the vehicles that the model allows; {nearest}. Record more, or allow more: {}, {}",
        setting("ms", format!("{:.1}", 1.25 * sensitivity)), setting("phase_margin", format!("{:.0}", 0.8 * phase_margin))
    )]
    OutOfReach {
        /// Degrees.
        phase_margin: f64,
        /// dB
        gain_margin: f64,
        /// The largest peak.
        sensitivity: f64,
        /// What the last ones do.
        nearest: String,
    },
    /// Numbers that overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
    /// A flight that is refused or breaks off.
    #[error(transparent)]
    Flight(#[from] planesman_flight::Error),
}
