//! The rows of the regression over whole records, and conversion of numbers per row or sample to lists per record.

use nalgebra::{DMatrix, DVector};

use crate::error::{IdentificationError, Result};
use crate::structure::Problem;

/// Degrees of freedom: number of rows minus number of parameters.
pub(super) fn freedom(rows: usize, parameters: usize) -> Result<f64> {
    match rows.checked_sub(parameters) {
        Some(freedom) if freedom > 0 => Ok(freedom as f64),
        _ => Err(IdentificationError::Record(format!(
            "{rows} rows of the regression are too few to estimate the accuracy of {parameters} parameters"
        ))),
    }
}

/// `Phi` and `y` of all records, one below the other.
pub(crate) fn regression(problem: &Problem<'_>) -> (DMatrix<f64>, DVector<f64>) {
    let layout = problem.layout();
    let (n, first) = (layout.structure.poles, layout.structure.history());
    let rows: usize = problem
        .runs
        .iter()
        .map(|run| run.outputs.len().saturating_sub(first))
        .sum();
    let mut phi = DMatrix::zeros(rows, layout.without_motion());
    let mut outputs = DVector::zeros(rows);
    let mut row = 0;
    for (r, (run, driving)) in problem.runs.iter().zip(problem.driving()).enumerate() {
        for k in first..run.outputs.len() {
            for i in 1..=n {
                phi[(row, i - 1)] = -run.outputs[k - i];
            }
            for (j, at) in layout.b(r).enumerate() {
                phi[(row, at)] = driving[k - j];
            }
            if let Some(at) = layout.offset(r) {
                phi[(row, at)] = 1.0;
            }
            outputs[row] = run.outputs[k];
            row += 1;
        }
    }
    (phi, outputs)
}

/// Splits numbers, one per row, into records.
pub(super) fn rows_by_run(problem: &Problem<'_>, rows: &[f64]) -> Vec<Vec<f64>> {
    let first = problem.structure.history();
    let mut rest = rows;
    problem
        .runs
        .iter()
        .map(|run| {
            let count = run.outputs.len().saturating_sub(first).min(rest.len());
            let (own, others) = rest.split_at(count);
            rest = others;
            own.to_vec()
        })
        .collect()
}

/// Splits numbers, one per sample, into records.
pub(super) fn samples_by_run(problem: &Problem<'_>, samples: &[f64]) -> Vec<Vec<f64>> {
    parts(samples, problem.runs.iter().map(|run| run.outputs.len()))
}

/// Splits numbers into parts of these lengths.
pub(super) fn parts(numbers: &[f64], lengths: impl Iterator<Item = usize>) -> Vec<Vec<f64>> {
    let mut rest = numbers;
    let part = |length| {
        let (own, others) = rest.split_at(length);
        rest = others;
        own.to_vec()
    };
    lengths.map(part).collect()
}

/// A unit impulse: 1 at one place, 0 elsewhere.
pub(crate) fn impulse(at: usize, count: usize) -> Vec<f64> {
    let mut impulse = vec![0.0; count];
    if let Some(value) = impulse.get_mut(at) {
        *value = 1.0;
    }
    impulse
}
