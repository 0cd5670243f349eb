//! Finds the samples of a slow sensor in a fast log, which repeats each sample until the next.

use crate::channel::Change;

/// The sensor's rate is computed from this number of new values.
const FEWEST: usize = 10;

/// The share of new values that must arrive the same number of rows after the previous new value, within one row.
const MOST: f64 = 0.85;

/// The share of new values that must be unique; the values of a switch are not.
const DISTINCT: f64 = 0.5;

/// The mean number of rows for each value, if each is repeated equally often, within one row.
pub(crate) fn rows_per_sample(values: &[f64]) -> Option<f64> {
    let mut changes = vec![];
    for (row, pair) in values.windows(2).enumerate() {
        if pair[0] != pair[1] {
            changes.push(row + 1);
        }
    }
    let mut runs: Vec<usize> = changes.windows(2).map(|it| it[1] - it[0]).collect();
    if runs.len() < FEWEST {
        return None;
    }
    let middle = runs.len() / 2;
    let rows = *runs.select_nth_unstable(middle).1;
    let usual: Vec<usize> = (runs.iter().copied())
        .filter(|it| *it > 1 && it.abs_diff(rows) <= 1)
        .collect();
    if rows < 2 || (usual.len() as f64) < MOST * runs.len() as f64 {
        return None;
    }
    let mean = usual.iter().sum::<usize>() as f64 / usual.len() as f64;
    let mut levels: Vec<f64> = changes.iter().map(|row| values[*row]).collect();
    levels.sort_unstable_by(f64::total_cmp);
    levels.dedup();
    (levels.len() as f64 >= DISTINCT * changes.len() as f64).then_some(mean)
}

/// Removes repeats.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Repeats {
    /// The mean number of rows for each value.
    pub(crate) rows: f64,
    last: Option<f64>,
    /// Rows since the last new value.
    since: usize,
}

impl Repeats {
    pub(crate) fn new(rows: f64) -> Self {
        Self {
            rows,
            last: None,
            since: 0,
        }
    }

    /// The change that a record makes to the samples.
    pub(crate) fn change(&self) -> Change {
        Change::RepeatsLeftOut { rows: self.rows }
    }

    /// Whether the row repeats the sample before. A sensor may measure the same value again.
    pub(crate) fn is_one(&mut self, value: f64) -> bool {
        self.since += 1;
        if self.last == Some(value) && (self.since as f64) < self.rows.ceil() {
            return true;
        }
        (self.last, self.since) = (Some(value), 0);
        false
    }
}
