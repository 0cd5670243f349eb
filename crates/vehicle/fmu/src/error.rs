//! Errors on the command line when an FMU is written, and for the importer when it runs.

use planesman_parameters::Refusal;
use planesman_text::{option, setting};

/// The reason why an FMU cannot be written, or cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An invalid vehicle.
    #[error(transparent)]
    Vehicle(#[from] planesman_plant::Error),
    /// An invalid actuator.
    #[error(transparent)]
    Actuator(#[from] planesman_hydraulics::Error),
    /// An invalid identified model.
    #[error(transparent)]
    Model(#[from] planesman_model_file::Error),
    /// An invalid value.
    #[error("{0}")]
    Value(#[from] Refusal),
    /// A step is given, but a model file has its own sampling interval.
    #[error(
        "{} s refused: the model is sampled every {tick} s; leave {} out",
        setting("step", step),
        option("step")
    )]
    Sampled {
        /// The requested step, s.
        step: f64,
        /// The model's, s.
        tick: f64,
    },
    /// A file that cannot be read or written.
    #[error("'{path}': {reason}")]
    File {
        /// Its path.
        path: String,
        /// The system's error.
        reason: std::io::Error,
    },
    /// No built-in subject and no file has that name.
    #[error(
        "no built-in actuator '{name}' ({actuators}); as a vehicle or a model: {reason}{meant}"
    )]
    NoSubject {
        /// The name.
        name: String,
        /// The names of the built-in actuators.
        actuators: String,
        /// A suggestion of the probable name, as a question.
        meant: String,
        /// The reason why it is not a vehicle.
        reason: Box<planesman_vehicle::vehicle_file::VehicleError>,
    },
    /// The file is neither a vehicle, a model nor an actuator.
    #[error(
        "'{file}' is read as an actuator file, since it has neither 'particulars' nor 'inputs' (a \
         vehicle) nor 'format: planesman model' (a model from sysid fit): {reason}"
    )]
    Unknown {
        /// Its path.
        file: String,
        /// The reason why it is not a valid actuator.
        reason: Box<Error>,
    },
    /// The library that runs FMUs is missing.
    #[error(
        "{library} is missing in the program's folder, in deps/ and in ../lib/: build it with \
         'cargo build --release' in the repository, or give its path with {}",
        option("library")
    )]
    NoLibrary {
        /// Its name.
        library: String,
    },
    /// The library is not the expected one.
    #[error("'{0}' is not a libplanesman_fmu of this version")]
    OtherLibrary(String),
    /// The FMU's files do not belong to this library.
    #[error("resources/{file}: {reason}")]
    Resources {
        /// The file.
        file: &'static str,
        /// The error.
        reason: String,
    },
}
