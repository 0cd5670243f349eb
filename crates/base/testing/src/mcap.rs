//! MCAP files put together byte by byte, so that they may lie. Layouts: the MCAP specification, "Records".

/// The magic at the start and the end of every file.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A record.
pub fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    lying_record(opcode, body.len() as u64, body)
}

/// A record that claims another length than it has.
pub fn lying_record(opcode: u8, claimed: u64, body: &[u8]) -> Vec<u8> {
    [&[opcode], &claimed.to_le_bytes()[..], body].concat()
}

/// A text or list of bytes behind its length.
pub fn sized(bytes: impl AsRef<[u8]>) -> Vec<u8> {
    let bytes = bytes.as_ref();
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

/// A file's beginning: magic and a header with two empty strings.
pub fn beginning() -> Vec<u8> {
    [MAGIC, &record(1, &[0; 8])].concat()
}

/// A file's end, without an index.
pub fn end() -> Vec<u8> {
    [
        record(0x0F, &[0; 4]),
        record(0x02, &[0; 20]),
        MAGIC.to_vec(),
    ]
    .concat()
}

/// A schema record.
pub fn schema(id: u16, name: &str, encoding: &str, text: impl AsRef<[u8]>) -> Vec<u8> {
    let texts = [sized(name), sized(encoding), sized(text)].concat();
    record(3, &[&id.to_le_bytes()[..], &texts].concat())
}

/// A channel record without metadata.
pub fn channel(id: u16, schema: u16, topic: &str, encoding: &str) -> Vec<u8> {
    let texts = [sized(topic), sized(encoding), sized("")].concat();
    record(
        4,
        &[&id.to_le_bytes()[..], &schema.to_le_bytes(), &texts].concat(),
    )
}

/// A message record without a number.
pub fn message(channel: u16, time: u64, payload: &[u8]) -> Vec<u8> {
    numbered_message(channel, 0, time, payload)
}

/// A message record.
pub fn numbered_message(channel: u16, number: u32, time: u64, payload: &[u8]) -> Vec<u8> {
    let mut body = channel.to_le_bytes().to_vec();
    body.extend(number.to_le_bytes());
    body.extend([time.to_le_bytes(), time.to_le_bytes()].concat());
    body.extend(payload);
    record(5, &body)
}

/// A chunk record whose header says what the caller wants.
pub fn chunk(compression: &str, claimed: u64, packed_claim: u64, packed: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(claimed.to_le_bytes());
    body.extend(0_u32.to_le_bytes());
    body.extend(sized(compression));
    body.extend(packed_claim.to_le_bytes());
    body.extend(packed);
    record(6, &body)
}
