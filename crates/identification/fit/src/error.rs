//! Why there is no model, or no comparison.
//!
//! A sentence names an option as the command line does, `--order`; each is a field of the options, `order`. So there is one
//! sentence for the command line and for the verdicts, and who shows it elsewhere translates all of them alike.

use std::error::Error;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use planesman_equations::EquationsError;
use planesman_identification::IdentificationError;
use planesman_identification::estimators::{Form, Method};
use planesman_model_file::Refusal;
use planesman_vehicle::vehicle_file::VehicleError;

/// Why there is no model, or no comparison.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A value that an option does not take.
    #[error("invalid value '{value}' for '--{}': {rule}", dashed(option))]
    Value {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// Why.
        rule: RuleError,
    },
    /// An option without another that it needs.
    #[error("--{} needs --{}", dashed(.0), dashed(.1))]
    Needs(&'static str, &'static str),
    /// Two options that exclude each other.
    #[error("--{} excludes --{}", dashed(.0), dashed(.1))]
    Excludes(&'static str, &'static str),
    /// A structure for a method whose structure is the vehicle's.
    #[error("--method {}: order, delay and zeros are given by the vehicle's equations", .0.name())]
    StructureOfVehicle(Method),
    /// A structure for a method whose structure is its form's.
    #[error(
        "--method process: order, delay and integrators are those of its form, --process {}",
        forms()
    )]
    StructureOfProcess,
    /// A form of process model for another method.
    #[error("--process is for --method process; {} takes --order and --delay", .0.name())]
    NotProcess(Method),
    /// A coherence for another method.
    #[error("--coherence is for --method frf; {} takes all frequencies", .0.name())]
    NotFrequency(Method),
    /// Numerators of their own for the method that has one response.
    #[error(
        "--own-numerators: --method frf has one response of all segments; fit them one by one with --window"
    )]
    OneResponse,
    /// Coefficients of a vehicle for a method that has no use for them.
    #[error("--heave and --vehicle are for --method vehicle and kalman")]
    NoVehicle,
    /// A numerator of a model without a denominator.
    #[error("--method fir has no denominator: --order is the number of its coefficients")]
    NumeratorOfFir,
    /// An order above the largest of a model with poles, which only a finite impulse response has.
    #[error("--order: {0} at most, but for --method fir")]
    Order(usize),
    /// A static gain by a method that has none.
    #[error("--order 0, a static gain, is none of --method {}: name --order 1 or more, or another method", .0.name())]
    NoStatic(Method),
    /// A static curve beside a method that has none.
    #[error(
        "--curve is for one input of a linear model without --reference: --method automatic, output_error, box_jenkins, armax, \
         least_squares or n4sid"
    )]
    NoCurve,
    /// A model file with a static curve that is none.
    #[error("{}: {reason}", .model.display())]
    Curve {
        /// The file.
        model: PathBuf,
        /// Why.
        reason: Refusal,
    },
    /// A signal that is named twice.
    #[error("'{0}' is named twice; name each signal once")]
    Twice(String),
    /// A method of one input and one output.
    #[error(
        "--method {0} is for one input and one output; several take automatic, output_error and box_jenkins, which choose order \
         and delay of each channel"
    )]
    MethodOfSeveral(&'static str),
    /// An option of one input and one output.
    #[error("--{} is for one input and one output; leave it out, or name one --input and one --output", dashed(.0))]
    OfOne(&'static str),
    /// Several signals for a fit of one input and one output.
    #[error("several inputs or outputs are named: fit_several takes them")]
    Several,
    /// Equations that are refused, or not fitted.
    #[error(transparent)]
    Equations(#[from] EquationsError),
    /// An option that says nothing of equations.
    #[error("--{} says nothing of {}; leave it out", dashed(.0), .1)]
    NotOf(&'static str, &'static str),
    /// A model file of a model that has no sampling interval.
    #[error(
        "--model writes models of a sampling interval, and --continuous has none: --json has its numbers, and without --continuous a model is written"
    )]
    NoSampledModel,
    /// A delay in samples for a model that has none.
    #[error(
        "--delay counts samples, of which --continuous has no interval: --delay 0 is no dead time, without it one is sought"
    )]
    DelayInSamples,
    /// A signal for an input or output that is none of the equations.
    #[error(
        "--{option} {given}: the equations have the {option}s {}; write --{option} NAME=SIGNAL, NAME one of them",
        names.join(", ")
    )]
    Binding {
        /// input or output.
        option: &'static str,
        /// What was given.
        given: String,
        /// The names.
        names: Vec<String>,
    },
    /// No stretch of data has all outputs and inputs.
    #[error(
        "{0}: there is no stretch of time in which all outputs, and the inputs before them, are known: planesman sysid topics shows when each is; a longer --max-gap joins stretches"
    )]
    NoStretch(String),
    /// Options of the recursive methods for another.
    #[error(
        "--forgetting and --initial-covariance are for the recursive methods, as --method recursive_least_squares; {} uses \
         all samples at once", .0.name()
    )]
    NotRecursive(Method),
    /// A window to fit with samples of the one to validate.
    #[error("--window {}..{} overlaps --validation {}..{}: samples that were fitted validate nothing",
        window.0, window.1, validation.0, validation.1)]
    Overlap {
        /// To fit, s.
        window: (f64, f64),
        /// To validate, s.
        validation: (f64, f64),
    },
    /// A vehicle that is refused.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// A vehicle of six degrees of freedom that is refused.
    #[error(transparent)]
    SixDof(#[from] planesman_vehicle::six_dof::FileError),
    /// A word that names nothing of a vehicle.
    #[error("--{option} {word}: it names none of {names}")]
    NoNumber {
        /// The option.
        option: &'static str,
        /// The word.
        word: String,
        /// What there is.
        names: String,
    },
    /// Every number stays.
    #[error("no number is sought: --fixed takes all of them, or --free names numbers that are 0")]
    NothingSought,
    /// A recording without motion.
    #[error(
        "no signal of the motion is found ({0}): name them, --signal u=SIGNAL; planesman sysid topics lists the signals"
    )]
    NoMotion(String),
    /// Several topics of odometry, none of which is called odom.
    #[error(
        "several topics have odometry ({0}): name the signals, --signal u=TOPIC:twist.twist.linear.x"
    )]
    Odometry(String),
    /// Angles that are none in rad.
    #[error("{0}: beyond a whole turn; angles are in rad, convert degrees first")]
    Degrees(&'static str),
    /// Hardly more samples than unknowns.
    #[error(
        "{samples} samples for {unknown} unknowns, initial states among them: record longer, or seek fewer numbers, --free NAME,..."
    )]
    FewForVehicle {
        /// Samples of all signals.
        samples: usize,
        /// Unknowns.
        unknown: usize,
    },
    /// A search without a finite start.
    #[error(
        "the motion of '{0}' does not stay finite over a window of the recording: look at its signals and their signs, or make --horizon shorter"
    )]
    Diverges(String),
    /// A vehicle without linear equations.
    #[error("vehicle '{vehicle}' at {speed} m/s")]
    NotLinear {
        /// Its name.
        vehicle: String,
        /// Its speed, m/s.
        speed: f64,
        /// Why.
        source: planesman_linear::Error,
    },
    /// No data was given.
    #[error("no data")]
    NoData,
    /// No signal was named.
    #[error("no signal is named")]
    NoSignal,
    /// Data that cannot be read.
    #[error(transparent)]
    Data(Box<dyn Error + Send + Sync>),
    /// A record without dynamics, or one that cannot be filtered.
    #[error("{0}")]
    Record(String),
    /// No validation.
    #[error("the validation data")]
    Validation(#[source] Box<Self>),
    /// A record that determines no model.
    #[error(transparent)]
    Identification(#[from] IdentificationError),
    /// All methods were tried.
    #[error("no method finds a model")]
    NoMethod,
    /// A frequency response of a model that was fitted otherwise.
    #[error("--response writes what --method frf measures: ask for that")]
    NoResponse,
    /// Nothing to compare.
    #[error("a model file is needed, *.json or *.yaml, as sysid fit --model writes it")]
    NoModel,
    /// Models of different signals.
    #[error("{} is of '{}', {} of '{}': --{option} SIGNAL says which of the data's signals they are judged on",
        first.0.display(), first.1, other.0.display(), other.1)]
    Signals {
        /// The option that says which.
        option: &'static str,
        /// A model and its signal.
        first: (PathBuf, String),
        /// Another.
        other: (PathBuf, String),
    },
    /// Data that a model's grid does not suit.
    #[error("{} asks for a grid of {sample_time} s", model.display())]
    Grid {
        /// The model.
        model: PathBuf,
        /// Its sampling interval, s.
        sample_time: f64,
        /// Why.
        source: Box<Self>,
    },
    /// A model that cannot be judged on the data.
    #[error("{} (--rate {rate} makes a grid for it)", model.display())]
    Judgement {
        /// The model.
        model: PathBuf,
        /// Its sampling rate, Hz.
        rate: f64,
        /// Why.
        source: IdentificationError,
    },
}

impl FitError {
    pub(crate) fn value(option: &'static str, value: impl Display, rule: RuleError) -> Self {
        Self::Value {
            option,
            value: value.to_string(),
            rule,
        }
    }

    pub(crate) fn no_number<'a>(
        option: &'static str,
        word: &str,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::NoNumber {
            option,
            word: word.to_owned(),
            names: names.into_iter().collect::<Vec<_>>().join(", "),
        }
    }

    pub(crate) fn data(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Data(error.into())
    }
}

/// The forms of a process model.
fn forms() -> String {
    Form::ALL.map(Form::name).join(", ")
}

/// A field as an option is written.
fn dashed(field: &str) -> String {
    field.replace('_', "-")
}

/// Why an option does not take a value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RuleError {
    /// No number.
    #[error("'{0}' is not a number")]
    NotANumber(String),
    /// An infinite number, or NaN.
    #[error("'{0}' is not finite")]
    NotFinite(String),
    /// A number out of range; what is in it.
    #[error("{0}")]
    Range(&'static str),
    /// A count out of range.
    #[error("{0} is not in {1:?}")]
    Count(i128, RangeInclusive<i64>),
    /// Another number of coefficients of heave.
    #[error("expected four numbers: NU,ZETA,ETA,EPSILON")]
    NotFour,
    /// No pair of edges; what is one.
    #[error("'{0}' {1}")]
    NotASpan(String, &'static str),
    /// The upper edge first.
    #[error("'{0}' is reversed; write {2}..{1}")]
    Reversed(String, f64, f64),
    /// Neither data nor a window to validate on.
    #[error("there is no file or folder '{0}', and it is no window FROM..TO either")]
    NoValidation(String),
    /// Words that are no input.
    #[error(
        "it is no signal of the data, and as an input in words {expected} is expected at character {place}; write VALUE[UNIT] from TIME, as \
         '12V from 0.1s', '0 to 12V at 0.1s' or '5 from 1s, 0 from 4s'"
    )]
    NotAnInput {
        /// The character, from 1.
        place: usize,
        /// What is expected there.
        expected: String,
    },
    /// A rule of the one who reads the value.
    #[error("{0}")]
    Own(String),
}
