//! The bytes of a file from its beginning, unpacked if rosbag2 has packed the whole file with zstd.

use std::{
    fs::File,
    io::{self, BufReader, Read, Take},
    path::Path,
};

/// The size of one read.
pub(crate) const BUFFER: usize = 256 * 1024;

/// The first bytes of a zstd frame.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A packed file is unpacked to so many times its size at most: telemetry packs to a hundredth at best, a bomb to a
/// hundred-thousandth.
const MOST: u64 = 1000;

/// A file, read from its beginning.
pub(crate) enum Input {
    Plain(BufReader<File>),
    Packed(Box<Take<zstd::Decoder<'static, BufReader<File>>>>),
}

impl Input {
    /// The file at `path`.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let packed = is_packed(path)?;
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        let file = BufReader::with_capacity(BUFFER, file);
        Ok(if packed {
            let unpacked = zstd::Decoder::with_buffer(file)?;
            Self::Packed(Box::new(unpacked.take(size.saturating_mul(MOST))))
        } else {
            Self::Plain(file)
        })
    }
}

impl Read for Input {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(bytes),
            Self::Packed(file) => file.read(bytes),
        }
    }
}

/// Whether the file at `path` is packed with zstd, by its first bytes.
pub(crate) fn is_packed(path: &Path) -> io::Result<bool> {
    let mut first = Vec::new();
    File::open(path)?
        .take(ZSTD.len() as u64)
        .read_to_end(&mut first)?;
    Ok(first == ZSTD)
}
