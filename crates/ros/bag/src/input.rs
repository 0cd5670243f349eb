//! The bytes of a file from its beginning, unpacked if rosbag2 has packed the whole file with zstd.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Take},
    path::Path,
};

/// The size of one read.
pub(crate) const BUFFER: usize = 256 * 1024;

/// The first bytes of a zstd frame.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A packed file is unpacked to so many times its size at most: telemetry packs to a hundredth at best, a bomb to a
/// hundred-thousandth.
const MAX_EXPANSION: u64 = 1000;

/// A file, read from its beginning.
pub(crate) enum Input {
    Plain(BufReader<File>),
    Packed(Box<Take<zstd::Decoder<'static, BufReader<File>>>>),
}

impl Input {
    /// The file at `path`.
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

    /// Whether it is unpacked as it is read.
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
