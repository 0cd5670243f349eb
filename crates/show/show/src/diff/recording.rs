//! A recording: a bag, or a table whose columns are read as topics with one number each.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use planesman_bag::{BagReader, Limits, Message, Order, Topic};
use planesman_decode::{Decoder, FieldPath, StampDecoder, Types, Values, schema};
use planesman_signals::{CsvSource, Request, Source as _, SourceError, TableTime, is_table, types};

use crate::diff::options::{DiffError, Options};

/// A message with its topic and stamp.
pub(crate) struct Item {
    /// Index of its topic in the recording.
    pub(crate) topic: usize,
    /// The message's own stamp, ns.
    pub(crate) stamp: Option<i64>,
    pub(crate) payload: Vec<u8>,
}

/// A topic of a recording.
pub(crate) struct TopicOf {
    pub(crate) name: String,
    /// The message type, or why the messages cannot be decoded.
    pub(crate) types: Result<Types, String>,
    /// Whether the messages have stamps; a column's value has the time of its row.
    pub(crate) is_stamped: bool,
    /// Decoder of a bag message's stamp.
    stamp: Option<StampDecoder>,
    /// Number of messages, as far as it is known in advance.
    pub(crate) messages: u64,
}

/// An open recording.
pub(crate) struct Recording {
    pub(crate) name: String,
    source: Source,
    pub(crate) topics: Vec<TopicOf>,
    /// Whether the topics are columns of a table.
    pub(crate) is_table: bool,
}

enum Source {
    Bag(BagReader),
    /// The columns of a table.
    Table(CsvSource, Vec<Request>),
    /// Fields of a bag read as columns: by topic, the column indices and decoders.
    Columns(BagReader, BTreeMap<String, Vec<Column>>),
}

struct Column {
    topic: usize,
    decoder: Decoder,
    is_negative: bool,
}

/// Type definition of a column's messages.
const NUMBER: &str = "float64 data\n";

/// Opens both recordings. If one recording is a table, the bag is read as the table's columns, as far as these are known.
pub(crate) fn open(paths: [&Path; 2], options: &Options<'_>) -> Result<[Recording; 2], DiffError> {
    let tables = paths.map(is_table);
    if tables == [false; 2] {
        return Ok([bag(paths[0], options)?, bag(paths[1], options)?]);
    }
    match tables {
        [true, true] => Ok([table(paths[0])?, table(paths[1])?]),
        [true, false] => {
            let (table, bag) = beside(table(paths[0])?, paths[1], options)?;
            Ok([table, bag])
        }
        _ => {
            let (table, bag) = beside(table(paths[1])?, paths[0], options)?;
            Ok([bag, table])
        }
    }
}

/// Path of a type's stamp; for a list of stamped messages, the stamp of the first element.
fn stamp_path(types: &Types) -> Option<FieldPath> {
    let first = || {
        let fields = planesman_decode::Catalogue::of(types, 64).fields;
        let fields = fields.iter().map(|it| it.to_string());
        let found = fields.map(|it| it.strip_suffix("[0].header.stamp.sec").map(str::to_owned));
        let list = found.flatten().next()?;
        format!("{list}[0].header.stamp").parse().ok()
    };
    types.stamp().or_else(first)
}

/// Decoder of a type's stamp; `None` for a type without a stamp.
#[must_use]
pub fn stamp_decoder(types: &Types) -> Option<StampDecoder> {
    StampDecoder::at(types, &stamp_path(types)?)
}

fn bag(path: &Path, options: &Options<'_>) -> Result<Recording, DiffError> {
    let bag = BagReader::open_within(path, Limits::unpacked(options.most_unpacked))?;
    let of = |it: &planesman_bag::reader::TopicCount| {
        let found = types(&bag, &it.topic).map_err(|reason| reason.to_string());
        let stamp = found.as_ref().ok().and_then(stamp_decoder);
        TopicOf {
            name: it.topic.name.clone(),
            is_stamped: stamp.is_some(),
            stamp,
            types: found,
            messages: it.messages,
        }
    };
    let is_its = |it: &&planesman_bag::reader::TopicCount| {
        options.only.is_empty() || options.only.contains(&it.topic.name)
    };
    let topics = bag.topics().iter().filter(is_its);
    Ok(Recording {
        name: path.display().to_string(),
        topics: topics.map(of).collect(),
        source: Source::Bag(bag),
        is_table: false,
    })
}

/// Topics of one number each, by name.
fn columns<'n>(names: impl IntoIterator<Item = &'n str>) -> Result<Vec<TopicOf>, DiffError> {
    let types = schema::read("std_msgs/msg/Float64", "ros2msg", NUMBER);
    let types = types.map_err(|reason| SourceError::Data(reason.to_string()))?;
    let of = |name: &str| TopicOf {
        name: name.to_owned(),
        is_stamped: true,
        types: Ok(types.clone()),
        stamp: None,
        messages: 0,
    };
    Ok(names.into_iter().map(of).collect())
}

fn table(path: &Path) -> Result<Recording, DiffError> {
    let mut source = CsvSource::open(path, &TableTime::default())?;
    source.count_rows();
    let topics = source.topics().into_iter();
    let requests: Vec<Request> = topics.flat_map(|it| it.requests).collect();
    Ok(Recording {
        name: path.display().to_string(),
        topics: columns(requests.iter().map(|it| it.name.as_str()))?,
        source: Source::Table(source, requests),
        is_table: true,
    })
}

/// Reads a table and a bag; only those columns of the table are kept that the bag also contains.
fn beside(
    table: Recording,
    path: &Path,
    options: &Options<'_>,
) -> Result<(Recording, Recording), DiffError> {
    let bag = BagReader::open_within(path, Limits::unpacked(options.most_unpacked))?;
    let mut found: BTreeMap<String, Vec<Column>> = BTreeMap::new();
    let mut names = Vec::new();
    for (name, signal) in options.columns {
        if !table.topics.iter().any(|it| it.name == *name) {
            continue;
        }
        let is_negative = signal.starts_with('-');
        let Some((topic, field)) = signal.trim_start_matches('-').split_once(':') else {
            continue;
        };
        let is_its = |it: &&planesman_bag::reader::TopicCount| {
            it.topic
                .name
                .strip_suffix(topic)
                .is_some_and(|it| it.ends_with('/'))
        };
        let Some(topic) = bag.topics().iter().find(is_its).map(|it| &it.topic) else {
            continue;
        };
        if let Some(decoder) = of_field(&bag, topic, field) {
            let column = Column {
                topic: names.len(),
                decoder,
                is_negative,
            };
            found.entry(topic.name.clone()).or_default().push(column);
            names.push(*name);
        }
    }
    if names.is_empty() {
        let problem = format!(
            "{} and {}: no column of the table is a known signal of a bag; a bag can be compared only with tables written by `planesman sim`",
            table.name,
            path.display()
        );
        return Err(SourceError::Request(problem).into());
    }
    let Source::Table(source, mut requests) = table.source else {
        return Err(SourceError::Request("a table is expected".to_owned()).into());
    };
    requests.retain(|it| names.contains(&it.name.as_str()));
    let table = Recording {
        name: table.name,
        topics: columns(requests.iter().map(|it| it.name.as_str()))?,
        source: Source::Table(source, requests),
        is_table: true,
    };
    let bag = Recording {
        name: path.display().to_string(),
        topics: columns(names)?,
        source: Source::Columns(bag, found),
        is_table: true,
    };
    Ok((table, bag))
}

/// Decoder of the stamp and one field of a topic's messages.
fn of_field(bag: &BagReader, topic: &Topic, field: &str) -> Option<Decoder> {
    let types = types(bag, topic).ok()?;
    let stamp = stamp_path(&types)?;
    let [seconds, nanoseconds] = ["sec", "nanosec"].map(|name| stamp.field(name));
    Decoder::compile(&types, &[seconds, nanoseconds, field.parse().ok()?]).ok()
}

impl Recording {
    /// Passes every message of the selected topics to `take`, until `take` returns false. Returns notes that affect the result.
    pub(crate) fn read(
        &self,
        wanted: &dyn Fn(usize) -> bool,
        take: &mut dyn FnMut(Item) -> bool,
    ) -> Vec<String> {
        let mut notes = Vec::new();
        match &self.source {
            Source::Bag(bag) => self.read_bag(bag, wanted, take, &mut notes),
            Source::Table(table, requests) => {
                let mut of_cell = |topic, stamp, value: Option<f64>| match value {
                    Some(value) if wanted(topic) => take(number(topic, stamp, value)),
                    _ => true,
                };
                match table.read(requests, &mut of_cell, &|_| {}) {
                    Ok(reading) => notes.extend(reading.notes),
                    Err(error) => notes.push(error.to_string()),
                }
            }
            Source::Columns(bag, columns) => {
                read_columns(bag, columns, wanted, take, &mut notes);
            }
        }
        notes
    }

    fn read_bag(
        &self,
        bag: &BagReader,
        wanted: &dyn Fn(usize) -> bool,
        take: &mut dyn FnMut(Item) -> bool,
        notes: &mut Vec<String>,
    ) {
        let place = |name: &str| self.topics.iter().position(|it| it.name == name);
        let is_wanted = |it: &Topic| place(&it.name).is_some_and(wanted);
        let mut known: Vec<(Arc<Topic>, usize)> = Vec::new();
        let mut values = Values::default();
        for message in whole(bag, &is_wanted, notes) {
            let Message { topic, payload, .. } = message;
            let met = known.iter().find(|it| Arc::ptr_eq(&it.0, &topic));
            let topic = match met {
                Some((_, place)) => *place,
                None => {
                    let Some(place) = place(&topic.name) else {
                        continue;
                    };
                    known.push((topic, place));
                    place
                }
            };
            let stamp = self.topics[topic].stamp.as_ref();
            let stamp = stamp.and_then(|it| it.read(&payload, &mut values));
            if !take(Item {
                topic,
                stamp,
                payload,
            }) {
                return;
            }
        }
    }
}

/// The messages of a bag, up to the place where it is damaged.
fn whole<'b>(
    bag: &'b BagReader,
    wanted: &'b dyn Fn(&Topic) -> bool,
    notes: &'b mut Vec<String>,
) -> impl Iterator<Item = Message> + 'b {
    if !bag.completeness().is_whole() {
        notes.push(bag.completeness().to_string());
    }
    bag.messages_of(wanted, Order::File)
        .map_while(move |message| message.map_err(|error| notes.push(error.to_string())).ok())
}

fn read_columns(
    bag: &BagReader,
    columns: &BTreeMap<String, Vec<Column>>,
    wanted: &dyn Fn(usize) -> bool,
    take: &mut dyn FnMut(Item) -> bool,
    notes: &mut Vec<String>,
) {
    let mut values = Values::default();
    for message in whole(bag, &|it| columns.contains_key(&it.name), notes) {
        for column in columns.get(&message.topic.name).into_iter().flatten() {
            let is_read = column.decoder.read(&message.payload, &mut values).is_ok();
            let (stamp, value) = (values.nanoseconds(0), values.number(2));
            let Some((stamp, value)) = stamp.zip(value).filter(|_| is_read) else {
                continue;
            };
            let value = if column.is_negative { -value } else { value };
            if wanted(column.topic) && !take(number(column.topic, stamp, value)) {
                return;
            }
        }
    }
}

/// A column's value as a message.
fn number(topic: usize, stamp: i64, value: f64) -> Item {
    Item {
        topic,
        stamp: Some(stamp),
        payload: [&[0, 1, 0, 0], &value.to_le_bytes()[..]].concat(),
    }
}
