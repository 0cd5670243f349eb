//! How a table is written: what parts its cells, whether a row of names stands in front, what is a comment.
//!
//! - Cells are parted by tabs, semicolons or commas, whichever the first two rows agree on, or else by blanks.
//! - A line that begins with `#` or `%` is a comment; the last one in front of the numbers holds the names, if it has as
//!   many cells as they have.
//! - A first row of numbers is no header: the columns are then `c1`, `c2` and so on.

use std::io::{self, BufRead, BufReader, Read};

use csv::{ByteRecord, Reader, ReaderBuilder};

use crate::csv_cell::{date, number};

/// The longest line taken, bytes.
const LONGEST_LINE: usize = 1 << 20;

/// Comments and empty lines in front of a table at most.
const PREFACE: usize = 1000;

/// The form of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Form {
    delimiter: u8,
    /// Cells are parted by any number of blanks.
    by_blanks: bool,
    comment: u8,
    /// The first row holds the names.
    has_header: bool,
    /// The names of the columns.
    pub(crate) columns: Vec<String>,
}

impl Form {
    /// Finds the form of the table that `input` begins.
    ///
    /// # Errors
    /// When the input cannot be read, or a line is longer than any table's.
    pub(crate) fn of(input: impl Read) -> io::Result<Self> {
        let mut lines = BufReader::new(Lines::new(input, false));
        let mut comment: Option<Vec<u8>> = None;
        let mut first: Vec<Vec<u8>> = Vec::new();
        for _ in 0..PREFACE {
            let mut line = Vec::new();
            if lines.read_until(b'\n', &mut line)? == 0 {
                break;
            }
            let line = line.trim_ascii();
            match line.first() {
                None => {}
                Some(b'#' | b'%') if first.is_empty() => comment = Some(line.to_vec()),
                Some(_) => first.push(line.to_vec()),
            }
            if first.len() == 2 {
                break;
            }
        }
        let lines: Vec<&[u8]> = first.iter().map(Vec::as_slice).collect();
        let delimiter = delimiter(&lines);
        let mut form = Self {
            delimiter: delimiter.unwrap_or(b'\t'),
            by_blanks: delimiter.is_none(),
            comment: comment.as_ref().map_or(b'#', |line| line[0]),
            has_header: false,
            columns: Vec::new(),
        };
        let row = form.cells(lines.first().copied().unwrap_or_default());
        form.has_header = !row.iter().all(|it| is_value(it)) || row.iter().all(String::is_empty);
        form.columns = if form.has_header {
            row
        } else {
            let of_comment = comment.map(|line| form.cells(&line[1..]));
            let names = of_comment.filter(|names| names.len() == row.len());
            names.unwrap_or_else(|| (1..=row.len()).map(|k| format!("c{k}")).collect())
        };
        Ok(form)
    }

    /// The rows of a table of this form, without its header.
    pub(crate) fn rows<R: Read>(&self, input: R) -> Reader<Lines<R>> {
        ReaderBuilder::new()
            .delimiter(self.delimiter)
            .has_headers(self.has_header)
            .comment(Some(self.comment))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(Lines::new(input, self.by_blanks))
    }

    /// The cells of one line.
    fn cells(&self, line: &[u8]) -> Vec<String> {
        let mut row = ByteRecord::new();
        let form = Self {
            has_header: false,
            ..self.clone()
        };
        // A line of memory is always read.
        let _ = form.rows(line.trim_ascii()).read_byte_record(&mut row);
        let text = |cell| String::from_utf8_lossy(cell).into_owned();
        row.iter().map(text).collect()
    }
}

/// What parts the cells of these lines: tabs, semicolons or commas in equal number in the first two, or the one that the
/// first has most of; `None` for blanks.
fn delimiter(lines: &[&[u8]]) -> Option<u8> {
    let all = [b'\t', b';', b','];
    let count = |line: usize, sign: u8| {
        let mut is_quoted = false;
        let bytes = lines.get(line)?.iter().filter(|byte| {
            is_quoted ^= **byte == b'"';
            !is_quoted && **byte == sign
        });
        Some(bytes.count())
    };
    let agree = |sign: &u8| {
        let first = count(0, *sign).unwrap_or(0);
        first > 0 && count(1, *sign).is_none_or(|second| second == first)
    };
    let most = || {
        let present = all.into_iter().filter(|it| count(0, *it) > Some(0));
        present.max_by_key(|it| count(0, *it))
    };
    all.into_iter().find(agree).or_else(most)
}

/// Whether a cell holds what a column of numbers or times does, or nothing.
fn is_value(cell: &str) -> bool {
    cell.is_empty() || number(cell).is_some() || date(cell).is_some()
}

/// Passes bytes on, and fails in a line that is longer than any table's. A run of blanks in a line becomes one tab, if
/// asked for.
pub(crate) struct Lines<R> {
    input: R,
    by_blanks: bool,
    length: usize,
    /// The last byte was a blank, or ended a line.
    is_blank: bool,
}

impl<R> Lines<R> {
    fn new(input: R, by_blanks: bool) -> Self {
        Self {
            input,
            by_blanks,
            length: 0,
            is_blank: true,
        }
    }

    /// Makes one tab of each run of blanks, and none at the beginning of a line; returns how many bytes are left.
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
            if !self.by_blanks {
                return Ok(count);
            }
            // Nothing left is no end.
            match self.squeeze(&mut bytes[..count]) {
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
        let form = Form::of(text.as_bytes()).unwrap();
        let rows = form.rows(text.as_bytes()).into_byte_records();
        let text = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
        let rows = rows.map(|row| row.unwrap().iter().map(text).collect());
        (form, rows.collect())
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
            let mut input = BufReader::with_capacity(size, Lines::new(&text[..], true));
            let mut squeezed = String::new();
            input.read_to_string(&mut squeezed).unwrap();
            assert_eq!(squeezed, "a\tb\t\n1\t2\n");
        }
    }
}
