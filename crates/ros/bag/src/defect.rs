//! What is wrong with a file's bytes.

/// What is wrong with a file's bytes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the texts say what the numbers are")]
pub enum Defect {
    /// What the operating system, or the database, says.
    #[error("{0}")]
    Unreadable(String),
    /// There is no end.
    #[error("it was not closed")]
    NotClosed,
    /// The data ends properly, the file does not.
    #[error("its index is cut off; every message is there")]
    IndexCut,
    /// A record was lost, or made unknown.
    #[error("its index lists {indexed} messages, {met} are there")]
    Index { indexed: u64, met: u64 },
    /// Opcode and length of a record are not all there.
    #[error("cut off inside a record's frame")]
    FrameCut,
    /// A record is not all there.
    #[error("cut off inside a record (opcode {opcode:#04x}): {there} of {length} bytes are there")]
    RecordCut { opcode: u8, there: u64, length: u64 },
    /// A record beyond the [limit](crate::Limits).
    #[error("a record (opcode {opcode:#04x}) claims {length} bytes; at most {limit} are taken")]
    RecordLength { opcode: u8, length: u64, limit: u64 },
    /// A record ends within a field.
    #[error("a record is shorter than its fields")]
    ShortRecord,
    /// A name or an encoding.
    #[error("a text is not UTF-8")]
    Text,
    /// Beyond 63 bits.
    #[error("the time {0} ns is beyond what ROS can count")]
    Time(u64),
    /// A chunk's packed bytes are not all there.
    #[error("a chunk claims {length} bytes, {there} are there")]
    ChunkCut { length: u64, there: usize },
    /// A chunk beyond the [limit](crate::Limits).
    #[error("a chunk claims {length} bytes unpacked; at most {limit} are taken")]
    ChunkLength { length: u64, limit: u64 },
    /// Chunks, or messages packed one by one, beyond the [limit](crate::Limits) of all together.
    #[error("it unpacks to more than the {0} bytes asked for")]
    Unpacked(u64),
    /// A chunk's packed bytes are damaged; what the decompressor says.
    #[error("a chunk that its header says holds {length} bytes does not unpack: {reason}")]
    ChunkPacked { length: u64, reason: String },
    /// A compression that is not read.
    #[error("a chunk is compressed with '{0}'; none, zstd and lz4 are read")]
    Compression(String),
    /// A chunk unpacks to another length.
    #[error("a chunk holds {there} bytes, its header says {length}")]
    ChunkHolds { there: usize, length: u64 },
    /// A chunk unpacks to other bytes.
    #[error("a chunk's checksum does not match its bytes")]
    Checksum,
    /// A message packed by itself is damaged; what the decompressor says.
    #[error("a message does not unpack: {0}")]
    MessagePacked(String),
    /// A message packed by itself is beyond the [limit](crate::Limits).
    #[error("a message unpacks to more than {0} bytes")]
    MessageLength(u64),
    /// A schema's number is given again, for another schema.
    #[error("schema {0} has two meanings")]
    Schema(u16),
    /// A channel's number is given again, for another channel.
    #[error("channel {0} has two meanings")]
    Channel(u16),
    /// A channel's schema is not in the file.
    #[error("topic {topic} has the unknown schema {schema}")]
    UnknownSchema { topic: String, schema: u16 },
    /// A message's channel is not in the file.
    #[error("a message belongs to the unknown channel {0}")]
    UnknownChannel(u16),
    /// One of the others, in the records that a chunk holds.
    #[error("inside a chunk: {0}")]
    InChunk(Box<Defect>),
}
