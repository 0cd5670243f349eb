//! The file that a bag is written to.

use std::{
    fs::File,
    io::{self, Write},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};

use mcap::{McapError, write::NoSeek};

/// Compression of chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// No compression: the least work per message.
    None,
    /// Zstandard at its default level, on the writing thread: reduces the size to a third or less.
    #[default]
    Zstd,
}

/// Creates a file; returns two handles to it.
pub(super) fn create_new(path: &Path) -> io::Result<(File, File)> {
    let file = File::create_new(path)?;
    let handle = file.try_clone()?;
    Ok((file, handle))
}

/// The part of an error that matters to the user: the operating system's message, if there is one.
pub(super) fn reason(error: McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// Starts an `.mcap` file.
pub(super) fn begin(
    output: Box<dyn Write + Send>,
    compression: Compression,
) -> Result<(mcap::Writer<NoSeek<Sink>>, Arc<Gate>), McapError> {
    let gate = Arc::new(Gate::default());
    let sink = Sink {
        output,
        gate: Arc::clone(&gate),
    };
    // Chunks are built in memory (no seeking), so that the file never holds half of one;
    // this writer alone decides when one ends (no chunk size).
    let mcap = mcap::WriteOptions::new()
        .profile("ros2")
        .library(concat!("planesman_bag ", env!("CARGO_PKG_VERSION")))
        .compression(match compression {
            Compression::None => None,
            Compression::Zstd => Some(mcap::Compression::Zstd),
        })
        .compression_threads(0)
        .chunk_size(None)
        .disable_seeking(true)
        .create(NoSeek::new(sink))?;
    Ok((mcap, gate))
}

/// State shared by the bag and its file: number of bytes written, and whether the file is still open for writing.
#[derive(Default)]
pub(super) struct Gate {
    pub(super) bytes: AtomicU64,
    pub(super) closed: AtomicBool,
}

/// The file, which refuses data once its gate is closed. The file is not buffered: a chunk is written at once, and the small records between chunks
/// are rare.
pub(super) struct Sink {
    output: Box<dyn Write + Send>,
    gate: Arc<Gate>,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.gate.closed.load(Ordering::Relaxed) {
            return Err(io::Error::other("the bag accepts no more data"));
        }
        let written = self.output.write(bytes)?;
        self.gate.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}
