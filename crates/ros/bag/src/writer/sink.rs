//! The file that a bag is written into.

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

/// How chunks are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all: the least work per message.
    None,
    /// Zstandard at its default level, on the writing thread: a third of the size or less.
    #[default]
    Zstd,
}

/// A new file, and the same file again.
pub(super) fn create_new(path: &Path) -> io::Result<(File, File)> {
    let file = File::create_new(path)?;
    let handle = file.try_clone()?;
    Ok((file, handle))
}

/// The part of an error that matters to the user: the message of the operating system, if there is one.
pub(super) fn reason(error: McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// Begins an `.mcap` file.
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

/// State shared by the bag and its file: the number of bytes accepted, and whether more are.
#[derive(Default)]
pub(super) struct Gate {
    pub(super) bytes: AtomicU64,
    pub(super) closed: AtomicBool,
}

/// The file, which takes nothing more once its gate is closed. It is not buffered: a chunk
/// comes as one piece, and the few small records between chunks are rare.
pub(super) struct Sink {
    output: Box<dyn Write + Send>,
    gate: Arc<Gate>,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.gate.closed.load(Ordering::Relaxed) {
            return Err(io::Error::other("the bag takes nothing more"));
        }
        let written = self.output.write(bytes)?;
        self.gate.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}
