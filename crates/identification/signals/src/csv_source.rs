//! Samples from a CSV file: columns of numbers; one column is the time, or the rows have a known interval.
//!
//! Delimiter, header and comments are detected ([`Form`]). An empty or non-numeric cell is a missing sample; both are counted for each
//! column and noted.
//!
//! A column `NAME [UNIT]`, `NAME (UNIT)` or `NAME_UNIT` is found by `NAME` too.

mod time;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use csv::ByteRecord;
use planesman_text::{did_you_mean, option, setting, shown, unmarked};

use crate::csv_cell::{decimal, is_missing, number, quantity};
use crate::csv_form::{Form, RowReader};
use crate::csv_heading::Heading;
use crate::csv_long::LongForm;
use crate::csv_time::{FORMS, TimeFormat};
use crate::error::{Result, SourceError, listed, size};
use crate::request::{PROGRESS_INTERVAL, Reading, Request, Take, places};
use crate::source::{Source, SourceTopic};
use crate::time_unit::{self, JudgedUnit, Known, TimeUnit};
use crate::unit_name::with_unit;

/// Below this share of non-empty cells a table is sparse. Then: number of rows examined, and maximum number of columns and groups.
const SPARSE: f64 = 0.6;
const FEWEST_ROWS: usize = 10;
const MOST_COLUMNS: usize = 10_000;
const MOST_GROUPS: usize = 100;

/// Number of rows searched for a time that no name reveals.
const LOOKED_AT: usize = 100;

/// Maximum number of characters of a cell quoted in a note.
const QUOTED: usize = 40;

/// Time of the rows of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableTime {
    /// The time's column, or two columns as `SECONDS+NANOSECONDS` or `DATE+TIME`; `None` for a column with a usual name, or a first column that
    /// increases.
    pub column: Option<String>,
    /// The unit of its numbers; `None` for the unit at the end of its name, or seconds.
    pub unit: Option<TimeUnit>,
    /// The interval between two rows of a table without a time, s.
    pub sample_time: Option<f64>,
}

/// Source of a row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    /// The time is in a column that was given or has a usual name.
    Named(usize),
    /// The time is in the first column, because its numbers increase.
    Rising,
    /// The time is in two columns: seconds, and their fraction in this unit.
    Parts(usize, usize, TimeUnit),
    /// The time is in two columns: the date, and the time of day.
    Dated(usize, usize),
    /// From the row's number, with this many ns from row to row.
    Rows(f64),
    /// The time is unknown; the first column only counts the rows.
    Counted,
    /// Nowhere.
    Unknown,
}

/// A table.
#[derive(Clone, Debug)]
pub struct CsvSource {
    path: PathBuf,
    bytes: u64,
    form: Form,
    /// The signals of a long table, in which each row names its signal.
    long: Option<Box<LongForm>>,
    time: Time,
    written: TimeFormat,
    /// Source of the unit.
    known: Known,
    /// Explanation of how the form of the time was detected, for display.
    written_told: String,
    /// In a sparse table: columns grouped by the rows in which they have cells; each group has its own rows.
    groups: Vec<Vec<usize>>,
}

impl CsvSource {
    /// Determines the form of the table at `path`, and its time.
    ///
    /// # Errors
    /// One line with the path: no file, no columns, no such column.
    pub fn open(path: &Path, time: &TableTime) -> Result<Self> {
        let name = path.display();
        let unreadable = SourceError::unreadable(path);
        let bytes = size(path)?;
        let form = Form::of(text_at(path)?).map_err(unreadable)?;
        let form = form.map_err(|reason| SourceError::Data(format!("{name}: {reason}")))?;
        if form.columns.len() < 2 {
            return Err(SourceError::Data(format!(
                "{name}: its first line does not have two columns separated by ',', ';', tabs or \
                 blanks"
            )));
        }
        let mut table = Self {
            path: path.to_owned(),
            bytes,
            form,
            long: None,
            time: Time::Unknown,
            written: TimeFormat::default(),
            known: Known::Named,
            written_told: String::new(),
            groups: Vec::new(),
        };
        let start = table.start()?;
        table.time = table.find_time(time, &start)?;
        table.find_written(time, &start)?;
        let of_time = [table.time_column(), table.time_part()];
        let of_time: Vec<usize> = of_time.into_iter().flatten().collect();
        let mut reader = table.reader()?;
        let next = |row: &mut ByteRecord| Ok(reader.read(row)?);
        table.long = LongForm::find(&table.form.columns, &of_time, &start, next)
            .map_err(unreadable)?
            .filter(|_| table.has_time() && !matches!(table.time, Time::Rows(_)))
            .map(Box::new);
        table.groups = table.find_groups(&of_time, &start);
        Ok(table)
    }

    /// In a sparse table: the columns with cells in the same of the first rows; empty for any other table.
    fn find_groups(&self, of_time: &[usize], start: &[Vec<String>]) -> Vec<Vec<usize>> {
        let mut groups: BTreeMap<Vec<bool>, Vec<usize>> = BTreeMap::new();
        let (mut cells, mut filled) = (0, 0);
        if start.len() < FEWEST_ROWS || self.form.columns.len() > MOST_COLUMNS {
            return Vec::new();
        }
        for at in (0..self.form.columns.len()).filter(|it| !of_time.contains(it)) {
            let has_cell = |row: &Vec<String>| row.get(at).is_some_and(|it| !is_missing(it));
            let rows: Vec<bool> = start.iter().map(has_cell).collect();
            let count = rows.iter().filter(|it| **it).count();
            if count > 0 {
                (cells, filled) = (cells + rows.len(), filled + count);
            }
            groups.entry(rows).or_default().push(at);
        }
        let empty = groups.remove(&vec![false; start.len()]);
        let are_sparse = (filled as f64) < SPARSE * cells as f64;
        let are_few = (2..=MOST_GROUPS).contains(&groups.len());
        if !are_sparse || !are_few || !self.has_time() || self.long.is_some() {
            return Vec::new();
        }
        let mut groups: Vec<Vec<usize>> = groups.into_values().rev().collect();
        groups[0].extend(empty.into_iter().flatten());
        groups
    }

    /// The first rows.
    fn start(&self) -> Result<Vec<Vec<String>>> {
        let mut reader = self.reader()?;
        let (mut row, mut rows) = (ByteRecord::new(), Vec::new());
        while rows.len() < LOOKED_AT && reader.read(&mut row)? {
            let text = |cell| String::from_utf8_lossy(cell).into_owned();
            rows.push(row.iter().take(self.form.columns.len()).map(text).collect());
        }
        Ok(rows)
    }

    /// Its name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn time_column(&self) -> Option<usize> {
        match self.time {
            Time::Named(column) | Time::Parts(column, ..) | Time::Dated(column, _) => Some(column),
            Time::Rising => Some(0),
            Time::Rows(_) | Time::Counted | Time::Unknown => None,
        }
    }

    /// The second column of the time.
    fn time_part(&self) -> Option<usize> {
        match self.time {
            Time::Parts(_, column, _) | Time::Dated(_, column) => Some(column),
            _ => None,
        }
    }

    /// The columns except the time; for a long table its signals.
    #[must_use]
    pub fn signals(&self) -> Vec<&str> {
        if let Some(long) = &self.long {
            return long.signals().iter().map(String::as_str).collect();
        }
        let time = self.time_column();
        let columns = self.form.columns.iter().enumerate();
        let part = self.time_part();
        let others = columns.filter(|(it, _)| Some(*it) != time && Some(*it) != part);
        others.map(|(_, name)| name.as_str()).collect()
    }

    /// The name of a column, or of a signal of a long table; signals are numbered after the columns.
    fn name_of(&self, place: usize) -> &str {
        let columns = &self.form.columns;
        match (columns.get(place), &self.long) {
            (Some(name), _) => name,
            (None, Some(long)) => &long.signals()[place - columns.len()],
            (None, None) => "",
        }
    }

    /// The place of each column, by its full name and by its name without the unit (`pitch` for `pitch [rad]`); a second place if two have
    /// that name.
    pub(crate) fn places(&self) -> BTreeMap<&str, (usize, Option<usize>)> {
        let mut places: BTreeMap<&str, (usize, Option<usize>)> = BTreeMap::new();
        let columns = || self.form.columns.iter().enumerate();
        for (place, name) in columns() {
            let of_name = places.entry(with_unit(name).0).or_insert((place, None));
            if of_name.0 != place {
                of_name.1 = of_name.1.or(Some(place));
            }
        }
        places.extend(columns().map(|(place, name)| (name.as_str(), (place, None))));
        let signals = self.long.iter().flat_map(|it| it.signals());
        let behind = signals.zip(self.form.columns.len()..);
        places.extend(behind.map(|(name, place)| (name.as_str(), (place, None))));
        places
    }

    /// The column of that name.
    ///
    /// # Errors
    /// A sentence, if there is no such column, or there are several.
    pub(crate) fn place(
        &self,
        places: &BTreeMap<&str, (usize, Option<usize>)>,
        name: &str,
    ) -> Result<usize> {
        let columns = &self.form.columns;
        let path = self.path.display();
        if let Some(long) = &self.long {
            let place = places.get(name).filter(|it| it.1.is_none());
            let is_of_several = place.is_some_and(|it| long.holds(it.0)) || long.is_shared(name);
            if place.is_none() || is_of_several {
                let why = match is_of_several {
                    true => format!(
                        "several signals have the name '{name}', and each row contains the name of its signal"
                    ),
                    false => format!("there is no signal '{name}'"),
                };
                let names = long.signals().iter().map(String::as_str);
                return Err(SourceError::Request(format!(
                    "{path}: {why}; choose one of {}{}",
                    listed(names.clone()),
                    did_you_mean(name, names)
                )));
            }
        }
        match places.get(name) {
            Some((place, None)) => Ok(*place),
            Some((first, Some(second))) => Err(SourceError::Request(format!(
                "{path}: '{name}' may mean '{}' or '{}'. Write the full name",
                columns[*first], columns[*second]
            ))),
            None => Err(SourceError::Request(format!(
                "{path}: there is no column '{name}'; there are {}{}{}",
                listed(columns.iter().map(String::as_str)),
                did_you_mean(name, places.keys().copied()),
                match &self.form.notes[..] {
                    [] => String::new(),
                    notes => format!(" ({})", notes.join("; ")),
                }
            ))),
        }
    }

    fn reader(&self) -> Result<RowReader<File>> {
        Ok(self.form.rows(text_at(&self.path)?))
    }

    /// The rows, with the column of each signal (its number in the requests).
    ///
    /// # Errors
    /// If the table's time is not known.
    pub(crate) fn rows(
        &self,
        signals: Vec<(usize, usize)>,
        requests: &[Request],
        reading: &mut Reading,
    ) -> Result<Rows<'_>> {
        let path = self.path.display();
        let columns = &self.form.columns;
        match self.time {
            Time::Unknown => {
                return Err(SourceError::Request(format!(
                    "{path}: no column contains the time: none has the name {}, and the first column does not increase from row to row. Give the column with {} ({} or DATE+TIME if date and time have two columns), or the interval between rows with {}, for example {}",
                    time_unit::NAMES[..4].join(", "),
                    setting("time", "COLUMN"),
                    setting("time", "SECONDS+NANOSECONDS"),
                    option("sample_time"),
                    setting("sample_time", "0.1s")
                )));
            }
            Time::Counted => {
                return Err(SourceError::Request(format!(
                    "{path}: no column contains the time: the first column, '{}', counts the rows. Give the interval between rows with {}, for example {}, or the column of the time with {}",
                    columns[0],
                    option("sample_time"),
                    setting("sample_time", "0.1s"),
                    setting("time", "COLUMN")
                )));
            }
            Time::Rising if signals.iter().any(|it| it.1 == 0) => {
                return Err(SourceError::Request(format!(
                    "{path}: '{}' is assumed to be the time, because it is the first column and increases from row to row. If it is a signal, give the column of the time with {}, or the interval between rows with {}",
                    columns[0],
                    setting("time", "COLUMN"),
                    option("sample_time")
                )));
            }
            _ => {}
        }
        reading.stamps = self.stamps();
        reading.unit = JudgedUnit {
            unit: self.written.unit,
            known: self.known,
        };
        let notes = self.form.notes.iter();
        reading
            .notes
            .extend(notes.map(|note| format!("{path}: {note}")));
        for (signal, column) in &signals {
            let (asked, name) = (&requests[*signal].name, self.name_of(*column));
            if name != asked && !asked.ends_with(&format!(":{name}")) {
                reading
                    .notes
                    .push(format!("'{asked}' is the column '{name}'"));
                reading.columns.insert(asked.clone(), name.to_owned());
            }
        }
        Ok(Rows {
            faults: vec![Faults::default(); signals.len()],
            table: self,
            reader: self.reader()?,
            row: ByteRecord::new(),
            key: Vec::new(),
            signals,
            count: 0,
            heading: self.form.heading.clone(),
            part: (0, 0),
            last: 0,
            timeless: Faults::default(),
            others: None,
            broken: None,
        })
    }

    /// The time of a row.
    fn stamp(&self, row: &ByteRecord, count: u64) -> Option<i64> {
        let cell = |column: usize| std::str::from_utf8(row.get(column)?).ok();
        match self.time {
            Time::Rows(step) => Some((count as f64 * step).round() as i64),
            Time::Named(column) => self.written.nanoseconds(cell(column)?),
            Time::Rising => self.written.nanoseconds(cell(0)?),
            Time::Parts(seconds, part, unit) => {
                let whole = decimal(cell(seconds)?, TimeUnit::S)?;
                whole.checked_add(decimal(cell(part)?, unit)?)
            }
            Time::Dated(date, time) => {
                let text = format!("{} {}", cell(date)?, cell(time)?);
                self.written.nanoseconds(&text)
            }
            Time::Counted | Time::Unknown => None,
        }
    }

    /// The source of the stamps, for people.
    fn stamps(&self) -> String {
        let Some(column) = self.time_column() else {
            let step = self.sample_time().unwrap_or(1.0);
            return format!("of the rows, which are {step} s apart{}", self.written_told);
        };
        let name = |column: usize| &self.form.columns[column];
        let mut text = match self.time_part() {
            Some(part) => format!("of the columns '{}' and '{}'", name(column), name(part)),
            None => format!("of the column '{}'", name(column)),
        };
        if self.time == Time::Rising {
            text += ", the first column, which increases from row to row";
        }
        if let Time::Parts(_, _, unit) = self.time {
            text += &format!(", in s and {}", unit.name());
        }
        text + &self.written_told
    }
}

impl Source for CsvSource {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }

    fn sample_time(&self) -> Option<f64> {
        match self.time {
            Time::Rows(step) => Some(step * 1e-9),
            _ => None,
        }
    }

    fn has_time(&self) -> bool {
        !matches!(self.time, Time::Unknown | Time::Counted)
    }

    fn count_rows(&mut self) {
        if !self.has_time() {
            self.time = Time::Rows(1e9);
        }
    }

    /// All columns except the time. The signals of a long table have separate times, and so do groups of columns in a sparse table.
    fn topics(&self) -> Vec<SourceTopic> {
        let requests = self.signals().into_iter().map(Request::output);
        let topic = |requests| SourceTopic {
            name: self.name(),
            type_name: "",
            requests,
        };
        match self.long {
            Some(_) => requests.map(|it| topic(vec![it])).collect(),
            None if !self.groups.is_empty() => {
                let request = |at: &usize| Request::output(&self.form.columns[*at]);
                let requests = |group: &Vec<usize>| group.iter().map(request).collect();
                self.groups.iter().map(|it| topic(requests(it))).collect()
            }
            None => vec![topic(requests.collect())],
        }
    }

    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let known = self.places();
        let columns = places(requests, |it| self.place(&known, &it.name))?;
        let mut reading = Reading::default();
        let signals = columns.into_iter().enumerate().collect();
        let rows = self.rows(signals, requests, &mut reading)?;
        read_rows(vec![rows], &mut reading, take, progress)?;
        Ok(reading)
    }
}

/// Passes every cell of the tables' columns to `take`, row by row, in the order of their times.
///
/// # Errors
/// Like [`Rows::end`].
pub(crate) fn read_rows(
    tables: Vec<Rows<'_>>,
    reading: &mut Reading,
    take: &mut Take<'_>,
    progress: &dyn Fn(u64),
) -> Result<()> {
    let each = tables.into_iter().map(|mut rows| (rows.next(), rows));
    let mut tables: Vec<_> = each.collect();
    let mut count = 0_u64;
    loop {
        let waiting = tables.iter_mut().filter(|it| it.0.is_some());
        let Some((next @ Some(_), rows)) = waiting.min_by_key(|it| it.0) else {
            break;
        };
        if !next.is_some_and(|stamp| rows.hand(stamp, take)) {
            break;
        }
        *next = rows.next();
        count += 1;
        if count.is_multiple_of(PROGRESS_INTERVAL) {
            progress(tables.iter().map(|it| it.1.bytes()).sum());
        }
    }
    for (_, rows) in tables {
        rows.end(reading)?;
    }
    Ok(())
}

/// The rows of a table, as they are read.
pub(crate) struct Rows<'a> {
    table: &'a CsvSource,
    reader: RowReader<File>,
    row: ByteRecord,
    key: Vec<u8>,
    signals: Vec<(usize, usize)>,
    faults: Vec<Faults>,
    /// Rows read.
    count: u64,
    /// The heading of the current part, its first row, and that row's time, ns.
    heading: Heading,
    part: (u64, i64),
    /// The time of the last row, ns.
    last: i64,
    timeless: Faults,
    /// The line that has the names in another order.
    others: Option<u64>,
    /// The reason why reading stopped before the end.
    broken: Option<String>,
}

impl Rows<'_> {
    /// Advances to the next row with a time; returns the time.
    pub(crate) fn next(&mut self) -> Option<i64> {
        loop {
            match self.reader.read(&mut self.row) {
                Ok(true) if self.is_of_heading() => match self.broken {
                    Some(_) => return None,
                    None => continue,
                },
                Ok(true) => self.count += 1,
                Ok(false) => return None,
                Err(error) => {
                    self.broken = Some(error.to_string());
                    return None;
                }
            }
            let (first, begin) = self.part;
            if let Some(stamp) = self.table.stamp(&self.row, self.count - 1 - first) {
                self.last = stamp.saturating_add(begin);
                return Some(self.last);
            }
            let line = self.line();
            if self.others.is_none() && self.has_other_names() {
                self.others = Some(line);
            }
            let column = self.table.time_column().unwrap_or_default();
            let cell = self.row.get(column).unwrap_or_default();
            self.timeless.count(cell, line);
        }
    }

    /// Whether the row belongs to a heading between rows without times; after the heading the rows restart.
    fn is_of_heading(&mut self) -> bool {
        let first = &self.table.form.heading;
        let text = |cell| std::str::from_utf8(cell).unwrap_or_default();
        let key = text(self.row.get(0).unwrap_or_default());
        if !first.has_interval() || key.is_empty() || number(key).is_some() {
            return false;
        }
        if self.heading.take(self.row.iter().map(text)) && self.count > 0 {
            self.part = (self.count, self.heading.begins(first, self.last));
        }
        if self.heading.interval != first.interval {
            let line = self.line();
            self.broken = Some(format!(
                "from line {line} on the interval between rows is different, so these rows are left out. Make a separate file of each part"
            ));
        }
        true
    }

    /// Whether the row contains the column names in another order, or some of them: then another table begins.
    fn has_other_names(&self) -> bool {
        let names = &self.table.form.columns;
        let cells: Vec<&str> = self
            .row
            .iter()
            .filter_map(|it| std::str::from_utf8(it).ok())
            .collect();
        let is_name = |cell: &&&str| !cell.is_empty() && names.iter().any(|it| it == **cell);
        let known = cells.iter().filter(is_name).count();
        let is_same = || {
            cells
                .iter()
                .zip(names)
                .all(|(cell, name)| name.starts_with(cell))
        };
        known > 1 && 2 * known >= cells.len() && !(cells.len() <= names.len() && is_same())
    }

    /// The bytes read.
    pub(crate) fn bytes(&self) -> u64 {
        self.row.position().map_or(0, csv::Position::byte)
    }

    /// The line of the row in the file.
    fn line(&self) -> u64 {
        let line = self.row.position().map_or(self.count, csv::Position::line);
        self.table.form.skipped + line
    }

    /// Passes the numbers of the row to `take`; returns whether more rows are needed.
    pub(crate) fn hand(&mut self, stamp: i64, take: &mut Take<'_>) -> bool {
        let line = self.line();
        let mut more = true;
        let width = self.table.form.columns.len();
        let long = self.table.long.as_ref();
        let series = long.and_then(|it| it.series(&self.row, &mut self.key));
        for ((signal, column), faults) in self.signals.iter().zip(&mut self.faults) {
            let column = match column.checked_sub(width) {
                None => Some(*column),
                Some(of_long) => long.zip(series).and_then(|(it, at)| it.column(of_long, at)),
            };
            let Some(column) = column else { continue };
            let value = faults.number(self.row.get(column).unwrap_or_default(), line);
            more &= take(*signal, stamp, value);
        }
        more
    }

    /// Adds notes on values that could not be read.
    ///
    /// # Errors
    /// If no row of the table has a time.
    pub(crate) fn end(self, reading: &mut Reading) -> Result<()> {
        let path = self.table.path.display();
        reading
            .notes
            .extend(self.broken.map(|it| format!("{path}: {it}")));
        let columns = &self.table.form.columns;
        if let Some(line) = self.others {
            return Err(SourceError::Data(format!(
                "{path}: the names occur again in line {line}, in another order, so a second table begins there. Split the file in two"
            )));
        }
        let timeless = self.timeless.empty + self.timeless.others;
        if let (Some(column), true) = (self.table.time_column(), timeless > 0) {
            let name = &columns[column];
            let shown = match (self.timeless.first, self.timeless.first_empty) {
                (Some((text, line)), _) => format!(", the first '{}' in line {line}", shown(text)),
                (None, line) => format!(", the first in line {}", line.unwrap_or_default()),
            };
            let note = format!(
                "{path}: {timeless} of {} rows have no time in '{name}'{shown}",
                self.count
            );
            if timeless == self.count {
                return Err(SourceError::Data(format!(
                    "{note}. A time can be a number ({}), {FORMS}",
                    option("time_unit")
                )));
            }
            reading.notes.push(note);
        }
        for (faults, (_, column)) in self.faults.iter().zip(&self.signals) {
            if let Some((text, line)) = faults.doubtful() {
                return Err(SourceError::Data(format!(
                    "{path}: '{}' in line {line} of '{}' may be a fraction or group thousands. \
                     All numbers of the column have three digits after a separator, or no separator. Write the numbers without grouping",
                    shown(text),
                    self.table.name_of(*column)
                )));
            }
            if let Some((first, (unit, line))) = faults.of_several_units(self.count) {
                let named = |unit: &str| match unit {
                    "" => "no unit".to_owned(),
                    unit => format!("the unit '{}'", shown(unit)),
                };
                return Err(SourceError::Data(format!(
                    "{path}: cells of '{}' have several units: the first cell has {}, the cell in line {line} has {}. Use one unit",
                    self.table.name_of(*column),
                    named(first),
                    named(unit)
                )));
            }
            let note = faults.note(self.table.name_of(*column), self.count - timeless);
            reading.notes.extend(note);
        }
        Ok(())
    }
}

/// The cells of a column without a number.
#[derive(Clone, Debug, Default)]
struct Faults {
    empty: u64,
    others: u64,
    /// The first non-empty cell without a number, and its line in the file.
    first: Option<(String, u64)>,
    /// The line of the first empty cell.
    first_empty: Option<u64>,
    /// The first number with three digits after its only separator, for example 1.234.
    grouped: Option<(String, u64)>,
    /// Whether a number has no separator, and whether one has a separator that does not group thousands.
    has_whole: bool,
    has_fraction: bool,
    /// Whether the first number except 0 has no unit; otherwise the units, which few columns have.
    is_bare: bool,
    units: Option<Box<Units>>,
}

/// The units after a column's numbers.
#[derive(Clone, Debug, Default)]
struct Units {
    /// The first unit, which may be empty, and another with its line.
    first: String,
    other: Option<(String, u64)>,
    /// Number of values left out because they have a unit, but the first value has none.
    left_out: u64,
}

impl Units {
    fn of(first: &str) -> Self {
        Self {
            first: first.to_owned(),
            ..Self::default()
        }
    }

    fn see(&mut self, unit: &str, line: u64) {
        if self.first != unit {
            self.other.get_or_insert_with(|| (unit.to_owned(), line));
        }
    }
}

impl Faults {
    /// The number in a cell on that line; counts cells without a number.
    fn number(&mut self, cell: &[u8], line: u64) -> Option<f64> {
        let text = std::str::from_utf8(cell).ok();
        let found = text.and_then(number);
        if let Some(number) = found {
            if !self.has_fraction {
                self.see_sign(cell, line);
            }
            match &mut self.units {
                _ if number == 0.0 => {}
                None => self.is_bare = true,
                Some(units) if !units.first.is_empty() => units.see("", line),
                Some(_) => {}
            }
            return found;
        }
        let Some((number, unit)) = text.and_then(quantity) else {
            self.count(cell, line);
            return None;
        };
        let first = if self.is_bare { "" } else { unit };
        let units = self.units.get_or_insert_with(|| Box::new(Units::of(first)));
        units.see(unit, line);
        if units.first.is_empty() {
            units.left_out += 1;
            self.count(cell, line);
            return None;
        }
        Some(number)
    }

    /// The first unit and another unit with its line, if numbers with several units are read, or more than a few with one unit are left out.
    fn of_several_units(&self, rows: u64) -> Option<(&str, &(String, u64))> {
        let units = self.units.as_ref()?;
        let matters = !units.first.is_empty() || units.left_out * 100 > rows;
        Some((units.first.as_str(), units.other.as_ref()?)).filter(|_| matters)
    }

    /// Checks whether the number may have grouped thousands.
    fn see_sign(&mut self, cell: &[u8], line: u64) {
        let Some(at) = cell.iter().position(|it| matches!(it, b'.' | b',')) else {
            self.has_whole |= cell.iter().all(|it| it.is_ascii_digit() || *it == b'-');
            return;
        };
        let (whole, part) = (
            cell[..at].strip_prefix(b"-").unwrap_or(&cell[..at]),
            &cell[at + 1..],
        );
        let is_group = (1..=3).contains(&whole.len()) && whole[0] != b'0';
        if is_group && part.len() == 3 && part.iter().all(u8::is_ascii_digit) {
            let text = || (String::from_utf8_lossy(cell).into_owned(), line);
            self.grouped.get_or_insert_with(text);
        } else {
            self.has_fraction = true;
        }
    }

    /// A number that may be a thousand times as large.
    fn doubtful(&self) -> Option<&(String, u64)> {
        let is_doubtful = self.has_whole && !self.has_fraction;
        self.grouped.as_ref().filter(|_| is_doubtful)
    }

    /// Counts a cell on that line.
    fn count(&mut self, cell: &[u8], line: u64) {
        if cell.is_empty() {
            self.empty += 1;
            self.first_empty.get_or_insert(line);
        } else {
            self.others += 1;
            self.first.get_or_insert_with(|| {
                let text = String::from_utf8_lossy(cell);
                (text.chars().take(QUOTED).collect(), line)
            });
        }
    }

    fn note(&self, column: &str, rows: u64) -> Option<String> {
        let mut parts = Vec::new();
        if self.empty > 0 {
            let first = self.first_empty.unwrap_or_default();
            parts.push(format!(
                "{} are empty, the first in line {first}",
                self.empty
            ));
        }
        if let Some((text, line)) = &self.first {
            let text = shown(text);
            parts.push(format!(
                "{} contain no number, the first '{text}' in line {line}",
                self.others
            ));
        }
        let parts = parts.join(", ");
        (!parts.is_empty()).then(|| format!("'{column}': of {rows} cells {parts}"))
    }
}

/// The file at `path`, after its byte-order mark if it has one.
fn text_at(path: &Path) -> Result<File> {
    let unreadable = SourceError::unreadable(path);
    let mut file = File::open(path).map_err(unreadable)?;
    let mut first = Vec::new();
    let count = (&mut file)
        .take(4)
        .read_to_end(&mut first)
        .map_err(unreadable)?;
    let text = unmarked(&first).map_err(|reason| {
        SourceError::Data(format!(
            "{0}: {reason}: `iconv -f UTF-16 -t UTF-8 {0} > NEW.csv`",
            path.display()
        ))
    })?;
    file.seek(SeekFrom::Start((count - text.len()) as u64))
        .map_err(unreadable)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::Role;

    #[test]
    fn a_column_is_found_by_its_name_without_the_unit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, "depth [m],t [s],pitch [rad],pitch\n1,2,3,4\n").unwrap();
        let table = CsvSource::open(&path, &TableTime::default()).unwrap();
        assert_eq!(table.form.columns[table.time_column().unwrap()], "t [s]");
        for (name, place) in [
            ("depth", 0),
            ("depth [m]", 0),
            ("pitch [rad]", 2),
            ("pitch", 3),
        ] {
            assert_eq!(table.place(&table.places(), name).unwrap(), place, "{name}");
        }
        let refusal = table
            .place(&table.places(), "dpeth")
            .unwrap_err()
            .to_string();
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
            refusal.contains("'pitch' is named both as input and as output"),
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
            let requests: Vec<Request> = table
                .signals()
                .into_iter()
                .take(2)
                .map(Request::output)
                .collect();
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
