//! Reads the messages of an `.mcap` file from front to back. Memory contains one record, its unpacked chunk, and the topics.

use std::{
    io::{self, Read, Take},
    ops::Range,
    sync::Arc,
};

use crate::{
    Topic, chunk,
    defect::Defect,
    definitions::{Channels, Definitions, Known},
    fields::{self, op},
    input::Input,
    limits::Limits,
    records::{Damage, Records, record_at},
};

/// A message as stored in the file.
pub(crate) struct Raw<'a> {
    pub(crate) topic: &'a Arc<Topic>,
    pub(crate) message: fields::Message<'a>,
}

/// Stream of a file's messages.
pub(crate) struct Walk {
    records: Records<Take<Input>>,
    limits: Limits,
    pub(crate) definitions: Definitions,
    /// Unpacked records of a chunk, or one message.
    unpacked: Vec<u8>,
    /// Number of bytes unpacked from chunks so far, plus those of messages outside chunks.
    unpacked_bytes: u64,
    left: Left,
    /// Number of messages so far, including those of omitted topics.
    pub(crate) met: u64,
    /// Whether the last record has been read.
    ended: bool,
    /// Whether the data section has a proper end.
    pub(crate) data_ended: bool,
}

/// Unpacked bytes that have not been returned yet.
enum Left {
    Nothing,
    /// One message.
    Message,
    /// Records from this byte on.
    From(usize),
}

impl Walk {
    /// The messages of an input up to the byte `readable`. `found`: the topics, if the file was read before.
    pub(crate) fn new(
        mut input: Input,
        readable: u64,
        limits: &Limits,
        found: Option<Arc<Channels>>,
    ) -> io::Result<Self> {
        let start = mcap::MAGIC.len() as u64;
        io::copy(&mut (&mut input).take(start), &mut io::sink())?;
        let rest = input.take(readable.saturating_sub(start));
        Ok(Self {
            records: Records::new(rest, start, limits.chunk),
            limits: limits.clone(),
            definitions: Definitions::within(limits.definitions, found),
            unpacked: Vec::new(),
            unpacked_bytes: 0,
            left: Left::Nothing,
            met: 0,
            ended: false,
            data_ended: false,
        })
    }

    /// The next message; `None` after the last one. A chunk is read completely or not at all.
    pub(crate) fn next(&mut self) -> Result<Option<Raw<'_>>, Damage> {
        let place = loop {
            match self.next_place() {
                Some(place) => {
                    self.met += 1;
                    if self.raw(place.clone()).is_some() {
                        break place;
                    }
                }
                None if self.ended => return Ok(None),
                None => self.next_record()?,
            }
        };
        Ok(self.raw(place))
    }

    /// Number of bytes of the file read.
    pub(crate) fn offset(&self) -> u64 {
        self.records.offset()
    }

    /// The message at this place; `None` if its topic is omitted.
    fn raw(&self, place: Range<usize>) -> Option<Raw<'_>> {
        let message = fields::Message::read(self.unpacked.get(place)?).ok()?;
        match self.definitions.topic(message.channel_id) {
            Known::Topic(topic) => Some(Raw { topic, message }),
            Known::Omitted | Known::Unknown => None,
        }
    }

    /// Place of the next unpacked message that has not been returned yet.
    fn next_place(&mut self) -> Option<Range<usize>> {
        let record = |at| record_at(&self.unpacked, at).ok().flatten();
        match &mut self.left {
            Left::Nothing => None,
            Left::Message => {
                self.left = Left::Nothing;
                Some(0..self.unpacked.len())
            }
            Left::From(at) => loop {
                let (opcode, place) = record(*at)?;
                *at = place.end;
                if opcode == op::MESSAGE {
                    return Some(place);
                }
            },
        }
    }

    /// Reads the next record of the file.
    fn next_record(&mut self) -> Result<(), Damage> {
        let Some(record) = self.records.next(is_read)? else {
            self.ended = true;
            return Ok(());
        };
        let offset = record.offset;
        let damage = |reason| Damage { offset, reason };
        match record.opcode {
            op::SCHEMA | op::CHANNEL => self
                .definitions
                .take(record.opcode, record.body)
                .map_err(damage)?,
            op::MESSAGE => {
                let size = record.body.len() as u64;
                within(&mut self.unpacked_bytes, size, &self.limits).map_err(damage)?;
                checked(record.body, &self.definitions).map_err(damage)?;
                self.unpacked.clear();
                self.unpacked.extend_from_slice(record.body);
                self.left = Left::Message;
            }
            op::CHUNK => {
                self.left = Left::Nothing;
                let chunk = fields::Chunk::read(record.body).map_err(damage)?;
                within(&mut self.unpacked_bytes, chunk.unpacked_size, &self.limits)
                    .map_err(damage)?;
                chunk::unpack(&chunk, &self.limits, &mut self.unpacked).map_err(damage)?;
                self.open_chunk()
                    .map_err(|reason| damage(Defect::InChunk(Box::new(reason))))?;
            }
            op::DATA_END | op::FOOTER => {
                self.ended = true;
                self.data_ended = true;
            }
            _ => {}
        }
        Ok(())
    }

    /// Checks all records of the unpacked chunk and reads its schemas and channels.
    fn open_chunk(&mut self) -> Result<(), Defect> {
        let mut at = 0;
        while let Some((opcode, place)) = record_at(&self.unpacked, at)? {
            let body = &self.unpacked[place.clone()];
            match opcode {
                op::SCHEMA | op::CHANNEL => self.definitions.take(opcode, body)?,
                op::MESSAGE => checked(body, &self.definitions)?,
                _ => {}
            }
            at = place.end;
        }
        self.left = Left::From(0);
        Ok(())
    }
}

/// Adds unpacked bytes to the total and checks the limit.
fn within(bytes: &mut u64, more: u64, limits: &Limits) -> Result<(), Defect> {
    *bytes = bytes.saturating_add(more);
    match *bytes > limits.unpacked {
        true => Err(Defect::Unpacked(limits.unpacked)),
        false => Ok(()),
    }
}

/// Checks that a message record is valid.
fn checked(body: &[u8], definitions: &Definitions) -> Result<(), Defect> {
    let message = fields::Message::read(body)?;
    match definitions.topic(message.channel_id) {
        Known::Topic(_) | Known::Omitted => Ok(()),
        Known::Unknown => Err(Defect::UnknownChannel(message.channel_id)),
    }
}

/// Whether a record contains messages or topics; others (attachments, indexes) are skipped.
pub(crate) fn is_read(opcode: u8) -> bool {
    matches!(
        opcode,
        op::FOOTER
            | op::SCHEMA
            | op::CHANNEL
            | op::MESSAGE
            | op::CHUNK
            | op::STATISTICS
            | op::DATA_END
            | op::SUMMARY_OFFSET
    )
}
