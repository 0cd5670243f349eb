//! Memory limits and message order for reading a bag.

/// Memory limits for reading a bag. The defaults are far above the needs of ordinary bags, and protect against hostile bags. Memory is used for at
/// most one record, its unpacked chunk, one message and the topics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest record, and largest unpacked chunk, bytes. Default 128 MiB; recorders write about 1 MiB.
    pub chunk: u64,
    /// Memory for all topics and their types, bytes. Default 192 MiB, enough for a million topics; a busy bag needs 1 MiB. Topics beyond the
    /// limit are reported by [`BagReader::omitted`](crate::BagReader::omitted).
    pub definitions: u64,
    /// Largest total of unpacked chunks and messages per file, bytes; the rest is not read. No limit by default. Separately compressed messages
    /// count twice: in their chunk, and unpacked.
    pub unpacked: u64,
}

impl Limits {
    /// The defaults, with a limit of unpacked bytes per file if one is given.
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

/// Order in which messages are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The order in the file.
    #[default]
    File,
    /// The order of log time (equal times in file order). Messages that are out of order are sorted, with up to [`SORTED`](crate::reader::SORTED)
    /// bytes in memory. Their sequence numbers are then 0, because the numbers may count the file order. Messages stay in file order if only the
    /// clock was set back now and then.
    LogTime,
}
