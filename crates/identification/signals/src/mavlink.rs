//! Telemetry logs of MAVLink (`.tlog`): each frame is preceded by the time of its reception, us since 1970 (mavlink.io, "Packet
//! Serialization").
//!
//! The log does not define the meaning of a frame's bytes. `mavlink.txt` defines 110 messages of the dialects minimal, standard, common and
//! ardupilotmega. Each has number, CRC seed, name, and the fields in the order of the wire, with their letter (as in Python's `struct`) and
//! the length of lists; `!` marks the field that distinguishes instances.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::rc::Rc;

use crate::ahead::Ahead;
use crate::binary::{number, size};
use crate::log_message::{LogMessage, LogReader};

const MESSAGES: &str = include_str!("mavlink.txt");

/// The size of a stamp, and of the longest frame, bytes.
const STAMP: usize = 8;
const LONGEST: usize = 10 + 255 + 2 + 13;

/// Maximum number of unknown message numbers that are listed.
const LISTED: usize = 10;

struct Field {
    letter: u8,
    /// Number of elements, for a list.
    count: Option<usize>,
    at: usize,
    is_instance: bool,
}

struct Definition {
    seed: u8,
    name: &'static str,
    fields: Vec<Field>,
    /// The names of the numbers.
    numbers: Rc<[String]>,
}

/// The messages of a log.
pub(crate) struct Telemetry {
    file: Ahead,
    /// Definitions that have been needed so far.
    known: BTreeMap<u32, Option<Rc<Definition>>>,
    unknown: BTreeSet<u32>,
    skipped: u64,
}

/// A frame.
struct Frame {
    stamp: i64,
    sender: (u8, u8),
    id: u32,
    payload: std::ops::Range<usize>,
    /// Whether the frame is of version 2, which omits zeros at the end.
    is_cut: bool,
    length: usize,
}

impl Telemetry {
    pub(crate) fn of(file: File) -> Self {
        Self {
            file: Ahead::of(file),
            known: BTreeMap::new(),
            unknown: BTreeSet::new(),
            skipped: 0,
        }
    }
}

/// The frame at the beginning of the bytes, after its stamp.
fn frame(bytes: &[u8]) -> Option<Frame> {
    let stamp = u64::from_be_bytes(*bytes.first_chunk()?);
    let stamp = i64::try_from(stamp).ok()?.checked_mul(1000)?;
    let at = |place: usize| bytes.get(STAMP + place).copied();
    let size = usize::from(at(1)?);
    let (head, tail, sender, id) = match at(0)? {
        0xfe => (6, 2, (at(3)?, at(4)?), u32::from(at(5)?)),
        0xfd => {
            let signature = if at(2)? & 1 == 1 { 13 } else { 0 };
            let id = u32::from_le_bytes([at(7)?, at(8)?, at(9)?, 0]);
            (10, 2 + signature, (at(5)?, at(6)?), id)
        }
        _ => return None,
    };
    let start = STAMP + head;
    Some(Frame {
        stamp,
        sender,
        id,
        payload: start..start + size,
        is_cut: head == 10,
        length: start + size + tail,
    })
    .filter(|it| it.length <= bytes.len())
}

/// The checksum of a frame without its first byte, including the seed (X.25).
fn checksum(bytes: &[u8], seed: u8) -> u16 {
    bytes.iter().chain([&seed]).fold(0xffff, |crc: u16, byte| {
        let low = byte ^ (crc & 0xff) as u8;
        let low = u16::from(low ^ (low << 4));
        (crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
    })
}

fn definition(id: u32) -> Option<Definition> {
    let line = MESSAGES
        .lines()
        .find(|it| it.split(' ').next().and_then(|it| it.parse().ok()) == Some(id))?;
    let mut words = line.split(' ').skip(1);
    let (seed, name) = (words.next()?.parse().ok()?, words.next()?);
    let (mut fields, mut numbers, mut at) = (Vec::new(), Vec::new(), 0);
    while let (Some(kind), Some(name)) = (words.next(), words.next()) {
        let letter = *kind.as_bytes().first()?;
        let count = kind[1..].trim_end_matches('!').parse().ok();
        let is_instance = kind.ends_with('!');
        match count {
            _ if letter == b'c' => {}
            None => numbers.push(name.to_owned()),
            Some(count) => numbers.extend((0..count).map(|k| format!("{name}[{k}]"))),
        }
        fields.push(Field {
            letter,
            count,
            at,
            is_instance,
        });
        at += size(letter)? * count.unwrap_or(1);
    }
    Some(Definition {
        seed,
        name,
        fields,
        numbers: numbers.into(),
    })
}

impl LogReader for Telemetry {
    fn next(&mut self, message: &mut LogMessage) -> io::Result<bool> {
        loop {
            let bytes = self.file.bytes(2 * (STAMP + LONGEST))?;
            if bytes.is_empty() {
                return Ok(false);
            }
            let known = &mut self.known;
            let found = frame(bytes).and_then(|frame| {
                let behind = &bytes[frame.length..];
                let known = known
                    .entry(frame.id)
                    .or_insert_with(|| definition(frame.id).map(Rc::new));
                let is_whole = match known {
                    Some(definition) => {
                        let end = frame.payload.end;
                        let sum = u16::from_le_bytes(*bytes.get(end..)?.first_chunk()?);
                        checksum(&bytes[STAMP + 1..end], definition.seed) == sum
                    }
                    // Its seed is not known: another frame follows, or nothing.
                    None => behind.is_empty() || matches!(behind.get(STAMP), Some(0xfe | 0xfd)),
                };
                is_whole.then(|| (frame, known.clone()))
            });
            let Some((frame, definition)) = found else {
                self.file.pass(1);
                self.skipped += 1;
                continue;
            };
            let mut payload = bytes[frame.payload.clone()].to_vec();
            self.file.pass(frame.length);
            let Some(definition) = definition else {
                self.unknown.insert(frame.id);
                continue;
            };
            if frame.is_cut {
                payload.resize(payload.len().max(255), 0);
            }
            definition.read(&payload, &frame, message);
            return Ok(true);
        }
    }

    fn position(&self) -> u64 {
        self.file.position()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.skipped > 0 {
            notes.push(format!(
                "{} bytes belong to no frame: the log is damaged at these places, or cut off",
                self.skipped
            ));
        }
        if !self.unknown.is_empty() {
            let ids = self.unknown.iter().take(LISTED).map(u32::to_string);
            let more = if self.unknown.len() > LISTED {
                ", ..."
            } else {
                ""
            };
            notes.push(format!(
                "messages with the numbers {}{more} are not known and not read; `mavlogdump.py --types NAME --format csv FILE > NEW.csv` converts them",
                ids.collect::<Vec<_>>().join(", ")
            ));
        }
        notes
    }
}

impl Definition {
    fn read(&self, payload: &[u8], frame: &Frame, message: &mut LogMessage) {
        message.begin(self.name, frame.stamp, &self.numbers);
        message.labels[0] = format!("{}.{}", frame.sender.0, frame.sender.1);
        for field in &self.fields {
            let bytes = payload.get(field.at..).unwrap_or_default();
            if field.letter == b'c' {
                let text = &bytes[..bytes.len().min(field.count.unwrap_or(1))];
                let text = text.split(|it| *it == 0).next().unwrap_or_default();
                if field.is_instance {
                    message.labels[1] = String::from_utf8_lossy(text).into_owned();
                }
                continue;
            }
            let size = size(field.letter).unwrap_or_default();
            for element in 0..field.count.unwrap_or(1) {
                let bytes = bytes.get(element * size..).unwrap_or_default();
                message.values.push(number(field.letter, bytes));
            }
            if field.is_instance {
                let value = message.values.last().copied().flatten();
                message.labels[1] = value.map_or(String::new(), |it| it.to_string());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_definition_is_one() {
        for line in MESSAGES.lines() {
            let id = line.split(' ').next().unwrap().parse().unwrap();
            let definition = definition(id).unwrap();
            let words = line.split(' ').count();
            assert_eq!(definition.fields.len() * 2 + 3, words, "{line}");
            let last = definition.fields.last().unwrap();
            let end = last.at + size(last.letter).unwrap() * last.count.unwrap_or(1);
            assert!(end <= 255, "{line}");
        }
        // The check value of CRC-16/MCRF4XX, and seeds as mavlink.io gives them.
        assert_eq!(checksum(b"12345678", b'9'), 0x6f91);
        for (id, seed) in [(0, 50), (30, 39), (36, 222)] {
            assert_eq!(definition(id).unwrap().seed, seed);
        }
    }
}
