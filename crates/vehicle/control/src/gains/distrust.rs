//! The reason why an identified model is not used for the gains.

use planesman_model_file::Refusal;

/// The reason why an identified model is not used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Distrust {
    /// No model has been received yet.
    #[error("no model has been received yet")]
    NoModel,
    /// The last model is too old; the model's age, s.
    #[error("the last model is {0:.1} s old")]
    Old(f64),
    /// `sysid` marked the model as not valid; the reason given by `sysid`.
    #[error("sysid: {0}")]
    Invalid(String),
    /// A model file lacks the speed.
    #[error(transparent)]
    File(#[from] Refusal),
    /// The model has direct feedthrough.
    #[error(
        "the model has direct feedthrough, but planes move the vehicle only after a delay. Fit the model with a delay of 1"
    )]
    Feedthrough,
    /// The model has other signals.
    #[error("model of {output} over {input} refused: pitch_rate over dive_planes is needed")]
    Signals {
        /// Its input.
        input: String,
        /// Its output.
        output: String,
    },
    /// The covariance does not match the number of coefficients.
    #[error("model refused: its covariance does not match its coefficients")]
    Covariance,
    /// The model's sample time, s, is too long or too short for pitch.
    #[error("model refused: its sample time of {0} s is too long to resolve pitch")]
    SampleTime(f64),
    /// The model cannot be simulated, or its step response does not determine a pitch model.
    #[error("model refused: {0}")]
    Undetermined(String),
    /// The model's step response overflows.
    #[error("model refused: its step response overflows")]
    Overflow,
    /// The deviations of its parameters overflow.
    #[error("model refused: its uncertainty is not finite")]
    InfiniteUncertainty,
    /// A parameter is too far from the schedule's value.
    #[error("{name} is {ratio:.2} times its scheduled value")]
    Far {
        /// The parameter.
        name: &'static str,
        /// The parameter divided by its scheduled value.
        ratio: f64,
    },
    /// A parameter is too uncertain.
    #[error("{name} is known only to within {:.0} %", 100.0 * .deviation)]
    Uncertain {
        /// The parameter.
        name: &'static str,
        /// Standard deviation divided by the value.
        deviation: f64,
    },
}

/// The reason why no gains can be computed from a model file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// The file is not a valid model file.
    #[error(transparent)]
    File(#[from] planesman_model_file::Error),
    /// The model in the file cannot be used.
    #[error("model file '{path}': {reason}")]
    Distrusted {
        /// The file.
        path: String,
        /// The reason.
        reason: Distrust,
    },
}
