//! The errors of the plant.

use planesman_vehicle::{
    Diverged, MotionError,
    six_dof::{FileError, Unmoved},
    vehicle_file::VehicleError,
};

/// Refused parameters or motion; the plant stays unchanged.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The vehicle file, or its model file, is refused.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The file of a vehicle with six degrees of freedom is refused.
    #[error(transparent)]
    SixDof(#[from] FileError),
    /// A vehicle with six degrees of freedom without any actuator that the loop can command.
    #[error("vehicle '{vehicle}': {reason}")]
    Unmoved {
        /// Its name.
        vehicle: String,
        /// The input.
        reason: Unmoved,
    },
    /// The parameter exists only for the equations of the vertical plane.
    #[error(
        "parameter '{parameter}' refused: it does not apply to vehicle '{vehicle}', which has six degrees of freedom. Leave it at its default"
    )]
    NotOfSixDof {
        /// The parameter.
        parameter: &'static str,
        /// The vehicle.
        vehicle: String,
    },
    /// Thrust is set for a vehicle without propulsion.
    #[error(
        "parameter 'propulsion': thrust refused: vehicle '{0}' has no propulsion model, so its speed is constant"
    )]
    NoPropulsion(String),
    /// No filter exists for these waves.
    #[error("environment.seaway refused: {0}")]
    Seaway(planesman_linear::Error),
    /// The frame prefix has characters that are not allowed; shown escaped.
    #[error("parameter 'frame_prefix': '{0}' refused: at most 100 letters, digits, '_' and '/'")]
    FramePrefix(String),
    /// A fixed parameter was changed at run time.
    #[error("parameters 'vehicle', 'tick' and 'step' are fixed at the start")]
    Fixed,
    /// The thrust exceeds full thrust.
    #[error("thrust {0} refused: it must be in [-1, 1], as a share of full thrust")]
    Thrust(f64),
    /// The numbers of names and commands differ.
    #[error("thruster_command refused: {names} names but {commands} commands")]
    Commands {
        /// Of `name`.
        names: usize,
        /// Of `command`.
        commands: usize,
    },
    /// The initial depth of a vehicle with six degrees of freedom is below the bottom.
    #[error("parameter 'initial_depth': {depth} m refused: 'environment.bottom' is at {bottom} m")]
    InTheGround {
        /// `initial_depth` \[m\].
        depth: f64,
        /// `environment.bottom` \[m\].
        bottom: f64,
    },
    /// The vehicle has no thrusters.
    #[error(
        "thruster_command refused: vehicle '{0}' has no thrusters; 'hover.vehicle' of \
         depth_controller must equal plant_sim's 'vehicle'"
    )]
    NoThrusters(String),
    /// The vehicle has no thruster of this name.
    #[error("unknown thruster '{name}' in thruster_command; known: {names}")]
    Thruster {
        /// Its name, escaped.
        name: String,
        /// The vehicle's.
        names: String,
    },
    /// The command exceeds full command.
    #[error("thruster_command refused: {0} must be in [-1, 1], as a share of full command")]
    Command(f64),
    /// The motion of the dive planes is refused.
    #[error(transparent)]
    DivePlanes(#[from] MotionError),
    /// Another motion, with its name, is refused.
    #[error("{0}: {1}")]
    Motion(&'static str, MotionError),
    /// A linear law of pitch damping lets the vehicle turn faster than its quadratic drag would.
    #[error(
        "step refused: the pitch rate of {pitch_rate:.3} rad/s at {speed:.3} m/s is larger than speed, planes and waves can cause against the drag N |q| q. pitch_damping '{law}' is linear about {rate} rad/s (pitch_damping_rate) and damps too little at this higher rate. Set pitch_damping to quadratic or coefficient"
    )]
    Damping {
        /// Its name.
        law: &'static str,
        /// Rate \[rad/s\] about which the law is linear.
        rate: f64,
        /// Pitch rate that the step would have given \[rad/s\].
        pitch_rate: f64,
        /// \[m/s\]
        speed: f64,
    },
    /// The vehicle's state left its allowed range.
    #[error(transparent)]
    Diverged(#[from] Diverged),
}
