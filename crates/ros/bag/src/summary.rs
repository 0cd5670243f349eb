//! The summary at the end of a closed file: topics, numbers of messages, time span.
//!
//! The summary is read as a stream, and used only if its checksum and its counts agree.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom},
};

use mcap::records::{Record as Parsed, Statistics};

use crate::{
    definitions::{Definitions, Known},
    fields::{self, op},
    input::BUFFER,
    limits::Limits,
    records::{Records, read_up_to},
    walk::is_read,
};

/// Size of the footer record and the magic after it: the last bytes of a closed file.
const TAIL: usize = 9 + 20 + 8;

/// Contents of a summary.
pub(crate) struct Summary {
    pub(crate) definitions: Definitions,
    /// Number of messages by channel.
    pub(crate) counts: BTreeMap<u16, u64>,
    /// Earliest and latest log time, ns.
    pub(crate) span: Option<(i64, i64)>,
}

/// Position of the summary (0 if there is none), if the file has the end of a closed file.
pub(crate) fn start(file: &mut File, size: u64) -> io::Result<Option<u64>> {
    let Some(start) = size.checked_sub(TAIL as u64) else {
        return Ok(None);
    };
    let mut tail = [0; TAIL];
    file.seek(SeekFrom::Start(start))?;
    if read_up_to(file, &mut tail)? < TAIL || !tail.ends_with(mcap::MAGIC) {
        return Ok(None);
    }
    Ok(match Records::new(&tail[..], start, 20).next(|_| true) {
        // Asked first: `parse_record` panics on a short attachment.
        Ok(Some(record)) if record.opcode == op::FOOTER => {
            match mcap::parse_record(op::FOOTER, record.body) {
                Ok(Parsed::Footer(footer)) => Some(footer.summary_start),
                _ => None,
            }
        }
        _ => None,
    })
}

/// Reads the summary; `None` if it is missing or inconsistent.
pub(crate) fn read(file: &mut File, start: u64, size: u64, limits: &Limits) -> Option<Summary> {
    // The footer's last four bytes before the magic are the checksum of all from `start` to them.
    let end = size.checked_sub(8 + 4)?;
    let length = end.checked_sub(start)?;
    if start == 0 {
        return None;
    }
    file.seek(SeekFrom::Start(start)).ok()?;
    let mut input = BufReader::with_capacity(BUFFER, file);
    let mut summed = Summed {
        input: (&mut input).take(length),
        sum: crc32fast::Hasher::new(),
    };
    let mut definitions = Definitions::within(limits.definitions, None);
    let mut statistics: Option<Statistics> = None;
    let mut records = Records::new(&mut summed, start, limits.chunk);
    loop {
        let record = records.next(is_read).ok()??;
        match record.opcode {
            op::SCHEMA | op::CHANNEL => definitions.take(record.opcode, record.body).ok()?,
            op::STATISTICS => match mcap::parse_record(op::STATISTICS, record.body).ok()? {
                Parsed::Statistics(found) => statistics = Some(found),
                _ => return None,
            },
            op::FOOTER | op::SUMMARY_OFFSET => break,
            _ => {}
        }
    }
    io::copy(&mut summed, &mut io::sink()).ok()?;
    let sum = summed.sum.finalize();
    let mut saved = [0; 4];
    input.read_exact(&mut saved).ok()?;
    let saved = u32::from_le_bytes(saved);
    // A checksum of 0 stands for none.
    if saved != 0 && saved != sum {
        return None;
    }

    let statistics = statistics?;
    let counts = statistics.channel_message_counts;
    let counted = counts
        .values()
        .try_fold(0_u64, |sum, count| sum.checked_add(*count))?;
    let are_known = counts
        .keys()
        .all(|id| !matches!(definitions.topic(*id), Known::Unknown));
    if counted != statistics.message_count || !are_known {
        return None;
    }
    let span = if counted == 0 {
        None
    } else {
        Some((
            fields::time(statistics.message_start_time).ok()?,
            fields::time(statistics.message_end_time).ok()?,
        ))
    };
    Some(Summary {
        definitions,
        counts,
        span,
    })
}

/// Reader that computes the checksum of the bytes passing through.
struct Summed<R> {
    input: R,
    sum: crc32fast::Hasher,
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(bytes)?;
        self.sum.update(&bytes[..count]);
        Ok(count)
    }
}
