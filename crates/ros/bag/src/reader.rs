//! Reader of bags, complete or truncated.
//!
//! [`BagReader::open`] takes the bag's folder, its `metadata.yaml`, or a single `.mcap` or `.db3` file, and finds out the contents;
//! [`BagReader::messages`] streams the messages. Data of the file is not trusted: memory grows only as bytes arrive, chunks are unpacked within
//! [`Limits`] and checked, and every error names the path and the supported contents.
//!
//! A bag that was not closed (killed recorder, full disk) is read up to the last complete chunk; [`BagReader::completeness`] reports this.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
    fmt, fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    BagMetadata, Topic, chunk,
    defect::Defect,
    definitions::CHANNEL,
    files::{apart, bag_files, instead, is_packed, is_plain, listed, part_of, present, unpacked},
    metadata::{self, MetadataError},
    recording::{Counts, Recording, Stream},
    records::Damage,
    walk::Raw,
};

pub use crate::{
    limits::{Limits, Order},
    read_error::ReadError,
};

/// Whether a bag contains everything that was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Completeness {
    /// The bag was closed, and its message counts agree.
    Whole,
    /// The bag was not closed, or was cut off later: messages at the end may be missing.
    Truncated {
        /// The file or folder concerned.
        path: PathBuf,
        /// Number of readable bytes, if it is a file.
        readable: Option<u64>,
        /// Reason for this conclusion.
        reason: String,
    },
    /// The files were closed, but the metadata cannot be read.
    Unknown {
        /// The reason why the metadata cannot be read.
        reason: String,
    },
}

impl Completeness {
    /// Whether the bag is complete ([`Completeness::Whole`]).
    #[must_use]
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Whole)
    }
}

impl fmt::Display for Completeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => write!(f, "complete"),
            Self::Truncated {
                path,
                readable,
                reason,
            } => {
                write!(f, "incomplete: {}", path.display())?;
                if let Some(readable) = readable {
                    write!(f, ", readable up to byte {readable}")?;
                }
                write!(f, ": {reason}")
            }
            Self::Unknown { reason } => write!(f, "possibly incomplete: {reason}"),
        }
    }
}

/// A topic with its number of messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicCount {
    /// The topic.
    pub topic: Arc<Topic>,
    /// Number of messages in all files.
    pub messages: u64,
}

/// A message of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Topic of the message.
    pub topic: Arc<Topic>,
    /// Channel number in the file.
    pub channel: u16,
    /// Sequence number of the publisher or recorder; 0 if there is no number.
    pub sequence: u32,
    /// Time of reception, ns.
    pub log_time: i64,
    /// Time of publication, ns.
    pub publish_time: i64,
    /// CDR payload, including the four bytes of encapsulation.
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
    /// Limits for messages that rosbag2 compressed separately; `None` if messages are uncompressed.
    unpack: Option<Limits>,
    renamed: Option<String>,
}

impl BagReader {
    /// Opens the bag at `path`: its folder, its `metadata.yaml`, or one `.mcap` file.
    ///
    /// # Errors
    /// There is no bag, or it cannot be read. A truncated bag can be opened.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_within(path, Limits::default())
    }

    /// Like [`open`](Self::open), with memory limits.
    ///
    /// # Errors
    /// Same as [`open`](Self::open).
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

    /// Opens several files, in this order, as one bag: for example the remaining parts of a split bag.
    ///
    /// # Errors
    /// Same as [`open`](Self::open).
    pub fn open_all(files: &[PathBuf], limits: Limits) -> Result<Self, ReadError> {
        let path = files.first().map_or(Path::new(""), PathBuf::as_path);
        Self::open_files(path, files.to_vec(), None, None, limits)
    }

    fn open_folder(folder: &Path, limits: Limits) -> Result<Self, ReadError> {
        let listing = folder.join(metadata::FILE_NAME);
        let no_metadata = match BagMetadata::read(&listing) {
            Ok(metadata) => return Self::open_listed(&listing, folder, metadata, limits),
            Err(MetadataError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Completeness::Truncated {
                    path: folder.to_owned(),
                    readable: None,
                    reason: "the bag has no metadata.yaml, so it was not closed".to_owned(),
                }
            }
            Err(error) => Completeness::Unknown {
                reason: error.to_string(),
            },
        };
        let files = bag_files(folder)?;
        Self::open_files(folder, files, None, Some(no_metadata), limits)
    }

    /// Opens the files listed in the metadata at `listing`.
    fn open_listed(
        listing: &Path,
        folder: &Path,
        metadata: BagMetadata,
        limits: Limits,
    ) -> Result<Self, ReadError> {
        if !["mcap", "sqlite3"].contains(&metadata.storage_identifier.as_str()) {
            return Err(ReadError::Storage {
                path: listing.to_owned(),
                storage: metadata.storage_identifier,
            });
        }
        let mode = metadata.compression_mode.to_lowercase();
        // Older bags write the folder before the name; a bag's files never lie outside it.
        let files: Vec<PathBuf> = metadata
            .relative_file_paths
            .iter()
            .filter_map(|listed| Path::new(listed).file_name())
            .map(|name| folder.join(name))
            .map(|file| if mode == "file" { unpacked(file) } else { file })
            .collect();
        let by_zstd = metadata.compression_format == "zstd";
        let are_packed = mode == "message" && by_zstd;
        let (files, renamed) = present(files, folder)?;
        // Files that are packed otherwise may lie unpacked beside.
        let is_read = match mode.as_str() {
            "" | "none" | "storage" => true,
            "file" => files
                .iter()
                .all(|file| is_plain(file) || by_zstd && is_packed(file)),
            _ => are_packed,
        };
        if !is_read {
            return Err(ReadError::Compressed {
                path: listing.to_owned(),
                mode: metadata.compression_mode,
                format: metadata.compression_format,
            });
        }
        let unpack = are_packed.then(|| limits.clone());
        // More files than it lists are not all its own.
        let is_its = files.len() <= metadata.relative_file_paths.len();
        let bag = Self::open_files(folder, files, is_its.then_some(metadata), None, limits)?;
        Ok(Self {
            unpack,
            renamed,
            ..bag
        })
    }

    fn open_files(
        path: &Path,
        files: Vec<PathBuf>,
        metadata: Option<BagMetadata>,
        no_metadata: Option<Completeness>,
        limits: Limits,
    ) -> Result<Self, ReadError> {
        if files.is_empty() {
            return Err(ReadError::NoMcap {
                path: path.to_owned(),
                instead: instead(path),
            });
        }
        let mut topics = Topics::within(limits.definitions);
        let mut recordings = Vec::new();
        for file in &files {
            let limits = Limits {
                definitions: topics.room,
                ..limits
            };
            let (mut recording, counts) = Recording::open(file, limits)?;
            topics.take(&mut recording, &counts);
            recordings.push(recording);
        }
        if metadata.is_none()
            && let Some(differ) = apart(&recordings)
        {
            return Err(ReadError::Several {
                path: path.to_owned(),
                files: listed(&files),
                differ,
            });
        }
        let completeness = completeness(path, &recordings, metadata.as_ref(), no_metadata);
        Ok(Self {
            path: path.to_owned(),
            topics: topics.list,
            metadata,
            recordings,
            completeness,
            unpack: None,
            renamed: None,
        })
    }

    /// Path that was opened.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether messages at the end may be missing.
    #[must_use]
    pub fn completeness(&self) -> &Completeness {
        &self.completeness
    }

    /// The bag's `metadata.yaml`, if it was opened through it and is readable.
    #[must_use]
    pub fn metadata(&self) -> Option<&BagMetadata> {
        self.metadata.as_ref()
    }

    /// All topics with their numbers of messages, without [omitted](Self::omitted) topics.
    #[must_use]
    pub fn topics(&self) -> &[TopicCount] {
        &self.topics
    }

    /// A note on listed files that do not exist, and on the files read instead.
    #[must_use]
    pub fn renamed(&self) -> Option<&str> {
        self.renamed.as_deref()
    }

    /// Number of messages on all topics.
    #[must_use]
    pub fn message_count(&self) -> u64 {
        message_count(&self.recordings)
    }

    /// Number of topics skipped, with their messages, because they exceed [`Limits::definitions`]; in a split bag they count once per file.
    #[must_use]
    pub fn omitted(&self) -> u64 {
        self.recordings.iter().map(|it| it.omitted).sum()
    }

    /// Number of messages that the recorder reported as lost in the metadata.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.metadata.as_ref().map_or(0, BagMetadata::dropped)
    }

    /// Topics with messages that the recorder reported as lost, and their numbers.
    pub fn dropped_by_topic(&self) -> impl Iterator<Item = (&str, u64)> {
        self.metadata.iter().flat_map(BagMetadata::dropped_by_topic)
    }

    /// Earliest and latest log time, ns; `None` without messages.
    #[must_use]
    pub fn span(&self) -> Option<(i64, i64)> {
        self.recordings
            .iter()
            .filter_map(|recording| recording.span)
            .reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    /// The bag's files in order, with their sizes in bytes.
    pub fn files(&self) -> impl Iterator<Item = (&Path, u64)> {
        self.recordings
            .iter()
            .map(|recording| (recording.path.as_path(), recording.size))
    }

    /// All messages, file by file. Each call starts from the beginning.
    #[must_use]
    pub fn messages(&self, order: Order) -> Messages<'_> {
        self.messages_of(|_| true, order)
    }

    /// The messages of topics for which `wanted` returns true; other messages are not copied. `wanted` is called once per topic of a file.
    #[must_use]
    pub fn messages_of<'a>(
        &'a self,
        wanted: impl Fn(&Topic) -> bool + 'a,
        order: Order,
    ) -> Messages<'a> {
        Messages {
            remaining: self.recordings.iter(),
            passed: 0,
            current: None,
            order,
            ahead: None,
            unpack: self.unpack.as_ref(),
            unpacked: 0,
            wanted: Box::new(wanted),
            are_wanted: BTreeMap::new(),
        }
    }
}

/// Stream of messages. The iterator ends after an error (a file damaged after it was closed).
pub struct Messages<'a> {
    remaining: std::slice::Iter<'a, Recording>,
    /// Total size of the files before the current one, bytes.
    passed: u64,
    /// The file being read.
    current: Option<(&'a Recording, Stream)>,
    order: Order,
    /// Messages read ahead for sorting.
    ahead: Option<Ahead>,
    unpack: Option<&'a Limits>,
    /// Bytes of separately compressed messages unpacked from the current file so far.
    unpacked: u64,
    wanted: Box<dyn Fn(&Topic) -> bool + 'a>,
    /// Results of `wanted` for the current file's topics, by channel.
    are_wanted: BTreeMap<u16, bool>,
}

/// Size of messages read ahead to check their order, bytes.
const SEEN: usize = 16 << 20;

/// Largest size of messages waiting to be sorted, bytes.
pub const SORTED: usize = 256 << 20;

/// Memory per message in addition to its payload, bytes.
const BESIDE: usize = 128;

/// Share of late messages above which the messages count as unordered.
const DISORDER: f64 = 0.05;

/// Messages read ahead, by time and place.
struct Ahead {
    messages: BTreeMap<(i64, u64), Message>,
    /// Whether the following messages are sorted too.
    is_sorted: bool,
    bytes: usize,
    count: u64,
    /// The reason why reading stopped.
    failure: Option<ReadError>,
}

/// Whether messages are unordered: many are late, or blocks of messages that do not overlap are in the wrong order.
fn are_disordered(times: &[i64]) -> bool {
    let mut runs: Vec<(i64, i64)> = times
        .chunk_by(|a, b| a <= b)
        .map(|it| (it[0], it[it.len() - 1]))
        .collect();
    let is_mostly = runs.len() as f64 > 1.0 + DISORDER * times.len() as f64;
    let is_one = runs.len() < 2;
    runs.sort_unstable();
    !is_one && (is_mostly || runs.windows(2).all(|it| it[0].1 <= it[1].0))
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.order == Order::File {
            return self.read();
        }
        let mut ahead = match self.ahead.take() {
            Some(ahead) => ahead,
            None => self.look_ahead(),
        };
        if ahead.is_sorted {
            self.fill(&mut ahead, SORTED);
        }
        let mut next = ahead.messages.pop_first().map(|it| it.1);
        if let Some(message) = next.as_mut().filter(|_| ahead.is_sorted) {
            message.sequence = 0;
        }
        ahead.bytes -= next.as_ref().map_or(0, |it| it.payload.len() + BESIDE);
        let next = next.map(Ok).or_else(|| ahead.failure.take().map(Err));
        self.ahead = Some(ahead);
        next.or_else(|| self.read())
    }
}

impl Messages<'_> {
    /// Reads ahead until so many bytes are waiting.
    fn fill(&mut self, ahead: &mut Ahead, most: usize) {
        while ahead.bytes < most && ahead.failure.is_none() {
            match self.read() {
                Some(Ok(message)) => {
                    ahead.bytes += message.payload.len() + BESIDE;
                    ahead.count += 1;
                    let time = if ahead.is_sorted { message.log_time } else { 0 };
                    ahead.messages.insert((time, ahead.count), message);
                }
                Some(Err(failure)) => ahead.failure = Some(failure),
                None => return,
            }
        }
    }

    /// Reads the first messages, and sorts them if they are unordered.
    fn look_ahead(&mut self) -> Ahead {
        let mut ahead = Ahead {
            messages: BTreeMap::new(),
            is_sorted: false,
            bytes: 0,
            count: 0,
            failure: None,
        };
        self.fill(&mut ahead, SEEN);
        let times: Vec<i64> = ahead.messages.values().map(|it| it.log_time).collect();
        ahead.is_sorted = are_disordered(&times);
        if ahead.is_sorted {
            let messages = std::mem::take(&mut ahead.messages).into_iter();
            ahead.messages = messages
                .map(|((_, place), it)| ((it.log_time, place), it))
                .collect();
        }
        ahead
    }

    /// The next message in file order.
    fn read(&mut self) -> Option<Result<Message, ReadError>> {
        loop {
            let Some((recording, stream)) = &mut self.current else {
                let recording = self.remaining.next()?;
                self.are_wanted.clear();
                self.unpacked = 0;
                match recording.stream() {
                    Ok(stream) => self.current = Some((recording, stream)),
                    Err(error) => return self.end_with(error),
                }
                continue;
            };
            let damage = match stream.next() {
                Ok(Some(Raw { topic, message })) => {
                    let is_wanted = self
                        .are_wanted
                        .entry(message.channel_id)
                        .or_insert_with(|| (self.wanted)(topic));
                    if !*is_wanted {
                        continue;
                    }
                    let payload = match self.unpack {
                        None => Ok(message.payload.to_vec()),
                        Some(limits) => {
                            chunk::unpack_message(message.payload, limits, &mut self.unpacked)
                        }
                    };
                    match payload {
                        Ok(payload) => {
                            return Some(Ok(Message {
                                topic: Arc::clone(topic),
                                channel: message.channel_id,
                                sequence: message.sequence,
                                log_time: message.log_time,
                                publish_time: message.publish_time,
                                payload,
                            }));
                        }
                        Err(reason) => Damage {
                            offset: stream.offset(),
                            reason,
                        },
                    }
                }
                Ok(None) => {
                    // A record whose opcode was changed is passed by; its messages are missed here.
                    let (indexed, met) = (recording.messages, stream.met());
                    if indexed == met {
                        self.passed += recording.size;
                        self.current = None;
                        continue;
                    }
                    Damage {
                        offset: recording.readable,
                        reason: Defect::Index { indexed, met },
                    }
                }
                Err(damage) => damage,
            };
            let path = recording.path.clone();
            return self.end_with(ReadError::Damaged {
                path,
                offset: damage.offset,
                reason: damage.reason,
            });
        }
    }
}

impl Messages<'_> {
    /// Number of bytes of the bag's files read so far, for a progress display.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        let current = self.current.as_ref();
        self.passed + current.map_or(0, |(_, stream)| stream.offset())
    }

    fn end_with(&mut self, error: ReadError) -> Option<Result<Message, ReadError>> {
        self.remaining = [].iter();
        self.current = None;
        Some(Err(error))
    }
}

/// The topics of all files; a topic in several files is counted and stored once.
struct Topics {
    list: Vec<TopicCount>,
    /// Index of each topic in the list.
    places: BTreeMap<ByName, usize>,
    /// Remaining memory, bytes.
    room: u64,
}

/// A topic ordered by name and type.
struct ByName(Arc<Topic>);

impl ByName {
    fn key(&self) -> (&str, &str) {
        (&self.0.name, &self.0.kind.type_name)
    }
}

impl Ord for ByName {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

impl PartialOrd for ByName {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for ByName {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for ByName {}

impl Topics {
    fn within(room: u64) -> Self {
        Self {
            list: Vec::new(),
            places: BTreeMap::new(),
            room,
        }
    }

    /// Adds a file's topics and counts; a topic that is already known is shared.
    fn take(&mut self, recording: &mut Recording, counts: &Counts) {
        let mut taken = 0;
        let mut kinds = BTreeSet::new();
        for (id, topic) in Arc::make_mut(&mut recording.channels) {
            let messages = counts.get(id).copied().unwrap_or(0);
            let place = *self
                .places
                .entry(ByName(Arc::clone(topic)))
                .or_insert(self.list.len());
            let known = match self.list.get_mut(place) {
                Some(known) => known,
                None => self.list.push_mut(TopicCount {
                    topic: Arc::clone(topic),
                    messages: 0,
                }),
            };
            known.messages = known.messages.saturating_add(messages);
            if known.topic == *topic && !Arc::ptr_eq(&known.topic, topic) {
                *topic = Arc::clone(&known.topic);
                taken += CHANNEL;
            } else {
                taken += topic.size();
                if kinds.insert(Arc::as_ptr(&topic.kind)) {
                    taken += topic.kind.size();
                }
            }
        }
        self.room = self.room.saturating_sub(taken);
    }
}

fn message_count(recordings: &[Recording]) -> u64 {
    recordings
        .iter()
        .map(|recording| recording.messages)
        .fold(0, u64::saturating_add)
}

/// Completeness of the files; `no_metadata` is the result for a bag without metadata.
fn completeness(
    path: &Path,
    recordings: &[Recording],
    metadata: Option<&BagMetadata>,
    no_metadata: Option<Completeness>,
) -> Completeness {
    for recording in recordings {
        if let Some(reason) = &recording.cut {
            return Completeness::Truncated {
                path: recording.path.clone(),
                readable: Some(recording.readable),
                reason: reason.to_string(),
            };
        }
    }
    let counted = message_count(recordings);
    match metadata {
        Some(metadata) if metadata.message_count != counted => Completeness::Truncated {
            path: path.to_owned(),
            readable: None,
            reason: format!(
                "the bag's metadata.yaml lists {} messages, but its files contain {counted}",
                metadata.message_count
            ),
        },
        _ => no_metadata.unwrap_or(Completeness::Whole),
    }
}

/// Groups bag files into bags: the parts of a split bag in their order; every other file is a bag by itself.
#[must_use]
pub fn sorted_into_bags(files: &[PathBuf]) -> Vec<Vec<PathBuf>> {
    let mut bags: Vec<Vec<PathBuf>> = Vec::new();
    for file in files {
        let is_its = |bag: &&mut Vec<PathBuf>| {
            bag[0].parent() == file.parent() && part_of(&bag[0]).0 == part_of(file).0
        };
        match bags.iter_mut().find(is_its) {
            Some(bag) => bag.push(file.clone()),
            None => bags.push(vec![file.clone()]),
        }
    }
    let apart = |bag: &Vec<PathBuf>| {
        bag.len() > 1
            && matches!(
                BagReader::open_all(bag, Limits::default()),
                Err(ReadError::Several { .. })
            )
    };
    let (several, mut whole): (Vec<_>, Vec<_>) = bags.into_iter().partition(apart);
    whole.extend(several.into_iter().flatten().map(|file| vec![file]));
    whole
}
