//! Compares all methods on one record.

use planesman_identification::GivenModel;
use planesman_identification::analysis::{AHEAD, Analysis};
use planesman_identification::estimators::{Estimate, Method};
use planesman_signals::PreparedRecord;
use planesman_text::in_one_line;
use serde_json::{Value, json};

use crate::compare::Compared;
use crate::error::FitError;

/// Maximum number of methods drawn on a page.
const DRAWN: usize = 5;

/// A method with its result.
#[derive(Debug)]
pub struct Trial {
    /// The method.
    pub method: Method,
    /// The model, or the error of the fit.
    pub outcome: Result<Analysis, FitError>,
    /// Computing time, s.
    pub seconds: f64,
}

impl Trial {
    /// The model, if the method found one.
    #[must_use]
    pub fn found(&self) -> Option<&Analysis> {
        self.outcome.as_ref().ok()
    }

    /// Whether the residual is white, if residual tests exist.
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

/// Methods with a model, best first: sorted by the simulated fit on held-out data if at least one beats the output's mean there, otherwise by the
/// predictions.
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

/// The best methods on one record, for a page.
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

/// Order of a model: the number of its nonzero poles; `None` for a finite impulse response.
#[must_use]
pub fn order(of: &Estimate) -> Option<usize> {
    let a = &of.theta.as_slice()[of.layout.a()];
    Some(a.iter().rposition(|a| *a != 0.0)? + 1)
}
