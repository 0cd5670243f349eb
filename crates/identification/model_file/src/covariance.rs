//! The covariance as in a file: in long models, rows of zeros (most of those from a long delay) are written as `[]`.

use serde::{Deserialize as _, Deserializer, Serializer};

use crate::LARGEST_ORDER;

/// A covariance with at most this number of rows is written in full.
const FULL: usize = 80;

pub(crate) fn serialize<S: Serializer>(rows: &[Vec<f64>], to: S) -> Result<S::Ok, S::Error> {
    let is_known = |row: &[f64]| rows.len() > FULL && row.iter().all(|it| *it == 0.0);
    to.collect_seq(rows.iter().map(|row| match is_known(row) {
        true => &[],
        false => row.as_slice(),
    }))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Vec<f64>>, D::Error> {
    let mut rows = Vec::<Vec<f64>>::deserialize(from)?;
    let count = rows.len();
    if (FULL + 1..=2 * LARGEST_ORDER + 1).contains(&count) {
        let empty = rows.iter_mut().filter(|row| row.is_empty());
        empty.for_each(|row| row.resize(count, 0.0));
    }
    Ok(rows)
}
