//! The topics of one file, from its schemas and channels.
//!
//! A file numbers schemas and channels with 16 bits and may repeat them, in chunks and in its summary. Memory is limited: a topic that
//! exceeds the limit is *omitted*; only its number is kept, so that its messages can be skipped.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    mem::size_of,
    sync::Arc,
};

use crate::{
    Topic, TopicKind,
    defect::Defect,
    fields::{self, op},
    qos,
};

/// Topics by channel number.
pub(crate) type Channels = BTreeMap<u16, Arc<Topic>>;

/// Memory per topic, without its name, in all lists, bytes: the topic (64), the bookkeeping of its name, and its places among the file's
/// channels and the bag's topics.
const TOPIC: u64 = 160;

/// Memory of a channel whose topic is known, bytes.
pub(crate) const CHANNEL: u64 = 32;

impl Topic {
    /// Memory of a topic in bytes, without its kind.
    pub(crate) fn size(&self) -> u64 {
        TOPIC + self.name.len() as u64
    }
}

impl TopicKind {
    /// Memory in bytes.
    pub(crate) fn size(&self) -> u64 {
        let texts = [
            &self.type_name,
            &self.definition,
            &self.definition_encoding,
            &self.message_encoding,
            &self.type_hash,
        ];
        let offers = self.offered_qos.capacity() * size_of::<crate::OfferedQos>();
        let all = texts.iter().map(|text| text.len()).sum::<usize>() + offers;
        size_of::<Self>() as u64 + all as u64
    }
}

/// The schemas and channels read so far.
#[derive(Default)]
pub(crate) struct Definitions {
    /// Schemas by number; `None` for an omitted schema, whose channels are omitted too.
    schemas: BTreeMap<u16, Option<Schema>>,
    /// Topics by channel number; `None` for an omitted topic.
    channels: BTreeMap<u16, Option<Arc<Topic>>>,
    /// Topic kinds, by everything a channel contains except its name.
    kinds: BTreeMap<Vec<u8>, Arc<TopicKind>>,
    /// Topics found when the file was first opened; no others are kept.
    known_channels: Option<Arc<Channels>>,
    /// Remaining memory, bytes.
    room: u64,
}

/// State of a channel number.
pub(crate) enum Known<'a> {
    Topic(&'a Arc<Topic>),
    Omitted,
    Unknown,
}

#[derive(Default, PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

impl Definitions {
    /// An empty set with a memory limit in bytes; for a file that was read before, with its known topics.
    pub(crate) fn within(room: u64, known_channels: Option<Arc<Channels>>) -> Self {
        Self {
            room,
            known_channels,
            ..Self::default()
        }
    }

    /// State of a channel number.
    pub(crate) fn topic(&self, channel: u16) -> Known<'_> {
        match self.channels.get(&channel) {
            Some(Some(topic)) => Known::Topic(topic),
            Some(None) => Known::Omitted,
            None => Known::Unknown,
        }
    }

    /// The kept topics, and the number of omitted topics.
    pub(crate) fn into_channels(self) -> (Channels, u64) {
        let all = self.channels.len();
        let kept: Channels = self
            .channels
            .into_iter()
            .filter_map(|(id, topic)| Some((id, topic?)))
            .collect();
        let omitted = all - kept.len();
        (kept, omitted as u64)
    }

    /// Reads a schema or channel record. A number never changes its meaning.
    pub(crate) fn take(&mut self, opcode: u8, body: &[u8]) -> Result<(), Defect> {
        if opcode == op::SCHEMA {
            self.take_schema(&fields::Schema::read(body)?)
        } else {
            self.take_channel(&fields::Channel::read(body)?)
        }
    }

    /// Reserves memory, if enough is left.
    fn take_room(&mut self, bytes: u64) -> bool {
        let left = self.room.checked_sub(bytes);
        self.room = left.unwrap_or(self.room);
        left.is_some()
    }

    fn take_schema(&mut self, given: &fields::Schema<'_>) -> Result<(), Defect> {
        match self.schemas.get(&given.id) {
            Some(None) => return Ok(()),
            Some(Some(known)) => {
                let is_same = known.name == given.name
                    && known.encoding == given.encoding
                    && known.text == String::from_utf8_lossy(given.data);
                return if is_same {
                    Ok(())
                } else {
                    Err(Defect::Schema(given.id))
                };
            }
            None => {}
        }
        // A byte that is no UTF-8 becomes three.
        let texts = given.name.len() + given.encoding.len() + 3 * given.data.len();
        let fits = self.take_room(size_of::<Schema>() as u64 + CHANNEL + texts as u64);
        let schema = fits.then(|| Schema {
            name: given.name.to_owned(),
            encoding: given.encoding.to_owned(),
            text: String::from_utf8_lossy(given.data).into_owned(),
        });
        self.schemas.insert(given.id, schema);
        Ok(())
    }

    fn take_channel(&mut self, given: &fields::Channel<'_>) -> Result<(), Defect> {
        let two_meanings = || Err(Defect::Channel(given.id));
        let topic = self.kind(given)?.map(|kind| Topic {
            name: printable(given.topic),
            kind,
        });
        match (self.channels.get(&given.id), &topic) {
            (Some(None), _) => return Ok(()),
            (Some(Some(known)), Some(topic)) if **known == *topic => return Ok(()),
            (Some(Some(_)), _) => return two_meanings(),
            (None, _) => {}
        }
        let kept = match (topic, &self.known_channels) {
            (None, _) => None,
            (Some(topic), None) => self.take_room(topic.size()).then(|| Arc::new(topic)),
            (Some(topic), Some(channels)) => match channels.get(&given.id) {
                Some(known) if **known == topic => Some(Arc::clone(known)),
                Some(_) => return two_meanings(),
                None => None,
            },
        };
        self.channels.insert(given.id, kept);
        Ok(())
    }

    /// The kind of the channel's messages; `None` if memory is exhausted.
    fn kind(&mut self, given: &fields::Channel<'_>) -> Result<Option<Arc<TopicKind>>, Defect> {
        let no_schema = Schema::default();
        let schema = match self.schemas.get(&given.schema_id) {
            Some(Some(schema)) => schema,
            Some(None) => return Ok(None),
            None if given.schema_id == 0 => &no_schema,
            None => {
                return Err(Defect::UnknownSchema {
                    topic: given.topic.escape_default().to_string(),
                    schema: given.schema_id,
                });
            }
        };
        let about = |key| given.metadata.get(key).copied().unwrap_or_default();
        let [hash, offers] = ["topic_type_hash", "offered_qos_profiles"].map(about);
        let key = key(given.schema_id, [given.message_encoding, hash, offers]);
        let size = CHANNEL + key.len() as u64;
        let new = match self.kinds.entry(key) {
            Entry::Occupied(known) => return Ok(Some(Arc::clone(known.get()))),
            Entry::Vacant(new) => new,
        };
        let kind = TopicKind {
            type_name: printable(&schema.name),
            definition: schema.text.clone(),
            definition_encoding: schema.encoding.clone(),
            message_encoding: given.message_encoding.to_owned(),
            type_hash: hash.to_owned(),
            offered_qos: qos::from_text(offers),
        };
        let Some(room) = self.room.checked_sub(size + kind.size()) else {
            return Ok(None);
        };
        self.room = room;
        Ok(Some(Arc::clone(new.insert(Arc::new(kind)))))
    }
}

/// A name without control characters, which no ROS name has: it cannot affect a terminal.
pub(crate) fn printable(name: &str) -> String {
    name.replace(char::is_control, "\u{fffd}")
}

/// A unique key of a number and three texts.
fn key(number: u16, texts: [&str; 3]) -> Vec<u8> {
    let mut key = number.to_le_bytes().to_vec();
    for text in texts {
        key.extend(text.len().to_le_bytes());
        key.extend(text.as_bytes());
    }
    key
}
