//! What a model is good for.

use std::fmt;

use planesman_wording::{option, setting};

/// A held-out fit, %, from which a model is called very good.
pub(super) const VERY_GOOD: f64 = 90.0;
/// A held-out fit, %, from which a model is called good.
pub const GOOD: f64 = 80.0;
/// A held-out fit, %, from which a model is called usable.
pub const USABLE: f64 = 50.0;

/// What may be done with a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It simulates well.
    Good,
    /// It simulates.
    Usable,
    /// It may be used by who knows what speaks against it.
    UsableWithCare,
    /// There is nothing to judge it on.
    NotValidated,
    /// It is not to be used.
    NotUsable,
}

impl Standing {
    /// All.
    pub const ALL: [Self; 5] = [
        Self::Good,
        Self::Usable,
        Self::UsableWithCare,
        Self::NotValidated,
        Self::NotUsable,
    ];

    /// As files and JSON have it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::UsableWithCare => "usable_with_care",
            Self::NotValidated => "not_validated",
            Self::NotUsable => "not_usable",
        }
    }

    /// The one of that name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// What a model is good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The input accounts for too little of the output.
    NoEffect,
    /// The record does not determine a model.
    Undetermined,
    /// Inputs move together.
    Inseparable,
    /// There is nothing to judge it on.
    NotValidated,
    /// It has few samples for its parameters.
    FewSamples,
    /// The output drifts.
    Drift {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// The data seems closed-loop.
    ClosedLoop {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// The system is not linear, or changes in time.
    NotLinear {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// No model could fit better than it does.
    NoiseLimited {
        /// Whether it simulates well for all that.
        good: bool,
    },
    /// It does not simulate.
    Unusable,
    /// It does not hold all along the record.
    Unsteady,
    /// The times of the data are in doubt.
    TimeDoubtful,
    /// A signal seems to be two things in turns.
    Mixed,
    /// The output seems to come before its input.
    Early,
    /// Its steady-state gain is not determined.
    GainUndetermined,
    /// The data does not determine every parameter of equations that were given.
    ParametersUndetermined,
    /// Dynamics are missing.
    DynamicsMissing,
    /// It simulates.
    Usable,
    /// It simulates well.
    Good,
}

impl Verdict {
    /// All verdicts.
    pub const ALL: [Self; 23] = [
        Self::NoEffect,
        Self::Undetermined,
        Self::Inseparable,
        Self::NotValidated,
        Self::FewSamples,
        Self::Drift { usable: false },
        Self::Drift { usable: true },
        Self::ClosedLoop { usable: false },
        Self::ClosedLoop { usable: true },
        Self::NotLinear { usable: false },
        Self::NotLinear { usable: true },
        Self::NoiseLimited { good: false },
        Self::NoiseLimited { good: true },
        Self::Unusable,
        Self::Unsteady,
        Self::TimeDoubtful,
        Self::Mixed,
        Self::Early,
        Self::GainUndetermined,
        Self::ParametersUndetermined,
        Self::DynamicsMissing,
        Self::Usable,
        Self::Good,
    ];

    /// What may be done with the model.
    #[must_use]
    pub const fn standing(self) -> Standing {
        match self {
            Self::Good | Self::NoiseLimited { good: true } => Standing::Good,
            Self::Usable | Self::NoiseLimited { good: false } => Standing::Usable,
            Self::NotValidated => Standing::NotValidated,
            Self::NoEffect
            | Self::Undetermined
            | Self::Inseparable
            | Self::Unusable
            | Self::Drift { usable: false }
            | Self::ClosedLoop { usable: false }
            | Self::NotLinear { usable: false } => Standing::NotUsable,
            _ => Standing::UsableWithCare,
        }
    }

    /// What the verdict names, as files and JSON have it; with [`standing`](Self::standing) it tells verdicts apart.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::NoEffect => "no_effect",
            Self::Undetermined => "undetermined",
            Self::Inseparable => "inseparable",
            Self::NotValidated => "not_validated",
            Self::FewSamples => "few_samples",
            Self::Drift { .. } => "drift",
            Self::ClosedLoop { .. } => "closed_loop",
            Self::NotLinear { .. } => "not_linear",
            Self::NoiseLimited { .. } => "noise_limited",
            Self::Unusable => "does_not_simulate",
            Self::Unsteady => "unsteady",
            Self::TimeDoubtful => "time_doubtful",
            Self::Mixed => "mixed",
            Self::Early => "early",
            Self::GainUndetermined => "gain_undetermined",
            Self::ParametersUndetermined => "parameters_undetermined",
            Self::DynamicsMissing => "dynamics_missing",
            Self::Usable | Self::Good => "simulates",
        }
    }

    /// The verdict of that code and standing.
    #[must_use]
    pub fn of(code: &str, standing: Standing) -> Option<Self> {
        let is_it = |it: &Self| it.code() == code && it.standing() == standing;
        Self::ALL.into_iter().find(is_it)
    }

    /// What is next: `once_written`, where that is given and the model would be to write, else `otherwise`.
    pub(crate) fn next_once(
        self,
        once_written: Option<&str>,
        otherwise: impl FnOnce() -> String,
    ) -> String {
        match (self, once_written) {
            (Self::Good | Self::NoiseLimited { .. }, Some(next)) => next.to_owned(),
            _ => otherwise(),
        }
    }

    /// Whether the model may be used, if with care.
    #[must_use]
    pub const fn is_usable(self) -> bool {
        !matches!(
            self.standing(),
            Standing::NotUsable | Standing::NotValidated
        )
    }
}

impl Verdict {
    /// In a word.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::NoEffect => "no model of what the input does",
            Self::Undetermined => "the record does not determine a model",
            Self::Inseparable => "the inputs cannot be told apart",
            Self::NotValidated => "not validated",
            Self::FewSamples => "usable with care: few samples for so many parameters",
            Self::Drift { usable: false } => "not usable for simulation: the output drifts",
            Self::Drift { usable: true } => "usable with care: the output drifts",
            Self::ClosedLoop { usable: false } => {
                "not usable for simulation: the data seems closed-loop"
            }
            Self::ClosedLoop { usable: true } => "usable with care: the data seems closed-loop",
            Self::NotLinear { usable: false } => {
                "not usable for simulation: not linear, or varying"
            }
            Self::NotLinear { usable: true } => "usable with care: not linear, or varying",
            Self::NoiseLimited { good: false } => "usable: the noise limits its fit",
            Self::NoiseLimited { good: true } => "good: the noise limits its fit",
            Self::Unusable => "not usable for simulation",
            Self::Unsteady => "usable with care: it does not hold all along the record",
            Self::TimeDoubtful => "usable with care: the times are in doubt",
            Self::Mixed => "usable with care: a signal seems to be of two publishers in turns",
            Self::Early => "usable with care: the output seems to come before its input",
            Self::GainUndetermined => "usable with care: the steady-state gain is not determined",
            Self::ParametersUndetermined => {
                "usable with care: the data does not determine every parameter"
            }
            Self::DynamicsMissing => "usable with care: dynamics are missing",
            Self::Usable => "usable",
            Self::Good => "good",
        }
    }

    /// What to do next.
    #[must_use]
    pub fn next(self) -> String {
        let page = setting("html", "model.html");
        let reference = setting("reference", "TOPIC:FIELD");
        let window = setting("window", "FROM..TO");
        let write = setting("model", "model.yaml");
        match self {
            Self::NoEffect => {
                "excite the system more: a PRBS or steps that move the output well beyond its noise"
                    .to_owned()
            }
            Self::Undetermined => format!(
                "record again with a richer input (PRBS, several steps), or ask for a lower order: {}",
                setting("order", 1)
            ),
            Self::Inseparable => {
                "record again with each input moving by itself: one after the other, or by a PRBS of its own"
                    .to_owned()
            }
            Self::NotValidated => "record for longer, with the input moving to the end".to_owned(),
            Self::FewSamples => "record for longer".to_owned(),
            Self::Drift { .. } => format!("subtract the drift: {}", setting("detrend", "line")),
            Self::ClosedLoop { .. } => format!(
                "give the reference of the loop: {reference}, or compare {}",
                setting("method", "armax")
            ),
            Self::NotLinear { .. } => format!(
                "fit levels or times apart, {window}, or fit a curve that is named above with the dynamics: {}",
                option("curve")
            ),
            Self::NoiseLimited { .. } => format!(
                "record for longer or excite more, for narrower intervals; or write it: {write}"
            ),
            Self::Unusable => format!(
                "look at the page for where it fails: {page}; then choose a segment: {window}"
            ),
            Self::Unsteady => format!("fit segments apart: {window}, once for each"),
            Self::TimeDoubtful => format!(
                "name their unit or column: {}, {}; of a bag the clock: {}",
                option("time_unit"),
                option("time"),
                setting("stamp", "log")
            ),
            Self::Mixed => format!(
                "record each under a name of its own, or name one: {}, {}",
                option("input"),
                option("output")
            ),
            Self::Early => format!(
                "look at the stamps ({}, {}), or give the reference of the loop: {reference}",
                option("stamp"),
                option("time")
            ),
            Self::GainUndetermined => {
                "record steps that are held until the output settles".to_owned()
            }
            Self::ParametersUndetermined => {
                "fix one of those that are named above (fixed: VALUE), or record what tells them apart"
                    .to_owned()
            }
            Self::DynamicsMissing => format!(
                "let order, delay and method be chosen: {}",
                setting("method", "automatic")
            ),
            Self::Usable => format!(
                "compare with another method: {}; page: {page}",
                setting("method", "armax")
            ),
            Self::Good => format!("write it for the simulator and the controller: {write}"),
        }
    }

    /// The sentence of a verdict with what to do next.
    #[must_use]
    pub fn text(self, next: impl fmt::Display) -> String {
        format!("verdict: {}. Next: {next}", self.words())
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(self.next()))
    }
}
