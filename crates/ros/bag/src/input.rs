//! Reads a file from its beginning; decompresses it if rosbag2 compressed the whole file with zstd.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Take},
    path::Path,
};

/// Size of one read, bytes.
pub(crate) const BUFFER: usize = 256 * 1024;

/// The first bytes of a zstd frame.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Largest ratio of unpacked to packed size. Telemetry has a ratio of 100 at most, a decompression bomb of about 100,000.
const MAX_EXPANSION: u64 = 1000;

/// A file, read from its beginning.
pub(crate) enum Input {
    Plain(BufReader<File>),
    Packed(Box<Take<zstd::Decoder<'static, BufReader<File>>>>),
}

impl Input {
    /// Opens the file at `path`.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let size = file.metadata()?.len();
        let mut file = BufReader::with_capacity(BUFFER, file);
        if !file.fill_buf()?.starts_with(&ZSTD) {
            return Ok(Self::Plain(file));
        }
        let unpacked = zstd::Decoder::with_buffer(file)?;
        Ok(Self::Packed(Box::new(
            unpacked.take(size.saturating_mul(MAX_EXPANSION)),
        )))
    }

    /// Whether the file is decompressed while it is read.
    pub(crate) fn is_packed(&self) -> bool {
        matches!(self, Self::Packed(_))
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
