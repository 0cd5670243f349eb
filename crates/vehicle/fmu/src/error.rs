//! What is refused: on the command line when an FMU is written, and to the importer when it runs.

use planesman_parameters::Refusal;
use planesman_text::{option, setting};

/// Why an FMU is not written, or does not run on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A vehicle that is not taken.
    #[error(transparent)]
    Vehicle(#[from] planesman_plant::Error),
    /// An actuator that is not taken.
    #[error(transparent)]
    Actuator(#[from] planesman_hydraulics::Error),
    /// An identified model that is not taken.
    #[error(transparent)]
    Model(#[from] planesman_model_file::Error),
    /// A value that is not taken.
    #[error("{0}")]
    Value(#[from] Refusal),
    /// A model file has a sampling interval of its own.
    #[error(
        "{} s refused: the model is sampled every {tick} s; leave {} out",
        setting("step", step),
        option("step")
    )]
    Sampled {
        /// What was asked for, s.
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
    /// Nothing of that name is built in, and no file is there.
    #[error(
        "no actuator is built in as '{name}' ({actuators}); as a vehicle or a model: {reason}{meant}"
    )]
    NoSubject {
        /// The name.
        name: String,
        /// The names of the actuators that are.
        actuators: String,
        /// The one that was probably meant, as a question.
        meant: String,
        /// Why there is no other.
        reason: Box<planesman_vehicle::vehicle_file::VehicleError>,
    },
    /// The file is neither a vehicle's nor a model's, and no actuator's either.
    #[error(
        "'{file}' is taken for an actuator file, as it has neither 'particulars' nor 'inputs' (a vehicle) nor 'format: planesman model' (of sysid fit): {reason}"
    )]
    Unknown {
        /// Its path.
        file: String,
        /// Why it is no actuator's.
        reason: Box<Error>,
    },
    /// The library that runs FMUs is not where the program looks.
    #[error(
        "{library} is not beside the program, in deps/ or in ../lib/: build it with 'cargo build --release' in the repository, or name it with {}",
        option("library")
    )]
    NoLibrary {
        /// Its name.
        library: String,
    },
    /// The library is another.
    #[error("'{0}' is no libplanesman_fmu of this version")]
    OtherLibrary(String),
    /// The FMU's own files are not those of this library.
    #[error("resources/{file}: {reason}")]
    Resources {
        /// The file.
        file: &'static str,
        /// What is wrong.
        reason: String,
    },
}
