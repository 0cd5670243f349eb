//! Samples from a CSV file: columns of numbers, one of them the time, or rows at a known interval.
//!
//! What parts the cells, whether there is a header and what is a comment is found out ([`Form`]). A cell that is empty or
//! no number is a sample that is not there; both are counted for each column, and the count is noted.
//!
//! A column `NAME [UNIT]`, `NAME (UNIT)` or `NAME_UNIT` is found by `NAME` too.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use csv::{ByteRecord, Reader};
use planesman_text::{did_you_mean, shown, unmarked};

use crate::csv_cell::{date, nanoseconds, number};
use crate::csv_form::{Form, Lines};
use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Role, Take, distinct};
use crate::time_unit::{self, JudgedUnit, TimeUnit};

/// Units that may end a column's name behind `_`.
const UNITS: &[&str] = &[
    "s", "ms", "us", "ns", "sec", "msec", "usec", "nsec", "min", "h", "m", "cm", "mm", "km", "ft",
    "in", "nm", "kn", "kt", "kts", "mps", "kmh", "mph", "fps", "deg", "rad", "dps", "degs", "rads",
    "radps", "degps", "rpm", "Hz", "hz", "kHz", "g", "kg", "N", "kN", "Nm", "V", "mV", "v", "A",
    "mA", "W", "kW", "Ohm", "T", "uT", "G", "Pa", "hPa", "kPa", "MPa", "bar", "mbar", "psi", "C",
    "degC", "K", "F", "pct", "percent", "l", "L", "lpm", "lbf", "lb",
];

/// Rows in which a time is looked for that no name tells of.
const LOOKED_AT: usize = 100;

/// Rows in which its first numbers are looked for.
const MOST_LOOKED_AT: u64 = 10_000;

/// Names that are listed in an error at most.
const LISTED: usize = 20;

/// The interval of progress reports, in rows.
const PROGRESS_INTERVAL: u64 = 4096;

/// The characters of a cell that a note quotes at most.
const QUOTED: usize = 20;

/// How the time of a table is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableTime {
    /// The column; `None` for the one whose name says so, or a first column that rises.
    pub column: Option<String>,
    /// The unit of its numbers; `None` for the one that its name ends in, or seconds.
    pub unit: Option<TimeUnit>,
    /// The interval between two rows of a table without a time, s.
    pub sample_time: Option<f64>,
}

/// Where the time of a row stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    /// In a column that was named, or is named so.
    Named(usize),
    /// In the first column, whose numbers rise.
    Rising,
    /// Nowhere: so many ns are from row to row.
    Rows(f64),
    /// Nowhere.
    Unknown,
}

/// A table.
#[derive(Clone, Debug)]
pub struct CsvSource {
    path: PathBuf,
    bytes: u64,
    form: Form,
    time: Time,
    unit: JudgedUnit,
}

impl CsvSource {
    /// Finds the form of the table at `path`, and its time.
    ///
    /// # Errors
    /// A line with the path: no file, no columns, no such column.
    pub fn open(path: &Path, time: &TableTime) -> Result<Self> {
        let name = path.display();
        let unreadable = SourceError::unreadable(path);
        // Asked before it is opened: a pipe would be waited for, and a table is read twice.
        let about = std::fs::metadata(path).map_err(unreadable)?;
        if !about.is_file() {
            return Err(SourceError::Data(format!("{name} is not a regular file")));
        }
        let form = Form::of(text_at(path)?).map_err(unreadable)?;
        if form.columns.len() < 2 {
            return Err(SourceError::Data(format!(
                "{name}: its first line has no two columns parted by ',', ';', tabs or blanks"
            )));
        }
        let mut table = Self {
            path: path.to_owned(),
            bytes: about.len(),
            form,
            time: Time::Unknown,
            unit: TimeUnit::S.into(),
        };
        table.time = table.find_time(time)?;
        table.find_unit(time.unit)?;
        Ok(table)
    }

    fn find_time(&self, asked: &TableTime) -> Result<Time> {
        if let Some(seconds) = asked.sample_time {
            // As the grid of that rate has it: then every row lies on an instant.
            return Ok(Time::Rows(1e9 / (1.0 / seconds)));
        }
        if let Some(name) = &asked.column {
            return Ok(Time::Named(self.place(&self.places(), name)?));
        }
        let columns = &self.form.columns;
        let named = time_unit::column(columns.iter().map(String::as_str));
        Ok(match named {
            Some(place) => Time::Named(place),
            None if self.rises()? => Time::Rising,
            None => Time::Unknown,
        })
    }

    /// Whether the first column's numbers or dates rise from row to row.
    fn rises(&self) -> Result<bool> {
        let mut reader = self.reader()?;
        let (mut row, mut last, mut count) = (ByteRecord::new(), None, 0);
        while count < LOOKED_AT && reader.read_byte_record(&mut row)? {
            let cell = row.get(0).and_then(|it| std::str::from_utf8(it).ok());
            let stamp = cell.and_then(|it| nanoseconds(it, TimeUnit::Ms));
            if stamp.is_none() || stamp <= last {
                return Ok(false);
            }
            (last, count) = (stamp, count + 1);
        }
        Ok(count > 1)
    }

    /// The unit asked for, or that of the column's name; or the one that its first numbers are in.
    fn find_unit(&mut self, asked: Option<TimeUnit>) -> Result<()> {
        let Some(column) = self.time_column() else {
            return Ok(());
        };
        let name = &self.form.columns[column];
        let named = time_unit::named(name).1;
        let is_seconds = name.eq_ignore_ascii_case("seconds").then_some(TimeUnit::S);
        if let Some(unit) = asked.or(named).or(is_seconds) {
            self.unit = unit.into();
            return Ok(());
        }
        let (mut reader, mut row) = (self.reader()?, ByteRecord::new());
        let mut numbers = Vec::new();
        while numbers.len() < time_unit::LOOKED_AT && reader.read_byte_record(&mut row)? {
            let cell = row.get(column).and_then(|it| std::str::from_utf8(it).ok());
            match cell.and_then(number) {
                Some(number) => numbers.push(number),
                // Dates have no unit.
                None if cell.and_then(date).is_some() => return Ok(()),
                None if row
                    .position()
                    .is_some_and(|it| it.record() > MOST_LOOKED_AT) =>
                {
                    break;
                }
                None => {}
            }
        }
        self.unit = time_unit::judged(&numbers);
        Ok(())
    }

    /// Its name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its size.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Seconds from row to row, where the table has no time and they were given.
    #[must_use]
    pub fn sample_time(&self) -> Option<f64> {
        match self.time {
            Time::Rows(step) => Some(step * 1e-9),
            _ => None,
        }
    }

    /// The same table; its rows are a second apart if nothing is known of their time.
    #[must_use]
    pub fn counted(mut self) -> Self {
        if self.time == Time::Unknown {
            self.time = Time::Rows(1e9);
        }
        self
    }

    fn time_column(&self) -> Option<usize> {
        match self.time {
            Time::Named(column) => Some(column),
            Time::Rising => Some(0),
            Time::Rows(_) | Time::Unknown => None,
        }
    }

    /// The columns beside the time.
    #[must_use]
    pub fn signals(&self) -> Vec<&str> {
        let time = self.time_column();
        let columns = self.form.columns.iter().enumerate();
        let others = columns.filter(|(it, _)| Some(*it) != time);
        others.map(|(_, name)| name.as_str()).collect()
    }

    /// Where each column is, by its name in full and by its name without the unit (`pitch` for `pitch [rad]`); of
    /// several of one name the first.
    fn places(&self) -> BTreeMap<&str, usize> {
        let columns = || self.form.columns.iter().enumerate().rev();
        let plain = columns().map(|(place, name)| (with_unit(name).0, place));
        let full = columns().map(|(place, name)| (name.as_str(), place));
        plain.chain(full).collect()
    }

    fn place(&self, places: &BTreeMap<&str, usize>, name: &str) -> Result<usize> {
        places.get(name).copied().ok_or_else(|| {
            let names = self.form.columns.iter().take(LISTED);
            let more = self.form.columns.len().saturating_sub(LISTED);
            SourceError::Request(format!(
                "{}: it has no column '{name}'; it has {}{}{}",
                self.path.display(),
                names.cloned().collect::<Vec<_>>().join(", "),
                match more {
                    0 => String::new(),
                    more => format!(" and {more} more"),
                },
                did_you_mean(name, places.keys().copied())
            ))
        })
    }

    fn reader(&self) -> Result<Reader<Lines<File>>> {
        Ok(self.form.rows(text_at(&self.path)?))
    }

    /// Hands every cell of the columns to `take`, row by row.
    ///
    /// # Errors
    /// A column that is not there, a table whose time is not known, or without a row that has one.
    pub fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let places = self.places();
        let columns = requests
            .iter()
            .map(|request| self.place(&places, &request.name))
            .collect::<Result<Vec<_>>>()?;
        distinct(requests, &columns)?;
        let shown_path = self.path.display();
        match self.time {
            Time::Unknown => {
                return Err(SourceError::Request(format!(
                    "{shown_path}: no column is the time: none is named {}, and the first does not rise from row to row; name it \
                 with --time COLUMN, or give the interval between rows with --sample-time, as in --sample-time 0.1s",
                    time_unit::NAMES[..4].join(", ")
                )));
            }
            Time::Rising if columns.contains(&0) => {
                return Err(SourceError::Request(format!(
                    "{shown_path}: '{}' is taken as the time, since it is first and rises from row to row; if it is a signal, \
                 name the time with --time COLUMN or give --sample-time",
                    self.form.columns[0]
                )));
            }
            _ => {}
        }
        let mut reading = Reading {
            stamps: self.stamps(),
            unit: self.unit.known,
            ..Reading::default()
        };
        for (request, column) in requests.iter().zip(&columns) {
            let name = &self.form.columns[*column];
            if *name != request.name {
                let note = format!("'{}' is the column '{name}'", request.name);
                reading.notes.push(note);
                let columns = &mut reading.columns;
                columns.insert(request.name.clone(), name.clone());
            }
        }
        let mut reader = self.reader()?;
        let mut row = ByteRecord::new();
        let mut faults = vec![Faults::default(); columns.len()];
        let (mut rows, mut timeless) = (0_u64, 0_u64);
        loop {
            match reader.read_byte_record(&mut row) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => {
                    reading.notes.push(format!("{shown_path}: {error}"));
                    break;
                }
            }
            rows += 1;
            if rows.is_multiple_of(PROGRESS_INTERVAL) {
                progress(row.position().map_or(0, |at| at.byte()));
            }
            let cell = |column: usize| row.get(column).unwrap_or_default();
            let stamp = match self.time {
                Time::Rows(step) => Some(((rows - 1) as f64 * step).round() as i64),
                _ => self.time_column().and_then(|column| {
                    let cell = std::str::from_utf8(cell(column)).ok()?;
                    nanoseconds(cell, self.unit.unit)
                }),
            };
            let Some(stamp) = stamp else {
                timeless += 1;
                continue;
            };
            let line = row.position().map_or(rows, csv::Position::line);
            let mut more = true;
            for (signal, (column, faults)) in columns.iter().zip(&mut faults).enumerate() {
                let value = faults.number(cell(*column), line);
                more &= take(signal, stamp, value);
            }
            if !more {
                break;
            }
        }
        if let (Some(column), true) = (self.time_column(), timeless > 0) {
            let name = &self.form.columns[column];
            let note = format!("{shown_path}: {timeless} of {rows} rows have no time in '{name}'");
            if timeless == rows {
                return Err(SourceError::Data(note));
            }
            reading.notes.push(note);
        }
        for (faults, column) in faults.iter().zip(&columns) {
            let name = &self.form.columns[*column];
            reading.notes.extend(faults.note(name, rows - timeless));
        }
        Ok(reading)
    }

    /// Where the stamps come from.
    fn stamps(&self) -> String {
        let Some(column) = self.time_column() else {
            let step = self.sample_time().unwrap_or(1.0);
            return format!("of the rows, {step} s apart");
        };
        let mut text = format!("of the column '{}'", self.form.columns[column]);
        if self.time == Time::Rising {
            text += ", the first, which rises from row to row";
        }
        text += &self.unit.told();
        text
    }

    /// Requests for all columns beside the time.
    #[must_use]
    pub fn requests(&self) -> Vec<Request> {
        let request = |name: &str| Request {
            name: name.to_owned(),
            role: Role::Output,
        };
        self.signals().into_iter().map(request).collect()
    }
}

/// The cells of a column that hold no number.
#[derive(Clone, Debug, Default)]
struct Faults {
    empty: u64,
    others: u64,
    /// The first that is not empty, and the line of the file.
    first: Option<(String, u64)>,
    /// The line of the first that is empty.
    first_empty: Option<u64>,
}

impl Faults {
    /// The number in a cell on that line; counts one that is none.
    fn number(&mut self, cell: &[u8], line: u64) -> Option<f64> {
        let text = std::str::from_utf8(cell).ok();
        let found = text.and_then(number);
        if cell.is_empty() {
            self.empty += 1;
            self.first_empty.get_or_insert(line);
        } else if found.is_none() {
            self.others += 1;
            self.first.get_or_insert_with(|| {
                let text = String::from_utf8_lossy(cell);
                (text.chars().take(QUOTED).collect(), line)
            });
        }
        found
    }

    fn note(&self, column: &str, rows: u64) -> Option<String> {
        let mut parts = Vec::new();
        if self.empty > 0 {
            let first = self.first_empty.unwrap_or_default();
            parts.push(format!("{} empty, the first in line {first}", self.empty));
        }
        if let Some((text, line)) = &self.first {
            let text = shown(text);
            parts.push(format!(
                "{} no numbers, the first '{text}' in line {line}",
                self.others
            ));
        }
        let parts = parts.join(", ");
        (!parts.is_empty()).then(|| format!("'{column}': of {rows} cells {parts}"))
    }
}

/// The name and the unit of a column `NAME [UNIT]`, `NAME (UNIT)` or `NAME_UNIT`.
pub(crate) fn with_unit(column: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        let unclosed = column.strip_suffix(close);
        if let Some((name, unit)) = unclosed.and_then(|it| it.rsplit_once(open)) {
            return (name.trim_end(), Some(unit.trim()));
        }
    }
    match column.rsplit_once('_') {
        Some((name, unit)) if !name.is_empty() && UNITS.contains(&unit) => (name, Some(unit)),
        _ => (column, None),
    }
}

/// The file at `path`, from behind its byte-order mark if it has one.
fn text_at(path: &Path) -> Result<File> {
    let unreadable = SourceError::unreadable(path);
    let mut file = File::open(path).map_err(unreadable)?;
    let mut first = Vec::new();
    let count = (&mut file)
        .take(4)
        .read_to_end(&mut first)
        .map_err(unreadable)?;
    let text = unmarked(&first)
        .map_err(|reason| SourceError::Data(format!("{}: {reason}", path.display())))?;
    file.seek(SeekFrom::Start((count - text.len()) as u64))
        .map_err(unreadable)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_found_by_its_name_without_the_unit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, "depth [m],t [s],pitch [rad],pitch\n1,2,3,4\n").unwrap();
        let table = CsvSource::open(&path, &TableTime::default()).unwrap();
        assert_eq!(table.form.columns[table.time_column().unwrap()], "t [s]");
        let places = table.places();
        for (name, place) in [
            ("depth", 0),
            ("depth [m]", 0),
            ("pitch [rad]", 2),
            ("pitch", 3),
        ] {
            assert_eq!(table.place(&places, name).unwrap(), place, "{name}");
        }
        let refusal = table.place(&places, "dpeth").unwrap_err().to_string();
        assert!(refusal.contains("did you mean 'depth'?"), "{refusal}");
    }

    #[test]
    fn one_column_as_input_and_output_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, "t,pitch [rad]\n1,2\n").unwrap();
        let table = CsvSource::open(&path, &TableTime::default()).unwrap();
        let request = |name: &str, role| Request {
            name: name.to_owned(),
            role,
        };
        let same = [
            request("pitch", Role::Input),
            request("pitch [rad]", Role::Output),
        ];
        let refusal = table
            .read(&same, &mut |_, _, _| true, &|_| {})
            .unwrap_err()
            .to_string();
        assert!(
            refusal.contains("'pitch' is the input and the output"),
            "{refusal}"
        );
    }

    #[test]
    fn tables_made_to_hurt_are_refused_or_read_in_part() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        for (case, bytes) in planesman_testing::hostile::tables() {
            std::fs::write(&path, bytes).unwrap();
            let Ok(table) = CsvSource::open(&path, &TableTime::default()) else {
                continue;
            };
            let requests: Vec<Request> = table.requests().into_iter().take(2).collect();
            let mut count = [0_u64; 2];
            let mut take = |signal: usize, _, _| {
                count[signal] += 1;
                true
            };
            let _ = table.read(&requests, &mut take, &|_| {});
            assert!(count.iter().all(|rows| *rows <= 1_000_000), "{case}");
        }
    }
}
