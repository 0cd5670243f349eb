//! MCAP's framing: bytes into records.
//!
//! A file is the magic, then records, then the magic again; a chunk's contents are records
//! too. A record is an opcode (1 byte), a length (8 bytes, little endian) and that many bytes
//! (MCAP specification, "Records"). A length is only what the file claims: the bytes are
//! taken as they come, so a lying length costs no memory.
//!
//! `mcap`'s own `sans_io::LinearReader` is as fast, but loads each record whole: an attachment longer than the limit would end
//! the bag here, and a cut record would not say how many of its bytes are there. Inside a chunk it yields records before
//! the chunk has been unpacked to its end.

use std::io::{self, Read};
use std::ops::Range;

use crate::defect::Defect;

/// Opcode and length.
pub(crate) const FRAME: usize = 1 + 8;

/// Where and how a file stops being readable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Damage {
    /// The byte from which on nothing can be read: the start of the first bad record.
    pub(crate) offset: u64,
    /// The reason.
    pub(crate) reason: Defect,
}

/// Splits a stream into records.
pub(crate) struct Records<R> {
    input: R,
    /// Where the next record starts.
    offset: u64,
    /// The longest record taken.
    limit: u64,
    body: Vec<u8>,
}

/// One record.
pub(crate) struct Record<'a> {
    pub(crate) opcode: u8,
    /// Where it starts.
    pub(crate) offset: u64,
    /// Its bytes; none if it was not wanted.
    pub(crate) body: &'a [u8],
}

impl<R: Read> Records<R> {
    /// Records from `input`, whose first byte is at `offset`; none longer than `limit` bytes.
    pub(crate) fn new(input: R, offset: u64, limit: u64) -> Self {
        Self {
            input,
            offset,
            limit,
            body: Vec::new(),
        }
    }

    /// Where the next record starts.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// The next record; `None` where the input ends between two. A record whose opcode is not
    /// `wanted` is passed over, however long it is.
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

/// The record at byte `at` of a chunk's records: its opcode, and where its bytes lie; `None` at the end.
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

/// Fills `bytes` as far as `input` goes, and returns how far.
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
