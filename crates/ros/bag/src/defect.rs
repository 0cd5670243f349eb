//! Defects of a bag file.

/// A defect of a bag file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the texts say what the numbers are")]
pub enum Defect {
    /// Error text of the operating system, or of the database.
    #[error("{0}")]
    Unreadable(String),
    /// The file has no end marker.
    #[error("the file was not closed")]
    NotClosed,
    /// All messages are there, but the index after the messages is cut off.
    #[error("the file's index is cut off, but all messages are there")]
    IndexCut,
    /// The index counts more messages than the file contains.
    #[error("the file's index lists {indexed} messages, but the file contains {met}")]
    Index { indexed: u64, met: u64 },
    /// The file ends within the opcode or length of a record.
    #[error("the file is cut off inside the frame of a record")]
    FrameCut,
    /// The file ends within a record.
    #[error(
        "the file is cut off inside a record (opcode {opcode:#04x}): {there} of {length} bytes are there"
    )]
    RecordCut { opcode: u8, there: u64, length: u64 },
    /// A record larger than the [limit](crate::Limits).
    #[error("a record (opcode {opcode:#04x}) claims {length} bytes; the limit is {limit}")]
    RecordLength { opcode: u8, length: u64, limit: u64 },
    /// A record ends within a field.
    #[error("a record is shorter than its fields")]
    ShortRecord,
    /// A name or encoding is not UTF-8.
    #[error("a text is not UTF-8")]
    Text,
    /// A time beyond 63 bits.
    #[error("the time {0} ns is too large for ROS")]
    Time(u64),
    /// The file ends within a chunk's compressed bytes.
    #[error("a chunk claims {length} bytes, but only {there} are there")]
    ChunkCut { length: u64, there: usize },
    /// A chunk larger than the [limit](crate::Limits).
    #[error("a chunk claims {length} bytes unpacked; the limit is {limit}")]
    ChunkLength { length: u64, limit: u64 },
    /// Chunks or compressed messages that exceed the total [limit](crate::Limits).
    #[error("its unpacked size exceeds the limit of {0} bytes")]
    Unpacked(u64),
    /// Damaged bytes of a chunk, with the decompressor's error.
    #[error("a chunk of {length} bytes (according to its header) cannot be unpacked: {reason}")]
    ChunkPacked { length: u64, reason: String },
    /// An unsupported compression.
    #[error("a chunk has the unsupported compression '{0}'; supported: none, zstd, lz4")]
    Compression(String),
    /// The unpacked length of a chunk differs from its header.
    #[error("a chunk contains {there} bytes, but its header says {length}")]
    ChunkHolds { there: usize, length: u64 },
    /// The checksum of a chunk does not match its unpacked bytes.
    #[error("a chunk's checksum does not match its bytes")]
    Checksum,
    /// A damaged compressed message, with the decompressor's error.
    #[error("a message cannot be unpacked: {0}")]
    MessagePacked(String),
    /// A compressed message larger than the [limit](crate::Limits).
    #[error("a message unpacks to more than {0} bytes")]
    MessageLength(u64),
    /// Two different schemas with the same number.
    #[error("two schemas have the same number {0}")]
    Schema(u16),
    /// Two different channels with the same number.
    #[error("two channels have the same number {0}")]
    Channel(u16),
    /// The schema of a channel is missing.
    #[error("topic {topic} refers to the unknown schema {schema}")]
    UnknownSchema { topic: String, schema: u16 },
    /// The channel of a message is missing.
    #[error("a message belongs to the unknown channel {0}")]
    UnknownChannel(u16),
    /// A defect in the records of a chunk.
    #[error("inside a chunk: {0}")]
    InChunk(Box<Defect>),
}
