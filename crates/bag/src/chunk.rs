//! A chunk's contents: unpacked within a limit, and checked.

use std::io::Read;

use crate::{fields::Chunk, reader::Limits};

/// Unpacks a chunk's records as its header says, and checks length and checksum.
///
/// # Errors
/// A sentence that says what is wrong.
pub(crate) fn unpack(chunk: &Chunk<'_>, limits: &Limits) -> Result<Vec<u8>, String> {
    let packed = chunk.packed;
    let length = chunk.unpacked_size;
    if length > limits.chunk {
        return Err(format!(
            "a chunk claims {length} bytes unpacked; at most {} are taken",
            limits.chunk
        ));
    }
    let records = match chunk.compression {
        "" => packed.to_vec(),
        "zstd" => unpack_stream(
            zstd::stream::read::Decoder::with_buffer(packed).map_err(|e| e.to_string())?,
            length,
        )?,
        "lz4" => unpack_stream(lz4_flex::frame::FrameDecoder::new(packed), length)?,
        other => {
            return Err(format!(
                "a chunk is compressed with '{}'; none, zstd and lz4 are read",
                other.escape_default()
            ));
        }
    };
    if records.len() as u64 != length {
        return Err(format!(
            "a chunk holds {} bytes, its header says {length}",
            records.len()
        ));
    }
    // A checksum of 0 stands for none; rosbag2 writes none.
    if chunk.crc != 0 && crc32fast::hash(&records) != chunk.crc {
        return Err("a chunk's checksum does not match its bytes".to_owned());
    }
    Ok(records)
}

/// All of `unpacked`, which ought to be `length` bytes; one more is read to see if it is not.
fn unpack_stream(unpacked: impl Read, length: u64) -> Result<Vec<u8>, String> {
    let mut records = Vec::new();
    unpacked
        .take(length.saturating_add(1))
        .read_to_end(&mut records)
        .map_err(|error| format!("a chunk does not unpack: {error}"))?;
    Ok(records)
}
