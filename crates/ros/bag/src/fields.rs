//! The fields of the MCAP records that a reader needs, borrowed from the record's bytes.
//!
//! Layouts are those of the MCAP specification ("Records"): little-endian integers; strings and maps follow their length in bytes (4 bytes).
//! Footer and statistics are parsed by `mcap::parse_record`. That function does not parse the other records here, because it reserves as much memory as a
//! string claims (4 GiB from four hostile bytes), copies every string, and takes 1.4 times as long for a bag's messages.

use std::collections::BTreeMap;

use crate::defect::Defect;

/// Opcodes of the records that are read.
pub(crate) mod op {
    pub(crate) use mcap::records::op::{
        CHANNEL, CHUNK, DATA_END, FOOTER, HEADER, MESSAGE, SCHEMA, STATISTICS, SUMMARY_OFFSET,
    };
}

/// The remaining bytes of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], Defect> {
        let Some((taken, rest)) = self.0.split_at_checked(count) else {
            return Err(Defect::ShortRecord);
        };
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Defect> {
        let Some((taken, rest)) = self.0.split_first_chunk::<N>() else {
            return Err(Defect::ShortRecord);
        };
        self.0 = rest;
        Ok(*taken)
    }

    fn u16(&mut self) -> Result<u16, Defect> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Defect> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Defect> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes that follow their length.
    fn sized(&mut self) -> Result<&'a [u8], Defect> {
        let length = self.u32()?;
        self.bytes(length as usize)
    }

    fn text(&mut self) -> Result<&'a str, Defect> {
        std::str::from_utf8(self.sized()?).map_err(|_| Defect::Text)
    }
}

/// First record of the file.
pub(crate) struct Header<'a> {
    #[expect(dead_code, reason = "read so that a cut header is found out")]
    pub(crate) profile: &'a str,
    #[expect(dead_code, reason = "read so that a cut header is found out")]
    pub(crate) library: &'a str,
}

impl<'a> Header<'a> {
    pub(crate) fn read(body: &'a [u8]) -> Result<Self, Defect> {
        let mut fields = Fields(body);
        Ok(Self {
            profile: fields.text()?,
            library: fields.text()?,
        })
    }
}

/// A message type.
pub(crate) struct Schema<'a> {
    pub(crate) id: u16,
    pub(crate) name: &'a str,
    pub(crate) encoding: &'a str,
    pub(crate) data: &'a [u8],
}

impl<'a> Schema<'a> {
    pub(crate) fn read(body: &'a [u8]) -> Result<Self, Defect> {
        let mut fields = Fields(body);
        Ok(Self {
            id: fields.u16()?,
            name: fields.text()?,
            encoding: fields.text()?,
            data: fields.sized()?,
        })
    }
}

/// A channel: one topic.
pub(crate) struct Channel<'a> {
    pub(crate) id: u16,
    /// Number of the schema; 0 if there is none.
    pub(crate) schema_id: u16,
    pub(crate) topic: &'a str,
    pub(crate) message_encoding: &'a str,
    pub(crate) metadata: BTreeMap<&'a str, &'a str>,
}

impl<'a> Channel<'a> {
    pub(crate) fn read(body: &'a [u8]) -> Result<Self, Defect> {
        let mut fields = Fields(body);
        Ok(Self {
            id: fields.u16()?,
            schema_id: fields.u16()?,
            topic: fields.text()?,
            message_encoding: fields.text()?,
            metadata: {
                let mut pairs = Fields(fields.sized()?);
                let mut metadata = BTreeMap::new();
                while !pairs.0.is_empty() {
                    metadata.insert(pairs.text()?, pairs.text()?);
                }
                metadata
            },
        })
    }
}

/// A message record.
pub(crate) struct Message<'a> {
    pub(crate) channel_id: u16,
    pub(crate) sequence: u32,
    pub(crate) log_time: i64,
    pub(crate) publish_time: i64,
    pub(crate) payload: &'a [u8],
}

impl<'a> Message<'a> {
    pub(crate) fn read(body: &'a [u8]) -> Result<Self, Defect> {
        let mut fields = Fields(body);
        Ok(Self {
            channel_id: fields.u16()?,
            sequence: fields.u32()?,
            log_time: time(fields.u64()?)?,
            publish_time: time(fields.u64()?)?,
            payload: fields.0,
        })
    }
}

/// A time as ROS stores it, ns.
pub(crate) fn time(nanoseconds: u64) -> Result<i64, Defect> {
    i64::try_from(nanoseconds).map_err(|_| Defect::Time(nanoseconds))
}

/// A chunk: several records, possibly compressed.
pub(crate) struct Chunk<'a> {
    pub(crate) unpacked_size: u64,
    /// Checksum of the unpacked bytes; 0 if there is none.
    pub(crate) crc: u32,
    /// Name of the compression; empty for uncompressed data.
    pub(crate) compression: &'a str,
    pub(crate) packed: &'a [u8],
}

impl<'a> Chunk<'a> {
    pub(crate) fn read(body: &'a [u8]) -> Result<Self, Defect> {
        let mut fields = Fields(body);
        let [_earliest, _latest] = [fields.u64()?, fields.u64()?];
        Ok(Self {
            unpacked_size: fields.u64()?,
            crc: fields.u32()?,
            compression: fields.text()?,
            packed: {
                let length = fields.u64()?;
                let there = fields.0.len();
                usize::try_from(length)
                    .ok()
                    .and_then(|length| fields.bytes(length).ok())
                    .ok_or(Defect::ChunkCut { length, there })?
            },
        })
    }
}
