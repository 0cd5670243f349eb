//! What the fuzz targets share.

use std::fs::File;
use std::io::Write as _;
use std::os::fd::AsRawFd as _;
use std::path::PathBuf;

/// Bytes as a file that is nowhere on disk, for readers that want a path.
pub struct InMemory {
    file: File,
}

impl InMemory {
    /// A file of these bytes.
    pub fn file(bytes: &[u8]) -> Self {
        let flags = rustix::fs::MemfdFlags::CLOEXEC;
        let memory = rustix::fs::memfd_create("fuzz", flags).expect("a file in memory");
        let mut file = File::from(memory);
        file.write_all(bytes).expect("room in memory");
        Self { file }
    }

    /// A path that it can be opened by.
    pub fn path(&self) -> PathBuf {
        format!("/proc/self/fd/{}", self.file.as_raw_fd()).into()
    }
}

/// Some bytes of the input that choose, and the rest.
pub fn choice(data: &[u8]) -> Option<(u8, &[u8])> {
    data.split_first().map(|(first, rest)| (*first, rest))
}
