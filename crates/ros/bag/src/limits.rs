//! Limits and order of reading a bag.

/// Limits on the memory that a bag may use. The defaults are far above what recorders write, and keep a hostile bag from taking
/// the memory: that is at most one record, its chunk unpacked, one message and the topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one record, and of one chunk when unpacked. 128 MiB; recorders write about 1.
    pub chunk: u64,
    /// Bytes that all topics and their types may take in memory. 192 MiB, a million topics; a busy bag takes 1. What is
    /// beyond is reported as [`BagReader::omitted`](crate::BagReader::omitted).
    pub definitions: u64,
    /// Bytes of all chunks and messages of one file when unpacked: what is beyond is not read. No limit. Messages that are packed one
    /// by one count twice: as the chunk holds them, and unpacked, each up to the limit.
    pub unpacked: u64,
}

impl Limits {
    /// The defaults, with so many unpacked bytes of a file at most, where there is a limit.
    #[must_use]
    pub fn unpacked(most: Option<u64>) -> Self {
        Self {
            unpacked: most.unwrap_or(u64::MAX),
            ..Self::default()
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            chunk: 128 << 20,
            definitions: 192 << 20,
            unpacked: u64::MAX,
        }
    }
}

/// The order of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// As written.
    #[default]
    File,
    /// By log time, equal times as written, where they are not written so ([`SORTED`](crate::reader::SORTED) bytes of them are in memory then).
    /// Their numbers, which may count them as written, are 0 then. A clock that is set back now and then leaves them as written: what follows is
    /// of another time.
    LogTime,
}
