//! Download of a bag's file, up to the part already written.
//!
//! The path comes from a diagnostic message, which anybody in the domain may send. The path may be a pipe without a writer, a device with side
//! effects, or a file on a disk that does not respond. So only regular files are opened, a few at a time and each on its own thread: a file that
//! hangs blocks only that thread.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _};
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::{FileExt as _, OpenOptionsExt as _};
use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use futures::Stream;
use rustix::fs::OFlags;
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

/// Maximum number of files that are opened or read at once.
const MAX_FILES: usize = 4;
/// Timeout for opening a file or reading a part.
const DISK_TIMEOUT: Duration = Duration::from_secs(5);
/// Size of a part, bytes.
const PART_BYTES: u64 = 1 << 16;
/// The first bytes of an MCAP file; no other file is sent, regardless of the path in a diagnostic.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// The threads that wait for disks.
#[derive(Clone)]
pub(crate) struct Disks(Arc<Semaphore>);

impl Default for Disks {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_FILES)))
    }
}

impl Disks {
    /// Runs a function on a separate thread, once one is free.
    ///
    /// # Errors
    /// The function's own error, or `TimedOut`; a thread that hangs does not become free again.
    async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> io::Result<T> + Send + 'static,
    ) -> io::Result<T> {
        let threads = Arc::clone(&self.0);
        let working = async move {
            let permit = threads.acquire_owned().await.map_err(io::Error::other)?;
            spawn_blocking(move || {
                let _permit = permit;
                work()
            })
            .await?
        };
        let late = |_| {
            io::Error::new(
                io::ErrorKind::TimedOut,
                "the disk with the file does not answer",
            )
        };
        timeout(DISK_TIMEOUT, working).await.map_err(late)?
    }

    /// Opens the bag's file and returns its length.
    ///
    /// # Errors
    /// Not a regular file, not an MCAP file, or not readable; `TimedOut` if the disk does not answer.
    pub(crate) async fn open(&self, path: String) -> io::Result<(File, u64)> {
        self.run(move || opened(&path)).await
    }

    /// The first `length` bytes of a file, in parts.
    pub(crate) fn parts(
        &self,
        file: File,
        length: u64,
    ) -> impl Stream<Item = io::Result<Bytes>> + use<> {
        let file = Arc::new(file);
        futures::stream::unfold(
            (self.clone(), file, 0),
            move |(disks, file, at)| async move {
                let size = PART_BYTES.min(length - at);
                if size == 0 {
                    return None;
                }
                let read = Arc::clone(&file);
                let outcome = disks
                    .run(move || {
                        let mut part = vec![0; usize::try_from(size).unwrap_or(0)];
                        let count = read.read_at(&mut part, at)?;
                        part.truncate(count);
                        Ok(Bytes::from(part))
                    })
                    .await;
                // A file that has become shorter ends there.
                let end = match &outcome {
                    Ok(part) if !part.is_empty() => at + part.len() as u64,
                    _ => length,
                };
                Some((outcome, (disks, file, end)))
            },
        )
    }
}

fn opened(path: &str) -> io::Result<(File, u64)> {
    let refuse = |reason| Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    // The path itself first, which opens nothing yet: a device may act on it.
    let place = OpenOptions::new()
        .read(true)
        .custom_flags(OFlags::PATH.bits().cast_signed())
        .open(path)?;
    let metadata = place.metadata()?;
    if !metadata.is_file() {
        return refuse("it is not a regular file");
    }
    let mut file = OpenOptions::new()
        .read(true)
        .custom_flags(OFlags::NONBLOCK.bits().cast_signed())
        .open(format!("/proc/self/fd/{}", place.as_raw_fd()))?;
    let mut magic = [0; MAGIC.len()];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == MAGIC => Ok((file, metadata.len())),
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => Err(error),
        _ => refuse("the file is not a bag"),
    }
}
