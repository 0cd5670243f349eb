//! The errors of the plant.

use planesman_linear::LARGEST_POLE_STEP;
use planesman_vehicle::{Diverged, MotionError, vehicle_file::VehicleError};

/// Parameters or a motion that are refused; nothing changes then.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The vehicle file, or the model file behind it.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The tick is no whole number of steps.
    #[error(
        "parameter 'step': {step} refused: the tick, {tick} s, must be a whole number of steps"
    )]
    Steps {
        /// s.
        step: f64,
        /// s.
        tick: f64,
    },
    /// More steps in a tick than can be counted.
    #[error("parameter 'step': {step} refused: too small for the tick, {tick} s")]
    SmallStep {
        /// s.
        step: f64,
        /// s.
        tick: f64,
    },
    /// The vehicle's fastest mode outruns the step.
    #[error(
        "parameter 'step': {step} refused: vehicle '{vehicle}' has a mode of {mode:.3} rad/s at \
         {speed} m/s, the step must be at most {:.3e} s",
        LARGEST_POLE_STEP / mode
    )]
    FastMode {
        /// s.
        step: f64,
        /// Its name.
        vehicle: String,
        /// rad/s.
        mode: f64,
        /// m/s.
        speed: f64,
    },
    /// Thrust is asked for, and the vehicle has none.
    #[error(
        "parameter 'propulsion': thrust refused: vehicle '{0}' has no propulsion, its speed \
         can only be held"
    )]
    NoPropulsion(String),
    /// Waves that no filter shapes.
    #[error("environment.seaway refused: {0}")]
    Seaway(planesman_linear::Error),
    /// An axis of the vehicle.
    #[error("vehicle '{vehicle}' refused: {reason}")]
    Turning {
        /// Its name.
        vehicle: String,
        /// What is wrong with the axis.
        reason: planesman_linear::Error,
    },
    /// The linear model at the speed.
    #[error("vehicle '{vehicle}' at {speed} m/s refused: {reason}")]
    Speed {
        /// Its name.
        vehicle: String,
        /// m/s.
        speed: f64,
        /// What is wrong with the model.
        reason: planesman_linear::Error,
    },
    /// A frame prefix of other characters, shown escaped.
    #[error("parameter 'frame_prefix': '{0}' refused: at most 100 letters, digits, '_' and '/'")]
    FramePrefix(String),
    /// A live change of what cannot change.
    #[error("parameters 'vehicle', 'tick' and 'step' are fixed at the start")]
    Fixed,
    /// A share of thrust beyond all of it.
    #[error("thrust {0} refused: a share of full thrust lies in [-1, 1]")]
    Thrust(f64),
    /// The dive planes' motion.
    #[error(transparent)]
    DivePlanes(#[from] MotionError),
    /// Another motion, by its name.
    #[error("{0}: {1}")]
    Motion(&'static str, MotionError),
    /// The vehicle's numbers left their range.
    #[error(transparent)]
    Diverged(#[from] Diverged),
}
