//! Reading bags: whole ones, cut ones, and files that are no bag at all.
//!
//! [`BagReader::open`] takes the bag's folder, its `metadata.yaml`, or a single `.mcap` file, and
//! finds out what is there; [`BagReader::messages`] streams it. What comes from the file is
//! never believed: lengths are taken only as bytes arrive, chunks are unpacked within
//! [`Limits`] and checked, and every refusal names the path and what would be accepted.
//!
//! A bag that was not closed (a killed recorder, a full disk) is read up to the last whole chunk,
//! and [`BagReader::completeness`] says so.

use std::{
    collections::BTreeMap,
    fmt, fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    BagMetadata, Topic,
    metadata::{self, MetadataError},
    recording::{Recording, Walk},
    records::Damage,
};

/// What is taken from a file at most. The defaults are far above what recorders write, and keep
/// a hostile file from taking the memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one record, and of one chunk when unpacked. 256 MiB; recorders write about 1.
    pub chunk: u64,
    /// Bytes of all schemas and channels together. 64 MiB; a busy bag has 1.
    pub definitions: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            chunk: 256 << 20,
            definitions: 64 << 20,
        }
    }
}

/// The order of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// As written.
    #[default]
    File,
    /// By log time within each chunk; equal times as written. Chunks stay as written.
    LogTimeInChunk,
}

/// Why a bag cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Nothing has that path.
    #[error(
        "{path}: no such file or folder; a bag is a folder, its metadata.yaml, or a .mcap file"
    )]
    NotFound {
        /// The path asked for.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("{path} cannot be read: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A file without a byte.
    #[error("{path} is empty; a .mcap file is wanted")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Something else than an MCAP file.
    #[error(
        "{path} is no MCAP file but {found}; a bag is a folder, its metadata.yaml, or a .mcap file"
    )]
    NotABag {
        /// The file.
        path: PathBuf,
        /// What it seems to be.
        found: &'static str,
    },
    /// The file is cut off before its first record.
    #[error("{path} is cut off or damaged in its header: no message can be read")]
    NoHeader {
        /// The file.
        path: PathBuf,
    },
    /// A folder without `.mcap` files.
    #[error("{path} is no bag: it holds no .mcap file")]
    NoMcap {
        /// The folder.
        path: PathBuf,
    },
    /// A storage other than MCAP.
    #[error(
        "{path} is a bag in rosbag2's '{storage}' storage; only mcap is read ('ros2 bag convert' makes one of the other)"
    )]
    Storage {
        /// The metadata.
        path: PathBuf,
        /// The storage it names.
        storage: String,
    },
    /// Files or messages compressed by rosbag2 rather than by MCAP.
    #[error(
        "{path} is a bag compressed by {mode} ({format}); only MCAP's own chunk compression is read ('ros2 bag convert' makes one of the other)"
    )]
    Compressed {
        /// The metadata.
        path: PathBuf,
        /// `file` or `message`.
        mode: String,
        /// The compressor.
        format: String,
    },
    /// `metadata.yaml` is not what it should be.
    #[error(transparent)]
    Metadata(#[from] MetadataError),
    /// A file that was closed, and damaged since.
    #[error("{path} is damaged at byte {offset}: {reason}; what comes before has been read")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where nothing more can be read.
        offset: u64,
        /// What is wrong there.
        reason: String,
    },
}

impl ReadError {
    pub(crate) fn open(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        if source.kind() == io::ErrorKind::NotFound {
            Self::NotFound { path }
        } else {
            Self::Io { path, source }
        }
    }
}

/// Whether a bag is all that was to be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Completeness {
    /// It was closed, and its counts agree.
    Whole,
    /// It was not closed, or has been cut since: later messages may be missing.
    Truncated {
        /// The file (or folder) that shows it.
        path: PathBuf,
        /// Bytes of that file that are read, if it is a file.
        readable: Option<u64>,
        /// What shows it.
        reason: String,
    },
}

impl Completeness {
    /// Whether it is [`Completeness::Whole`].
    #[must_use]
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Whole)
    }
}

impl fmt::Display for Completeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => write!(f, "whole"),
            Self::Truncated {
                path,
                readable,
                reason,
            } => {
                write!(f, "not whole: {}", path.display())?;
                if let Some(readable) = readable {
                    write!(f, ", readable up to byte {readable}")?;
                }
                write!(f, ": {reason}")
            }
        }
    }
}

/// A topic and its messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicCount {
    /// The topic.
    pub topic: Arc<Topic>,
    /// Its messages in all files.
    pub messages: u64,
}

/// A message of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Its topic.
    pub topic: Arc<Topic>,
    /// Its number, as the recorder gave it.
    pub sequence: u32,
    /// When it was received, in nanoseconds.
    pub log_time: i64,
    /// When it was sent, in nanoseconds.
    pub publish_time: i64,
    /// Its bytes as DDS delivers them, with four of encapsulation in front.
    pub payload: Vec<u8>,
}

/// A bag open for reading.
#[derive(Debug)]
pub struct BagReader {
    path: PathBuf,
    metadata: Option<BagMetadata>,
    recordings: Vec<Recording>,
    topics: Vec<TopicCount>,
    completeness: Completeness,
    limits: Limits,
}

impl BagReader {
    /// Opens the bag at `path`: its folder, its `metadata.yaml`, or one `.mcap` file.
    ///
    /// # Errors
    /// When there is no bag, or none that can be read. A bag that is merely cut off is opened.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_within(path, Limits::default())
    }

    /// As [`open`](Self::open), with other limits.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_within(path: &Path, limits: Limits) -> Result<Self, ReadError> {
        let is_folder = fs::metadata(path)
            .map_err(|source| ReadError::open(path, source))?
            .is_dir();
        let is_metadata = path
            .extension()
            .is_some_and(|extension| extension == "yaml" || extension == "yml");
        if is_folder {
            Self::open_folder(path, limits)
        } else if is_metadata {
            let folder = path.parent().unwrap_or(Path::new("."));
            let metadata = BagMetadata::read(path)?;
            Self::open_listed(path, folder, metadata, limits)
        } else {
            Self::open_files(path, vec![path.to_owned()], None, None, limits)
        }
    }

    /// Opens several `.mcap` files, in this order, as one bag: what remains of a split bag.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_all(files: &[PathBuf]) -> Result<Self, ReadError> {
        let path = files.first().map_or(Path::new(""), PathBuf::as_path);
        Self::open_files(path, files.to_vec(), None, None, Limits::default())
    }

    fn open_folder(folder: &Path, limits: Limits) -> Result<Self, ReadError> {
        let told = folder.join(metadata::FILE_NAME);
        let not_told = match BagMetadata::read(&told) {
            Ok(metadata) => return Self::open_listed(&told, folder, metadata, limits),
            Err(MetadataError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                "it has no metadata.yaml: it was not closed".to_owned()
            }
            Err(error) => error.to_string(),
        };
        let files = mcap_files(folder)?;
        Self::open_files(folder, files, None, Some(not_told), limits)
    }

    /// Opens the files that the metadata at `told` lists.
    fn open_listed(
        told: &Path,
        folder: &Path,
        metadata: BagMetadata,
        limits: Limits,
    ) -> Result<Self, ReadError> {
        if metadata.storage_identifier != "mcap" {
            return Err(ReadError::Storage {
                path: told.to_owned(),
                storage: metadata.storage_identifier,
            });
        }
        if !matches!(
            metadata.compression_mode.to_lowercase().as_str(),
            "" | "none" | "storage"
        ) {
            return Err(ReadError::Compressed {
                path: told.to_owned(),
                mode: metadata.compression_mode,
                format: metadata.compression_format,
            });
        }
        // Older bags write the folder before the name; a bag's files never lie outside it.
        let files = metadata
            .relative_file_paths
            .iter()
            .filter_map(|listed| Path::new(listed).file_name())
            .map(|name| folder.join(name))
            .collect();
        Self::open_files(folder, files, Some(metadata), None, limits)
    }

    fn open_files(
        path: &Path,
        files: Vec<PathBuf>,
        metadata: Option<BagMetadata>,
        not_told: Option<String>,
        limits: Limits,
    ) -> Result<Self, ReadError> {
        if files.is_empty() {
            return Err(ReadError::NoMcap {
                path: path.to_owned(),
            });
        }
        let mut recordings = files
            .iter()
            .map(|file| Recording::open(file, &limits))
            .collect::<Result<Vec<_>, _>>()?;
        let completeness = completeness(path, &recordings, metadata.as_ref(), not_told);
        Ok(Self {
            path: path.to_owned(),
            topics: merged(&mut recordings),
            metadata,
            recordings,
            completeness,
            limits,
        })
    }

    /// The path that was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether later messages may be missing.
    #[must_use]
    pub fn completeness(&self) -> &Completeness {
        &self.completeness
    }

    /// The bag's `metadata.yaml`, if it was opened by it and it could be read.
    #[must_use]
    pub fn metadata(&self) -> Option<&BagMetadata> {
        self.metadata.as_ref()
    }

    /// Every topic with its messages.
    #[must_use]
    pub fn topics(&self) -> &[TopicCount] {
        &self.topics
    }

    /// Messages on all topics.
    #[must_use]
    pub fn message_count(&self) -> u64 {
        self.topics.iter().map(|topic| topic.messages).sum()
    }

    /// Messages that the recorder knew to be lost, as its metadata tells.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.metadata.as_ref().map_or(0, BagMetadata::dropped)
    }

    /// The earliest and latest log time, in nanoseconds; `None` without messages.
    #[must_use]
    pub fn span(&self) -> Option<(i64, i64)> {
        self.recordings
            .iter()
            .filter_map(|recording| recording.span)
            .reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    /// The `.mcap` files, in order, each with its size in bytes.
    pub fn files(&self) -> impl Iterator<Item = (&Path, u64)> {
        self.recordings
            .iter()
            .map(|recording| (recording.path.as_path(), recording.size))
    }

    /// Every message from the first, file by file. Each call starts anew.
    #[must_use]
    pub fn messages(&self, order: Order) -> Messages<'_> {
        Messages {
            remaining: self.recordings.iter(),
            passed: 0,
            current: None,
            order,
            limits: &self.limits,
            wanted: None,
        }
    }

    /// The messages of the named topics only; the others cost no copy.
    #[must_use]
    pub fn messages_of<'a>(&'a self, topics: &'a [&'a str], order: Order) -> Messages<'a> {
        Messages {
            wanted: Some(topics),
            ..self.messages(order)
        }
    }
}

/// A stream of messages. After an error (a file damaged since it was closed) it ends.
pub struct Messages<'a> {
    remaining: std::slice::Iter<'a, Recording>,
    /// Bytes of the files before the current one.
    passed: u64,
    /// The file being read, and the messages met in it.
    current: Option<(&'a Recording, Walk, u64)>,
    order: Order,
    limits: &'a Limits,
    wanted: Option<&'a [&'a str]>,
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some((recording, walk, met)) = &mut self.current else {
                let recording = self.remaining.next()?;
                match recording.walk(self.order, self.limits) {
                    Ok(walk) => self.current = Some((recording, walk, 0)),
                    Err(error) => return self.end_with(error),
                }
                continue;
            };
            match walk.next() {
                Ok(Some(raw)) => {
                    *met += 1;
                    let unwanted = self
                        .wanted
                        .is_some_and(|wanted| !wanted.contains(&raw.topic.name.as_str()));
                    if unwanted {
                        continue;
                    }
                    return Some(Ok(Message {
                        topic: Arc::clone(raw.topic),
                        sequence: raw.sequence,
                        log_time: raw.log_time,
                        publish_time: raw.publish_time,
                        payload: raw.payload.to_vec(),
                    }));
                }
                // A record whose opcode was changed is passed by; its messages are missed here.
                Ok(None) if *met != recording.message_count() => {
                    let (path, offset) = (recording.path.clone(), recording.readable);
                    let reason = format!(
                        "its index tells of {} messages, {met} are there",
                        recording.message_count()
                    );
                    return self.end_with(ReadError::Damaged {
                        path,
                        offset,
                        reason,
                    });
                }
                Ok(None) => {
                    self.passed += recording.size;
                    self.current = None;
                }
                Err(Damage { offset, reason }) => {
                    let path = recording.path.clone();
                    return self.end_with(ReadError::Damaged {
                        path,
                        offset,
                        reason,
                    });
                }
            }
        }
    }
}

impl Messages<'_> {
    /// How many bytes of the bag's files have been read, to show how far one is.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        let current = self.current.as_ref();
        self.passed + current.map_or(0, |(_, walk, _)| walk.offset())
    }

    fn end_with(&mut self, error: ReadError) -> Option<Result<Message, ReadError>> {
        self.remaining = [].iter();
        self.current = None;
        Some(Err(error))
    }
}

/// The `.mcap` files in `folder`, in the order they were written: `NAME_2` before `NAME_10`.
fn mcap_files(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let unreadable = |source| ReadError::open(folder, source);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "mcap")
        {
            files.push(path);
        }
    }
    files.sort_by_cached_key(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let (name, number) = stem.rsplit_once('_').unwrap_or((&stem, ""));
        match number.parse::<u64>() {
            Ok(number) => (name.to_owned(), number),
            Err(_) => (stem.into_owned(), 0),
        }
    });
    Ok(files)
}

/// Every topic of every file; one that is in several files is counted together, and kept once.
fn merged(recordings: &mut [Recording]) -> Vec<TopicCount> {
    let mut topics: Vec<TopicCount> = Vec::new();
    let mut places: BTreeMap<(String, String), usize> = BTreeMap::new();
    let of_all = recordings.iter_mut().flat_map(|it| &mut it.topics);
    for (topic, messages) in of_all {
        let messages = *messages;
        let key = (topic.name.clone(), topic.type_name.clone());
        let place = *places.entry(key).or_insert(topics.len());
        match topics.get_mut(place) {
            Some(known) => {
                known.messages = known.messages.saturating_add(messages);
                if known.topic == *topic {
                    *topic = Arc::clone(&known.topic);
                }
            }
            None => topics.push(TopicCount {
                topic: Arc::clone(topic),
                messages,
            }),
        }
    }
    topics
}

fn completeness(
    path: &Path,
    recordings: &[Recording],
    metadata: Option<&BagMetadata>,
    not_told: Option<String>,
) -> Completeness {
    for recording in recordings {
        if let Some(reason) = &recording.cut {
            return Completeness::Truncated {
                path: recording.path.clone(),
                readable: Some(recording.readable),
                reason: reason.clone(),
            };
        }
    }
    let counted: u64 = recordings
        .iter()
        .map(Recording::message_count)
        .fold(0, u64::saturating_add);
    let reason = match (not_told, metadata) {
        (Some(reason), _) => reason,
        (None, Some(metadata)) if metadata.message_count != counted => format!(
            "its metadata.yaml tells of {} messages, its files hold {counted}",
            metadata.message_count
        ),
        _ => return Completeness::Whole,
    };
    Completeness::Truncated {
        path: path.to_owned(),
        readable: None,
        reason,
    }
}
