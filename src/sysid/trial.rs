//! Every method on one record, beside each other.

use anyhow::Result;
use planesman_identification::GivenModel;
use planesman_identification::analysis::{AHEAD, Analysis};
use planesman_identification::estimators::Method;
use planesman_signals::Taken;
use serde_json::{Value, json};

use super::compared::{Compared, order, percent};
use planesman_console::{Format, Table};

/// Methods drawn on a page.
const DRAWN: usize = 5;

/// A method that was tried.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The method.
    pub method: Method,
    /// The model, or why there is none.
    pub outcome: Result<Analysis, String>,
    /// How long it took, s.
    pub seconds: f64,
}

impl Trial {
    fn found(&self) -> Option<&Analysis> {
        self.outcome.as_ref().ok()
    }

    fn is_white(&self) -> Option<bool> {
        let tests = self.found()?.residuals.as_ref()?;
        Some(tests.whiteness.passes())
    }

    pub(super) fn as_json(&self) -> Value {
        let structure = self.found().map(|it| &it.estimate.layout.structure);
        json!({
            "method": self.method.name(),
            "order": structure.map(|it| it.poles),
            "numerator": structure.map(|it| it.numerator),
            "delay": structure.map(|it| it.delay),
            "held_out_fit": self.found().and_then(|it| it.held_out_fit),
            "predicted_fit": self.found().and_then(|it| it.predicted_fit),
            "white": self.is_white(),
            "seconds": self.seconds,
            "refused": self.outcome.as_ref().err(),
        })
    }
}

/// Those with a model, the best first: by the simulated fit on held-out data if one is better than the mean of the
/// output there, else by the predictions.
fn ranked(tried: &[Trial]) -> Vec<&Trial> {
    let by = |of: fn(&Analysis) -> Option<f64>| {
        move |trial: &Trial| trial.found().and_then(of).unwrap_or(f64::NEG_INFINITY)
    };
    let (held, predicted) = (by(|it| it.held_out_fit), by(|it| it.predicted_fit));
    let simulates = tried.iter().any(|trial| held(trial) > 0.0);
    let mut ranked: Vec<&Trial> = tried.iter().filter(|it| it.outcome.is_ok()).collect();
    ranked.sort_by(|p, q| match simulates {
        true => held(q).total_cmp(&held(p)),
        false => predicted(q).total_cmp(&predicted(p)),
    });
    ranked
}

/// The best model.
pub(super) fn best(tried: &[Trial]) -> Option<&Analysis> {
    ranked(tried).first()?.found()
}

/// A row for each method, within the terminal's width.
pub(super) fn table(tried: &[Trial]) -> Result<String> {
    let ahead = format!("{AHEAD} ahead, %");
    let mut table = Table::new([
        "method",
        "order",
        "delay",
        "held out, %",
        &ahead,
        "white",
        "s",
        "best",
    ]);
    let best = ranked(tried).first().map(|it| it.method);
    for trial in tried {
        let of = |of: &dyn Fn(&Analysis) -> String| trial.found().map_or("-".to_owned(), of);
        table.row([
            trial.method.name().to_owned(),
            of(&|it| order(&it.estimate)),
            of(&|it| it.estimate.layout.structure.delay.to_string()),
            of(&|it| percent(it.held_out_fit)),
            of(&|it| percent(it.predicted_fit)),
            match trial.is_white() {
                None => "-".to_owned(),
                Some(white) => if white { "yes" } else { "no" }.to_owned(),
            },
            format!("{:.2}", trial.seconds),
            if best == Some(trial.method) { "<-" } else { "" }.to_owned(),
        ]);
    }
    Ok(table.text(Format::Table))
}

/// What is to be said of the table.
pub(super) fn notes(tried: &[Trial]) -> String {
    let mut text = String::new();
    for trial in tried {
        if let Err(reason) = &trial.outcome {
            text += &format!("{}: {reason}\n", trial.method.name());
        }
    }
    if !tried.iter().any(|it| it.method.is_of_the_vehicle()) {
        text += "vehicle and kalman are tried with --heave or --vehicle.\n";
    }
    text + "The best of many on the same held-out data does less well on new data than its figure says.\n"
}

/// The best of them on one record, for a page.
///
/// # Errors
/// When a model cannot be judged on the record.
pub(super) fn compared(tried: &[Trial], taken: &Taken) -> Result<Vec<Compared>> {
    let best = ranked(tried).into_iter().take(DRAWN);
    best.filter_map(|trial| Some((trial.method, trial.found()?)))
        .map(|(method, found)| {
            let given = GivenModel::of(&found.estimate, found.longest);
            let judgement = given.on(&taken.resampled.record, &[1, AHEAD])?;
            Ok(Compared {
                name: method.name().to_owned(),
                method: found.method_name().to_owned(),
                judgement,
            })
        })
        .collect()
}
