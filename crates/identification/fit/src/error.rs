//! Reasons why there is no model or no comparison.
//!
//! A message names an option by its field; each front end writes the name in its own form ([`planesman_text::Wording`]).

use std::error::Error;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use planesman_equations::EquationsError;
use planesman_identification::IdentificationError;
use planesman_identification::estimators::{Form, Method, Property};
use planesman_model_file::Refusal;
use planesman_text::{option, setting};

/// Reasons why there is no model or no comparison.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// An option has an invalid value.
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
    /// An option requires another one.
    #[error("{} needs {}", option(.0), option(.1))]
    Needs(&'static str, &'static str),
    /// Two options exclude each other.
    #[error("{} excludes {}", option(.0), option(.1))]
    Excludes(&'static str, &'static str),
    /// A structure is given, but the method uses the vehicle's equations.
    #[error("{} takes order, delay and zeros from the vehicle's equations. Leave these options out", setting("method", .0.name()))]
    StructureOfVehicle(Method),
    /// A structure is given, but the method uses the form of a process model.
    #[error(
        "{} takes order, delay and integrators from its form. Choose the form with {}",
        setting("method", "process"),
        setting("process", forms())
    )]
    StructureOfProcess,
    /// The form of a process model is given, but the method fits no process model.
    #[error("{} needs {}; {} uses {} and {}", option("process"), setting("method", "process"), .0.name(), option("order"), option("delay"))]
    NotProcess(Method),
    /// A coherence is given, but the method does not use a frequency response.
    #[error("{} needs {}, because method {} uses all frequencies", option("coherence"), setting("method", "frf"), .0.name())]
    NotFrequency(Method),
    /// Separate numerators are requested, but the frequency method has one response for all segments.
    #[error(
        "{} does not apply to {}, which computes one response for all segments. Fit each segment separately with {}",
        option("own_numerators"),
        setting("method", "frf"),
        option("window")
    )]
    OneResponse,
    /// Coefficients of a vehicle are given, but the method does not use them.
    #[error(
        "{} and {} need {} or kalman",
        option("heave"),
        option("vehicle"),
        setting("method", "vehicle")
    )]
    NoVehicle,
    /// A number of numerator coefficients is given, but the model has no denominator.
    #[error(
        "{} fits a model without a denominator. Use {} for the number of coefficients",
        setting("method", "fir"),
        option("order")
    )]
    NumeratorOfFir,
    /// The order is above the maximum for models with poles; only a finite impulse response allows more.
    #[error(
        "{} may be at most {}, unless you use {}",
        option("order"), .0,
        setting("method", "fir")
    )]
    Order(usize),
    /// A static gain is requested, but the method cannot fit one.
    #[error("{} is a static gain, which {} cannot fit. Use {} or more, or another method", setting("order", 0), setting("method", .0.name()), setting("order", 1))]
    NoStatic(Method),
    /// A static curve is requested together with options or a method that exclude a curve.
    #[error(
        "{} needs one input and a linear model without {}. Allowed values of {}: {}",
        option("curve"),
        option("reference"),
        option("method"),
        Method::all_with(Property::TakesCurve).map(Method::name).collect::<Vec<_>>().join(", ")
    )]
    NoCurve,
    /// The model file's static curve is invalid.
    #[error("{}: {reason}", .model.display())]
    Curve {
        /// The file.
        model: PathBuf,
        /// Why.
        reason: Refusal,
    },
    /// A signal is given twice.
    #[error("signal '{0}' is given twice; name each signal once")]
    Twice(String),
    /// The method is for one input and one output, but several are given.
    #[error(
        "{} is for one input and one output. For several, use automatic, output_error or box_jenkins: these methods choose order and delay of each channel", setting("method", .0)
    )]
    MethodOfSeveral(&'static str),
    /// The option is for one input and one output, but several are given.
    #[error("{} is for one input and one output. Leave it out, or name one {} and one {}", option(.0), option("input"), option("output"))]
    OfOne(&'static str),
    /// Several signals, but the fit is for one input and one output.
    #[error("several inputs or outputs are given: use fit_several")]
    Several,
    /// Equations that are invalid or cannot be fitted.
    #[error(transparent)]
    Equations(#[from] EquationsError),
    /// An option that does not apply to equations.
    #[error("{} does not apply to {}; leave the option out", option(.0), .1)]
    NotOf(&'static str, &'static str),
    /// A continuous-time model, which a model file cannot store.
    #[error(
        "{} cannot store the continuous-time model of {}. Use {}, or leave out {}",
        option("model"),
        option("continuous"),
        option("json"),
        option("continuous")
    )]
    NoSampledModel,
    /// A delay in samples for a continuous-time model.
    #[error(
        "{} is a number of samples, but a continuous-time model has no samples. Use {} for no dead time, or leave the option out to estimate the dead time",
        option("delay"),
        setting("delay", 0)
    )]
    DelayInSamples,
    /// A signal for an input or output that the equations do not have.
    #[error(
        "{} does not name an {option} of the equations. They have the {option}s {}. Write {} with one of these names",
        setting(option, given), names.join(", "), setting(option, "NAME=SIGNAL")
    )]
    Binding {
        /// input or output.
        option: &'static str,
        /// The given text.
        given: String,
        /// The names.
        names: Vec<String>,
    },
    /// No time interval of the data has all outputs and inputs.
    #[error(
        "{}: at no time are all outputs and their earlier inputs known. See each signal's times with planesman sysid topics, or join segments with a longer {}", .0, option("max_gap"))]
    NoStretch(String),
    /// Options of the recursive methods are given with another method.
    #[error(
        "{} and {} apply only to recursive methods such as {}; {} uses all samples at once",
        option("forgetting"), option("initial_covariance"), setting("method", "recursive_least_squares"), .0.name()
    )]
    NotRecursive(Method),
    /// The window to fit overlaps the window for validation.
    #[error("{} overlaps {}: validation needs samples that were not used for the fit",
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
    /// No signal is given.
    #[error("no signal is given")]
    NoSignal,
    /// The data cannot be read.
    #[error(transparent)]
    Data(Box<dyn Error + Send + Sync>),
    /// A record without dynamics, or one that cannot be filtered.
    #[error("{0}")]
    Record(String),
    /// No validation.
    #[error("the validation data")]
    Validation(#[source] Box<Self>),
    /// The record does not determine a model.
    #[error(transparent)]
    Identification(#[from] IdentificationError),
    /// All methods failed.
    #[error("no method found a model")]
    NoMethod,
    /// A frequency response is requested from another method.
    #[error(
        "{} needs {}, because only this method computes a frequency response",
        option("response"),
        setting("method", "frf")
    )]
    NoResponse,
    /// No model to compare.
    #[error("no model file is given; give a *.json or *.yaml file written by sysid fit --model")]
    NoModel,
    /// The models have different signals.
    #[error("{} has the signal '{}', but {} has '{}'. Choose one signal of the data for both models with {}",
        first.0.display(), first.1, other.0.display(), other.1, setting(option, "SIGNAL"))]
    Signals {
        /// The option that chooses the signal.
        option: &'static str,
        /// A model and its signal.
        first: (PathBuf, String),
        /// Another.
        other: (PathBuf, String),
    },
    /// The data cannot be resampled to a model's grid.
    #[error("{} needs a grid of {sample_time} s", model.display())]
    Grid {
        /// The model.
        model: PathBuf,
        /// Its sampling interval, s.
        sample_time: f64,
        /// Why.
        source: Box<Self>,
    },
    /// The model cannot be validated on the data.
    #[error("{} cannot be compared with this data ({} resamples the data to the model's interval)", model.display(), setting("rate", rate))]
    Judgement {
        /// The model.
        model: PathBuf,
        /// The model's sampling rate, Hz, to which the data can be resampled.
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

/// The names of the process forms.
fn forms() -> String {
    Form::ALL.map(Form::name).join(", ")
}

/// The reason why a value is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RuleError {
    /// No number.
    #[error("'{0}' is not a number")]
    NotANumber(String),
    /// An infinite number, or NaN.
    #[error("'{0}' is not finite")]
    NotFinite(String),
    /// A number out of range; the text names the range.
    #[error("{0}")]
    Range(&'static str),
    /// A count out of range.
    #[error("{0} is not in {1:?}")]
    Count(i128, RangeInclusive<i64>),
    /// The number of heave coefficients is not four.
    #[error("expected four numbers: NU,ZETA,ETA,EPSILON")]
    NotFour,
    /// The text is not a pair of bounds; the second text describes what is expected.
    #[error("'{0}' {1}")]
    NotASpan(String, &'static str),
    /// The upper bound comes first.
    #[error("'{0}' is reversed; write {2}..{1}")]
    Reversed(String, f64, f64),
    /// Neither a data source nor a window for validation.
    #[error("'{0}' is neither an existing file or folder nor a window FROM..TO")]
    NoValidation(String),
    /// An input in words that cannot be parsed.
    #[error(
        "neither a signal of the data nor an input in words. In words, {expected} is expected at character {place}. Write VALUE[UNIT] from TIME, for example '12V from 0.1s', '0 to 12V at 0.1s' or '5 from 1s, 0 from 4s'"
    )]
    NotAnInput {
        /// The character, from 1.
        place: usize,
        /// The text expected there.
        expected: String,
    },
    /// A rule of the reader of the value.
    #[error("{0}")]
    Own(String),
}
