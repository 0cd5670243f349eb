//! Time histories of differing fields, for plots.

use std::path::Path;

use planesman_decode::difference::Value;
use planesman_decode::{Decoder, FieldPath, Values};
use planesman_linear::TimeHistory;

use crate::diff::comparison::Comparison;
use crate::diff::options::{DiffError, Options};
use crate::diff::recording;

/// Values of a field in both recordings, and their difference at common stamps; time in s from the earliest stamp.
#[derive(Clone, Debug)]
pub struct History {
    /// The topic.
    pub topic: String,
    /// The field; empty for a column of a table.
    pub field: String,
    /// The field's values in A and in B.
    pub values: [Vec<(f64, f64)>; 2],
    /// B less A.
    pub difference: Vec<(f64, f64)>,
}

/// The fields with the largest differences, at most `most` per topic. Both recordings are read once more.
///
/// # Errors
/// Same as [`diff`](crate::diff::diff()).
pub fn histories(
    [a, b]: [&Path; 2],
    options: &Options<'_>,
    comparison: &Comparison,
    most: usize,
) -> Result<Vec<History>, DiffError> {
    let recordings = recording::open([a, b], options)?;
    let mut wanted: Vec<(String, String)> = Vec::new();
    for topic in &comparison.topics {
        let mut fields: Vec<_> = topic
            .fields
            .values()
            .filter(|it| it.largest.is_some())
            .collect();
        fields.sort_by(|a, b| b.relative().total_cmp(&a.relative()));
        let fields = fields
            .iter()
            .take(most)
            .filter_map(|it| it.largest.as_ref());
        let fields = fields.filter(|it| !matches!(it.values[0], Value::Length(_)));
        wanted.extend(fields.map(|it| (topic.name.clone(), it.place.clone())));
    }
    let read = [0, 1].map(|side| samples(&recordings[side], &wanted));
    let stamps = read.iter().flatten().filter_map(|it| Some(it.first()?.0));
    let origin = stamps.min().unwrap_or_default();
    let [a, b] = read;
    let all = wanted.into_iter().zip(a.into_iter().zip(b));
    let all = all.filter(|(_, (a, b))| !a.is_empty() && !b.is_empty());
    Ok(all
        .map(|((topic, field), (a, b))| History {
            difference: thinned(paired(&a, &b), origin),
            values: [a, b].map(|it| thinned(it.into_iter(), origin)),
            field: if recordings[0].is_table {
                String::new()
            } else {
                field
            },
            topic,
        })
        .collect())
}

/// The values of fields of a recording with their stamps, ns; messages without a stamp are left out.
fn samples(recording: &recording::Recording, wanted: &[(String, String)]) -> Vec<Vec<(i64, f64)>> {
    let mut decoders = Vec::new();
    for (number, (topic, field)) in wanted.iter().enumerate() {
        let place = recording.topics.iter().position(|it| it.name == *topic);
        let Some((place, types)) =
            place.and_then(|it| Some((it, recording.topics[it].types.as_ref().ok()?)))
        else {
            continue;
        };
        let Ok(path) = field.parse::<FieldPath>() else {
            continue;
        };
        if recording.topics[place].is_stamped
            && let Ok(decoder) = Decoder::compile(types, &[path])
        {
            decoders.push((place, number, decoder));
        }
    }
    let mut found = vec![Vec::new(); wanted.len()];
    let mut values = Values::default();
    let is_wanted = |topic: usize| decoders.iter().any(|it| it.0 == topic);
    recording.read(&is_wanted, &mut |item| {
        for (_, number, decoder) in decoders.iter().filter(|it| it.0 == item.topic) {
            if decoder.read(&item.payload, &mut values).is_ok()
                && let Some((stamp, value)) = item.stamp.zip(values.number(0))
            {
                found[*number].push((stamp, value));
            }
        }
        true
    });
    found
}

/// The differences at common stamps.
fn paired(a: &[(i64, f64)], b: &[(i64, f64)]) -> impl Iterator<Item = (i64, f64)> {
    let mut at = 0;
    a.iter().filter_map(move |(stamp, value)| {
        while b.get(at).is_some_and(|it| it.0 < *stamp) {
            at += 1;
        }
        let partner = b.get(at).filter(|it| it.0 == *stamp)?;
        Some((*stamp, partner.1 - value))
    })
}

/// Reduces a time history to the number of points a plot shows.
fn thinned(samples: impl Iterator<Item = (i64, f64)>, origin: i64) -> Vec<(f64, f64)> {
    let mut history = TimeHistory::default();
    for (stamp, value) in samples {
        history.take(stamp.saturating_sub(origin) as f64 * 1e-9, value);
    }
    history.points().collect()
}
