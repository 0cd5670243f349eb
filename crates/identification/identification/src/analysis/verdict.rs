//! What a model is good for.

use std::fmt;

use planesman_wording::{option, setting};

/// A held-out fit, %, from which a model is called very good.
pub(super) const VERY_GOOD: f64 = 90.0;
/// A held-out fit, %, from which a model is called good.
pub const GOOD: f64 = 80.0;
/// A held-out fit, %, from which a model is called usable.
pub const USABLE: f64 = 50.0;

planesman_wording::choices! {
    /// What may be done with a model.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Standing {
        /// It simulates well.
        Good = "good",
        /// It simulates.
        Usable = "usable",
        /// It may be used by who knows what speaks against it.
        UsableWithCare = "usable_with_care",
        /// There is nothing to judge it on.
        NotValidated = "not_validated",
        /// It is not to be used.
        NotUsable = "not_usable",
    }
}

impl Standing {
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
    /// Something that is not recorded moves the output.
    Disturbed {
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

/// What is said of each verdict: what may be done with the model, the code, the verdict in a word.
macro_rules! verdicts {
    ($($verdict:ident $({ $field:ident: $value:literal })?: $standing:ident, $code:literal, $words:literal;)+) => {
        impl Verdict {
            /// All verdicts.
            pub const ALL: [Self; [$($code),+].len()] = [$(Self::$verdict $({ $field: $value })?),+];

            const fn row(self) -> (Standing, &'static str, &'static str) {
                match self {
                    $(Self::$verdict $({ $field: $value })? => (Standing::$standing, $code, $words),)+
                }
            }
        }
    };
}

verdicts! {
    NoEffect: NotUsable, "no_effect", "no model: the input has no effect on the output";
    Undetermined: NotUsable, "undetermined", "the record does not determine a model";
    Inseparable: NotUsable, "inseparable", "the inputs cannot be told apart";
    NotValidated: NotValidated, "not_validated", "not validated";
    FewSamples: UsableWithCare, "few_samples", "usable with care: few samples for so many parameters";
    Drift { usable: false }: NotUsable, "drift", "not usable for simulation: the output drifts";
    Drift { usable: true }: UsableWithCare, "drift", "usable with care: the output drifts";
    ClosedLoop { usable: false }: NotUsable, "closed_loop", "not usable for simulation: the data seems closed-loop";
    ClosedLoop { usable: true }: UsableWithCare, "closed_loop", "usable with care: the data seems closed-loop";
    NotLinear { usable: false }: NotUsable, "not_linear", "not usable for simulation: not linear, or varying";
    NotLinear { usable: true }: UsableWithCare, "not_linear", "usable with care: not linear, or varying";
    Disturbed { usable: false }: NotUsable, "disturbed", "not usable for simulation: something that is not recorded moves the output";
    Disturbed { usable: true }: UsableWithCare, "disturbed", "usable with care: something that is not recorded moves the output";
    NoiseLimited { good: false }: Usable, "noise_limited", "usable: the noise limits its fit";
    NoiseLimited { good: true }: Good, "noise_limited", "good: the noise limits its fit";
    Unusable: NotUsable, "does_not_simulate", "not usable for simulation";
    Unsteady: UsableWithCare, "unsteady", "usable with care: the model does not fit all parts of the record";
    TimeDoubtful: UsableWithCare, "time_doubtful", "usable with care: the times are in doubt";
    Mixed: UsableWithCare, "mixed", "usable with care: a signal seems to mix the values of two publishers";
    Early: UsableWithCare, "early", "usable with care: the output seems to move before its input";
    GainUndetermined: UsableWithCare, "gain_undetermined", "usable with care: the steady-state gain is not determined";
    ParametersUndetermined: UsableWithCare, "parameters_undetermined", "usable with care: the data does not determine every parameter";
    DynamicsMissing: UsableWithCare, "dynamics_missing", "usable with care: dynamics are missing";
    Usable: Usable, "simulates", "usable";
    Good: Good, "simulates", "good";
}

impl Verdict {
    /// What may be done with the model.
    #[must_use]
    pub const fn standing(self) -> Standing {
        self.row().0
    }

    /// What the verdict names, as files and JSON have it; with [`standing`](Self::standing) it tells verdicts apart.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.row().1
    }

    /// In a word.
    #[must_use]
    pub const fn words(self) -> &'static str {
        self.row().2
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
                "record again with an input of more variation (PRBS, several steps), or use a lower order: {}",
                setting("order", 1)
            ),
            Self::Inseparable => {
                "record again with each input moving independently: one after the other, or each with a separate PRBS"
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
                "fit input levels or times separately: {window}; or use your own equations: {}",
                option("equations")
            ),
            Self::Disturbed { .. } => format!(
                "record the disturbance as an additional input, or leave out the time when it acts: {window}"
            ),
            Self::NoiseLimited { .. } => format!(
                "record for longer or excite more to get narrower intervals; or write the model: {write}"
            ),
            Self::Unusable => format!(
                "look at the page to see where the model fails: {page}; then choose a segment: {window}"
            ),
            Self::Unsteady => format!("fit each segment separately: {window}"),
            Self::TimeDoubtful => format!(
                "name the unit or column of the time: {}, {}; for a bag, name the clock: {}",
                option("time_unit"),
                option("time"),
                setting("stamp", "log")
            ),
            Self::Mixed => format!(
                "record each publisher under a separate name, or choose one publisher: {}, {}",
                option("input"),
                option("output")
            ),
            Self::Early => format!(
                "check the stamps ({}, {}), or give the reference of the loop: {reference}",
                option("stamp"),
                option("time")
            ),
            Self::GainUndetermined => {
                "record steps, each held until the output settles".to_owned()
            }
            Self::ParametersUndetermined => {
                "fix one of the parameters named above (fixed: VALUE), or record a manoeuvre that separates them"
                    .to_owned()
            }
            Self::DynamicsMissing => format!(
                "let the program choose order, delay and method: {}",
                setting("method", "automatic")
            ),
            Self::Usable => format!(
                "compare with another method: {}; to see the page: {page}",
                setting("method", "armax")
            ),
            Self::Good => format!("write the model for the simulator and the controller: {write}"),
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
