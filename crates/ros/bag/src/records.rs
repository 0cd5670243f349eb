//! Framing of MCAP: splits bytes into records.
//!
//! A file is the magic, records, and the magic again; a chunk also contains records. A record is an opcode (1 byte), a length (8 bytes, little
//! endian) and that many bytes (MCAP specification, "Records"). A length is only a claim of the file: bytes are read as they arrive, so a wrong
//! length costs no memory.
//!
//! `mcap`'s own `sans_io::LinearReader` is as fast, but loads each record completely: an attachment larger than the limit would end the bag
//! here, and a truncated record would not report how many of its bytes exist. Within a chunk it yields records before the whole chunk has been
//! unpacked.

use std::io::{self, Read};
use std::ops::Range;

use crate::defect::Defect;

/// Size of opcode and length, bytes.
pub(crate) const FRAME: usize = 1 + 8;

/// Position and reason at which a file becomes unreadable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Damage {
    /// Position of the first bad record, bytes.
    pub(crate) offset: u64,
    /// The reason.
    pub(crate) reason: Defect,
}

/// Splits a stream into records.
pub(crate) struct Records<R> {
    input: R,
    /// Position of the next record, bytes.
    offset: u64,
    /// Largest record that is read, bytes.
    limit: u64,
    body: Vec<u8>,
}

/// One record.
pub(crate) struct Record<'a> {
    pub(crate) opcode: u8,
    /// Position of the record, bytes.
    pub(crate) offset: u64,
    /// The record's bytes; empty if the record was skipped.
    pub(crate) body: &'a [u8],
}

impl<R: Read> Records<R> {
    /// Records of `input`, whose first byte is at `offset`; records larger than `limit` bytes are errors.
    pub(crate) fn new(input: R, offset: u64, limit: u64) -> Self {
        Self {
            input,
            offset,
            limit,
            body: Vec::new(),
        }
    }

    /// Position of the next record, bytes.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// The next record; `None` if the input ends between two records. Skips records whose opcode is not `wanted`, regardless of their length.
    pub(crate) fn next(&mut self, wanted: fn(u8) -> bool) -> Result<Option<Record<'_>>, Damage> {
        let start = self.offset;
        let damage = |reason| Damage {
            offset: start,
            reason,
        };
        let unreadable = |error: io::Error| damage(Defect::Unreadable(error.to_string()));

        let mut frame = [0; FRAME];
        let framed = read_up_to(&mut self.input, &mut frame).map_err(unreadable)?;
        if framed == 0 {
            return Ok(None);
        }
        if framed < frame.len() {
            return Err(damage(Defect::FrameCut));
        }
        let [opcode, length @ ..] = frame;
        let length = u64::from_le_bytes(length);

        self.body.clear();
        let taken = if !wanted(opcode) {
            io::copy(&mut (&mut self.input).take(length), &mut io::sink()).map_err(unreadable)?
        } else if length > self.limit {
            return Err(damage(Defect::RecordLength {
                opcode,
                length,
                limit: self.limit,
            }));
        } else {
            (&mut self.input)
                .take(length)
                .read_to_end(&mut self.body)
                .map_err(unreadable)? as u64
        };
        if taken < length {
            return Err(damage(Defect::RecordCut {
                opcode,
                there: taken,
                length,
            }));
        }
        self.offset = start.saturating_add(FRAME as u64).saturating_add(length);
        Ok(Some(Record {
            opcode,
            offset: start,
            body: &self.body,
        }))
    }
}

/// The record at byte `at` of a chunk's records: its opcode, and the range of its bytes; `None` at the end.
pub(crate) fn record_at(records: &[u8], at: usize) -> Result<Option<(u8, Range<usize>)>, Defect> {
    let Some(rest) = records.get(at..).filter(|rest| !rest.is_empty()) else {
        return Ok(None);
    };
    let Some((&[opcode, length @ ..], body)) = rest.split_first_chunk::<FRAME>() else {
        return Err(Defect::FrameCut);
    };
    let length = u64::from_le_bytes(length);
    let begin = at + FRAME;
    match usize::try_from(length) {
        Ok(length) if length <= body.len() => Ok(Some((opcode, begin..begin + length))),
        _ => Err(Defect::RecordCut {
            opcode,
            there: body.len() as u64,
            length,
        }),
    }
}

/// Reads into `bytes` until it is full or the input ends; returns the number of bytes.
pub(crate) fn read_up_to(input: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < bytes.len() {
        match input.read(&mut bytes[filled..]) {
            Ok(0) => break,
            Ok(more) => filled += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
