//! A chunk's contents, and a message that rosbag2 has packed by itself: unpacked within a limit, and checked.

use std::io::Read;

use crate::{fields::Chunk, limits::Limits};

/// Unpacks a chunk's records into `records` as its header says, and checks length and checksum.
///
/// # Errors
/// A sentence that says what is wrong.
pub(crate) fn unpack(
    chunk: &Chunk<'_>,
    limits: &Limits,
    records: &mut Vec<u8>,
) -> Result<(), String> {
    let packed = chunk.packed;
    let length = chunk.unpacked_size;
    if length > limits.chunk {
        return Err(format!(
            "a chunk claims {length} bytes unpacked; at most {} are taken",
            limits.chunk
        ));
    }
    let garbled = |error| {
        format!("a chunk that its header says holds {length} bytes does not unpack: {error}")
    };
    records.clear();
    match chunk.compression {
        "" => records.extend_from_slice(packed),
        "zstd" => {
            records.reserve_exact(length as usize);
            zstd::bulk::Decompressor::new()
                .and_then(|mut zstd| zstd.decompress_to_buffer(packed, records))
                .map_err(garbled)?;
        }
        "lz4" => {
            // One byte more than there ought to be, to see whether there is.
            lz4_flex::frame::FrameDecoder::new(packed)
                .take(length.saturating_add(1))
                .read_to_end(records)
                .map_err(garbled)?;
        }
        other => {
            return Err(format!(
                "a chunk is compressed with '{}'; none, zstd and lz4 are read",
                other.escape_default()
            ));
        }
    }
    if records.len() as u64 != length {
        return Err(format!(
            "a chunk holds {} bytes, its header says {length}",
            records.len()
        ));
    }
    // A checksum of 0 stands for none; rosbag2 writes none.
    if chunk.crc != 0 && crc32fast::hash(records) != chunk.crc {
        return Err("a chunk's checksum does not match its bytes".to_owned());
    }
    Ok(())
}

/// Unpacks a message that rosbag2 has packed with zstd, to at most so many bytes.
///
/// # Errors
/// A sentence that says what is wrong.
pub(crate) fn unpack_message(packed: &[u8], most: u64) -> Result<Vec<u8>, String> {
    let mut payload = Vec::new();
    zstd::stream::read::Decoder::with_buffer(packed)
        .and_then(|zstd| zstd.take(most + 1).read_to_end(&mut payload))
        .map_err(|error| format!("a message does not unpack: {error}"))?;
    if payload.len() as u64 > most {
        return Err(format!("a message unpacks to more than {most} bytes"));
    }
    Ok(payload)
}
