//! Why an identified model is not used for the gains.

use planesman_model_file::Refusal;

/// Why an identified model is not used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Distrust {
    /// There is none yet.
    #[error("no model has come yet")]
    NoModel,
    /// The last one is too old; its age, s.
    #[error("the last model is {0:.1} s old")]
    Old(f64),
    /// `sysid` marked it as not valid; its reason.
    #[error("sysid: {0}")]
    Invalid(String),
    /// A model file lacks the speed.
    #[error(transparent)]
    File(#[from] Refusal),
    /// The input acts on the output of the same sample.
    #[error("direct feedthrough: planes move the vehicle only later; fit it with a delay of 1")]
    Feedthrough,
    /// The model is of other signals.
    #[error("model of {output} over {input} refused: pitch_rate over dive_planes is needed")]
    Signals {
        /// Its input.
        input: String,
        /// Its output.
        output: String,
    },
    /// Its covariance has another size than its coefficients.
    #[error("model refused: its covariance does not belong to its coefficients")]
    Covariance,
    /// Its sample time, s, is too long or too short for pitch.
    #[error("model refused: a sample time of {0} s does not resolve pitch")]
    SampleTime(f64),
    /// It cannot be simulated, or its step response determines no pitch model.
    #[error("model refused: {0}")]
    Undetermined(String),
    /// Its step response overflows.
    #[error("model refused: its step response overflows")]
    Overflow,
    /// The deviations of its parameters overflow.
    #[error("model refused: its uncertainty is not finite")]
    InfiniteUncertainty,
    /// A parameter is too far from the schedule's.
    #[error("{name} is {ratio:.2} times the scheduled one")]
    Far {
        /// The parameter.
        name: &'static str,
        /// Its value over the scheduled one.
        ratio: f64,
    },
    /// A parameter is too uncertain.
    #[error("{name} is known to {:.0} % only", 100.0 * .deviation)]
    Uncertain {
        /// The parameter.
        name: &'static str,
        /// Its standard deviation over its value.
        deviation: f64,
    },
}

/// Why no gains come from a model file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// The file is no model file.
    #[error(transparent)]
    File(#[from] planesman_model_file::Error),
    /// Its model is not used.
    #[error("model file '{path}': {reason}")]
    Distrusted {
        /// The file.
        path: String,
        /// Why not.
        reason: Distrust,
    },
}
