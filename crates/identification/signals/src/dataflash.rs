//! ArduPilot's log format DataFlash (`.bin`), which describes itself (ArduPilot, `libraries/AP_Logger/LogStructure.h`).
//!
//! A message is `A3 95`, the number of its format, and its fields. A format definition is also a message: number, length, name, a letter for each
//! field, and the fields' names. Numbers are scaled by their format letter (`c`, `C`, `e`, `E` are hundredths, `L` is 1e-7 degrees), the same as in
//! ArduPilot's own tools. `FMTU` marks the field that distinguishes instances with `#`.

use std::fs::File;
use std::io;
use std::rc::Rc;

use crate::ahead::Ahead;
use crate::binary;
use crate::log_message::{LogMessage, LogReader};

const HEAD: [u8; 2] = [0xa3, 0x95];

/// The number and the length of the formats' own format.
const FORMAT: u8 = 128;
const FORMAT_LENGTH: usize = 89;

/// The format of one kind of message.
#[derive(Clone, Debug)]
struct Format {
    length: usize,
    name: String,
    /// Every field: its name, its letter, and where it begins.
    fields: Vec<(String, u8, usize)>,
    /// The names of the numeric fields.
    numbers: Rc<[String]>,
    /// The stamp's field, and its unit in ns.
    time: Option<(usize, i64)>,
    /// The field with the instance's number.
    instance: Option<usize>,
}

/// The messages of a log.
pub(crate) struct DataFlash {
    file: Ahead,
    formats: Vec<Option<Rc<Format>>>,
    skipped: u64,
}

impl DataFlash {
    /// The messages of a log; `None` if the file is not such a log.
    pub(crate) fn of(file: File) -> io::Result<Option<Self>> {
        let mut file = Ahead::of(file);
        let is_log = file.bytes(3)?.starts_with(&[HEAD[0], HEAD[1], FORMAT]);
        let formats = vec![None; 256];
        Ok(is_log.then_some(Self {
            file,
            formats,
            skipped: 0,
        }))
    }

    fn take_format(&mut self, body: &[u8]) -> Option<()> {
        let text = |from: usize, to: usize| {
            let bytes = body.get(from..to)?;
            let end = bytes.iter().position(|it| *it == 0).unwrap_or(bytes.len());
            std::str::from_utf8(&bytes[..end]).ok()
        };
        let (number, length) = (*body.first()?, usize::from(*body.get(1)?));
        let (name, letters, names) = (text(2, 6)?, text(6, 22)?, text(22, 86)?);
        let mut fields = Vec::new();
        let mut at = 0;
        for (letter, name) in letters.bytes().zip(names.split(',')) {
            fields.push((name.to_owned(), letter, at));
            at += size(letter)?;
        }
        // What does not lie as it says is not read.
        (at + 3 == length && fields.len() == letters.len()).then_some(())?;
        let place = |name: &str| fields.iter().position(|it| it.0 == name);
        let time = place("TimeUS").map(|it| (it, 1000));
        let time = time.or(place("TimeMS").map(|it| (it, 1_000_000)));
        // Without units: the I of a controller is a number like any other.
        let instance = fields
            .get(1)
            .filter(|it| it.1 == b'B' && matches!(it.0.as_str(), "I" | "Instance"));
        let is_number = |it: &&(String, u8, usize)| !matches!(it.1, b'n' | b'N' | b'Z' | b'a');
        let numbers = fields.iter().filter(is_number);
        let numbers =
            numbers.filter(|it| Some(it.0.as_str()) != time.map(|it| fields[it.0].0.as_str()));
        self.formats[usize::from(number)] = Some(Rc::new(Format {
            length,
            name: name.to_owned(),
            numbers: numbers.map(|it| it.0.clone()).collect(),
            time,
            instance: instance.map(|_| 1),
            fields,
        }));
        Some(())
    }

    /// Reads the units of a format's fields; one unit marks the instance.
    fn take_units(&mut self, units: &Format, body: &[u8]) -> Option<()> {
        let field = |name: &str| units.fields.iter().find(|it| it.0 == name);
        let of = *body.get(field("FmtType")?.2)?;
        let ids = body.get(field("UnitIds")?.2..)?;
        let ids = ids.get(..16.min(ids.len()))?;
        let format = self.formats[usize::from(of)].as_mut()?;
        Rc::make_mut(format).instance = ids.iter().position(|it| *it == b'#');
        Some(())
    }
}

impl LogReader for DataFlash {
    fn next(&mut self, message: &mut LogMessage) -> io::Result<bool> {
        loop {
            let bytes = self.file.bytes(3 + 2 * 255)?;
            let [first, second, number, ..] = *bytes else {
                return Ok(false);
            };
            let format = self.formats[usize::from(number)].as_ref();
            let length = match number {
                FORMAT => Some(FORMAT_LENGTH),
                _ => format.map(|it| it.length),
            };
            // A message that another follows, or none.
            let behind = length.and_then(|length| bytes.get(length..));
            let is_whole =
                behind.is_some_and(|it| it.is_empty() || it.starts_with(&HEAD[..it.len().min(2)]));
            let (true, Some(length)) = ([first, second] == HEAD && is_whole, length) else {
                self.file.pass(1);
                self.skipped += 1;
                continue;
            };
            let body = bytes[3..length].to_vec();
            self.file.pass(length);
            if number == FORMAT {
                let _ = self.take_format(&body);
                continue;
            }
            let format = self.formats[usize::from(number)].clone();
            match format {
                Some(units) if units.name == "FMTU" => {
                    let _ = self.take_units(&units, &body);
                }
                Some(format) if format.read(&body, message).is_some() => return Ok(true),
                _ => {}
            }
        }
    }

    fn position(&self) -> u64 {
        self.file.position()
    }

    fn notes(&self) -> Vec<String> {
        let note = || {
            format!(
                "{} bytes belong to no message: the log is damaged at these places, or cut off",
                self.skipped
            )
        };
        (self.skipped > 0).then(note).into_iter().collect()
    }
}

impl Format {
    /// The numbers of a message; `None` if it has no time.
    fn read(&self, body: &[u8], message: &mut LogMessage) -> Option<()> {
        let (time, unit) = self.time?;
        let (_, letter, at) = self.fields[time];
        let bytes = body.get(at..)?;
        let stamp = match letter {
            b'Q' => u64::from_le_bytes(*bytes.first_chunk()?).try_into().ok()?,
            b'I' => i64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            _ => return None,
        };
        let stamp = i64::checked_mul(stamp, unit)?;
        message.begin(&self.name, stamp, &self.numbers);
        let instance = self.instance.and_then(|it| self.fields.get(it));
        if let Some((_, letter, at)) = instance {
            let instance = number(*letter, body.get(*at..)?)?;
            message.labels[1] = instance.to_string();
        }
        for (place, (_, letter, at)) in self.fields.iter().enumerate() {
            if place != time && !matches!(letter, b'n' | b'N' | b'Z' | b'a') {
                message.values.push(number(*letter, body.get(*at..)?));
            }
        }
        Some(())
    }
}

/// The size of a field, bytes.
fn size(letter: u8) -> Option<usize> {
    Some(match letter {
        b'M' => 1,
        b'c' | b'C' | b'g' => 2,
        b'e' | b'E' | b'L' | b'n' => 4,
        b'N' => 16,
        b'Z' | b'a' => 64,
        _ => return binary::size(letter),
    })
}

fn number(letter: u8, bytes: &[u8]) -> Option<f64> {
    let scaled = |letter, by| Some(binary::number(letter, bytes)? / by);
    match letter {
        b'c' => scaled(b'h', 100.0),
        b'C' => scaled(b'H', 100.0),
        b'e' => scaled(b'i', 100.0),
        b'E' => scaled(b'I', 100.0),
        b'L' => scaled(b'i', 1e7),
        b'M' => binary::number(b'B', bytes),
        b'g' => Some(half(u16::from_le_bytes(*bytes.first_chunk()?))),
        _ => binary::number(letter, bytes),
    }
}

/// A number of 16 bits (IEEE 754, binary16).
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (
        i32::from(bits >> 10 & 0x1f),
        f64::from(bits & 0x3ff) / 1024.0,
    );
    let size = match exponent {
        0 => fraction * 2_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2_f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}
