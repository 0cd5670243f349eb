//! The form of a table: its delimiter, its first row, its names and its comments.
//!
//! - Cells are separated by tabs, semicolons, commas, bars or blanks: the delimiter that gives the most numbers is chosen.
//! - The first row is the first line with as many cells as the rows below, and with numbers or times in the same columns. A text cell does
//!   not make the line a header.
//! - Names are in the line before the first row, either in a comment (`#`, `%`) or as words. A line of units may follow the names. Earlier lines are
//!   not part of the table, and are noted.
//! - Without names the columns are `c1`, `c2` and so on.

use std::collections::BTreeMap;
use std::collections::HashSet;
use std::io::{self, BufRead, BufReader, Read};

use csv::{ByteRecord, Reader, ReaderBuilder};

use crate::csv_cell::{is_missing, number, value};
use crate::csv_heading::Heading;
use crate::csv_serial::SerialForm;
use crate::csv_time;
use crate::time_unit;
use crate::unit_name::is_unit;

/// The longest accepted line, bytes.
const LONGEST_LINE: usize = 1 << 20;

/// Maximum number of comments and empty lines before a table.
const PREFACE: usize = 1000;

/// Lines, and their bytes, from which the form is determined.
const SAMPLE: usize = 200;
const SAMPLE_BYTES: usize = 1 << 20;

/// The name of the column of stamps that a terminal adds in front.
const STAMP: &str = "time";

/// Maximum number of lines with units or descriptions between names and rows.
const MOST_UNITS: usize = 3;

/// The delimiters; if two fit equally well, the first one is used.
const DELIMITERS: [Delimiter; 5] = [
    Delimiter::Sign(b'\t'),
    Delimiter::Sign(b';'),
    Delimiter::Sign(b','),
    Delimiter::Sign(b'|'),
    Delimiter::Blanks,
];

/// The separator of a line's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Delimiter {
    Sign(u8),
    /// Any number of blanks.
    Blanks,
}

/// The form of a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Form {
    delimiter: Delimiter,
    comment: u8,
    /// The format of lines printed by a microcontroller.
    pub(crate) serial: SerialForm,
    /// The lines before the table that give an interval between its rows.
    pub(crate) heading: Heading,
    /// Lines before the first row.
    pub(crate) skipped: u64,
    /// The names of the columns.
    pub(crate) columns: Vec<String>,
    /// Whether the file has names.
    pub(crate) has_names: bool,
    /// Notes on what was skipped, and whether the result is doubtful.
    pub(crate) notes: Vec<String>,
}

/// A line of the beginning of a file.
struct Line {
    /// Counted from 1.
    number: u64,
    text: Vec<u8>,
    is_comment: bool,
}

impl Form {
    /// Determines the form of the table at the beginning of `input`.
    ///
    /// # Errors
    /// If the input cannot be read, or a line is longer than any table's; the inner error is a sentence if names and rows do not match.
    pub(crate) fn of(input: impl Read) -> io::Result<Result<Self, String>> {
        let mut lines = beginning(input)?;
        let given = lines.first().and_then(|it| given_delimiter(&it.text));
        if given.is_some() {
            lines.remove(0);
        }
        let comment = lines.iter().rfind(|it| it.is_comment);
        let mut form = Self {
            delimiter: Delimiter::Blanks,
            comment: comment.map_or(b'#', |it| it.text[0]),
            serial: SerialForm::default(),
            heading: Heading::default(),
            skipped: 0,
            columns: Vec::new(),
            has_names: true,
            notes: Vec::new(),
        };
        let candidates = match given {
            Some(sign) => vec![Delimiter::Sign(sign)],
            None => DELIMITERS.to_vec(),
        };
        if lines.iter().any(|it| it.text.contains(&b'\r')) {
            let reason = "its lines end with CR only, as on old Macs; convert them with `tr '\\r' '\\n' < FILE > NEW.csv`";
            return Ok(Err(reason.to_owned()));
        }
        let body: Vec<&Line> = lines.iter().filter(|it| !it.is_comment).collect();
        let texts = body[body.len() / 2..].iter().map(|it| &it.text[..]);
        form.serial.has_stamps = SerialForm::have_stamps(texts);
        let grids = candidates.into_iter().map(|delimiter| {
            form.delimiter = delimiter;
            form.serial.names.clear();
            let rows = |form: &Self| body.iter().map(|it| form.cells(&it.text)).collect();
            let mut cells: Vec<Vec<String>> = rows(&form);
            form.serial.find_names(&cells[cells.len() / 2..]);
            if !form.serial.names.is_empty() {
                cells = rows(&form);
            }
            let names = form.serial.names.clone();
            Cells::of(cells).map(|cells| (delimiter, cells, names))
        });
        // The first of those that fit as well.
        let best = grids.flatten().reduce(|best, next| {
            if next.1.score > best.1.score {
                next
            } else {
                best
            }
        });
        let Some((delimiter, cells, names)) = best else {
            form.delimiter = Delimiter::Blanks;
            form.serial.names.clear();
            form.columns = body.first().map_or(Vec::new(), |it| form.cells(&it.text));
            return Ok(Ok(form));
        };
        form.delimiter = delimiter;
        form.serial.names = names;
        Ok(form.with_names(&lines, &body, &cells))
    }

    /// Finds the first row and the line of names before it.
    fn with_names(mut self, lines: &[Line], body: &[&Line], cells: &Cells) -> Result<Self, String> {
        let first = cells.first_row();
        let number = |row: usize| body.get(row).map(|it| it.number);
        // Without a row, the table ends behind its names.
        let first_line =
            number(first).unwrap_or_else(|| lines.last().map_or(1, |it| it.number + 1));
        self.skipped = first_line - 1;
        for row in &cells.rows[..first] {
            self.heading.take(row.iter().map(String::as_str));
        }
        let of_blanks = self.delimiter == Delimiter::Blanks;
        let mut begins = first_line;
        // A title behind an empty line has not the rows' cells.
        let is_next = |row: usize| number(row).is_some_and(|it| it + 1 == first_line);
        let printed = !self.serial.names.is_empty();
        let names = cells.names(first, of_blanks).filter(|(row, names, _)| {
            !printed && (names.len() == cells.width || is_next(*row) || first == body.len())
        });
        // Names of several words are parted by two blanks.
        let by_two = || {
            let row = first
                .checked_sub(1)
                .filter(|row| of_blanks && is_next(*row))?;
            let text = String::from_utf8_lossy(&body[row].text);
            let names = text.split("  ").map(str::trim).filter(|it| !it.is_empty());
            let names: Vec<String> = names.map(str::to_owned).collect();
            (names.len() == cells.width).then_some((row, names, Vec::new()))
        };
        let names = names.or_else(by_two);
        let of_comment = || {
            let is_before = |it: &&Line| it.is_comment && it.number < first_line;
            let last = lines.iter().rfind(is_before)?;
            let names = attached(self.cells(&last.text[1..]), of_blanks);
            (names.len() == cells.width).then_some((last.number, names))
        };
        if printed {
            let stamp = self.serial.has_stamps.then(|| STAMP.to_owned());
            let names = self.serial.names.iter().cloned();
            self.columns = stamp.into_iter().chain(names).collect();
        } else if let Some((row, names, units)) = names {
            begins = number(row).unwrap_or(first_line);
            self.columns = self.fitted(begins, names, cells, first)?;
            for (name, unit) in self.columns.iter_mut().zip(units) {
                if !unit.is_empty() {
                    *name += &format!(" [{unit}]");
                }
            }
            if self.serial.has_stamps {
                STAMP.clone_into(&mut self.columns[0]);
            }
        } else if let Some((_, names)) = of_comment() {
            self.columns = names;
        } else {
            self.has_names = false;
            self.columns = (1..=cells.width).map(|k| format!("c{k}")).collect();
        }
        let titles = body.iter().filter(|it| it.number < begins).count();
        if titles > 0 {
            let names = match begins == first_line {
                true => "without names".to_owned(),
                false => format!("with the names {}", some(&self.columns)),
            };
            self.notes.insert(
                0,
                format!(
                    "the table begins in line {begins}, {names}; the lines before it are skipped"
                ),
            );
        }
        self.tell_apart();
        Ok(self)
    }

    /// The names in that line, one for each cell of a row.
    fn fitted(
        &mut self,
        line: u64,
        mut names: Vec<String>,
        cells: &Cells,
        first: usize,
    ) -> Result<Vec<String>, String> {
        let width = cells.width;
        if names.len() > width {
            let spare = names.split_off(width);
            if spare.iter().any(|it| !it.is_empty()) {
                self.notes.push(format!(
                    "line {line} has {} names, but the rows have {width} cells; the last names, {}, have no data",
                    width + spare.len(),
                    some(&spare)
                ));
                names.extend(spare);
            }
        } else if names.len() + 1 == width {
            if cells.is_empty(width - 1) {
                return Ok(names);
            }
            if !cells.counts(0, first) {
                return Err(unmatched(line, names.len(), width));
            }
            // As R writes them.
            self.notes.push(format!(
                "line {line} has one name fewer than its rows have cells: the first cell is assumed to be the row's number"
            ));
            names.insert(0, "row".to_owned());
        } else if names.len() < width {
            return Err(unmatched(line, names.len(), width));
        }
        Ok(names)
    }

    /// Makes equal names unique by their places: `u [c2]`, `u [c4]`.
    fn tell_apart(&mut self) {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for name in &self.columns {
            *counts.entry(name).or_default() += 1;
        }
        let repeated: Vec<bool> = self
            .columns
            .iter()
            .map(|it| counts[it.as_str()] > 1)
            .collect();
        for (place, name) in self.columns.iter_mut().enumerate() {
            if repeated[place] {
                *name = format!("{name} [c{}]", place + 1).trim_start().to_owned();
            }
        }
    }

    /// The rows of a table of this form, without the lines before the first row.
    pub(crate) fn rows<R: Read>(&self, input: R) -> RowReader<R> {
        let by_blanks = self.delimiter == Delimiter::Blanks;
        RowReader {
            reader: self.reader(Lines::new(input, by_blanks, self.skipped)),
            serial: Some(self.serial.clone()).filter(|it| !it.is_plain()),
        }
    }

    fn reader<R: Read>(&self, lines: Lines<R>) -> Reader<Lines<R>> {
        ReaderBuilder::new()
            .delimiter(match self.delimiter {
                Delimiter::Sign(sign) => sign,
                Delimiter::Blanks => b'\t',
            })
            .has_headers(false)
            .comment(Some(self.comment))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(lines)
    }

    /// The cells of one line.
    fn cells(&self, line: &[u8]) -> Vec<String> {
        let mut row = ByteRecord::new();
        let by_blanks = self.delimiter == Delimiter::Blanks;
        // A line of memory is always read.
        let line = match by_blanks {
            true => line.trim_ascii(),
            false => line,
        };
        let _ = (self.reader(Lines::new(line, by_blanks, 0))).read_byte_record(&mut row);
        if !self.serial.is_plain() {
            row = self.serial.row(&row);
        }
        let text = |cell| String::from_utf8_lossy(cell).into_owned();
        row.iter().map(text).collect()
    }
}

/// The rows of a table, as they are read.
pub(crate) struct RowReader<R> {
    reader: Reader<Lines<R>>,
    serial: Option<SerialForm>,
}

impl<R: Read> RowReader<R> {
    /// Reads the next row; returns whether there is one.
    pub(crate) fn read(&mut self, row: &mut ByteRecord) -> csv::Result<bool> {
        let is_row = self.reader.read_byte_record(row)?;
        if let Some(serial) = self.serial.as_ref().filter(|_| is_row) {
            *row = serial.row(row);
        }
        Ok(is_row)
    }
}

/// The first non-empty lines.
fn beginning(input: impl Read) -> io::Result<Vec<Line>> {
    let mut input = BufReader::new(Lines::new(input, false, 0));
    let mut lines: Vec<Line> = Vec::new();
    let (mut bytes, mut rows, mut number) = (0, 0, 0);
    while number < PREFACE as u64 && rows < SAMPLE && (bytes < SAMPLE_BYTES || rows < 2) {
        let mut text = Vec::new();
        let count = input.read_until(b'\n', &mut text)?;
        if count == 0 {
            break;
        }
        (number, bytes) = (number + 1, bytes + count);
        // A tab at the end is an empty cell.
        let end = text.trim_ascii_end().len();
        let blank = text[end..]
            .iter()
            .take_while(|it| matches!(**it, b'\t' | b' '))
            .count();
        text.truncate(end + blank);
        let is_comment = matches!(text.first(), Some(b'#' | b'%'));
        if !text.trim_ascii().is_empty() {
            rows += usize::from(!is_comment);
            lines.push(Line {
                number,
                text,
                is_comment,
            });
        }
    }
    Ok(lines)
}

/// The delimiter in Excel's line `sep=;`.
fn given_delimiter(line: &[u8]) -> Option<u8> {
    let line = line.trim_ascii_start();
    let line = line.strip_prefix(b"\"").unwrap_or(line);
    let (head, tail) = line.split_at_checked(4)?;
    let sign = *tail.first()?;
    let is_alone = matches!(tail[1..].trim_ascii(), b"" | b"\"");
    (head.eq_ignore_ascii_case(b"sep=") && is_alone).then_some(sign)
}

fn unmatched(line: u64, names: usize, width: usize) -> String {
    format!(
        "line {line} has {names} names, but the rows below it have {width} cells; give every column a name, or delete that line (the columns are then c1 to c{width}); if numbers have a decimal comma, separate the cells by ';' or tabs"
    )
}

/// A few names.
fn some(names: &[String]) -> String {
    let few = names
        .iter()
        .take(5)
        .map(|it| planesman_text::shown(it).to_string());
    let more = if names.len() > 5 { ", ..." } else { "" };
    few.collect::<Vec<_>>().join(", ") + more
}

/// Splits words separated by blanks into names: a unit in brackets belongs to the name before it.
fn attached(words: Vec<String>, by_blanks: bool) -> Vec<String> {
    if !by_blanks {
        return words;
    }
    let mut names: Vec<String> = Vec::new();
    for word in words {
        match names.last_mut() {
            Some(name) if word.starts_with(['[', '(']) => *name += &format!(" {word}"),
            _ => names.push(word),
        }
    }
    names
}

/// The kinds of cells in a column.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    values: usize,
    others: usize,
}

/// The cells of the first lines.
struct Cells {
    rows: Vec<Vec<String>>,
    /// Number of cells in a row.
    width: usize,
    /// The kinds are counted over the later half of the rows, because the first rows may be titles.
    kinds: Vec<Kind>,
    /// Number of numbers and times minus number of texts.
    score: i64,
}

impl Cells {
    /// The cells, if the lines have at least two.
    fn of(rows: Vec<Vec<String>>) -> Option<Self> {
        let tail = || &rows[rows.len() / 2..];
        let values = |row: &[String]| row.iter().filter(|it| is_value(it)).count();
        let mut by_width: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        for row in tail().iter().filter(|it| it.len() > 1) {
            let (numbers, count) = by_width.entry(row.len()).or_default();
            (*numbers, *count) = (*numbers + values(row), *count + 1);
        }
        let (width, _) = by_width.into_iter().max_by_key(|it| it.1)?;
        let mut kinds = vec![Kind::default(); width];
        for row in tail().iter().filter(|it| it.len() == width) {
            for (cell, kind) in row.iter().zip(&mut kinds) {
                kind.values += usize::from(is_value(cell));
                kind.others += usize::from(!is_value(cell) && !is_missing(cell));
            }
        }
        let score = kinds
            .iter()
            .map(|it| it.values as i64 - it.others as i64)
            .sum();
        Some(Self {
            rows,
            width,
            kinds,
            score,
        })
    }

    /// Counts values and texts of a line in the numeric columns.
    fn counts_of(&self, row: &[String]) -> Kind {
        let mut all = Kind::default();
        for (cell, kind) in row.iter().zip(&self.kinds) {
            if kind.values > kind.others {
                all.values += usize::from(is_value(cell));
                all.others += usize::from(!is_value(cell) && !is_missing(cell));
            }
        }
        all
    }

    /// The first line that is a row.
    fn first_row(&self) -> usize {
        // A key in front of numbers, where rows have nothing.
        let is_of_heading = |row: &Vec<String>| self.is_empty(0) && !is_missing(&row[0]);
        let is_row = |row: &Vec<String>| {
            let counts = self.counts_of(row);
            let is_whole = row.len() == self.width && counts.values > 0 && counts.others == 0;
            is_whole && has_number(row) && !is_of_heading(row)
        };
        let is_mostly = |row: &Vec<String>| {
            let counts = self.counts_of(row);
            row.len() == self.width && counts.values > counts.others && has_number(row)
        };
        let Some(mut first) = self.rows.iter().position(is_row) else {
            return self.rows.len();
        };
        while first > 0 && is_mostly(&self.rows[first - 1]) {
            first -= 1;
        }
        // Rows of texts with a time, as of states, stand below the names too.
        let are_units = |row: &Vec<String>| row.iter().all(|it| it.is_empty() || is_unit(it));
        let is_stamped =
            |row: &Vec<String>| row.len() == self.width && has_number(row) && !are_units(row);
        let stamped = self.rows[..first]
            .iter()
            .rev()
            .take_while(|it| is_stamped(it))
            .count();
        let head = (first - stamped).checked_sub(1).map(|it| &self.rows[it]);
        if head.is_some_and(|it| it.len() == self.width && has_time(it)) {
            first -= stamped;
        }
        // As pandas numbers columns without names.
        let is_numbered = |row: &[String]| {
            let mut rest = row.iter().skip(1).enumerate();
            row.len() > 2 && row[0].is_empty() && rest.all(|(k, cell)| *cell == k.to_string())
        };
        first + usize::from(is_numbered(&self.rows[first]))
    }

    /// The names before the first row, with their line, and the units in between.
    fn names(&self, first: usize, by_blanks: bool) -> Option<(usize, Vec<String>, Vec<String>)> {
        let line = |row: usize| attached(self.rows[row].clone(), by_blanks);
        let near = |names: &Vec<String>| {
            let is_r = || names.len() + 1 == self.width && self.counts(0, first);
            let fits = match by_blanks {
                true => names.len() == self.width || is_r(),
                false => names.len() > 1,
            };
            fits && names.iter().any(|it| !it.is_empty())
        };
        let mut at = first.checked_sub(1)?;
        let mut names = Some(line(at)).filter(near)?;
        let mut units = Vec::new();
        let is_units = |it: &String| it.is_empty() || is_unit(it);
        let bare = |it: &String| it.trim_matches(['[', ']', '(', ')']).to_owned();
        while at > 0 {
            let fits = |row: &Vec<String>| near(row) && row.len() == names.len();
            let is_of_time = |up: &usize| {
                let row = line(at - up);
                let is_below = names.iter().all(is_units) || are_units(&names, &row);
                fits(&row) && has_time(&row) && is_below && !row.iter().any(|it| is_value(it))
            };
            let upper = line(at - 1);
            let up = match (1..=at.min(MOST_UNITS)).find(is_of_time) {
                Some(up) if !by_blanks && !has_time(&names) => up,
                _ if !fits(&upper) => break,
                _ if names.iter().all(is_units) => 1,
                _ if !by_blanks && units.is_empty() && are_units(&names, &upper) => 1,
                _ => break,
            };
            let below = if up == 1 { names } else { line(at + 1 - up) };
            units = below.iter().map(bare).collect();
            (at, names) = (at - up, line(at - up));
        }
        Some((at, names, units))
    }

    /// Whether a column is empty in all rows.
    fn is_empty(&self, column: usize) -> bool {
        self.kinds[column].values == 0 && self.kinds[column].others == 0
    }

    /// Whether the column's cells count up by one, or are texts.
    fn counts(&self, column: usize, first: usize) -> bool {
        let rows = self.rows[first..]
            .iter()
            .filter(|it| it.len() == self.width);
        let numbers: Vec<Option<f64>> = rows.map(|row| number(&row[column])).collect();
        self.kinds[column].values == 0
            || numbers.is_sorted_by(|a, b| a.zip(*b).is_some_and(|(a, b)| b - a == 1.0))
    }
}

fn has_time(names: &[String]) -> bool {
    names.iter().any(|it| time_unit::is_name(it))
}

/// Whether words below names are units. At least one unit must be known or belong to a time; all names must differ and cover each column, and no word
/// may be a number, a signal's letter or the name of a time.
fn are_units(words: &[String], names: &[String]) -> bool {
    let all: HashSet<&String> = names.iter().collect();
    let is_name = |it: &String| !it.is_empty() && !is_value(it);
    // A letter that is no unit names a signal.
    let is_word = |it: &String| (!is_value(it) && it.len() != 1) || is_unit(it);
    let is_known = |it: &String| !it.is_empty() && is_unit(it);
    all.len() == names.len()
        && names.iter().all(is_name)
        && words.iter().all(is_word)
        && (words.iter().any(is_known) || has_time(names))
        && !has_time(words)
}

/// Whether a cell of a row is a number or a time alone: `12 V` may be a name.
fn has_number(row: &[String]) -> bool {
    row.iter()
        .any(|it| number(it).is_some() || csv_time::is_time(it))
}

/// Whether a cell contains a number or a time.
fn is_value(cell: &str) -> bool {
    value(cell).is_some() || csv_time::is_time(cell)
}

/// Passes bytes on, and fails at a line that is longer than any table's. On request, each run of blanks in a line becomes one tab; a number
/// of first lines is skipped.
pub(crate) struct Lines<R> {
    input: R,
    by_blanks: bool,
    /// Lines still to skip.
    skipped: u64,
    length: usize,
    /// Whether the last byte was a blank, or ended a line.
    is_blank: bool,
}

impl<R> Lines<R> {
    fn new(input: R, by_blanks: bool, skipped: u64) -> Self {
        Self {
            input,
            by_blanks,
            skipped,
            length: 0,
            is_blank: true,
        }
    }

    /// Removes bytes of skipped lines; returns how many bytes remain.
    fn skip(&mut self, bytes: &mut [u8]) -> usize {
        let mut at = 0;
        while self.skipped > 0 {
            let Some(end) = bytes[at..].iter().position(|it| *it == b'\n') else {
                return 0;
            };
            (at, self.skipped) = (at + end + 1, self.skipped - 1);
        }
        bytes.copy_within(at.., 0);
        bytes.len() - at
    }

    /// Replaces each run of blanks by one tab, or by nothing at the beginning of a line; returns how many bytes remain.
    fn squeeze(&mut self, bytes: &mut [u8]) -> usize {
        let mut kept = 0;
        for at in 0..bytes.len() {
            let byte = match bytes[at] {
                b' ' | b'\t' if self.is_blank => continue,
                b' ' | b'\t' => b'\t',
                byte => byte,
            };
            self.is_blank = matches!(byte, b'\t' | b'\n' | b'\r');
            bytes[kept] = byte;
            kept += 1;
        }
        kept
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = self.input.read(bytes)?;
            for byte in &bytes[..count] {
                self.length = if *byte == b'\n' { 0 } else { self.length + 1 };
                if self.length > LONGEST_LINE {
                    return Err(io::Error::other(format!(
                        "a line has more than {LONGEST_LINE} bytes: not a CSV file"
                    )));
                }
            }
            let left = match self.skipped {
                0 => count,
                _ => self.skip(&mut bytes[..count]),
            };
            let left = match self.by_blanks {
                true => self.squeeze(&mut bytes[..left]),
                false => left,
            };
            // Nothing left is no end.
            match left {
                0 if count > 0 => {}
                kept => return Ok(kept),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Form, Vec<Vec<String>>) {
        let form = Form::of(text.as_bytes()).unwrap().unwrap();
        let (mut reader, mut row) = (form.rows(text.as_bytes()), ByteRecord::new());
        let mut rows = Vec::new();
        while reader.read(&mut row).unwrap() {
            let text = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
            rows.push(row.iter().map(text).collect());
        }
        (form, rows)
    }

    #[test]
    fn tables_of_every_form_have_the_same_names_and_cells() {
        for text in [
            "a,b\n1,2\n3,4\n",
            "a;b\r\n1;2\r\n3;4",
            "a\tb\n1\t2\n3\t4\n",
            "  a   b \n 1  2\n\n  3\t 4\n",
            "# made by x;y;z\n\na, b\n1, 2\n# later\n3, 4\n",
            "# a, b\n1,2\n3,4\n",
            "% a b\n1 2\n3 4\n",
            "%a\tb\n1\t2\n3\t4\n",
            "\"a\",\"b\"\n1,2\n3,4\n",
        ] {
            let (form, rows) = read(text);
            assert_eq!(form.columns, ["a", "b"], "{text}");
            assert_eq!(rows, [["1", "2"], ["3", "4"]], "{text}");
        }
    }

    #[test]
    fn columns_without_names_are_counted_through() {
        for (text, cells) in [
            ("1,2\n3,4\n", ["1", "2"]),
            ("0,5;1,5\n1;2\n", ["0,5", "1,5"]),
            ("# of a rig\n0.5 nan\n", ["0.5", "nan"]),
            ("2024-01-01 00:00:00,\n", ["2024-01-01 00:00:00", ""]),
        ] {
            let (form, rows) = read(text);
            assert_eq!(form.columns, ["c1", "c2"], "{text}");
            assert_eq!(rows[0], cells, "{text}");
        }
    }

    #[test]
    fn what_parts_the_cells_is_what_two_rows_agree_on() {
        for (text, count) in [
            // A decimal comma in both rows, in one, in none.
            ("t;u;y\n0,1;2,5;3,5\n", 3),
            ("0,1;2,5;3\n1;2;3\n", 3),
            ("t;u, V;y\n0,1;2,5;3,5\n", 3),
            ("t,u;v,y\n0,1,2\n", 3),
            ("a;b\n", 2),
            ("x\n1\n", 1),
        ] {
            assert_eq!(read(text).0.columns.len(), count, "{text}");
        }
    }

    #[test]
    fn blanks_are_squeezed_wherever_a_read_ends() {
        let text = b"  a   b \n\t1  2\n";
        for size in 1..text.len() {
            let mut input = BufReader::with_capacity(size, Lines::new(&text[..], true, 0));
            let mut squeezed = String::new();
            input.read_to_string(&mut squeezed).unwrap();
            assert_eq!(squeezed, "a\tb\t\n1\t2\n");
        }
    }
}
