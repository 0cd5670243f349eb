//! Why there are no gains.

use planesman_identification::IdentificationError;

/// A result of this crate.
pub(crate) type Result<T, E = TuneError> = std::result::Result<T, E>;

/// Why there are no gains. Each sentence ends with what to do next.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// The verdict says that it is no model to rely on.
    #[error(
        "{0}: gains for such a model are a guess. Identify it anew, or take it as it is: --anyway"
    )]
    Verdict(String),
    /// A model without a covariance, which is not known exactly.
    #[error(
        "the model file has no covariance: nothing says how far the plant may be from it. Identify it by planesman sysid fit --model, or tune it \
         as if it were exact: --anyway"
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
         to its command, --computing-delay {0}"
    )]
    Feedthrough(f64),
    /// Another tick than the model's, and no continuous counterpart.
    #[error(
        "the model has no continuous counterpart ({source}): keep its own sample time, --period {sample_time}, and whole samples of \
         --computing-delay"
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
         below {least:.2}, and --ms is {limit}. Shorten the dead time (--period, --computing-delay, the actuator), or allow more: --ms {allowed:.1}"
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
    #[error("--method {method} is for {needs}, and the model has {found}. Use --method optimise")]
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
    #[error("--{option} is for --method {methods}")]
    Option {
        /// The option.
        option: &'static str,
        /// The methods that take it.
        methods: &'static str,
    },
    /// A phase that no controller of the kind has.
    #[error(
        "--crossover {crossover}: {reason}. Choose a {direction} crossover, or --controller pid"
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
