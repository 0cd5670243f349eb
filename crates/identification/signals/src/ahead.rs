//! Reads a file with look-ahead; this is needed to resynchronise after damage.

use std::fs::File;
use std::io::{self, Read};

/// Bytes read at once, several times the longest look-ahead.
const ROOM: usize = 1 << 20;

/// A file, from the first unused byte on.
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

    /// The next bytes, at least `count` unless the file ends before.
    pub(crate) fn bytes(&mut self, count: usize) -> io::Result<&[u8]> {
        if self.buffer.len() - self.start < count {
            self.buffer.drain(..self.start);
            self.start = 0;
            let room = (ROOM.max(count) - self.buffer.len()) as u64;
            (&mut self.file).take(room).read_to_end(&mut self.buffer)?;
        }
        Ok(&self.buffer[self.start..])
    }

    /// Advances by this many bytes.
    pub(crate) fn pass(&mut self, count: usize) {
        let count = count.min(self.buffer.len() - self.start);
        self.start += count;
        self.position += count as u64;
    }

    /// The number of used bytes.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }
}
