//! Reasons why there are no gains.

use planesman_identification::IdentificationError;
use planesman_identification::analysis::Verdict;
use planesman_text::{option, setting};

/// A result of this crate.
pub(crate) type Result<T, E = TuneError> = std::result::Result<T, E>;

/// Reasons why there are no gains. Each message ends with the next step.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// The model's verdict says that the model is not reliable.
    #[error(
        "the model's verdict is '{}', so gains from this model would be a guess. Identify a better model, or use this one anyway: {}",
        .0.words(), option("anyway")
    )]
    Verdict(Verdict),
    /// A judgement that no fit of this version writes.
    #[error("this program does not know the model file's judgement '{standing}', '{code}'")]
    Judgement {
        /// The standing in the file.
        standing: String,
        /// What decided.
        code: String,
    },
    /// The model has no covariance, and the options do not say that it is exact.
    #[error(
        "the model file has no covariance, so the uncertainty of the plant is unknown. Use a model of planesman sysid fit, or treat this one as exact: {}",
        option("anyway")
    )]
    NoCovariance,
    /// The 95 % interval of the gain contains 0.
    #[error(
        "the {what} is {interval}, so its sign is uncertain, and gains with the wrong sign make the loop unstable. Record steps of the input that move the \
         output well beyond its noise"
    )]
    Sign {
        /// Which gain.
        what: &'static str,
        /// With its 95 % interval.
        interval: String,
    },
    /// The model has direct feedthrough.
    #[error(
        "the input acts on the output of the same sample, but a controller must read the output first. Give the delay from the sample to its command: {}", setting("computing_delay", format_args!("{}s", .0))
    )]
    Feedthrough(f64),
    /// The tick differs from the model's sampling interval, but the model has no equivalent in continuous time.
    #[error(
        "the model has no equivalent in continuous time ({source}): use its own sample time, {}, and whole samples of {}",
        setting("period", sample_time),
        option("computing_delay")
    )]
    NoContinuous {
        /// The model's, s.
        sample_time: f64,
        /// Why.
        source: IdentificationError,
    },
    /// The plant has an unstable pole, and a dead time so long that no controller keeps the limit.
    #[error(
        "the plant has an unstable pole with a time constant of {time_constant:.4} s, and {delay:.4} s of dead time. Therefore no controller has a sensitivity peak below {least:.2}, but the limit {} is {limit}. \
         Shorten the dead time ({}, {}, the actuator), or allow a higher peak: {}",
        option("ms"), option("period"), option("computing_delay"), setting("ms", format!("{allowed:.1}"))
    )]
    TooLate {
        /// Time constant of the pole, s.
        time_constant: f64,
        /// s
        delay: f64,
        /// The bound.
        least: f64,
        /// The requested limit.
        limit: f64,
        /// A limit that a controller can keep.
        allowed: f64,
    },
    /// The rule is for another kind of model.
    #[error(
        "{} needs {needs}, but the model has {found}. Use {}",
        setting("method", method),
        setting("method", "optimise")
    )]
    NotFor {
        /// The method.
        method: &'static str,
        /// The kind of model that the rule needs.
        needs: &'static str,
        /// The property that the model has instead.
        found: String,
    },
    /// No gains of the method satisfy the limits.
    #[error(
        "{method}: no gains keep {limits} in 95 % of the plants within the model's uncertainty; \
         {best}. {advice}"
    )]
    OutOfReach {
        /// The method.
        method: &'static str,
        /// The limits.
        limits: String,
        /// The margins of the best gains.
        best: String,
        /// The next step.
        advice: String,
    },
    /// The option is for another method.
    #[error(
        "{} is for {}",
        planesman_text::option(option),
        setting("method", methods)
    )]
    Option {
        /// The option.
        option: &'static str,
        /// The methods that use the option.
        methods: &'static str,
    },
    /// The crossover needs a phase that no controller of this kind can have.
    #[error(
        "{}: {reason}. Choose a {direction} crossover, or {}",
        setting("crossover", crossover),
        setting("controller", "pid")
    )]
    Crossover {
        /// rad/s
        crossover: f64,
        /// Why.
        reason: String,
        /// `lower` or `higher`.
        direction: &'static str,
    },
    /// If numbers overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
    /// An invalid model.
    #[error(transparent)]
    Model(#[from] IdentificationError),
}
