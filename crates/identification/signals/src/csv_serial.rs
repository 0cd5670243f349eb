//! Lines printed by a microcontroller, as terminals show them: with a stamp in front (`10:00:00.000 -> 20,19.95`, Arduino's serial
//! monitor), or each number after its name (`pwm:20,speed:19.95`, Arduino's plotter; `pwm=20 speed=19.95`).

use csv::ByteRecord;

use crate::csv_cell::value;
use crate::csv_time;

/// The separator after the stamp.
const ARROW: &[u8] = b"->";

/// The share of lines that must have this form.
const MOST: f64 = 0.8;

/// Maximum number of names in a line.
const NAMES: usize = 1000;

/// The form of the lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct SerialForm {
    pub(crate) has_stamps: bool,
    /// The names before the numbers; empty if there are no names.
    pub(crate) names: Vec<String>,
}

fn is_most(lines: usize, of: usize) -> bool {
    lines > 1 && lines as f64 >= MOST * of as f64
}

/// The bytes before and after the first separator.
fn parted<'a>(cell: &'a [u8], by: &[u8]) -> Option<(&'a [u8], &'a [u8])> {
    let at = cell.windows(by.len()).position(|it| it == by)?;
    let (before, behind) = (&cell[..at], &cell[at + by.len()..]);
    Some((before.trim_ascii(), behind.trim_ascii()))
}

/// The name before a number, and the text after it.
fn named(cell: &[u8]) -> Option<(&[u8], &[u8])> {
    let sign = cell.iter().position(|it| matches!(it, b':' | b'='))?;
    let (name, number) = (cell[..sign].trim_ascii(), cell[sign + 1..].trim_ascii());
    let begins = |it: &u8| it.is_ascii_alphabetic() || *it == b'_' || !it.is_ascii();
    name.first().is_some_and(begins).then_some((name, number))
}

/// Names and numbers of a line; `None` if the line contains anything else. A blank between them is allowed.
fn pairs<'a>(cells: &[&'a [u8]]) -> Option<Vec<(&'a [u8], &'a [u8])>> {
    let mut pairs = Vec::new();
    let mut waiting = None;
    for cell in cells.iter().filter(|it| !it.is_empty()) {
        let (name, number) = match waiting.take() {
            Some(name) => (name, *cell),
            None => named(cell)?,
        };
        match number.is_empty() {
            true => waiting = Some(name),
            false => {
                value(std::str::from_utf8(number).ok()?)?;
                pairs.push((name, number));
            }
        }
    }
    (!pairs.is_empty() && waiting.is_none()).then_some(pairs)
}

impl SerialForm {
    /// Whether most lines begin with a stamp and an arrow.
    pub(crate) fn have_stamps<'a>(lines: impl ExactSizeIterator<Item = &'a [u8]>) -> bool {
        let of = lines.len();
        let is_stamped = |line: &&[u8]| {
            let stamp = parted(line, ARROW).and_then(|it| std::str::from_utf8(it.0).ok());
            stamp.is_some_and(csv_time::is_time)
        };
        is_most(lines.filter(is_stamped).count(), of)
    }

    /// Finds the names before the numbers of these rows, if most rows have them.
    pub(crate) fn find_names(&mut self, rows: &[Vec<String>]) {
        let mut names: Vec<String> = Vec::new();
        let mut count = 0;
        for row in rows {
            let cells: Vec<&[u8]> = row.iter().map(String::as_bytes).collect();
            let Some(pairs) = pairs(&cells[usize::from(self.has_stamps).min(cells.len())..]) else {
                continue;
            };
            count += 1;
            for (name, _) in pairs {
                let name = String::from_utf8_lossy(name);
                if names.len() < NAMES && !names.iter().any(|it| *it == name) {
                    names.push(name.into_owned());
                }
            }
        }
        if is_most(count, rows.len()) {
            self.names = names;
        }
    }

    /// Whether the lines have the form of an ordinary table.
    pub(crate) fn is_plain(&self) -> bool {
        !self.has_stamps && self.names.is_empty()
    }

    /// The cells of a line: its stamp, then the numbers in the order of their names.
    pub(crate) fn row(&self, row: &ByteRecord) -> ByteRecord {
        let mut cells: Vec<&[u8]> = row.iter().collect();
        if self.has_stamps {
            match cells.first().and_then(|it| parted(it, ARROW)) {
                Some((stamp, behind)) => {
                    cells[0] = stamp;
                    if !behind.is_empty() {
                        cells.insert(1, behind);
                    }
                }
                None if cells.get(1) == Some(&ARROW) => drop(cells.remove(1)),
                None => {}
            }
        }
        let stamp = usize::from(self.has_stamps).min(cells.len());
        if let Some(pairs) = pairs(&cells[stamp..]).filter(|_| !self.names.is_empty()) {
            cells.truncate(stamp);
            let number = |(at, name): (usize, &String)| {
                let is_it = |it: &&(&[u8], &[u8])| it.0 == name.as_bytes();
                let pair = pairs
                    .get(at)
                    .filter(is_it)
                    .or_else(|| pairs.iter().find(is_it));
                pair.map_or(&b""[..], |it| it.1)
            };
            cells.extend(self.names.iter().enumerate().map(number));
        }
        let mut changed = ByteRecord::from(cells);
        changed.set_position(row.position().cloned());
        changed
    }
}
