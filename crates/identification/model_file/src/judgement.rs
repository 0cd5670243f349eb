//! The judgement on a model, as data.

use serde::{Deserialize, Serialize};

/// The judgement on a model, from its fit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judgement {
    /// `good`, `usable`, `usable_with_care`, `not_validated` or `not_usable`.
    pub standing: String,
    /// The reason for the standing, as `noise_limited` or `closed_loop`.
    pub code: String,
    /// Findings for and against the model, in the order of the sentences.
    #[serde(default)]
    pub findings: Vec<String>,
}

/// Verdict texts of the first format, each with its standing and code.
const OF_FORMAT_ONE: [(&str, &str, &str); 23] = [
    ("no model of what the input does", "not_usable", "no_effect"),
    (
        "the record does not determine a model",
        "not_usable",
        "undetermined",
    ),
    (
        "the inputs cannot be told apart",
        "not_usable",
        "inseparable",
    ),
    ("not validated", "not_validated", "not_validated"),
    (
        "usable with care: few samples for so many parameters",
        "usable_with_care",
        "few_samples",
    ),
    (
        "not usable for simulation: the output drifts",
        "not_usable",
        "drift",
    ),
    (
        "usable with care: the output drifts",
        "usable_with_care",
        "drift",
    ),
    (
        "not usable for simulation: the data seems closed-loop",
        "not_usable",
        "closed_loop",
    ),
    (
        "usable with care: the data seems closed-loop",
        "usable_with_care",
        "closed_loop",
    ),
    (
        "not usable for simulation: not linear, or varying",
        "not_usable",
        "not_linear",
    ),
    (
        "usable with care: not linear, or varying",
        "usable_with_care",
        "not_linear",
    ),
    (
        "usable: the noise limits its fit",
        "usable",
        "noise_limited",
    ),
    ("good: the noise limits its fit", "good", "noise_limited"),
    (
        "not usable for simulation",
        "not_usable",
        "does_not_simulate",
    ),
    (
        "usable with care: it does not hold all along the record",
        "usable_with_care",
        "unsteady",
    ),
    (
        "usable with care: the times are in doubt",
        "usable_with_care",
        "time_doubtful",
    ),
    (
        "usable with care: a signal seems to be of two publishers in turns",
        "usable_with_care",
        "mixed",
    ),
    (
        "usable with care: the output seems to come before its input",
        "usable_with_care",
        "early",
    ),
    (
        "usable with care: the steady-state gain is not determined",
        "usable_with_care",
        "gain_undetermined",
    ),
    (
        "usable with care: the data does not determine every parameter",
        "usable_with_care",
        "parameters_undetermined",
    ),
    (
        "usable with care: dynamics are missing",
        "usable_with_care",
        "dynamics_missing",
    ),
    ("usable", "usable", "simulates"),
    ("good", "good", "simulates"),
];

impl Judgement {
    /// Reads the judgement from the sentences of a file of the first format, which has no codes.
    pub(crate) fn of_sentences(verdict: &[String]) -> Option<Self> {
        let words = verdict.iter().find_map(|it| it.strip_prefix("verdict: "))?;
        let words = words.split(". Next:").next()?;
        let known = OF_FORMAT_ONE.iter().find(|it| it.0 == words)?;
        Some(Self {
            standing: known.1.to_owned(),
            code: known.2.to_owned(),
            findings: Vec::new(),
        })
    }
}
