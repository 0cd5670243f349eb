//! Samples from a CSV file: a header row with column names, one of them the time.
//!
//! Cells are parted by commas, semicolons or tabs, whichever the header has most of (RFC 4180 quotes are
//! understood). A cell that is no number is a sample that is not there.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use csv::{ByteRecord, Reader, ReaderBuilder};
use planesman_text::{did_you_mean, unmarked};

use crate::request::{Reading, Request, Role, Take, TimeUnit, distinct};

/// The longest line taken, bytes.
const LONGEST_LINE: usize = 1 << 20;

/// Names under which the time is looked for.
const TIMES: [&str; 4] = ["time", "t", "stamp", "timestamp"];

/// Names that are listed in an error at most.
const LISTED: usize = 20;

/// The interval of progress reports, in rows.
const TELL: u64 = 4096;

/// A table.
#[derive(Clone, Debug)]
pub struct CsvSource {
    path: PathBuf,
    bytes: u64,
    delimiter: u8,
    columns: Vec<String>,
    /// Which column is the time.
    time: usize,
    unit: TimeUnit,
}

impl CsvSource {
    /// Reads the header of the table at `path`; its time is in the column `time`, or in the one that seems so.
    ///
    /// # Errors
    /// A line with the path: no file, no header, no such column.
    pub fn open(path: &Path, time: Option<&str>, unit: TimeUnit) -> Result<Self> {
        let shown = path.display();
        let unreadable = || format!("{shown} cannot be read");
        // Asked before it is opened: a pipe would be waited for, and a table is read twice.
        let about = std::fs::metadata(path).with_context(unreadable)?;
        if !about.is_file() {
            bail!("{shown} is not a regular file");
        }
        let bytes = about.len();
        let mut header = Vec::new();
        BufReader::new(ShortLines::new(text_at(path)?))
            .read_until(b'\n', &mut header)
            .with_context(unreadable)?;
        let count = |sign: u8| header.iter().filter(|byte| **byte == sign).count();
        let delimiter = [b',', b';', b'\t']
            .into_iter()
            .rev()
            .max_by_key(|sign| count(*sign));
        let delimiter = delimiter.unwrap_or(b',');
        let mut table = Self {
            path: path.to_owned(),
            bytes,
            delimiter,
            columns: Vec::new(),
            time: 0,
            unit,
        };
        let header = table.reader()?.byte_headers()?.clone();
        let text = |cell| String::from_utf8_lossy(cell).into_owned();
        table.columns = header.iter().map(text).collect();
        if table.columns.len() < 2 {
            bail!("{shown}: its first line has no two columns parted by ',', ';' or tabs");
        }
        table.time = match time {
            Some(name) => table.place(&table.places(), name)?,
            None => TIMES
                .iter()
                .find_map(|name| {
                    table
                        .columns
                        .iter()
                        .position(|it| without_unit(it).eq_ignore_ascii_case(name))
                })
                .unwrap_or(0),
        };
        Ok(table)
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

    /// The columns beside the time.
    #[must_use]
    pub fn signals(&self) -> Vec<&str> {
        let others = self
            .columns
            .iter()
            .enumerate()
            .filter(|(it, _)| *it != self.time);
        others.map(|(_, name)| name.as_str()).collect()
    }

    /// Where each column is, by its name in full and by its name without the unit (`pitch` for `pitch [rad]`); of
    /// several of one name the first.
    fn places(&self) -> BTreeMap<&str, usize> {
        let columns = || self.columns.iter().enumerate().rev();
        let plain = columns().map(|(place, name)| (without_unit(name), place));
        let full = columns().map(|(place, name)| (name.as_str(), place));
        plain.chain(full).collect()
    }

    fn place(&self, places: &BTreeMap<&str, usize>, name: &str) -> Result<usize> {
        places.get(name).copied().ok_or_else(|| {
            let names = self.columns.iter().take(LISTED);
            let more = self.columns.len().saturating_sub(LISTED);
            anyhow!(
                "{}: it has no column '{name}'; it has {}{}{}",
                self.path.display(),
                names.cloned().collect::<Vec<_>>().join(", "),
                match more {
                    0 => String::new(),
                    more => format!(" and {more} more"),
                },
                did_you_mean(name, places.keys().copied()),
            )
        })
    }

    fn reader(&self) -> Result<Reader<ShortLines<File>>> {
        Ok(ReaderBuilder::new()
            .delimiter(self.delimiter)
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(ShortLines::new(text_at(&self.path)?)))
    }

    /// Hands every cell of the columns to `take`, row by row.
    ///
    /// # Errors
    /// A column that is not there, or a table without a row that has a time.
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
        let mut reading = Reading {
            stamps: format!("of the column '{}'", self.columns[self.time]),
            notes: Vec::new(),
        };
        let mut reader = self.reader()?;
        let mut row = ByteRecord::new();
        let (mut rows, mut timeless) = (0_u64, 0_u64);
        loop {
            match reader.read_byte_record(&mut row) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => {
                    reading
                        .notes
                        .push(format!("{}: {error}", self.path.display()));
                    break;
                }
            }
            rows += 1;
            if rows.is_multiple_of(TELL) {
                progress(row.position().map_or(0, |at| at.byte()));
            }
            let cell = |column: usize| std::str::from_utf8(row.get(column)?).ok();
            let Some(stamp) = cell(self.time).and_then(|it| nanoseconds(it, self.unit)) else {
                timeless += 1;
                continue;
            };
            let mut more = true;
            for (signal, column) in columns.iter().enumerate() {
                more &= take(signal, stamp, cell(*column).and_then(|it| it.parse().ok()));
            }
            if !more {
                break;
            }
        }
        if timeless > 0 {
            let note = format!(
                "{}: {timeless} of {rows} rows have no time in '{}'",
                self.path.display(),
                self.columns[self.time]
            );
            if timeless == rows {
                bail!("{note}");
            }
            reading.notes.push(note);
        }
        Ok(reading)
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

/// The name of a column `NAME [UNIT]`.
fn without_unit(column: &str) -> &str {
    let name = column.strip_suffix(']').and_then(|it| it.rsplit_once('['));
    name.map_or(column, |(name, _)| name.trim_end())
}

/// The file at `path`, from behind its byte-order mark if it has one.
fn text_at(path: &Path) -> Result<File> {
    let unreadable = || format!("{} cannot be read", path.display());
    let mut file = File::open(path).with_context(unreadable)?;
    let mut first = Vec::new();
    let count = (&mut file)
        .take(4)
        .read_to_end(&mut first)
        .with_context(unreadable)?;
    let text = unmarked(&first).map_err(|reason| anyhow!("{}: {reason}", path.display()))?;
    file.seek(SeekFrom::Start((count - text.len()) as u64))
        .with_context(unreadable)?;
    Ok(file)
}

/// A decimal number of time units in nanoseconds, exactly where it is written with digits and a point; 64-bit
/// floating point cannot hold the nanoseconds of a date.
fn nanoseconds(text: &str, unit: TimeUnit) -> Option<i64> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let is_plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !is_plain(whole) || !is_plain(part) {
        // An exponent.
        let nanoseconds = text.parse::<f64>().ok()? * f64::from(10_u32.pow(unit.places()));
        let fits = nanoseconds.abs() < i64::MAX as f64;
        return fits.then_some(nanoseconds.round() as i64);
    }
    let places = unit.places() as usize;
    let padded = format!("{part:0<places$}");
    let rounded = padded
        .as_bytes()
        .get(places)
        .is_some_and(|digit| *digit >= b'5');
    let nanoseconds: i64 = format!("{whole}{}", &padded[..places]).parse().ok()?;
    let nanoseconds = nanoseconds.checked_add(i64::from(rounded))?;
    Some(if negative { -nanoseconds } else { nanoseconds })
}

/// Passes bytes on, and fails in a line that is longer than any table's.
struct ShortLines<R> {
    input: R,
    length: usize,
}

impl<R> ShortLines<R> {
    fn new(input: R) -> Self {
        Self { input, length: 0 }
    }
}

impl<R: Read> Read for ShortLines<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(bytes)?;
        for byte in &bytes[..count] {
            self.length = if *byte == b'\n' { 0 } else { self.length + 1 };
            if self.length > LONGEST_LINE {
                return Err(io::Error::other(format!(
                    "a line has more than {LONGEST_LINE} bytes: not a CSV file"
                )));
            }
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_found_by_its_name_without_the_unit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.csv");
        std::fs::write(&path, "depth [m],t [s],pitch [rad],pitch\n1,2,3,4\n").unwrap();
        let table = CsvSource::open(&path, None, TimeUnit::S).unwrap();
        assert_eq!(table.columns[table.time], "t [s]");
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
        let table = CsvSource::open(&path, None, TimeUnit::S).unwrap();
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
    fn a_time_is_read_to_the_nanosecond() {
        for (text, unit, expected) in [
            ("0.05", TimeUnit::S, Some(50_000_000)),
            (
                "1700000000.123456789",
                TimeUnit::S,
                Some(1_700_000_000_123_456_789),
            ),
            (
                "1700000000.1234567895",
                TimeUnit::S,
                Some(1_700_000_000_123_456_790),
            ),
            ("-1.5", TimeUnit::Ms, Some(-1_500_000)),
            ("7", TimeUnit::Ns, Some(7)),
            ("2.5e-3", TimeUnit::S, Some(2_500_000)),
            ("1e300", TimeUnit::S, None),
            ("99999999999999999999", TimeUnit::Ns, None),
            ("noon", TimeUnit::S, None),
            ("", TimeUnit::S, None),
            ("nan", TimeUnit::S, None),
        ] {
            assert_eq!(nanoseconds(text, unit), expected, "{text}");
        }
    }
}
