//! A model on data, and what the tables and the page of a comparison say of it.

use planesman_identification::estimators::Estimate;
use planesman_identification::validation::residuals::Correlation;
use planesman_identification::{Judgement, Reading, Uncertain};

use super::page::{Response, frequency_response};
use planesman_console::Table;

/// A model and the judgement on it.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Its name in the tables.
    pub name: String,
    /// The method that found it.
    pub method: String,
    /// What it does on the data.
    pub judgement: Judgement,
}

impl Compared {
    pub(super) fn reading(&self) -> Reading<'_> {
        Reading::of(&self.judgement.estimate, self.judgement.longest)
    }

    pub(super) fn order(&self) -> String {
        order(&self.judgement.estimate)
    }

    pub(super) fn delay(&self) -> usize {
        self.judgement.estimate.layout.structure.delay
    }

    /// The poles in s, the slowest first, of a pair the upper one.
    pub(super) fn poles(&self) -> Vec<Uncertain> {
        let mut poles = self.reading().continuous_poles().unwrap_or_default();
        poles.retain(|pole| pole.value.im >= 0.0);
        poles.sort_by(|p, q| p.value.norm().total_cmp(&q.value.norm()));
        poles
    }

    /// The tests of the residual: what it should be, and the correlations.
    pub(super) fn tests(&self) -> Vec<(&'static str, Correlation)> {
        let tests = self.judgement.residuals.iter();
        tests
            .flat_map(|it| {
                [
                    ("white", it.whiteness.clone()),
                    ("free of earlier inputs", it.of_earlier_inputs()),
                    ("free of later inputs", it.of_later_inputs()),
                ]
            })
            .collect()
    }
}

/// The frequency response of each; the phases of all begin within half a turn of the first's.
pub(super) fn frequency_responses(models: &[Compared]) -> Vec<Vec<Response>> {
    let mut first: Option<f64> = None;
    models
        .iter()
        .map(|model| {
            let sample_time = model.judgement.estimate.sample_time;
            let mut responses = frequency_response(&model.reading(), sample_time);
            if let Some(begins) = responses.first().map(|it| it.phase) {
                let turns = ((begins - *first.get_or_insert(begins)) / 360.0).round();
                responses
                    .iter_mut()
                    .for_each(|it| it.phase -= 360.0 * turns);
            }
            responses
        })
        .collect()
}

/// A fit as a cell.
pub(super) fn percent(fit: Option<f64>) -> String {
    match fit {
        None => "-".to_owned(),
        Some(fit) if fit < -1e5 => format!("{fit:.1e}"),
        Some(fit) => format!("{fit:.2}"),
    }
}

/// The poles that are not 0; of a finite impulse response, which has no others, its coefficients.
pub(super) fn order(of: &Estimate) -> String {
    let a = &of.theta.as_slice()[of.layout.a()];
    match a.iter().rposition(|a| *a != 0.0) {
        None => format!("{} (fir)", of.layout.structure.numerator),
        Some(last) => (last + 1).to_string(),
    }
}

/// What each model is, and how well it simulates and predicts.
pub(super) fn fits(models: &[Compared]) -> Table {
    let ahead = models.first().map_or(&[][..], |it| &it.judgement.predicted);
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(it, _)| format!("{it} ahead, %"))
        .collect();
    let columns = ["model", "method", "order", "delay", "simulated, %"].into_iter();
    let mut table = Table::of(columns.chain(ahead.iter().map(String::as_str)));
    for model in models {
        let first = [
            model.name.clone(),
            model.method.clone(),
            model.order(),
            model.delay().to_string(),
            percent(model.judgement.fit),
        ];
        let predicted = model.judgement.predicted.iter();
        table.row(
            first
                .into_iter()
                .chain(predicted.map(|(_, fit)| percent(*fit))),
        );
    }
    table
}
