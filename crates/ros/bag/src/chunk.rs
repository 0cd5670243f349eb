//! Unpacks a chunk, or a message that rosbag2 has compressed separately, within a limit, and checks the result.

use std::io::Read;

use crate::{defect::Defect, fields::Chunk, limits::Limits};

/// Unpacks a chunk's records into `records` and checks length and checksum against the chunk's header.
pub(crate) fn unpack(
    chunk: &Chunk<'_>,
    limits: &Limits,
    records: &mut Vec<u8>,
) -> Result<(), Defect> {
    let packed = chunk.packed;
    let length = chunk.unpacked_size;
    if length > limits.chunk {
        return Err(Defect::ChunkLength {
            length,
            limit: limits.chunk,
        });
    }
    let garbled = |error: std::io::Error| Defect::ChunkPacked {
        length,
        reason: error.to_string(),
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
        other => return Err(Defect::Compression(other.escape_default().to_string())),
    }
    if records.len() as u64 != length {
        return Err(Defect::ChunkHolds {
            there: records.len(),
            length,
        });
    }
    // A checksum of 0 stands for none; rosbag2 writes none.
    if chunk.crc != 0 && crc32fast::hash(records) != chunk.crc {
        return Err(Defect::Checksum);
    }
    Ok(())
}

/// Unpacks a message that rosbag2 has compressed with zstd. `unpacked` counts the bytes unpacked from its file so far.
pub(crate) fn unpack_message(
    packed: &[u8],
    limits: &Limits,
    unpacked: &mut u64,
) -> Result<Vec<u8>, Defect> {
    let mut payload = Vec::new();
    let left = limits.unpacked.saturating_sub(*unpacked);
    let most = limits.chunk.min(left);
    zstd::stream::read::Decoder::with_buffer(packed)
        .and_then(|zstd| zstd.take(most.saturating_add(1)).read_to_end(&mut payload))
        .map_err(|error| Defect::MessagePacked(error.to_string()))?;
    let length = payload.len() as u64;
    if length > left {
        return Err(Defect::Unpacked(limits.unpacked));
    }
    if length > most {
        return Err(Defect::MessageLength(most));
    }
    *unpacked += length;
    Ok(payload)
}
