//! Why there is no model, or no comparison.
//!
//! A sentence names an option by its field, which each front end writes as its user does ([`planesman_text::Wording`]).

use std::error::Error;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use planesman_equations::EquationsError;
use planesman_identification::IdentificationError;
use planesman_identification::estimators::{Form, Method, Property};
use planesman_model_file::Refusal;
use planesman_text::{option, setting};

/// Why there is no model, or no comparison.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A value that an option does not take.
    #[error(
        "invalid value '{value}' for '{}': {rule}",
        planesman_text::option(option)
    )]
    Value {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// Why.
        rule: RuleError,
    },
    /// An option without another that it needs.
    #[error("{} needs {}", option(.0), option(.1))]
    Needs(&'static str, &'static str),
    /// Two options that exclude each other.
    #[error("{} excludes {}", option(.0), option(.1))]
    Excludes(&'static str, &'static str),
    /// A structure for a method whose structure is the vehicle's.
    #[error("{}: order, delay and zeros are given by the vehicle's equations", setting("method", .0.name()))]
    StructureOfVehicle(Method),
    /// A structure for a method whose structure is its form's.
    #[error(
        "{}: order, delay and integrators are those of its form, {}",
        setting("method", "process"),
        setting("process", forms())
    )]
    StructureOfProcess,
    /// A form of process model for another method.
    #[error("{} is for {}; {} takes {} and {}", option("process"), setting("method", "process"), .0.name(), option("order"), option("delay"))]
    NotProcess(Method),
    /// A coherence for another method.
    #[error("{} is for {}; {} takes all frequencies", option("coherence"), setting("method", "frf"), .0.name())]
    NotFrequency(Method),
    /// Numerators of their own for the method that has one response.
    #[error(
        "{}: {} has one response of all segments; fit them one by one with {}",
        option("own_numerators"),
        setting("method", "frf"),
        option("window")
    )]
    OneResponse,
    /// Coefficients of a vehicle for a method that has no use for them.
    #[error(
        "{} and {} are for {} and kalman",
        option("heave"),
        option("vehicle"),
        setting("method", "vehicle")
    )]
    NoVehicle,
    /// A numerator of a model without a denominator.
    #[error(
        "{} has no denominator: {} is the number of its coefficients",
        setting("method", "fir"),
        option("order")
    )]
    NumeratorOfFir,
    /// An order above the largest of a model with poles, which only a finite impulse response has.
    #[error(
        "{}: {} at most, but for {}",
        option("order"), .0,
        setting("method", "fir")
    )]
    Order(usize),
    /// A static gain by a method that has none.
    #[error("{}, a static gain, is none of {}: name {} or more, or another method", setting("order", 0), setting("method", .0.name()), setting("order", 1))]
    NoStatic(Method),
    /// A static curve beside a method that has none.
    #[error(
        "{} is for one input of a linear model without {}; {} is then one of {}",
        option("curve"),
        option("reference"),
        option("method"),
        Method::all_with(Property::TakesCurve).map(Method::name).collect::<Vec<_>>().join(", ")
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
        "{} is for one input and one output; several take automatic, output_error and box_jenkins, which choose order and delay \
         of each channel", setting("method", .0)
    )]
    MethodOfSeveral(&'static str),
    /// An option of one input and one output.
    #[error("{} is for one input and one output; leave it out, or name one {} and one {}", option(.0), option("input"), option("output"))]
    OfOne(&'static str),
    /// Several signals for a fit of one input and one output.
    #[error("several inputs or outputs are named: fit_several takes them")]
    Several,
    /// Equations that are refused, or not fitted.
    #[error(transparent)]
    Equations(#[from] EquationsError),
    /// An option that says nothing of equations.
    #[error("{} says nothing of {}; leave it out", option(.0), .1)]
    NotOf(&'static str, &'static str),
    /// A model file of a model that has no sampling interval.
    #[error(
        "{} writes models of a sampling interval, and {} has none: {} has its numbers, and without {} a model is written",
        option("model"),
        option("continuous"),
        option("json"),
        option("continuous")
    )]
    NoSampledModel,
    /// A delay in samples for a model that has none.
    #[error(
        "{} counts samples, of which a transfer function in s has no interval: {} is no dead time, without it one is sought",
        option("delay"),
        setting("delay", 0)
    )]
    DelayInSamples,
    /// A signal for an input or output that is none of the equations.
    #[error(
        "{}: the equations have the {option}s {}; write {}, NAME one of them",
        setting(option, given), names.join(", "), setting(option, "NAME=SIGNAL")
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
        "{}: there is no stretch of time in which all outputs, and the inputs before them, are known: planesman sysid topics shows when each is; \
         a longer {} joins stretches", .0, option("max_gap"))]
    NoStretch(String),
    /// Options of the recursive methods for another.
    #[error(
        "{} and {} are for the recursive methods, as {}; {} uses all samples at once",
        option("forgetting"), option("initial_covariance"), setting("method", "recursive_least_squares"), .0.name()
    )]
    NotRecursive(Method),
    /// A window to fit with samples of the one to validate.
    #[error("{} overlaps {}: samples that were fitted validate nothing",
        setting("window", format!("{}..{}", window.0, window.1)),
        setting("validation", format!("{}..{}", validation.0, validation.1)))]
    Overlap {
        /// To fit, s.
        window: (f64, f64),
        /// To validate, s.
        validation: (f64, f64),
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
    #[error(
        "{} writes what {} measures: ask for that",
        option("response"),
        setting("method", "frf")
    )]
    NoResponse,
    /// Nothing to compare.
    #[error("a model file is needed, *.json or *.yaml, as sysid fit writes it")]
    NoModel,
    /// Models of different signals.
    #[error("{} is of '{}', {} of '{}': {} says which of the data's signals they are judged on",
        first.0.display(), first.1, other.0.display(), other.1, setting(option, "SIGNAL"))]
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
    #[error("{} ({} makes a grid for it)", model.display(), setting("rate", rate))]
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

    pub(crate) fn data(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Data(error.into())
    }
}

/// The forms of a process model.
fn forms() -> String {
    Form::ALL.map(Form::name).join(", ")
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
