//! A measured frequency response as a table and in JSON.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use planesman_identification::estimators::{FrequencyFit, Row};
use serde_json::{Value, json};

/// The columns of the table.
const COLUMNS: &str = "omega_rad_s,frequency_hz,magnitude_db,magnitude_deviation_db,phase_deg,phase_deviation_deg,coherence,averages,sigmas_95,\
                       used,model_magnitude_db,model_phase_deg";

/// Comma-separated table with one row for each frequency, below the column names. Deviations are standard deviations; `sigmas_95` times a deviation
/// is half of a 95 % interval.
pub(crate) fn table(fit: &FrequencyFit, sample_time: f64) -> String {
    let mut text = format!("{COLUMNS}\n");
    for it in fit.rows(sample_time) {
        let (size, phase) = match it.model {
            Some((size, phase)) => (size.to_string(), phase.to_string()),
            None => Default::default(),
        };
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{size},{phase}",
            it.omega,
            it.omega / TAU,
            it.decibels,
            it.decibel_deviation,
            it.phase,
            it.phase_deviation,
            it.coherence,
            it.averages,
            it.sigmas_95,
            u8::from(it.is_used),
        );
    }
    text
}

/// The table's values and the fitted transfer function.
pub(crate) fn as_json(fit: &FrequencyFit, sample_time: f64) -> Value {
    let rows = fit.rows(sample_time);
    let of = |column: fn(&Row) -> f64| rows.iter().map(column).collect::<Vec<_>>();
    let window = |samples: &usize| *samples as f64 * sample_time;
    let candidates = fit.candidates.iter().map(|it| {
        json!({"poles": it.orders.poles, "zeros": it.orders.zeros, "delay": it.delay, "cost": it.cost, "bic": it.bic})
    });
    json!({
        "windows": fit.windows.iter().map(window).collect::<Vec<_>>(),
        "band": fit.band,
        "least_coherence": fit.coherence,
        "by_reference": fit.by_reference,
        "equation": fit.equation(),
        "cost": fit.cost,
        "candidates": candidates.collect::<Vec<_>>(),
        "omega": of(|it| it.omega),
        "magnitude_db": of(|it| it.decibels),
        "magnitude_deviation_db": of(|it| it.decibel_deviation),
        "phase_deg": of(|it| it.phase),
        "phase_deviation_deg": of(|it| it.phase_deviation),
        "coherence": of(|it| it.coherence),
        "averages": of(|it| it.averages),
        "sigmas_95": of(|it| it.sigmas_95),
        "used": rows.iter().map(|it| it.is_used).collect::<Vec<_>>(),
        "model_magnitude_db": rows.iter().map(|it| it.model.map(|it| it.0)).collect::<Vec<_>>(),
        "model_phase_deg": rows.iter().map(|it| it.model.map(|it| it.1)).collect::<Vec<_>>(),
    })
}
