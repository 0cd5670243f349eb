//! Errors of the design tools.

use planesman_hydraulics::actuator_file::ActuatorFileError;
use planesman_text::{option, setting};
use planesman_vehicle::vehicle_file::VehicleError;

/// A result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The reason why a design or analysis failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A refused vehicle.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// A refused actuator.
    #[error(transparent)]
    Actuator(#[from] ActuatorFileError),
    /// The actuator has no slew response to analyse.
    #[error("actuator '{0}' does not follow a step of its command")]
    NoStep(String),
    /// The planes need more ticks to follow a command than can be analysed.
    #[error(
        "the planes need {needed:.0} ticks to follow a command, but at most {most} can be analysed: choose a lower {} or {}",
        option("rate"),
        option("computing_delay")
    )]
    Ticks {
        /// Number of ticks needed.
        needed: f64,
        /// Largest number of ticks.
        most: f64,
    },
    /// The model does not describe a vehicle.
    #[error("{0}")]
    Model(String),
    /// No gains keep the limits over the model's uncertainty.
    #[error(
        "no gains of the dive loops keep a phase margin of {phase_margin:.0} deg, a gain margin of {gain_margin:.1} dB and a sensitivity peak of {sensitivity:.2} in 95 % of the vehicles drawn from the model's covariance; {nearest}. Record more data, or relax the limits: {}, {}",
        setting("ms", format!("{:.1}", 1.25 * sensitivity)), setting("phase_margin", format!("{:.0}", 0.8 * phase_margin))
    )]
    OutOfReach {
        /// Minimum phase margin, degrees.
        phase_margin: f64,
        /// Minimum gain margin, dB.
        gain_margin: f64,
        /// Maximum sensitivity peak.
        sensitivity: f64,
        /// Margins of the last gains tried, as a sentence.
        nearest: String,
    },
    /// Numerical overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
    /// A simulated flight was refused, or stopped early.
    #[error(transparent)]
    Flight(#[from] planesman_flight::Error),
}
