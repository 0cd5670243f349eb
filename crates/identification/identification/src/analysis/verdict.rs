//! The verdict: the model's suitability for use.

use std::fmt;

use planesman_wording::{option, setting};

/// Above this held-out fit, %, a model is called very good.
pub(super) const VERY_GOOD: f64 = 90.0;
/// Above this held-out fit, %, a model is called good.
pub const GOOD: f64 = 80.0;
/// Above this held-out fit, %, a model is called usable.
pub const USABLE: f64 = 50.0;

planesman_wording::choices! {
    /// The permitted use of a model.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Standing {
        /// It simulates well.
        Good = "good",
        /// It simulates.
        Usable = "usable",
        /// The model may be used if the reasons against it are considered.
        UsableWithCare = "usable_with_care",
        /// No data was available to validate the model.
        NotValidated = "not_validated",
        /// The model must not be used.
        NotUsable = "not_usable",
    }
}

impl Standing {
    /// The standing with this name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// A verdict on the suitability of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The input explains too little of the output.
    NoEffect,
    /// The record does not determine a model.
    Undetermined,
    /// Inputs move together.
    Inseparable,
    /// No data is available to validate the model.
    NotValidated,
    /// The model has few samples for its number of parameters.
    FewSamples,
    /// The output drifts.
    Drift {
        /// Whether the model simulates well enough to be used with care.
        usable: bool,
    },
    /// The data seems closed-loop.
    ClosedLoop {
        /// Whether the model simulates well enough to be used with care.
        usable: bool,
    },
    /// The system is nonlinear or changes with time.
    NotLinear {
        /// Whether the model simulates well enough to be used with care.
        usable: bool,
    },
    /// Something that is not recorded moves the output.
    Disturbed {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// Noise prevents a better fit by any model.
    NoiseLimited {
        /// Whether the model nevertheless simulates well.
        good: bool,
    },
    /// The model does not simulate the output.
    Unusable,
    /// The model does not fit all parts of the record.
    Unsteady,
    /// The times of the data are in doubt.
    TimeDoubtful,
    /// A signal seems to mix two sources.
    Mixed,
    /// The output seems to precede its input.
    Early,
    /// The steady-state gain is not determined.
    GainUndetermined,
    /// The data does not determine every parameter of the user's equations.
    ParametersUndetermined,
    /// Dynamics are missing.
    DynamicsMissing,
    /// It simulates.
    Usable,
    /// It simulates well.
    Good,
}

/// For each verdict: permitted use, code, and verdict text.
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
    /// The permitted use of the model.
    #[must_use]
    pub const fn standing(self) -> Standing {
        self.row().0
    }

    /// The verdict's code in files and JSON; code and [`standing`](Self::standing) together identify the verdict.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.row().1
    }

    /// In a word.
    #[must_use]
    pub const fn words(self) -> &'static str {
        self.row().2
    }

    /// The verdict with this code and standing.
    #[must_use]
    pub fn of(code: &str, standing: Standing) -> Option<Self> {
        let is_it = |it: &Self| it.code() == code && it.standing() == standing;
        Self::ALL.into_iter().find(is_it)
    }

    /// The next step: `once_written` if it is given and the verdict recommends writing the model, otherwise `otherwise`.
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

    /// Whether the model may be used, at least with care.
    #[must_use]
    pub const fn is_usable(self) -> bool {
        !matches!(
            self.standing(),
            Standing::NotUsable | Standing::NotValidated
        )
    }
}

impl Verdict {
    /// The next step for the user.
    #[must_use]
    pub fn next(self) -> String {
        let page = setting("html", "model.html");
        let reference = setting("reference", "TOPIC:FIELD");
        let window = setting("window", "FROM..TO");
        let write = setting("model", "model.yaml");
        match self {
            Self::NoEffect => {
                "excite the system more, with a PRBS or steps that move the output well beyond its noise"
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
                "give the reference of the loop with {reference}, or compare with {}",
                setting("method", "armax")
            ),
            Self::NotLinear { .. } => format!(
                "fit input levels or times separately with {window}, or use your own equations with {}",
                option("equations")
            ),
            Self::Disturbed { .. } => format!(
                "record the disturbance as an additional input, or leave out the time when it acts: {window}"
            ),
            Self::NoiseLimited { .. } => format!(
                "record for longer or excite more to get narrower intervals; or write the model: {write}"
            ),
            Self::Unusable => format!(
                "look at the plots to see where the model fails: {page}. Then choose a segment with {window}"
            ),
            Self::Unsteady => format!("fit each segment separately: {window}"),
            Self::TimeDoubtful => format!(
                "name the unit or column of the time with {} or {}; for a bag, name the clock with {}",
                option("time_unit"),
                option("time"),
                setting("stamp", "log")
            ),
            Self::Mixed => format!(
                "record each publisher under a separate name, or choose one publisher with {} and {}",
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
                "fix one of the parameters named above (fixed: VALUE), or record a manoeuvre that separates their effects"
                    .to_owned()
            }
            Self::DynamicsMissing => format!(
                "let the program choose order, delay and method: {}",
                setting("method", "automatic")
            ),
            Self::Usable => format!(
                "compare with another method, {}, or write the plots with {page}",
                setting("method", "armax")
            ),
            Self::Good => format!("write the model for the simulator and the controller: {write}"),
        }
    }

    /// The verdict as a sentence, with the next step.
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
