//! A file that is read with a look ahead, as formats that are found again after damage need.

use std::fs::File;
use std::io::{self, Read};

/// The bytes read at once: several times as many as anybody looks ahead.
const ROOM: usize = 1 << 20;

/// A file, from the first byte that is not used up.
pub(crate) struct Ahead {
    file: File,
    buffer: Vec<u8>,
    start: usize,
    position: u64,
}

impl Ahead {
    pub(crate) fn of(file: File) -> Self {
        Self {
            file,
            buffer: Vec::new(),
            start: 0,
            position: 0,
        }
    }

    /// The next bytes: at least so many, unless the file ends before.
    pub(crate) fn bytes(&mut self, count: usize) -> io::Result<&[u8]> {
        if self.buffer.len() - self.start < count {
            self.buffer.drain(..self.start);
            self.start = 0;
            let room = (ROOM.max(count) - self.buffer.len()) as u64;
            (&mut self.file).take(room).read_to_end(&mut self.buffer)?;
        }
        Ok(&self.buffer[self.start..])
    }

    /// Uses so many bytes up.
    pub(crate) fn pass(&mut self, count: usize) {
        let count = count.min(self.buffer.len() - self.start);
        self.start += count;
        self.position += count as u64;
    }

    /// The bytes used up.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }
}
