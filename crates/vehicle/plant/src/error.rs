//! The errors of the plant.

use planesman_vehicle::{
    Diverged, MotionError,
    six_dof::{FileError, Unmoved},
    vehicle_file::VehicleError,
};

/// Parameters or a motion that are refused; nothing changes then.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The vehicle file, or the model file behind it.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The file of a vehicle of six degrees.
    #[error(transparent)]
    SixDof(#[from] FileError),
    /// A vehicle of six degrees that nothing of the loop can move.
    #[error("vehicle '{vehicle}': {reason}")]
    Unmoved {
        /// Its name.
        vehicle: String,
        /// The input.
        reason: Unmoved,
    },
    /// A parameter that is of the plane's equations.
    #[error(
        "parameter '{parameter}' refused: vehicle '{vehicle}' has six degrees of freedom, whose equations have no such choice; leave it at its \
         default"
    )]
    NotOfSixDof {
        /// The parameter.
        parameter: &'static str,
        /// The vehicle.
        vehicle: String,
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
    /// A frame prefix of other characters, shown escaped.
    #[error("parameter 'frame_prefix': '{0}' refused: at most 100 letters, digits, '_' and '/'")]
    FramePrefix(String),
    /// A live change of what cannot change.
    #[error("parameters 'vehicle', 'tick' and 'step' are fixed at the start")]
    Fixed,
    /// A share of thrust beyond all of it.
    #[error("thrust {0} refused: a share of full thrust lies in [-1, 1]")]
    Thrust(f64),
    /// Thrusters' names and commands that are not as many.
    #[error("thruster_command refused: {names} names and {commands} commands")]
    Commands {
        /// Of `name`.
        names: usize,
        /// Of `command`.
        commands: usize,
    },
    /// A vehicle of six degrees that begins in the ground.
    #[error("parameter 'initial_depth': {depth} m refused: 'environment.bottom' is at {bottom} m")]
    InTheGround {
        /// `initial_depth` \[m\].
        depth: f64,
        /// `environment.bottom` \[m\].
        bottom: f64,
    },
    /// A command to the thrusters of a vehicle without.
    #[error(
        "thruster_command refused: vehicle '{0}' has no thrusters; 'hover.vehicle' of depth_controller has to be plant_sim's 'vehicle'"
    )]
    NoThrusters(String),
    /// A thruster that the vehicle does not have.
    #[error("thruster_command refused: '{name}' is none of the thrusters: {names}")]
    Thruster {
        /// Its name, escaped.
        name: String,
        /// The vehicle's.
        names: String,
    },
    /// A command beyond all of it.
    #[error("thruster_command refused: {0} is no share of full command, in [-1, 1]")]
    Command(f64),
    /// The dive planes' motion.
    #[error(transparent)]
    DivePlanes(#[from] MotionError),
    /// Another motion, by its name.
    #[error("{0}: {1}")]
    Motion(&'static str, MotionError),
    /// A law of pitch damping that is linear lets the vehicle turn faster than its drag would.
    #[error(
        "step refused: pitch would turn at {pitch_rate:.3} rad/s at {speed:.3} m/s, faster than speed, planes and waves can turn it \
         against its drag N |q| q: pitch_damping '{law}' is linear about {rate} rad/s (pitch_damping_rate) and damps too little so \
         far above it; set pitch_damping to quadratic or coefficient"
    )]
    Damping {
        /// Its name.
        law: &'static str,
        /// The rate \[rad/s\] about which it is linear.
        rate: f64,
        /// Where pitch would have gone \[rad/s\].
        pitch_rate: f64,
        /// \[m/s\]
        speed: f64,
    },
    /// The vehicle's numbers left their range.
    #[error(transparent)]
    Diverged(#[from] Diverged),
}
