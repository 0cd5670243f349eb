//! Several tables as one source: a signal is a column of one table, and rows are joined by time.
//!
//! Each table has its own time, in its own unit.

use std::path::Path;

use planesman_text::did_you_mean;

use crate::csv_source::{CsvSource, TableTime, read_rows};
use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Take, places};
use crate::source::Source;

/// Maximum number of column names listed in an error.
const LISTED: usize = 40;

/// Tables joined by time.
#[derive(Clone, Debug)]
pub(crate) struct JoinedTables {
    tables: Vec<CsvSource>,
}

impl JoinedTables {
    /// Opens the tables. A requested time column is used for the tables that have it.
    ///
    /// # Errors
    /// Like [`CsvSource::open`]; also if no table has the column.
    pub(crate) fn open<P: AsRef<Path>>(paths: &[P], time: &TableTime) -> Result<Self> {
        let by_itself = TableTime {
            column: None,
            ..time.clone()
        };
        let (mut tables, mut refused) = (Vec::new(), Vec::new());
        for path in paths {
            let opened = CsvSource::open(path.as_ref(), time);
            tables.push(match opened {
                Err(error @ SourceError::Request(_)) if time.column.is_some() => {
                    refused.push(error);
                    CsvSource::open(path.as_ref(), &by_itself)?
                }
                opened => opened?,
            });
        }
        match refused.pop() {
            Some(error) if refused.len() + 1 == tables.len() => Err(error),
            _ => Ok(Self { tables }),
        }
    }

    /// The table and the column of a signal: `COLUMN`, or `FILE:COLUMN` if several tables have it.
    fn find(&self, name: &str) -> Result<(usize, usize)> {
        let mut found = Vec::new();
        for (at, table) in self.tables.iter().enumerate() {
            let places = table.places();
            if places.contains_key(name) {
                found.push((at, table.place(&places, name)?));
            }
        }
        let file = |at: usize| {
            let name = self.tables[at].path().file_name();
            name.unwrap_or_default().display().to_string()
        };
        match found[..] {
            [place] => return Ok(place),
            [(first, _), (second, _), ..] => {
                let (first, second) = match file(first) == file(second) {
                    true => [first, second]
                        .map(|at| self.tables[at].path().display().to_string())
                        .into(),
                    false => (file(first), file(second)),
                };
                return Err(SourceError::Request(format!(
                    "both {first} and {second} have a column '{name}'. Write {first}:{name} or {second}:{name}"
                )));
            }
            [] => {}
        }
        for (at, table) in self.tables.iter().enumerate() {
            let path = table.path();
            let names = [Some(path.as_os_str()), path.file_name(), path.file_stem()];
            for prefix in names.into_iter().flatten() {
                let prefix = format!("{}:", prefix.display());
                if let Some(column) = name.strip_prefix(&prefix) {
                    return Ok((at, table.place(&table.places(), column)?));
                }
            }
        }
        let columns = || self.tables.iter().flat_map(CsvSource::signals);
        let listed: Vec<&str> = columns().take(LISTED).collect();
        Err(SourceError::Request(format!(
            "no table has a column '{name}'; the columns are {}{}",
            listed.join(", "),
            did_you_mean(name, columns())
        )))
    }
}

impl Source for JoinedTables {
    fn name(&self) -> String {
        let paths = self.tables.iter().map(Source::name);
        paths.collect::<Vec<_>>().join(", ")
    }

    fn bytes(&self) -> u64 {
        self.tables.iter().map(Source::bytes).sum()
    }

    fn sample_time(&self) -> Option<f64> {
        self.tables.iter().find_map(Source::sample_time)
    }

    fn has_time(&self) -> bool {
        self.tables.iter().all(Source::has_time)
    }

    fn experiments(&self, signals: &[String]) -> Vec<Box<dyn Source>> {
        let has_all = |table: &CsvSource| {
            let places = table.places();
            signals
                .iter()
                .all(|name| places.contains_key(name.as_str()))
        };
        if !self.tables.iter().all(has_all) {
            return Vec::new();
        }
        let each = self.tables.iter().cloned();
        each.map(|it| Box::new(it) as Box<dyn Source>).collect()
    }

    /// Reads the tables in the order of the rows' times.
    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let places = places(requests, |it| self.find(&it.name))?;
        let mut reading = Reading::default();
        let (mut sources, mut stamps) = (Vec::new(), Vec::new());
        for (at, table) in self.tables.iter().enumerate() {
            let here = places.iter().enumerate().filter(|(_, place)| place.0 == at);
            let signals: Vec<(usize, usize)> =
                here.map(|(signal, place)| (signal, place.1)).collect();
            if signals.is_empty() {
                reading.notes.push(format!(
                    "{}: this table contains none of the requested signals",
                    table.path().display()
                ));
                continue;
            }
            let rows = table.rows(signals, requests, &mut reading)?;
            stamps.push(format!("{}: {}", table.path().display(), reading.stamps));
            sources.push(rows);
        }
        reading.stamps = stamps.join("; ");
        read_rows(sources, &mut reading, take, progress)?;
        Ok(reading)
    }
}
