//! Every method on one record, beside each other.

use planesman_identification::GivenModel;
use planesman_identification::analysis::{AHEAD, Analysis};
use planesman_identification::estimators::{Estimate, Method};
use planesman_signals::PreparedRecord;
use planesman_text::in_one_line;
use serde_json::{Value, json};

use crate::compare::Compared;
use crate::error::FitError;

/// Methods drawn on a page.
const DRAWN: usize = 5;

/// A method that was tried.
#[derive(Debug)]
pub struct Trial {
    /// The method.
    pub method: Method,
    /// The model, or why there is none.
    pub outcome: Result<Analysis, FitError>,
    /// How long it took, s.
    pub seconds: f64,
}

impl Trial {
    /// The model, if there is one.
    #[must_use]
    pub fn found(&self) -> Option<&Analysis> {
        self.outcome.as_ref().ok()
    }

    /// Whether its residual is white, where there are tests of it.
    #[must_use]
    pub fn is_white(&self) -> Option<bool> {
        let tests = self.found()?.residuals.as_ref()?;
        Some(tests.whiteness.passes())
    }

    pub(crate) fn as_json(&self) -> Value {
        let structure = self.found().map(|it| &it.estimate.layout.structure);
        json!({
            "method": self.method.name(),
            "order": structure.map(|it| it.poles),
            "numerator": structure.map(|it| it.numerator),
            "delay": structure.map(|it| it.delay),
            "held_out_fit": self.found().and_then(|it| it.held_out.fit),
            "predicted_fit": self.found().and_then(|it| it.predicted_fit),
            "white": self.is_white(),
            "seconds": self.seconds,
            "refused": self.outcome.as_ref().err().map(|it| in_one_line(it)),
        })
    }
}

/// Those with a model, the best first: by the simulated fit on held-out data if one is better than the mean of the
/// output there, else by the predictions.
#[must_use]
pub fn ranked(tried: &[Trial]) -> Vec<&Trial> {
    let by = |of: fn(&Analysis) -> Option<f64>| {
        move |trial: &Trial| trial.found().and_then(of).unwrap_or(f64::NEG_INFINITY)
    };
    let (held, predicted) = (by(|it| it.held_out.fit), by(|it| it.predicted_fit));
    let simulates = tried.iter().any(|trial| held(trial) > 0.0);
    let mut ranked: Vec<&Trial> = tried.iter().filter(|it| it.outcome.is_ok()).collect();
    ranked.sort_by(|p, q| match simulates {
        true => held(q).total_cmp(&held(p)),
        false => predicted(q).total_cmp(&predicted(p)),
    });
    ranked
}

/// The best of them on one record, for a page.
///
/// # Errors
/// When a model cannot be judged on the record.
pub fn compared(tried: &[Trial], prepared: &PreparedRecord) -> Result<Vec<Compared>, FitError> {
    let best = ranked(tried).into_iter().take(DRAWN);
    best.filter_map(|trial| Some((trial.method, trial.found()?)))
        .map(|(method, found)| {
            let given = GivenModel::new(&found.estimate, found.longest);
            let judgement = given.on(&prepared.resampled.record, &[1, AHEAD])?;
            Ok(Compared {
                name: method.name().to_owned(),
                method: found.method_name().to_owned(),
                judgement,
            })
        })
        .collect()
}

/// The order of a model: its poles that are not 0; `None` of a finite impulse response, which has no others.
#[must_use]
pub fn order(of: &Estimate) -> Option<usize> {
    let a = &of.theta.as_slice()[of.layout.a()];
    Some(a.iter().rposition(|a| *a != 0.0)? + 1)
}
