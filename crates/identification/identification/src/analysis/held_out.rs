//! How a model fares on data that it was not fitted to.

use super::checks;
use super::reason::{FitRemark, Reason};
use super::verdict::{GOOD, VERY_GOOD};
use crate::estimators::Estimator;
use crate::selection::criteria::first_part;
use crate::structure::{Problem, variance};

/// The fit of the best of models, %, up to which the output hardly moves beyond the noise.
const UNINFORMATIVE_FIT: f64 = 10.0;
/// By how much a fit, %, may be below what the noise leaves to the best of models, and be as good.
const AS_GOOD: f64 = 3.0;
/// By how much a fit, %, on held-out data is below that on the whole record when the model is called overfitted.
const OVERFITTED: f64 = 20.0;

/// The fits of what is held out of the longest run, or of the validation data, %.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldOutFits {
    /// Samples at the beginning of the longest run, behind which it was held out where there is no other data to validate on.
    pub from: usize,
    /// The output's standard deviation there, over that of all of the run.
    pub spread: Option<f64>,
    /// Simulated; `None` where the output hardly moves beyond the noise, which can be simulated neither well nor badly, or where
    /// the first part does not determine the model.
    pub fit: Option<f64>,
    /// Simulated, with the state fitted to the samples before alone.
    pub carried: Option<f64>,
    /// What the noise leaves to the best of models.
    pub attainable: Option<f64>,
}

impl HeldOutFits {
    /// The fits when the estimator is given the first part of each run.
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

    /// Whether a better fit is out of any model's reach.
    pub(crate) fn is_limited_by_noise(&self) -> bool {
        let pair = self.fit.zip(self.attainable);
        pair.is_some_and(|(held, attainable)| held > attainable - AS_GOOD)
    }

    /// The fit, beside that on all of the data, %.
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
