//! Writer of bags; flushed data stays readable.
//!
//! Messages are collected in a chunk in memory. The chunk is written to the file as one complete record when it reaches
//! [`WriterOptions::chunk_size`], or [`WriterOptions::flush_interval`] after the previous one. So the file always consists of complete records,
//! and after `kill -9` everything up to the last flushed chunk is readable. The writer does not wait for the disk unless
//! [`WriterOptions::fsync`] is set: a killed process loses no flushed data, but a power cut may. At each flush the path is checked: a file that
//! was removed or moved meanwhile is an error.
//!
//! A bag may be split: by [`WriterOptions::max_file_size`] and [`WriterOptions::max_file_duration`], or by [`BagWriter::split`]. Each of the
//! files `NAME_0.mcap`, `NAME_1.mcap` is closed before the next one begins. Each is a complete MCAP file with all topics of the bag so far.
//!
//! [`BagWriter::close`] writes the index and finally `metadata.yaml`. A writer that is dropped without it flushes its messages but writes
//! neither: such a bag is readable and reports that it is incomplete.

mod account;
mod sink;

use std::{
    collections::BTreeMap,
    fmt,
    fs::{self, File},
    io::{self, Write},
    os::unix::fs::MetadataExt as _,
    path::{Path, PathBuf},
    sync::{Arc, atomic::Ordering},
    time::{Duration, Instant},
};

use mcap::{
    McapError,
    records::{MessageHeader, Metadata},
    write::NoSeek,
};

use crate::{
    Topic,
    metadata::{self, BagMetadata, FileInformation, MetadataError},
    qos,
};
use sink::{Gate, Sink, begin, create_new, reason};

pub use sink::Compression;

/// Size of a message's frame and header, bytes, counted towards the size of a chunk.
const MESSAGE_OVERHEAD: u64 = 9 + 22;

/// Options of a bag's writer.
#[derive(Clone, Debug)]
pub struct WriterOptions {
    /// Compression of the chunks.
    pub compression: Compression,
    /// Uncompressed size at which a chunk is written, bytes. Larger chunks compress better, but a reader must keep one in memory. Default 768 KiB,
    /// the same as in rosbag2.
    pub chunk_size: u64,
    /// Longest time that a message waits in memory, checked on each message and in [`BagWriter::flush_if_due`]. `None`: until the chunk is full,
    /// so that the file depends only on the messages.
    pub flush_interval: Option<Duration>,
    /// Size at which the bag's next file begins, bytes; waiting messages count uncompressed, the index does not count. `None`: one file.
    pub max_file_size: Option<u64>,
    /// Time between a file's first and last log time after which the bag's next file begins. `None`: one file.
    pub max_file_duration: Option<Duration>,
    /// Whether each flush waits for the disk, so that a power cut loses no more than `kill -9` does. Not for a file started by
    /// [`BagWriter::create_in`].
    pub fsync: bool,
}

impl Default for WriterOptions {
    fn default() -> Self {
        Self {
            compression: Compression::default(),
            chunk_size: 768 * 1024,
            flush_interval: Some(Duration::from_secs(1)),
            max_file_size: None,
            max_file_duration: None,
            fsync: false,
        }
    }
}

/// Errors of writing a bag. Each message names the path or topic and the rule.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The path exists already.
    #[error("{path} exists already, and recordings are never overwritten. Name a new path")]
    Exists {
        /// The requested path.
        path: PathBuf,
    },
    /// The path has no name at its end.
    #[error("{path} does not end with a name. The last part of the path must be the bag's name")]
    NoName {
        /// The requested path.
        path: PathBuf,
    },
    /// An error of the file system while creating the bag.
    #[error("cannot create {path}: {source}")]
    Create {
        /// The path to create.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A write error, for example a full disk. The bag accepts no more messages; flushed data is readable.
    #[error("cannot write {path}: {reason}")]
    Failed {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// The messages were written, but not `metadata.yaml`.
    #[error("the messages were written, but not their metadata: {0}")]
    Metadata(#[from] MetadataError),
    /// A topic added twice with different descriptions.
    #[error("topic {name} is already in the bag with another type or QoS")]
    Conflict {
        /// The topic.
        name: String,
    },
    /// A message has another type than its topic.
    #[error("topic {name} has the type {expected}, not {given}")]
    WrongType {
        /// The topic.
        name: String,
        /// Its type.
        expected: String,
        /// The message's type.
        given: String,
    },
    /// A [`TopicId`] of another writer.
    #[error("this bag has no topic number {0}")]
    UnknownTopic(usize),
    /// A time before the clock's epoch.
    #[error("topic {name}: the time {nanoseconds} ns is negative, which MCAP cannot store")]
    NegativeTime {
        /// The topic.
        name: String,
        /// The time given.
        nanoseconds: i64,
    },
    /// A message that cannot be serialized.
    #[error("topic {name}: the message cannot be serialized: {reason}")]
    Encode {
        /// The topic.
        name: String,
        /// The reason.
        reason: String,
    },
}

/// Index of a topic in one [`BagWriter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TopicId(usize);

/// State of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Health {
    /// Total size of all files, bytes.
    pub bytes: u64,
    /// Number of messages still in memory.
    pub waiting: u64,
    /// All topics, in the order in which they were added.
    pub topics: Vec<TopicHealth>,
    /// The reason why writing has failed, if it has.
    pub failure: Option<String>,
}

/// State of a topic's recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicHealth {
    /// The topic.
    pub name: String,
    /// Number of messages written.
    pub messages: u64,
    /// Number of messages reported as lost.
    pub dropped: u64,
}

impl Health {
    /// Number of messages written on all topics.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.topics.iter().map(|topic| topic.messages).sum()
    }

    /// Number of messages reported as lost on all topics.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.topics.iter().map(|topic| topic.dropped).sum()
    }
}

/// A topic of the current file.
struct Channel {
    topic: Topic,
    /// Channel number in the current file.
    mcap_id: u16,
    messages: u64,
    /// Number of messages in earlier files.
    before: u64,
    dropped: u64,
}

/// A bag being written.
pub struct BagWriter {
    mcap: mcap::Writer<NoSeek<Sink>>,
    gate: Arc<Gate>,
    /// Path of the current `.mcap` file.
    file: PathBuf,
    /// Handle of that file; `None` for a file that will be moved, or is not a regular file.
    handle: Option<File>,
    /// Folder of the bag; `None` for a single file.
    folder: Option<PathBuf>,
    /// Earlier files of the bag.
    closed: Vec<FileInformation>,
    /// Total size of the earlier files, bytes.
    closed_bytes: u64,
    options: WriterOptions,
    channels: Vec<Channel>,
    /// Topic ids by name.
    ids: BTreeMap<String, TopicId>,
    /// First and last log time in the current file.
    span: Option<(i64, i64)>,
    /// Size, and number of messages, of the present chunk.
    pending_bytes: u64,
    pending_messages: u64,
    flushed: Instant,
    failure: Option<String>,
}

impl fmt::Debug for BagWriter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BagWriter")
            .field("file", &self.file)
            .field("health", &self.health())
            .finish_non_exhaustive()
    }
}

impl BagWriter {
    /// Starts the bag `folder/` with its first file `NAME_0.mcap`, where NAME is the folder's name. Missing parent folders are created.
    ///
    /// # Errors
    /// [`WriteError::Exists`] if the path exists; [`WriteError::Create`] for an error of the file system.
    pub fn create(folder: &Path, options: WriterOptions) -> Result<Self, WriteError> {
        let Some(name) = bag_name(folder) else {
            return Err(WriteError::NoName {
                path: folder.to_owned(),
            });
        };
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(|source| WriteError::Create {
                path: parent.to_owned(),
                source,
            })?;
        }
        fs::create_dir(folder).map_err(|source| refused(folder, source))?;
        let file = folder.join(format!("{name}_0.mcap"));
        let mut writer = Self::create_file(&file, options)?;
        writer.folder = Some(folder.to_owned());
        Ok(writer)
    }

    /// Starts a single `.mcap` file with the same contents, without folder and `metadata.yaml`.
    ///
    /// # Errors
    /// [`WriteError::Exists`] if the path exists; [`WriteError::Create`] for an error of the file system.
    pub fn create_file(file: &Path, options: WriterOptions) -> Result<Self, WriteError> {
        let (output, handle) = create_new(file).map_err(|source| refused(file, source))?;
        let mut writer = Self::create_in(output, file, options)?;
        writer.handle = Some(handle);
        writer.settle()?;
        Ok(writer)
    }

    /// Starts a single `.mcap` file in `output`, which will be moved to `file` once it is closed; errors name `file`.
    ///
    /// # Errors
    /// [`WriteError::Failed`] if writing fails.
    pub fn create_in(
        output: File,
        file: &Path,
        options: WriterOptions,
    ) -> Result<Self, WriteError> {
        Self::start(file, Box::new(output), options)
    }

    /// Writes the header into `output`, so that even a bag killed immediately is readable.
    fn start(
        file: &Path,
        output: Box<dyn Write + Send>,
        options: WriterOptions,
    ) -> Result<Self, WriteError> {
        let failed = |error: McapError| WriteError::Failed {
            path: file.to_owned(),
            reason: reason(error),
        };
        let (mcap, gate) = begin(output, options.compression).map_err(failed)?;
        let mut writer = Self {
            mcap,
            gate,
            file: file.to_owned(),
            handle: None,
            folder: None,
            closed: Vec::new(),
            closed_bytes: 0,
            options,
            channels: Vec::new(),
            ids: BTreeMap::new(),
            span: None,
            pending_bytes: 0,
            pending_messages: 0,
            flushed: Instant::now(),
            failure: None,
        };
        // As rosbag2 does: a recording that is never closed still has its metadata version, by
        // which a reader knows how the QoS is written.
        writer.embed(&BagMetadata::empty())?;
        writer.flush()?;
        Ok(writer)
    }

    /// Adds a topic, or returns the id of an equal one.
    ///
    /// # Errors
    /// [`WriteError::Conflict`] if the name exists with another description; [`WriteError::Failed`] if writing fails.
    pub fn add_topic(&mut self, topic: &Topic) -> Result<TopicId, WriteError> {
        if let Some(known) = self.ids.get(&topic.name) {
            return if self.topic(*known)? == topic {
                Ok(*known)
            } else {
                Err(WriteError::Conflict {
                    name: topic.name.clone(),
                })
            };
        }
        self.refuse_after_failure()?;
        let mcap_id = self.add_channel(topic)?;
        let id = TopicId(self.channels.len());
        self.ids.insert(topic.name.clone(), id);
        self.channels.push(Channel {
            topic: topic.clone(),
            mcap_id,
            messages: 0,
            before: 0,
            dropped: 0,
        });
        Ok(id)
    }

    /// Adds a topic to the current file.
    fn add_channel(&mut self, topic: &Topic) -> Result<u16, WriteError> {
        let kind = &topic.kind;
        let offered = qos::to_text(&kind.offered_qos).map_err(|error| WriteError::Encode {
            name: topic.name.clone(),
            reason: error.to_string(),
        })?;
        let about = BTreeMap::from([
            ("offered_qos_profiles".to_owned(), offered),
            ("topic_type_hash".to_owned(), kind.type_hash.clone()),
        ]);
        let added = self
            .mcap
            .add_schema(
                &kind.type_name,
                &kind.definition_encoding,
                kind.definition.as_bytes(),
            )
            .and_then(|schema| {
                self.mcap
                    .add_channel(schema, &topic.name, &kind.message_encoding, &about)
            });
        added.map_err(|error| self.fail(error))
    }

    /// Writes a CDR payload with its four bytes of encapsulation. `log_time`: time of reception, `publish_time`: time of publication, ns.
    ///
    /// # Errors
    /// [`WriteError::NegativeTime`], [`WriteError::UnknownTopic`]; [`WriteError::Failed`] if writing fails now or failed before.
    pub fn write_raw(
        &mut self,
        topic: TopicId,
        payload: &[u8],
        log_time: i64,
        publish_time: i64,
    ) -> Result<(), WriteError> {
        self.refuse_after_failure()?;
        if self.is_full(log_time) {
            self.split()?;
        }
        let channel = self
            .channels
            .get_mut(topic.0)
            .ok_or(WriteError::UnknownTopic(topic.0))?;
        let stamp = |nanoseconds: i64| {
            u64::try_from(nanoseconds).map_err(|_| WriteError::NegativeTime {
                name: channel.topic.name.clone(),
                nanoseconds,
            })
        };
        let header = MessageHeader {
            channel_id: channel.mcap_id,
            // The count on this topic; it wraps around, as DDS numbers in ROS bags do.
            sequence: channel.messages as u32,
            log_time: stamp(log_time)?,
            publish_time: stamp(publish_time)?,
        };
        let written = self.mcap.write_to_known_channel(&header, payload);
        if let Err(error) = written {
            return Err(self.fail(error));
        }
        channel.messages += 1;
        self.span = Some(match self.span {
            None => (log_time, log_time),
            Some((first, last)) => (first.min(log_time), last.max(log_time)),
        });
        self.pending_messages += 1;
        self.pending_bytes += MESSAGE_OVERHEAD + payload.len() as u64;
        if self.pending_bytes >= self.options.chunk_size {
            self.flush()
        } else {
            self.flush_if_due()
        }
    }

    /// Records that messages of `topic` were lost before they could be written.
    pub fn note_dropped(&mut self, topic: TopicId, messages: u64) {
        if let Some(channel) = self.channels.get_mut(topic.0) {
            channel.dropped += messages;
        }
    }

    /// Flushes if the flush interval has passed. A recorder's timer calls this, so that the last messages before a silence do not stay in memory.
    ///
    /// # Errors
    /// [`WriteError::Failed`] if writing fails now or has failed before.
    pub fn flush_if_due(&mut self) -> Result<(), WriteError> {
        match self.options.flush_interval {
            Some(interval) if self.flushed.elapsed() >= interval => self.flush(),
            _ => Ok(()),
        }
    }

    /// Ends the chunk and passes it to the operating system: all messages so far stay readable even if this process is killed.
    ///
    /// # Errors
    /// [`WriteError::Failed`] if writing fails now or has failed before.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.refuse_after_failure()?;
        let flushed = self.mcap.flush();
        if let Err(error) = flushed {
            return Err(self.fail(error));
        }
        self.pending_bytes = 0;
        self.pending_messages = 0;
        self.flushed = Instant::now();
        self.settle()
    }

    /// Checks that the path still leads to the open file, and waits for the disk if `fsync` is set.
    fn settle(&mut self) -> Result<(), WriteError> {
        let settled = self.settled();
        settled.map_err(|error| self.fail(McapError::Io(error)))
    }

    fn settled(&self) -> io::Result<()> {
        let Some(file) = &self.handle else {
            return Ok(());
        };
        let (ours, there) = (file.metadata()?, fs::metadata(&self.file));
        if !there.is_ok_and(|there| (there.dev(), there.ino()) == (ours.dev(), ours.ino())) {
            return Err(io::Error::other(GONE));
        }
        if self.options.fsync {
            file.sync_data()?;
            let mut folder = self.folder.iter();
            folder.try_for_each(|it| File::open(it)?.sync_all())?;
        }
        Ok(())
    }

    /// Whether a message with this time belongs to the next file.
    fn is_full(&self, log_time: i64) -> bool {
        let Some((first, _)) = self.span else {
            return false; // No file is without messages.
        };
        let longest = self.options.max_file_duration.map_or(i64::MAX, |longest| {
            longest.as_nanos().try_into().unwrap_or(i64::MAX)
        });
        let bytes = self.gate.bytes.load(Ordering::Relaxed) + self.pending_bytes;
        self.folder.is_some()
            && (log_time.saturating_sub(first) > longest
                || self.options.max_file_size.is_some_and(|most| bytes >= most))
    }

    /// Closes the current file and begins the bag's next one. Returns `false`, without effect, for a single file or a file without messages.
    ///
    /// # Errors
    /// [`WriteError::Failed`] if writing fails now or has failed before.
    pub fn split(&mut self) -> Result<bool, WriteError> {
        let (Some(folder), Some(_)) = (&self.folder, self.span) else {
            return Ok(false);
        };
        let name = bag_name(folder).unwrap_or_default();
        let file = folder.join(format!("{name}_{}.mcap", self.closed.len() + 1));
        self.finish()?;
        let begun = create_new(&file)
            .map_err(McapError::Io)
            .and_then(|(output, handle)| {
                let (mcap, gate) = begin(Box::new(output), self.options.compression)?;
                Ok((mcap, gate, handle))
            });
        let (mcap, gate, handle) = begun.map_err(|error| {
            self.file.clone_from(&file);
            self.fail(error)
        })?;
        self.closed.push(self.current_file());
        self.closed_bytes += self.gate.bytes.load(Ordering::Relaxed);
        (self.mcap, self.gate, self.file) = (mcap, gate, file);
        self.handle = Some(handle);
        self.span = None;
        for channel in &mut self.channels {
            channel.before = channel.messages;
        }
        self.embed(&BagMetadata::empty())?;
        for place in 0..self.channels.len() {
            let topic = self.channels[place].topic.clone();
            self.channels[place].mcap_id = self.add_channel(&topic)?;
        }
        self.flush()?;
        Ok(true)
    }

    /// Ends the current file.
    fn finish(&mut self) -> Result<(), WriteError> {
        self.embed(&self.account_of_file())?;
        let finished = self.mcap.finish();
        if let Err(error) = finished {
            return Err(self.fail(error));
        }
        self.settle()?;
        self.gate.closed.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// State of the recording.
    #[must_use]
    pub fn health(&self) -> Health {
        Health {
            bytes: self.closed_bytes + self.gate.bytes.load(Ordering::Relaxed),
            waiting: self.pending_messages,
            topics: self
                .channels
                .iter()
                .map(|channel| TopicHealth {
                    name: channel.topic.name.clone(),
                    messages: channel.messages,
                    dropped: channel.dropped,
                })
                .collect(),
            failure: self.failure.clone(),
        }
    }

    /// Path of the current `.mcap` file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The topic with this id.
    pub(crate) fn topic(&self, topic: TopicId) -> Result<&Topic, WriteError> {
        self.channels
            .get(topic.0)
            .map(|channel| &channel.topic)
            .ok_or(WriteError::UnknownTopic(topic.0))
    }

    /// Closes the bag: writes the last chunk, the index, and `metadata.yaml`, which is returned.
    ///
    /// # Errors
    /// [`WriteError::Failed`] if writing fails now or failed before; `metadata.yaml` is then missing. [`WriteError::Metadata`] if only
    /// `metadata.yaml` cannot be written.
    pub fn close(mut self) -> Result<BagMetadata, WriteError> {
        self.finish()?;
        let metadata = self.account();
        if let Some(folder) = &self.folder {
            metadata.write(folder)?;
            if self.options.fsync {
                let written = File::open(folder.join(metadata::FILE_NAME));
                let synced = written.and_then(|it| it.sync_all());
                synced.map_err(|error| self.fail(McapError::Io(error)))?;
            }
            self.settle()?;
        }
        Ok(metadata)
    }

    /// Writes the metadata also into the `.mcap` file, the same as rosbag2's storage.
    fn embed(&mut self, account: &BagMetadata) -> Result<(), WriteError> {
        self.refuse_after_failure()?;
        let text = serde_yaml_ng::to_string(account).map_err(|error| WriteError::Failed {
            path: self.file.clone(),
            reason: error.to_string(),
        })?;
        let embedded = self.mcap.write_metadata(&Metadata {
            name: "rosbag2".to_owned(),
            metadata: BTreeMap::from([("serialized_metadata".to_owned(), text)]),
        });
        embedded.map_err(|error| self.fail(error))
    }

    /// Stores the first error, after which the file accepts no more data.
    fn fail(&mut self, error: McapError) -> WriteError {
        self.gate.closed.store(true, Ordering::Relaxed);
        let told = |error| match reason(error) {
            gone if gone == GONE => gone,
            reason => format!("{reason}; everything flushed before is readable"),
        };
        let reason = self.failure.get_or_insert_with(|| told(error)).clone();
        WriteError::Failed {
            path: self.file.clone(),
            reason,
        }
    }

    fn refuse_after_failure(&self) -> Result<(), WriteError> {
        match &self.failure {
            None => Ok(()),
            Some(reason) => Err(WriteError::Failed {
                path: self.file.clone(),
                reason: reason.clone(),
            }),
        }
    }
}

impl Drop for BagWriter {
    /// Flushes the messages, without index and metadata, since the bag was not closed.
    fn drop(&mut self) {
        if self.failure.is_none() && !self.gate.closed.load(Ordering::Relaxed) {
            // A failure cannot be reported here; the file is readable up to the flush before.
            let _ = self.mcap.flush();
        }
        // mcap's own drop would write the index, and make the file look whole.
        self.gate.closed.store(true, Ordering::Relaxed);
    }
}

/// Error text for a file whose path has changed.
const GONE: &str = "the file was moved or removed while it was being written";

/// Name of the bag, which is the name of its folder.
fn bag_name(folder: &Path) -> Option<&str> {
    folder.file_name().and_then(|name| name.to_str())
}

fn refused(path: &Path, source: io::Error) -> WriteError {
    let path = path.to_owned();
    if source.kind() == io::ErrorKind::AlreadyExists {
        WriteError::Exists { path }
    } else {
        WriteError::Create { path, source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TopicKind;

    /// A disk with room for so many bytes.
    struct SmallDisk(usize);

    impl Write for SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let taken = bytes.len().min(self.0);
            self.0 -= taken;
            if taken == 0 && !bytes.is_empty() {
                return Err(io::ErrorKind::StorageFull.into());
            }
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn topic() -> Topic {
        Topic {
            name: "/depth".to_owned(),
            kind: Arc::new(TopicKind {
                type_name: "std_msgs/msg/Float64".to_owned(),
                definition: "float64 data\n".to_owned(),
                definition_encoding: "ros2msg".to_owned(),
                message_encoding: "cdr".to_owned(),
                ..TopicKind::default()
            }),
        }
    }

    #[test]
    fn a_full_disk_is_an_error_at_once_and_ever_after() {
        let file = Path::new("full.mcap");
        let options = || WriterOptions {
            compression: Compression::None,
            chunk_size: 256,
            flush_interval: None,
            ..WriterOptions::default()
        };
        for room in (0..6000).step_by(37) {
            let disk = Box::new(SmallDisk(room));
            let mut failures = Vec::new();
            match BagWriter::start(file, disk, options()) {
                Err(error) => failures.push(error),
                Ok(mut writer) => {
                    match writer.add_topic(&topic()) {
                        Err(error) => failures.push(error),
                        Ok(id) => failures.extend(
                            (0..400).filter_map(|k| writer.write_raw(id, &[0; 12], k, k).err()),
                        ),
                    }
                    failures.extend(writer.flush().err());
                    let failure = writer.health().failure;
                    assert_eq!(failure.is_some(), !failures.is_empty());
                    failures.extend(writer.close().err());
                }
            }
            let first = failures.first().expect("the disk is too small").to_string();
            assert!(first.contains("full.mcap"), "{first}");
            assert!(first.contains("no storage space"), "{first}");
            for later in &failures {
                assert_eq!(later.to_string(), first);
            }
        }
    }

    #[test]
    fn a_bag_that_is_removed_or_moved_while_it_is_written_is_an_error_at_the_next_flush() {
        let folder = tempfile::tempdir().expect("a folder");
        for fsync in [false, true] {
            for is_moved in [false, true] {
                let bag = folder.path().join(format!("bag_{fsync}_{is_moved}"));
                let options = WriterOptions {
                    fsync,
                    ..WriterOptions::default()
                };
                let mut writer = BagWriter::create(&bag, options).expect("a bag");
                let id = writer.add_topic(&topic()).expect("new");
                writer.write_raw(id, &[0; 12], 1, 1).expect("taken");
                writer.flush().expect("it is there");
                assert!(writer.split().expect("it is there"));
                writer.write_raw(id, &[0; 12], 2, 2).expect("taken");
                match is_moved {
                    true => fs::rename(&bag, folder.path().join("elsewhere")).expect("moved"),
                    false => fs::remove_dir_all(&bag).expect("removed"),
                }
                let failure = writer.flush().expect_err("it is gone").to_string();
                assert!(failure.contains("moved or removed"), "{failure}");
                assert_eq!(
                    writer
                        .write_raw(id, &[0; 12], 3, 3)
                        .expect_err("closed")
                        .to_string(),
                    failure
                );
                // Another file at the path is not the one that is written.
                fs::create_dir_all(&bag).expect("made");
                assert!(writer.close().is_err());
                fs::remove_dir_all(folder.path().join("elsewhere")).ok();
            }
        }
    }

    #[test]
    fn a_topic_is_added_once_and_as_one_thing() {
        let mut writer = BagWriter::start(
            Path::new("topics.mcap"),
            Box::new(io::sink()),
            WriterOptions::default(),
        )
        .expect("a sink takes all");
        let first = writer.add_topic(&topic()).expect("new");
        assert_eq!(writer.add_topic(&topic()).expect("the same"), first);
        let mut other = topic();
        Arc::make_mut(&mut other.kind).type_name = "std_msgs/msg/Float32".to_owned();
        assert!(matches!(
            writer.add_topic(&other),
            Err(WriteError::Conflict { .. })
        ));
        assert!(matches!(
            writer.write_raw(TopicId(7), &[], 0, 0),
            Err(WriteError::UnknownTopic(7))
        ));
        assert!(matches!(
            writer.write_raw(first, &[], -1, 0),
            Err(WriteError::NegativeTime { .. })
        ));
        assert_eq!(writer.health().messages(), 0);
    }
}
