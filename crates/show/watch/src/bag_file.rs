//! The file of a bag, as far as it is written, to be downloaded.
//!
//! Its path comes from a diagnostic, which anybody in the domain may send: it may be a pipe that nobody writes, a device that does
//! something when it is opened, or lie on a file system that does not answer. So nothing but a regular file is opened, and files are
//! opened and read on threads of their own, a few at a time: one that hangs takes its thread, and nothing else.

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

/// Files that are opened or read at once.
const MAX_FILES: usize = 4;
/// How long a disk may take to open a file or to read a part.
const DISK_TIMEOUT: Duration = Duration::from_secs(5);
/// Bytes that are read at once.
const PART_BYTES: u64 = 1 << 16;
/// How an MCAP file begins: whatever path a diagnostic names, nothing else is handed out.
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
    /// Does it on a thread of its own, once one is free.
    ///
    /// # Errors
    /// Its own, or that it has not been done in time; a thread that hangs is not free again.
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
        let late = |_| io::Error::new(io::ErrorKind::TimedOut, "its disk does not answer");
        timeout(DISK_TIMEOUT, working).await.map_err(late)?
    }

    /// Opens the bag's file, and tells its length.
    ///
    /// # Errors
    /// When it is no regular file, no MCAP file, or cannot be read; `TimedOut` when nobody can tell.
    pub(crate) async fn open(&self, path: String) -> io::Result<(File, u64)> {
        self.run(move || opened(&path)).await
    }

    /// A file's first `length` bytes, a part at a time.
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
        return refuse("it is no regular file");
    }
    let mut file = OpenOptions::new()
        .read(true)
        .custom_flags(OFlags::NONBLOCK.bits().cast_signed())
        .open(format!("/proc/self/fd/{}", place.as_raw_fd()))?;
    let mut magic = [0; MAGIC.len()];
    match file.read_exact(&mut magic) {
        Ok(()) if magic == MAGIC => Ok((file, metadata.len())),
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => Err(error),
        _ => refuse("it is no bag"),
    }
}
