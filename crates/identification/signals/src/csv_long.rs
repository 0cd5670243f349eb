//! Long tables: each row has the numbers of one series, and a text names the series: `time,name,value`, as written by InfluxDB, Grafana and pandas'
//! `melt`, or `time,vehicle,x,y`.
//!
//! A table is long if its header implies this ([`KEYS`], [`VALUES`]), or if its texts change from row to row. The rows with the same name form a
//! series. The numbers of a series are signals, named after the series if each row has only one number (`depth`), otherwise `x[alpha]`.

use std::collections::BTreeMap;
use std::io;

use csv::ByteRecord;

use crate::csv_cell::{is_missing, value};
use crate::csv_time;

/// Names of the column that names a row's number, and of the number's column, without leading underscores.
#[rustfmt::skip]
const KEYS: [&str; 20] = [
    "field", "name", "metric", "variable", "signal", "series", "channel", "tag", "parameter", "param", "key", "measurement", "topic",
    "sensor", "item", "legend", "quantity", "entity_id", "entity", "statistic_id",
];
const VALUES: [&str; 8] = [
    "value", "val", "values", "reading", "data", "number", "state", "mean",
];

/// The last names are values only next to one of these names, for example in Home Assistant.
const OF_ENTITIES: usize = 2;
const OF_STATES: [&str; 3] = ["entity_id", "entity", "statistic_id"];

/// Names of text columns that do not identify what a number describes.
#[rustfmt::skip]
const NO_KEYS: [&str; 16] = [
    "unit", "units", "quality", "status", "state", "comment", "message", "description", "flag", "type", "mode", "start", "stop", "result",
    "level", "severity",
];

/// For tables whose names do not show that they are long: share of rows with the time of the row before and another text, share of rows
/// with another text at all, and mean number of rows of each series.
const OFTEN: f64 = 0.25;
const MOSTLY: f64 = 0.6;
const FEWEST: usize = 10;

/// Maximum number of series of a table, and of columns that name them.
const SERIES: usize = 1000;
const MOST_KEYS: usize = 8;

/// The form of a long table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LongForm {
    /// The columns of texts that distinguish series.
    keys: Vec<usize>,
    /// The columns of numbers.
    values: Vec<usize>,
    /// Series by their texts.
    series: BTreeMap<Vec<u8>, usize>,
    /// The signals: each column of the first series, then of the next.
    signals: Vec<String>,
    /// The name of each series alone, if others share it.
    shared: Vec<String>,
}

/// A name in lower case without leading underscores.
fn plain(name: &str) -> String {
    name.trim_start_matches('_').to_ascii_lowercase()
}

/// The name of each series, and the names that several share. Names come from the texts of one column (`first`, if it is known), and of further
/// columns if they are needed to distinguish series.
fn labels(
    found: &BTreeMap<Vec<u8>, usize>,
    keys: usize,
    first: Option<usize>,
) -> Option<(Vec<String>, Vec<String>)> {
    let mut series: Vec<(&Vec<u8>, usize)> = found.iter().map(|it| (it.0, *it.1)).collect();
    series.sort_by_key(|it| it.1);
    let parts: Vec<Vec<String>> = series.iter().map(|it| parts(it.0)).collect();
    let varies = |at: &usize| parts.iter().any(|it| it[*at] != parts[0][*at]);
    let telling: Vec<usize> = (0..keys)
        .filter(|at| varies(at) && Some(*at) != first)
        .collect();
    let (first, telling) = match (first, telling.split_first()) {
        (Some(first), _) => (first, &telling[..]),
        (None, Some((first, rest))) => (*first, rest),
        (None, None) => return None,
    };
    let is_shared = |place: usize| {
        let same = parts.iter().filter(|it| it[first] == parts[place][first]);
        same.count() > 1
    };
    let label = |place: usize| {
        let of = &parts[place];
        match is_shared(place) {
            false => of[first].clone(),
            true => {
                let around = telling.iter().map(|at| of[*at].as_str());
                let all: Vec<&str> = around.chain([of[first].as_str()]).collect();
                all.join(".")
            }
        }
    };
    let labels: Vec<String> = (0..parts.len()).map(label).collect();
    let of_several = (0..parts.len()).filter(|it| is_shared(*it));
    let mut shared: Vec<String> = of_several.map(|it| parts[it][first].clone()).collect();
    shared.dedup();
    Some((labels, shared))
}

impl LongForm {
    /// The form of a table with these columns, from its first rows and from all rows; `None` if the table is not long. `others` are the columns of
    /// the time.
    pub(crate) fn find(
        columns: &[String],
        others: &[usize],
        start: &[Vec<String>],
        mut next: impl FnMut(&mut ByteRecord) -> io::Result<bool>,
    ) -> io::Result<Option<Self>> {
        let cells = |at: usize| start.iter().filter_map(move |row| row.get(at));
        let given = |at: usize| cells(at).filter(|it| !is_missing(it));
        let is_one_of = |at: usize, names: &[&str]| names.contains(&plain(&columns[at]).as_str());
        let free: Vec<usize> = (0..columns.len())
            .filter(|it| !others.contains(it) && given(*it).next().is_some())
            .collect();
        let is_number = |at: &usize| given(*at).all(|it| value(it).is_some());
        let is_text = |it: &String| value(it).is_none() && !csv_time::is_time(it);
        let is_key = |at: &usize| given(*at).all(is_text) && !is_one_of(*at, &NO_KEYS);
        let named = |names: &[&str], of: &[usize]| {
            let place = |name: &&str| of.iter().copied().find(|at| plain(&columns[*at]) == **name);
            names.iter().find_map(place)
        };
        // Of its values some may be texts.
        let is_of_states = columns
            .iter()
            .any(|it| OF_STATES.contains(&plain(it).as_str()));
        let values = match is_of_states {
            true => &VALUES[..],
            false => &VALUES[..VALUES.len() - OF_ENTITIES],
        };
        let value = named(values, &free);
        let mut keys: Vec<usize> = free.iter().copied().filter(is_key).collect();
        keys.retain(|at| Some(*at) != value);
        keys.truncate(MOST_KEYS);
        let of_name = value.and_then(|_| named(&KEYS, &keys));
        let of = |row: &Vec<String>| -> Vec<String> {
            let cells = keys.iter().map(|at| row.get(*at).cloned());
            cells.map(Option::unwrap_or_default).collect()
        };
        let at_once = |it: &&[Vec<String>]| {
            let is_same = |at: &usize| it[0].get(*at) == it[1].get(*at);
            others.iter().all(is_same) && of(&it[0]) != of(&it[1])
        };
        let changes = |it: &&[Vec<String>]| of(&it[0]) != of(&it[1]);
        let share = |count: usize| count as f64 / start.len() as f64;
        let is_often = share(start.windows(2).filter(at_once).count()) > OFTEN
            || share(start.windows(2).filter(changes).count()) > MOSTLY;
        if keys.is_empty() || others.is_empty() || !(of_name.is_some() || is_often) {
            return Ok(None);
        }
        let values = match (of_name, value) {
            (Some(_), Some(value)) => vec![value],
            _ => free.iter().copied().filter(is_number).collect(),
        };
        let mut found: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
        let (mut row, mut text, mut rows) = (ByteRecord::new(), Vec::new(), 0);
        while next(&mut row)? {
            // Names may stand again before each series.
            let is_value = |at: usize, it: &[u8]| !it.is_empty() && it != columns[at].as_bytes();
            let has_value = |at: &usize| row.get(*at).is_some_and(|it| is_value(*at, it));
            if row.len() < columns.len() || !values.iter().any(has_value) {
                continue;
            }
            key(&keys, &row, &mut text);
            rows += 1;
            let count = found.len();
            if count > SERIES {
                return Ok(None);
            }
            found.entry(text.clone()).or_insert(count);
        }
        let are_few = of_name.is_none() && found.len() * FEWEST > rows;
        if values.is_empty() || found.len() < 2 || are_few {
            return Ok(None);
        }
        let first = of_name.and_then(|name| keys.iter().position(|at| *at == name));
        let values_of = |label: &String| -> Vec<String> {
            let each = values.iter().map(|value| match values.len() {
                1 => label.clone(),
                _ => format!("{}[{label}]", columns[*value]),
            });
            each.collect()
        };
        let Some((labels, shared)) = labels(&found, keys.len(), first) else {
            return Ok(None);
        };
        let signals = labels.iter().flat_map(values_of).collect();
        Ok(Some(Self {
            keys,
            values,
            series: found,
            signals,
            shared,
        }))
    }

    /// The signals, in their order.
    pub(crate) fn signals(&self) -> &[String] {
        &self.signals
    }

    /// Whether a column contains the numbers of several series, or names the series.
    pub(crate) fn holds(&self, column: usize) -> bool {
        self.values.contains(&column) || self.keys.contains(&column)
    }

    /// Whether several series have that name.
    pub(crate) fn is_shared(&self, name: &str) -> bool {
        self.shared.iter().any(|it| it == name)
    }

    /// The series of a row.
    pub(crate) fn series(&self, row: &ByteRecord, text: &mut Vec<u8>) -> Option<usize> {
        key(&self.keys, row, text);
        self.series.get(text).copied()
    }

    /// The column with the number of the signal in a row of that series.
    pub(crate) fn column(&self, signal: usize, series: usize) -> Option<usize> {
        let width = self.values.len();
        (signal / width == series).then(|| self.values[signal % width])
    }
}

/// The texts of a row's keys, each terminated by a zero byte.
fn key(keys: &[usize], row: &ByteRecord, text: &mut Vec<u8>) {
    text.clear();
    for at in keys {
        text.extend(row.get(*at).unwrap_or_default());
        text.push(0);
    }
}

fn parts(text: &[u8]) -> Vec<String> {
    let parts = text.split(|it| *it == 0);
    parts
        .map(|it| String::from_utf8_lossy(it).into_owned())
        .collect()
}
