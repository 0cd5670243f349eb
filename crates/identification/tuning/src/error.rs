//! Why there are no gains.

use planesman_identification::IdentificationError;
use planesman_identification::analysis::Verdict;
use planesman_text::{option, setting};

/// A result of this crate.
pub(crate) type Result<T, E = TuneError> = std::result::Result<T, E>;

/// Why there are no gains. Each sentence ends with what to do next.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// The verdict says that it is no model to rely on.
    #[error(
        "the model's verdict is '{}': gains for such a model are a guess. Identify it anew, or take it as it is: {}",
        .0.words(), option("anyway")
    )]
    Verdict(Verdict),
    /// A judgement that no fit of this version writes.
    #[error("the model file's judgement '{standing}', '{code}' is not known")]
    Judgement {
        /// What may be done with it.
        standing: String,
        /// What decided.
        code: String,
    },
    /// A model without a covariance, which is not known exactly.
    #[error(
        "the model file has no covariance: nothing says how far the plant may be from it. Identify it by planesman sysid fit, or tune it as if \
         it were exact: {}",
        option("anyway")
    )]
    NoCovariance,
    /// The 95 % interval of the gain contains 0.
    #[error(
        "the {what} is {interval}: its sign is not determined, and gains of the wrong sign are unstable. Record steps of the input that move the \
         output well beyond its noise"
    )]
    Sign {
        /// Which gain.
        what: &'static str,
        /// With its 95 % interval.
        interval: String,
    },
    /// The input acts on the output of the same sample.
    #[error(
        "the input acts on the output of the same sample, which a controller that reads the output first cannot use: give the time from the sample \
         to its command, {}", setting("computing_delay", .0)
    )]
    Feedthrough(f64),
    /// Another tick than the model's, and no continuous counterpart.
    #[error(
        "the model has no continuous counterpart ({source}): keep its own sample time, {}, and whole samples of {}",
        setting("period", sample_time),
        option("computing_delay")
    )]
    NoContinuous {
        /// The model's, s.
        sample_time: f64,
        /// Why.
        source: IdentificationError,
    },
    /// An unstable pole and a dead time that no controller gets along with.
    #[error(
        "the plant has an unstable pole of time constant {time_constant:.4} s behind {delay:.4} s of dead time: no controller has a sensitivity peak \
         below {least:.2}, and {} is {limit}. Shorten the dead time ({}, {}, the actuator), or allow more: {}",
        option("ms"), option("period"), option("computing_delay"), setting("ms", format!("{allowed:.1}"))
    )]
    TooLate {
        /// Of the pole, s.
        time_constant: f64,
        /// s
        delay: f64,
        /// The bound.
        least: f64,
        /// The limit asked for.
        limit: f64,
        /// A limit above the bound.
        allowed: f64,
    },
    /// A rule for another kind of model.
    #[error(
        "{} is for {needs}, and the model has {found}. Use {}",
        setting("method", method),
        setting("method", "optimise")
    )]
    NotFor {
        /// The method.
        method: &'static str,
        /// What it is for.
        needs: &'static str,
        /// What the model has instead.
        found: String,
    },
    /// No gains of the method keep the limits.
    #[error(
        "{method}: no gains keep {limits} in 95 % of the plants that the model allows; {best}. {advice}"
    )]
    OutOfReach {
        /// The method.
        method: &'static str,
        /// The limits.
        limits: String,
        /// What the best ones do.
        best: String,
        /// What to do.
        advice: String,
    },
    /// An option for another method.
    #[error(
        "{} is for {}",
        planesman_text::option(option),
        setting("method", methods)
    )]
    Option {
        /// The option.
        option: &'static str,
        /// The methods that take it.
        methods: &'static str,
    },
    /// A phase that no controller of the kind has.
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
    /// Numbers that overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
    /// A model that is none.
    #[error(transparent)]
    Model(#[from] IdentificationError),
}
