//! Logs of MOOS (`.alog`): each line has a time in seconds since the log's start, a variable, its source, and its value (MOOS-IvP, "The
//! Alog Toolbox").
//!
//! A numeric value becomes the field `value`; each number of `X=1.5,Y=2` becomes a field.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::rc::Rc;

use crate::csv_cell::{decimal, number};
use crate::log_message::{FIELDS, LogMessage, LogReader, VALUE};
use crate::time_unit::TimeUnit;

/// The longest line, bytes; the rest is read as a new line.
const LONGEST: u64 = 1 << 20;

/// The messages of a log.
pub(crate) struct Alog {
    file: BufReader<File>,
    position: u64,
    line: Vec<u8>,
    of_number: Rc<[String]>,
    refused: u64,
}

impl Alog {
    pub(crate) fn of(file: File) -> Self {
        Self {
            file: BufReader::new(file),
            position: 0,
            line: Vec::new(),
            of_number: [VALUE.to_owned()].into(),
            refused: 0,
        }
    }

    /// Reads a line as a message; `None` if it has no number.
    fn read(&self, line: &str, message: &mut LogMessage) -> Option<()> {
        let (time, rest) = line.split_once(char::is_whitespace)?;
        let (variable, rest) = rest.trim_start().split_once(char::is_whitespace)?;
        let (_source, value) = rest.trim_start().split_once(char::is_whitespace)?;
        let (stamp, value) = (decimal(time, TimeUnit::S)?, value.trim());
        if let Some(number) = number(value) {
            message.begin(variable, stamp, &self.of_number);
            message.values.push(Some(number));
            return Some(());
        }
        let pair = |it: &str| {
            let (name, value) = it.split_once('=')?;
            Some((name.trim().to_owned(), Some(number(value.trim())?)))
        };
        let pairs = value.split([',', '#']).take(FIELDS).filter_map(pair);
        let (names, values): (Vec<String>, Vec<_>) = pairs.unzip();
        (!names.is_empty()).then_some(())?;
        message.begin(variable, stamp, &names.into());
        message.values = values;
        Some(())
    }
}

impl LogReader for Alog {
    fn next(&mut self, message: &mut LogMessage) -> io::Result<bool> {
        loop {
            self.line.clear();
            let count = (&mut self.file)
                .take(LONGEST)
                .read_until(b'\n', &mut self.line)?;
            if count == 0 {
                return Ok(false);
            }
            self.position += count as u64;
            let line = std::str::from_utf8(&self.line).unwrap_or_default().trim();
            if line.starts_with('%') {
                continue;
            }
            if self.read(line, message).is_some() {
                return Ok(true);
            }
            let has_time = line
                .split_whitespace()
                .next()
                .is_some_and(|it| it.parse::<f64>().is_ok());
            self.refused += u64::from(!line.is_empty() && !has_time);
        }
    }

    fn position(&self) -> u64 {
        self.position
    }

    fn notes(&self) -> Vec<String> {
        let note = || format!("{} lines do not begin with a time", self.refused);
        (self.refused > 0).then(note).into_iter().collect()
    }
}
