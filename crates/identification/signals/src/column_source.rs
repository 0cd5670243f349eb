//! Samples from columns in memory: lists of numbers of equal length; one list is the time, or the rows have a known interval.

use planesman_text::did_you_mean;

use crate::csv_source::TableTime;
use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Take, places};
use crate::source::{Source, SourceTopic};
use crate::time_unit::{self, JudgedUnit, TimeUnit};
use crate::unit_name::with_unit;

/// Columns in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSource {
    columns: Vec<(String, Vec<f64>)>,
    time: Time,
}

/// Source of a row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    /// The time is in a column, in this unit.
    Column(usize, JudgedUnit),
    /// The time follows from the row's number, with this many ns from row to row.
    Rows(f64),
}

impl ColumnSource {
    /// Takes columns by name, and finds their time: the given interval or column, else a column with a usual name (`time`, `t`, `stamp`).
    /// NaN is a missing sample.
    ///
    /// # Errors
    /// One line, if columns have different lengths, a column does not exist, or no time is found.
    pub fn new(columns: Vec<(String, Vec<f64>)>, time: &TableTime) -> Result<Self> {
        if let [(first, numbers), others @ ..] = &columns[..]
            && let Some((other, more)) = others.iter().find(|(_, it)| it.len() != numbers.len())
        {
            return Err(SourceError::Request(format!(
                "'{first}' has {} numbers, '{other}' {}: all columns must have the same length",
                numbers.len(),
                more.len()
            )));
        }
        let mut source = Self {
            columns,
            time: Time::Rows(0.0),
        };
        source.time = match (time.sample_time, &time.column) {
            (Some(seconds), _) => Time::Rows(seconds * 1e9),
            (None, Some(name)) => source.time_in(source.place(name)?, time.unit),
            (None, None) => {
                let names = source.columns.iter().map(|(name, _)| name.as_str());
                let found = time_unit::column(names).ok_or_else(|| {
                    SourceError::Request(format!(
                        "no column contains the time, because none has the name {}. Give the interval between rows (sample_time), or the column's name (time)",
                        time_unit::NAMES[..4].join(", ")
                    ))
                })?;
                source.time_in(found, time.unit)
            }
        };
        Ok(source)
    }

    fn time_in(&self, place: usize, asked: Option<TimeUnit>) -> Time {
        let (name, numbers) = &self.columns[place];
        let first = || numbers.iter().copied().filter(|it| it.is_finite());
        let judged = || time_unit::judged(&first().take(time_unit::LOOKED_AT).collect::<Vec<_>>());
        let named = asked.or_else(|| time_unit::named(name).1);
        Time::Column(place, named.map_or_else(judged, JudgedUnit::from))
    }

    fn place(&self, wanted: &str) -> Result<usize> {
        let names = || self.columns.iter().map(|(name, _)| name.as_str());
        let found = names()
            .position(|name| name == wanted)
            .or_else(|| names().position(|name| with_unit(name).0 == wanted));
        found.ok_or_else(|| {
            SourceError::Request(format!(
                "there is no column '{wanted}'; there are {}{}",
                names().collect::<Vec<_>>().join(", "),
                did_you_mean(wanted, names())
            ))
        })
    }
}

impl Source for ColumnSource {
    fn name(&self) -> String {
        "columns in memory".to_owned()
    }

    fn sample_time(&self) -> Option<f64> {
        match self.time {
            Time::Rows(step) => Some(step * 1e-9),
            Time::Column(..) => None,
        }
    }

    /// All columns except the time.
    fn topics(&self) -> Vec<SourceTopic> {
        let names = self.columns.iter().enumerate();
        let others =
            names.filter(|(place, _)| !matches!(self.time, Time::Column(it, _) if it == *place));
        vec![SourceTopic {
            name: "columns".to_owned(),
            type_name: "",
            requests: others.map(|(_, (name, _))| Request::output(name)).collect(),
        }]
    }

    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        _progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let places = places(requests, |it| self.place(&it.name))?;
        let rows = self.columns.first().map_or(0, |(_, numbers)| numbers.len());
        let mut reading = Reading {
            stamps: match self.time {
                Time::Column(place, unit) => {
                    format!("of the column '{}'{}", self.columns[place].0, unit.told())
                }
                Time::Rows(step) => format!("of the rows, which are {} s apart", step * 1e-9),
            },
            unit: match self.time {
                Time::Column(_, unit) => unit,
                Time::Rows(_) => JudgedUnit::default(),
            },
            ..Reading::default()
        };
        let mut timeless = 0;
        for row in 0..rows {
            let stamp = match self.time {
                Time::Rows(step) => TimeUnit::Ns.in_nanoseconds(row as f64 * step),
                Time::Column(place, unit) => unit.unit.in_nanoseconds(self.columns[place].1[row]),
            };
            let Some(stamp) = stamp else {
                timeless += 1;
                continue;
            };
            let mut more = true;
            for (signal, place) in places.iter().enumerate() {
                let number = self.columns[*place].1[row];
                let number = Some(number).filter(|it| !it.is_nan());
                more &= take(signal, stamp, number);
            }
            if !more {
                break;
            }
        }
        if timeless > 0 {
            reading
                .notes
                .push(format!("{timeless} of {rows} rows have no time"));
        }
        Ok(reading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(list: &[(&str, &[f64])]) -> Vec<(String, Vec<f64>)> {
        let column = |(name, numbers): &(&str, &[f64])| ((*name).to_owned(), numbers.to_vec());
        list.iter().map(column).collect()
    }

    fn read(source: &ColumnSource, name: &str) -> Vec<(i64, Option<f64>)> {
        let mut samples = Vec::new();
        let mut take = |_, stamp, value| {
            samples.push((stamp, value));
            true
        };
        let request = [Request::output(name)];
        source.read(&request, &mut take, &|_| ()).expect("read");
        samples
    }

    #[test]
    fn a_column_named_so_is_the_time_and_nan_is_no_sample() {
        let given = columns(&[
            ("t_ms", &[0.0, 50.0, f64::NAN]),
            ("u", &[1.0, f64::NAN, 3.0]),
        ]);
        let source = ColumnSource::new(given, &TableTime::default()).expect("columns");
        assert_eq!(read(&source, "u"), [(0, Some(1.0)), (50_000_000, None)]);
        assert_eq!(source.sample_time(), None);
    }

    #[test]
    fn rows_at_an_interval_need_no_time() {
        let time = TableTime {
            sample_time: Some(0.05),
            ..TableTime::default()
        };
        let source = ColumnSource::new(columns(&[("y [m]", &[1.0, 2.0])]), &time).expect("columns");
        assert_eq!(
            read(&source, "y"),
            [(0, Some(1.0)), (50_000_000, Some(2.0))]
        );
    }

    #[test]
    fn what_is_refused_is_refused_by_name() {
        let refusal = |given: &[(&str, &[f64])], column: Option<&str>| {
            let time = TableTime {
                column: column.map(str::to_owned),
                ..TableTime::default()
            };
            let refused = ColumnSource::new(columns(given), &time);
            refused.expect_err("refused").to_string()
        };
        assert!(refusal(&[("t", &[0.0]), ("u", &[])], None).contains("'u' 0"));
        assert!(refusal(&[("a", &[0.0]), ("u", &[0.0])], None).contains("sample_time"));
        assert!(refusal(&[("clock", &[0.0])], Some("clokc")).contains("did you mean 'clock'"));
    }
}
