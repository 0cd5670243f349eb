//! Performance of a model on data that was not used for its fit.

use super::checks;
use super::reason::{FitRemark, Reason};
use super::verdict::{GOOD, VERY_GOOD};
use crate::estimators::Estimator;
use crate::selection::criteria::first_part;
use crate::structure::{Problem, variance};

/// The output hardly moves beyond the noise if noise limits every fit to at most this, %.
const UNINFORMATIVE_FIT: f64 = 10.0;
/// A fit this close, %, to the limit set by noise counts as equally good.
const AS_GOOD: f64 = 3.0;
/// A model counts as overfitted if its fit on held-out data is this much, %, below that on the whole record.
const OVERFITTED: f64 = 20.0;

/// Fits on the held-out part of the longest run, or on the validation data, %.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldOutFits {
    /// Number of samples of the longest run before the held-out part, if there is no separate validation data.
    pub from: usize,
    /// Standard deviation of the output in the held-out part, relative to the whole run.
    pub spread: Option<f64>,
    /// Simulated fit; `None` if the output hardly moves beyond the noise, or if the first part does not determine the model.
    pub fit: Option<f64>,
    /// Simulated fit, with the initial state fitted only to the samples before.
    pub carried: Option<f64>,
    /// The largest fit that noise allows.
    pub attainable: Option<f64>,
}

impl HeldOutFits {
    /// The fits of a model estimated from the first part of each run.
    pub(super) fn of(estimator: &dyn Estimator, problem: &Problem<'_>, longest: usize) -> Self {
        let part = Problem {
            runs: problem.runs.iter().map(first_part).collect(),
            ..problem.clone()
        };
        let from = part.runs[longest].outputs.len();
        let run = problem.runs[longest];
        let held_out = &run.outputs[from..];
        let it = Self {
            from,
            spread: Some((variance(held_out) / variance(run.outputs)).sqrt()),
            attainable: checks::attainable_fit(problem, held_out),
            ..Self::default()
        };
        let found = (!it.is_noise())
            .then(|| estimator.fit(&part).ok())
            .flatten();
        let found = found.as_ref();
        Self {
            fit: found.and_then(|it| it.simulated_fit(longest, run, from)),
            carried: found.and_then(|it| it.fit_from_carried_state(longest, run, from)),
            ..it
        }
    }

    /// Whether the output hardly moves beyond the noise.
    pub(crate) fn is_noise(&self) -> bool {
        self.attainable.is_some_and(|fit| fit <= UNINFORMATIVE_FIT)
    }

    /// Whether noise prevents a better fit by any model.
    pub(crate) fn is_limited_by_noise(&self) -> bool {
        let pair = self.fit.zip(self.attainable);
        pair.is_some_and(|(held, attainable)| held > attainable - AS_GOOD)
    }

    /// The fit compared with the fit on all data, %, as a reason.
    pub(crate) fn reason(&self, whole: Option<f64>) -> Option<Reason> {
        let held = self.fit?;
        let remark = match whole {
            _ if held < 0.0 => FitRemark::WorseThanMean,
            _ if self.is_limited_by_noise() && held < GOOD => {
                FitRemark::NoiseLimited(self.attainable.unwrap_or(held))
            }
            _ if held >= VERY_GOOD => FitRemark::VeryGood,
            Some(fit) if held < fit - OVERFITTED => FitRemark::Overfitted(fit),
            _ => FitRemark::None,
        };
        Some(Reason::HeldOutFit(held, remark))
    }
}
