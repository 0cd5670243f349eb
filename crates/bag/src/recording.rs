//! One `.mcap` file, read front to back.
//!
//! What a file holds is told by its summary, if it was closed; else it is read through once and
//! counted. Either way [`Recording`] knows up to which byte it can be read, and [`Walk`] then
//! yields its messages. Memory holds one chunk (packed and unpacked) and the topics, each within
//! [`Limits`].

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom, Take},
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    Topic, chunk,
    fields::{self, Footer, Header, Statistics, op},
    qos,
    reader::{Limits, Order, ReadError},
    records::{Damage, FRAME, Records, read_up_to},
};

/// The footer record and the magic after it: the last bytes of a closed file.
const TAIL: usize = 9 + 20 + 8;

/// What is read of the file at once.
const BUFFER: usize = 256 * 1024;

/// What a file holds.
#[derive(Clone, Debug)]
pub(crate) struct Recording {
    pub(crate) path: PathBuf,
    /// Its size when it was opened.
    pub(crate) size: u64,
    /// Up to here it is read.
    pub(crate) readable: u64,
    /// Every topic with its messages, in the order of the file's channel numbers.
    pub(crate) topics: Vec<(Arc<Topic>, u64)>,
    /// The earliest and latest log time.
    pub(crate) span: Option<(i64, i64)>,
    /// Why it is not whole, if it is not.
    pub(crate) cut: Option<String>,
}

impl Recording {
    /// Finds out what the file at `path` holds.
    pub(crate) fn open(path: &Path, limits: &Limits) -> Result<Self, ReadError> {
        let unreadable = |source| ReadError::open(path, source);
        let mut file = File::open(path).map_err(unreadable)?;
        let about = file.metadata().map_err(unreadable)?;
        if !about.is_file() {
            return Err(ReadError::NotABag {
                path: path.to_owned(),
                found: "no regular file",
            });
        }
        let size = about.len();
        check_beginning(path, &mut file)?;
        let tail = tail(&mut file, size).map_err(unreadable)?;
        if let Some(summary_start) = tail
            && let Some(summary) = summary(&mut file, summary_start, size, limits)
        {
            return Ok(Self {
                path: path.to_owned(),
                size,
                readable: size,
                topics: summary.topics,
                span: summary.span,
                cut: None,
            });
        }
        let walk = Walk::new(file, size, Order::File, limits).map_err(unreadable)?;
        Ok(Self::counted(path, walk, size, tail.is_some()))
    }

    /// Reads the file through and counts.
    fn counted(path: &Path, mut walk: Walk, size: u64, has_tail: bool) -> Self {
        let mut counts: BTreeMap<u16, u64> = BTreeMap::new();
        let mut span: Option<(i64, i64)> = None;
        let damage = loop {
            let met = walk
                .next()
                .map(|raw| raw.map(|raw| (raw.channel, raw.log_time)));
            match met {
                Ok(Some((channel, time))) => {
                    *counts.entry(channel).or_default() += 1;
                    span = Some(match span {
                        None => (time, time),
                        Some((first, last)) => (first.min(time), last.max(time)),
                    });
                }
                Ok(None) => break None,
                Err(damage) => break Some(damage),
            }
        };
        let cut = damage.or_else(|| {
            let reason = if walk.data_ended {
                "its index is cut off; every message is there"
            } else {
                "it was not closed"
            };
            (!has_tail).then(|| Damage {
                offset: size,
                reason: reason.to_owned(),
            })
        });
        Self {
            path: path.to_owned(),
            size,
            readable: cut.as_ref().map_or(size, |damage| damage.offset),
            topics: walk.definitions.topics(&counts),
            span,
            cut: cut.map(|damage| damage.reason),
        }
    }

    /// Its messages on all topics.
    pub(crate) fn message_count(&self) -> u64 {
        self.topics
            .iter()
            .fold(0, |sum, (_, messages)| sum.saturating_add(*messages))
    }

    /// Its messages, from the first to the last that can be read.
    pub(crate) fn walk(&self, order: Order, limits: &Limits) -> Result<Walk, ReadError> {
        File::open(&self.path)
            .and_then(|file| Walk::new(file, self.readable, order, limits))
            .map_err(|source| ReadError::open(&self.path, source))
    }
}

/// Refuses what does not begin as an MCAP file does: the magic, then a whole header record.
fn check_beginning(path: &Path, file: &mut File) -> Result<(), ReadError> {
    const LONGEST_HEADER: u64 = 1 << 20;
    let unreadable = |source| ReadError::open(path, source);
    let mut beginning = [0; 16];
    let read = read_up_to(file, &mut beginning).map_err(unreadable)?;
    let beginning = &beginning[..read];
    if beginning.is_empty() {
        return Err(ReadError::Empty {
            path: path.to_owned(),
        });
    }
    if !mcap::MAGIC.starts_with(&beginning[..read.min(mcap::MAGIC.len())]) {
        return Err(ReadError::NotABag {
            path: path.to_owned(),
            found: guess(beginning),
        });
    }
    file.seek(SeekFrom::Start(mcap::MAGIC.len() as u64))
        .map_err(unreadable)?;
    match Records::new(file, mcap::MAGIC.len() as u64, LONGEST_HEADER).next(|_| true) {
        Ok(Some(record)) if record.opcode == op::HEADER && Header::read(record.body).is_ok() => {
            Ok(())
        }
        _ => Err(ReadError::NoHeader {
            path: path.to_owned(),
        }),
    }
}

/// What a file that is no MCAP file seems to be, by its first bytes.
fn guess(beginning: &[u8]) -> &'static str {
    const KINDS: [(&[u8], &str); 8] = [
        (b"\xFF\xD8\xFF", "a JPEG picture"),
        (b"\x89PNG", "a PNG picture"),
        (b"PK", "a ZIP archive"),
        (b"\x1F\x8B", "a gzip archive"),
        (b"\x28\xB5\x2F\xFD", "a zstd archive; unpack it first"),
        (
            b"SQLite format 3",
            "a database, perhaps rosbag2's sqlite3 storage; 'ros2 bag convert' makes MCAP of it",
        ),
        (
            b"#ROSBAG",
            "a ROS 1 bag; 'rosbags-convert' makes a ROS 2 bag of it",
        ),
        (b"rosbag2_bagfile", "the metadata of a bag"),
    ];
    KINDS
        .iter()
        .find(|(first, _)| beginning.starts_with(first))
        .map_or("something else", |(_, kind)| kind)
}

/// Where the summary starts (0 for none) if the file ends as a closed one does.
fn tail(file: &mut File, size: u64) -> io::Result<Option<u64>> {
    let Some(start) = size.checked_sub(TAIL as u64) else {
        return Ok(None);
    };
    let mut tail = [0; TAIL];
    file.seek(SeekFrom::Start(start))?;
    if read_up_to(file, &mut tail)? < TAIL || !tail.ends_with(mcap::MAGIC) {
        return Ok(None);
    }
    Ok(match Records::new(&tail[..], start, 20).next(|_| true) {
        Ok(Some(record)) if record.opcode == op::FOOTER => Footer::read(record.body)
            .ok()
            .map(|footer| footer.summary_start),
        _ => None,
    })
}

/// What a summary tells.
struct Summary {
    topics: Vec<(Arc<Topic>, u64)>,
    span: Option<(i64, i64)>,
}

/// Reads the summary; `None` if there is none, or none that can be trusted.
fn summary(file: &mut File, start: u64, size: u64, limits: &Limits) -> Option<Summary> {
    // The footer's last four bytes before the magic are the checksum of all from `start` to them.
    let end = size.checked_sub(8 + 4)?;
    let length = end.checked_sub(start)?;
    if start == 0 || length > limits.chunk {
        return None;
    }
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(start)).ok()?;
    file.take(length + 4).read_to_end(&mut bytes).ok()?;
    let (summary, saved) = bytes.split_last_chunk::<4>()?;
    let saved = u32::from_le_bytes(*saved);
    if saved != 0 && crc32fast::hash(summary) != saved {
        return None;
    }

    let mut definitions = Definitions::default();
    let mut statistics: Option<Statistics> = None;
    let mut records = Records::new(summary, start, limits.chunk);
    loop {
        let record = records.next(is_told).ok()??;
        match record.opcode {
            op::SCHEMA | op::CHANNEL => {
                definitions.take(record.opcode, record.body, limits).ok()?
            }
            op::STATISTICS => statistics = Some(Statistics::read(record.body).ok()?),
            op::FOOTER | op::SUMMARY_OFFSET => break,
            _ => {}
        }
    }

    let statistics = statistics?;
    let counts = statistics.message_counts;
    let counted = counts
        .values()
        .try_fold(0_u64, |sum, count| sum.checked_add(*count))?;
    let known = counts
        .keys()
        .all(|id| definitions.channels.contains_key(id));
    if counted != statistics.message_count || !known {
        return None;
    }
    let span = if counted == 0 {
        None
    } else {
        Some((
            fields::time(statistics.start_time).ok()?,
            fields::time(statistics.end_time).ok()?,
        ))
    };
    Some(Summary {
        topics: definitions.topics(&counts),
        span,
    })
}

/// What a schema or channel takes beside its texts, about.
const ENTRY: usize = 256;

/// The schemas and channels met so far.
#[derive(Default)]
struct Definitions {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Arc<Topic>>,
    /// Their bytes.
    size: u64,
}

#[derive(Default, PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

impl Definitions {
    /// Takes a schema or channel record. A number once given keeps its meaning.
    fn take(&mut self, opcode: u8, body: &[u8], limits: &Limits) -> Result<(), String> {
        let added = if opcode == op::SCHEMA {
            self.take_schema(&fields::Schema::read(body)?)?
        } else {
            self.take_channel(&fields::Channel::read(body)?)?
        };
        self.size += added as u64;
        if self.size > limits.definitions {
            return Err(format!(
                "its topics take more than {} bytes to describe",
                limits.definitions
            ));
        }
        Ok(())
    }

    /// Returns the bytes it takes; none if it is known.
    fn take_schema(&mut self, given: &fields::Schema<'_>) -> Result<usize, String> {
        let schema = Schema {
            name: given.name.to_owned(),
            encoding: given.encoding.to_owned(),
            text: String::from_utf8_lossy(given.data).into_owned(),
        };
        match self.schemas.get(&given.id) {
            Some(known) if *known == schema => Ok(0),
            Some(_) => Err(format!("schema {} has two meanings", given.id)),
            None => {
                let size = ENTRY + schema.name.len() + schema.text.len();
                self.schemas.insert(given.id, schema);
                Ok(size)
            }
        }
    }

    /// Returns the bytes it takes, its type's definition among them; none if it is known.
    fn take_channel(&mut self, given: &fields::Channel<'_>) -> Result<usize, String> {
        let no_schema = Schema::default();
        let schema = match self.schemas.get(&given.schema_id) {
            Some(schema) => schema,
            None if given.schema_id == 0 => &no_schema,
            None => {
                return Err(format!(
                    "topic {} has the unknown schema {}",
                    given.topic.escape_default(),
                    given.schema_id
                ));
            }
        };
        let about = |key| given.metadata.get(key).copied().unwrap_or_default();
        let topic = Topic {
            name: given.topic.to_owned(),
            type_name: schema.name.clone(),
            definition: schema.text.clone(),
            definition_encoding: schema.encoding.clone(),
            message_encoding: given.message_encoding.to_owned(),
            type_hash: about("topic_type_hash").to_owned(),
            offered_qos: qos::from_text(about("offered_qos_profiles")),
        };
        match self.channels.get(&given.id) {
            Some(known) if **known == topic => Ok(0),
            Some(_) => Err(format!("channel {} has two meanings", given.id)),
            None => {
                let size =
                    ENTRY + topic.name.len() + topic.type_name.len() + topic.definition.len();
                self.channels.insert(given.id, Arc::new(topic));
                Ok(size)
            }
        }
    }

    fn topics(&self, counts: &BTreeMap<u16, u64>) -> Vec<(Arc<Topic>, u64)> {
        self.channels
            .iter()
            .map(|(id, topic)| (Arc::clone(topic), counts.get(id).copied().unwrap_or(0)))
            .collect()
    }
}

/// The records that tell of messages and topics; all others (attachments, indexes) are passed by.
fn is_told(opcode: u8) -> bool {
    matches!(
        opcode,
        op::FOOTER
            | op::SCHEMA
            | op::CHANNEL
            | op::MESSAGE
            | op::CHUNK
            | op::STATISTICS
            | op::DATA_END
    )
}

/// A message as it lies in the file.
pub(crate) struct Raw<'a> {
    pub(crate) channel: u16,
    pub(crate) topic: &'a Arc<Topic>,
    pub(crate) sequence: u32,
    pub(crate) log_time: i64,
    pub(crate) publish_time: i64,
    pub(crate) payload: &'a [u8],
}

/// Where a message lies in the unpacked bytes.
struct Place {
    channel: u16,
    sequence: u32,
    log_time: i64,
    publish_time: i64,
    payload: Range<usize>,
}

impl Place {
    /// Reads a message record that ends at byte `end`.
    fn of(body: &[u8], end: usize, definitions: &Definitions) -> Result<Self, String> {
        let message = fields::Message::read(body)?;
        if !definitions.channels.contains_key(&message.channel_id) {
            return Err(format!(
                "a message belongs to the unknown channel {}",
                message.channel_id
            ));
        }
        Ok(Self {
            channel: message.channel_id,
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
            payload: end - message.payload.len()..end,
        })
    }
}

/// The messages of a file, one after the other.
pub(crate) struct Walk {
    records: Records<Take<BufReader<File>>>,
    order: Order,
    limits: Limits,
    definitions: Definitions,
    /// The bytes that `places` lie in: a chunk's records, or one message.
    unpacked: Vec<u8>,
    places: std::vec::IntoIter<Place>,
    /// Whether there is no further record to take.
    ended: bool,
    /// Whether that is because the data section was ended properly.
    data_ended: bool,
}

impl Walk {
    /// The messages of `file` up to the byte `readable`.
    fn new(mut file: File, readable: u64, order: Order, limits: &Limits) -> io::Result<Self> {
        let start = mcap::MAGIC.len() as u64;
        file.seek(SeekFrom::Start(start))?;
        let input = BufReader::with_capacity(BUFFER, file).take(readable.saturating_sub(start));
        Ok(Self {
            records: Records::new(input, start, limits.chunk),
            order,
            limits: limits.clone(),
            definitions: Definitions::default(),
            unpacked: Vec::new(),
            places: Vec::new().into_iter(),
            ended: false,
            data_ended: false,
        })
    }

    /// The next message; `None` after the last. A chunk is read whole or not at all.
    pub(crate) fn next(&mut self) -> Result<Option<Raw<'_>>, Damage> {
        let place = loop {
            if let Some(place) = self.places.next() {
                break place;
            }
            if self.ended {
                return Ok(None);
            }
            self.next_record()?;
        };
        let damage = |reason: &str| Damage {
            offset: self.records.offset(),
            reason: reason.to_owned(),
        };
        Ok(Some(Raw {
            channel: place.channel,
            topic: self
                .definitions
                .channels
                .get(&place.channel)
                .ok_or_else(|| damage("a message belongs to an unknown channel"))?,
            sequence: place.sequence,
            log_time: place.log_time,
            publish_time: place.publish_time,
            payload: self
                .unpacked
                .get(place.payload)
                .ok_or_else(|| damage("a message lies outside its chunk"))?,
        }))
    }

    /// The bytes of the file that have been taken.
    pub(crate) fn offset(&self) -> u64 {
        self.records.offset()
    }

    /// Takes one record of the file.
    fn next_record(&mut self) -> Result<(), Damage> {
        let Some(record) = self.records.next(is_told)? else {
            self.ended = true;
            return Ok(());
        };
        let offset = record.offset;
        let damage = |reason: String| Damage { offset, reason };
        match record.opcode {
            op::SCHEMA | op::CHANNEL => self
                .definitions
                .take(record.opcode, record.body, &self.limits)
                .map_err(damage)?,
            op::MESSAGE => {
                let place =
                    Place::of(record.body, record.body.len(), &self.definitions).map_err(damage)?;
                self.unpacked.clear();
                self.unpacked.extend_from_slice(record.body);
                self.places = vec![place].into_iter();
            }
            op::CHUNK => {
                let chunk = fields::Chunk::read(record.body).map_err(damage)?;
                self.unpacked = chunk::unpack(&chunk, &self.limits).map_err(damage)?;
                let mut places =
                    places(&self.unpacked, &mut self.definitions, &self.limits).map_err(damage)?;
                if self.order == Order::LogTimeInChunk {
                    places.sort_by_key(|place| place.log_time);
                }
                self.places = places.into_iter();
            }
            op::DATA_END | op::FOOTER => {
                self.ended = true;
                self.data_ended = true;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The messages in a chunk's records; its schemas and channels go to `definitions`.
fn places(
    unpacked: &[u8],
    definitions: &mut Definitions,
    limits: &Limits,
) -> Result<Vec<Place>, String> {
    let mut places = Vec::new();
    let mut records = Records::new(unpacked, 0, limits.chunk);
    while let Some(record) = records
        .next(is_told)
        .map_err(|damage| format!("inside a chunk: {}", damage.reason))?
    {
        match record.opcode {
            op::SCHEMA | op::CHANNEL => definitions.take(record.opcode, record.body, limits)?,
            op::MESSAGE => {
                let end = record.offset as usize + FRAME + record.body.len();
                places.push(Place::of(record.body, end, definitions)?);
            }
            _ => {}
        }
    }
    Ok(places)
}
