//! Samples from logs of vehicles: PX4's ULog, ArduPilot's DataFlash, telemetry of MAVLink, MOOS. Each is a row of [`KINDS`].
//!
//! A topic is a message or variable of the log. If several senders or instances send one, the topic has their label: `IMU[0]`, or
//! `ATTITUDE[1.1]` for system and component. Each format has a [`LogReader`]; damaged parts are skipped and noted.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use planesman_text::did_you_mean;

use crate::alog::Alog;
use crate::dataflash::DataFlash;
use crate::error::{Result, SourceError, listed, size};
use crate::log_message::{FIELDS, LogMessage, LogReader, VALUE};
use crate::mavlink::Telemetry;
use crate::request::{PROGRESS_INTERVAL, Reading, Request, Take, places};
use crate::source::{Source, SourceTopic};
use crate::ulog::Ulog;

/// Maximum number of topics.
const TOPICS: usize = 1000;

/// A reader, or the reason why the file does not have the format.
type Opened = std::result::Result<Box<dyn LogReader>, &'static str>;

/// A kind of log, with everything except its reader's code.
#[derive(Debug)]
pub struct LogKind {
    /// Who writes it.
    pub writer: &'static str,
    /// The endings of its files.
    pub endings: &'static [&'static str],
    /// The name of the format, used as the type of its messages.
    name: &'static str,
    /// The meaning of its stamps.
    stamps: &'static str,
    /// Makes a reader for a file, or returns the reason why the file does not have the format.
    open: fn(File) -> io::Result<Opened>,
}

static KINDS: [LogKind; 4] = [
    LogKind {
        writer: "PX4",
        endings: &["ulg", "ulog"],
        name: "ULog",
        stamps: SINCE_START,
        open: |file| Ok(Ulog::of(file)?.map(boxed).ok_or("no ULog")),
    },
    LogKind {
        writer: "ArduPilot",
        endings: &["bin"],
        name: "DataFlash",
        stamps: SINCE_START,
        open: |file| {
            let refusal = "not a DataFlash log of ArduPilot: it does not begin with A3 95 80";
            Ok(DataFlash::of(file)?.map(boxed).ok_or(refusal))
        },
    },
    LogKind {
        writer: "MAVLink",
        endings: &["tlog"],
        name: "MAVLink",
        stamps: "of the times at which messages were received",
        open: |file| Ok(Ok(boxed(Telemetry::of(file)))),
    },
    LogKind {
        writer: "MOOS",
        endings: &["alog"],
        name: "MOOS",
        stamps: "of the log, since its start",
        open: |file| Ok(Ok(boxed(Alog::of(file)))),
    },
];

const SINCE_START: &str = "of the messages, since the vehicle's start";

fn boxed(reader: impl LogReader + 'static) -> Box<dyn LogReader> {
    Box::new(reader)
}

impl LogKind {
    /// All supported kinds.
    #[must_use]
    pub fn all() -> &'static [Self] {
        &KINDS
    }

    /// The kind of a file, by its ending.
    #[must_use]
    pub fn of(path: &Path) -> Option<&'static Self> {
        KINDS.iter().find(|it| ends_in(path, it.endings))
    }
}

/// Whether a file name has one of these endings, in upper or lower case.
pub(crate) fn ends_in(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().unwrap_or_default();
    endings.iter().any(|it| ending.eq_ignore_ascii_case(it))
}

/// Topic and labels, as written in the log.
type Key = (String, [String; 2]);

/// The signals of a topic with its labels.
struct RequestedSignal<'a> {
    labels: &'a [String; 2],
    /// The names of the last message's fields.
    names: Rc<[String]>,
    /// For each signal its number, its field, and the field's place among the names.
    signals: Vec<(usize, &'a String, Option<usize>)>,
}

/// A log.
#[derive(Clone, Debug)]
pub struct LogSource {
    path: PathBuf,
    bytes: u64,
    kind: &'static LogKind,
    /// Fields by topic.
    topics: BTreeMap<String, (Key, Vec<String>)>,
    notes: Vec<String>,
}

impl LogSource {
    /// Reads the topics of the log of that kind at `path`.
    ///
    /// # Errors
    /// One line with the path: no file, not a log of its kind, or no message.
    pub fn open(path: &Path, kind: &'static LogKind) -> Result<Self> {
        let name = path.display();
        let mut source = Self {
            path: path.to_owned(),
            bytes: size(path)?,
            kind,
            topics: BTreeMap::new(),
            notes: Vec::new(),
        };
        let mut found: BTreeMap<Key, (Vec<String>, BTreeSet<String>)> = BTreeMap::new();
        let mut last: BTreeMap<Key, Rc<[String]>> = BTreeMap::new();
        source.notes = source.each(&mut |message, _| {
            let key = (message.topic.clone(), message.labels.clone());
            // Those of the message before are known.
            if last
                .get(&key)
                .is_some_and(|it| Rc::ptr_eq(it, &message.names))
            {
                return true;
            }
            if found.len() >= TOPICS && !found.contains_key(&key) {
                return true;
            }
            let (names, known) = found.entry(key.clone()).or_default();
            for name in &*message.names {
                if names.len() < FIELDS && known.insert(name.clone()) {
                    names.push(name.clone());
                }
            }
            last.insert(key, Rc::clone(&message.names));
            true
        })?;
        if found.is_empty() {
            return Err(SourceError::Data(format!(
                "{name}: the log contains no message with a time and a number{}",
                source.told()
            )));
        }
        // A label is told where the topic has several.
        let mut several: BTreeMap<&String, [BTreeSet<&String>; 2]> = BTreeMap::new();
        for (topic, labels) in found.keys() {
            let sets = several.entry(topic).or_default();
            sets.iter_mut().zip(labels).for_each(|(set, label)| {
                set.insert(label);
            });
        }
        let shown = |(topic, labels): &Key| {
            let told = labels
                .iter()
                .zip(&several[topic])
                .filter(|(_, set)| set.len() > 1);
            let told: Vec<&str> = told.map(|(label, _)| label.as_str()).collect();
            match told[..] {
                [] => topic.clone(),
                _ => format!("{topic}[{}]", told.join(",")),
            }
        };
        let topics = found
            .iter()
            .map(|(key, (names, _))| (shown(key), (key.clone(), names.clone())));
        source.topics = topics.collect();
        Ok(source)
    }

    /// The notes from opening the log, after a colon.
    fn told(&self) -> String {
        match &self.notes[..] {
            [] => String::new(),
            notes => format!("; {}", notes.join("; ")),
        }
    }

    /// Calls `take` with every message and its end position, until `take` returns false; returns notes on data that could not be read.
    fn each(&self, take: &mut dyn FnMut(&LogMessage, u64) -> bool) -> Result<Vec<String>> {
        let unreadable = SourceError::unreadable(&self.path);
        let file = File::open(&self.path).map_err(unreadable)?;
        let reader = (self.kind.open)(file).map_err(unreadable)?;
        let refused = |it: &str| SourceError::Data(format!("{} is {it}", self.path.display()));
        let mut reader = reader.map_err(refused)?;
        let mut message = LogMessage::default();
        while reader.next(&mut message).map_err(unreadable)? {
            if !take(&message, reader.position()) {
                break;
            }
        }
        Ok(reader.notes())
    }

    /// The topic and the field of a request.
    fn find(&self, request: &Request) -> Result<(&Key, String)> {
        let name = &request.name;
        let (topic, field) = name.split_once(':').unwrap_or((name, VALUE));
        let names = || self.topics.keys().map(String::as_str);
        let Some((key, fields)) = self.topics.get(topic) else {
            let is_of_it = |it: &&str| it.strip_prefix(topic).is_some_and(|it| it.starts_with('['));
            let of_it: Vec<&str> = names().filter(is_of_it).collect();
            let bare = topic
                .split('[')
                .next()
                .filter(|it| *it != topic && self.topics.contains_key(*it));
            return Err(SourceError::Request(match (&of_it[..], bare) {
                ([], Some(bare)) => {
                    format!(
                        "{name}: the log has only one instance of '{bare}'; write {bare}:{field}"
                    )
                }
                ([], None) => format!(
                    "{name}: the log has no such topic; it has {}{}{}",
                    listed(names()),
                    did_you_mean(topic, names()),
                    self.told()
                ),
                (several, _) => format!(
                    "{name}: the log has several instances: {}. Choose one of them",
                    listed(several.iter().copied())
                ),
            }));
        };
        if !fields.iter().any(|it| it == field) {
            let fields = || fields.iter().map(String::as_str);
            return Err(SourceError::Request(format!(
                "{name}: {topic} has no field '{field}'; it has {}{}",
                listed(fields()),
                did_you_mean(field, fields())
            )));
        }
        Ok((key, field.to_owned()))
    }
}

impl Source for LogSource {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }

    fn topics(&self) -> Vec<SourceTopic> {
        let topic = |(name, (_, fields)): (&String, &(Key, Vec<String>))| {
            let request = |field: &String| Request::output(format!("{name}:{field}"));
            SourceTopic {
                name: name.clone(),
                type_name: self.kind.name,
                requests: fields.iter().map(request).collect(),
            }
        };
        self.topics.iter().map(topic).collect()
    }

    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let places = places(requests, |it| self.find(it))?;
        let mut by_topic: BTreeMap<&str, Vec<RequestedSignal<'_>>> = BTreeMap::new();
        for (signal, ((topic, labels), field)) in places.iter().enumerate() {
            let of_topic = by_topic.entry(topic).or_default();
            let signal = (signal, field, None);
            match of_topic.iter_mut().find(|it| it.labels == labels) {
                Some(known) => known.signals.push(signal),
                None => of_topic.push(RequestedSignal {
                    labels,
                    names: Rc::default(),
                    signals: vec![signal],
                }),
            }
        }
        let mut count = 0_u64;
        let notes = self.each(&mut |message, position| {
            count += 1;
            if count.is_multiple_of(PROGRESS_INTERVAL) {
                progress(position);
            }
            // Once a message: to compare empty texts takes longer than to read a number.
            let is_of_it = |it: &&mut RequestedSignal<'_>| *it.labels == message.labels;
            let of_topic = by_topic.get_mut(message.topic.as_str());
            let Some(wanted) = of_topic.and_then(|it| it.iter_mut().find(is_of_it)) else {
                return true;
            };
            if !Rc::ptr_eq(&wanted.names, &message.names) {
                wanted.names = Rc::clone(&message.names);
                for (_, field, place) in &mut wanted.signals {
                    if place.and_then(|at| wanted.names.get(at)) != Some(*field) {
                        *place = wanted.names.iter().position(|it| it == *field);
                    }
                }
            }
            let mut more = true;
            for (signal, _, place) in &wanted.signals {
                if let Some(place) = place {
                    let value = message.values.get(*place).copied().flatten();
                    more &= take(*signal, message.stamp, value);
                }
            }
            more
        })?;
        Ok(Reading {
            stamps: self.kind.stamps.to_owned(),
            notes,
            ..Reading::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use planesman_testing::telemetry::Version;
    use planesman_testing::{dataflash, hostile, telemetry, ulog};
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn changed_logs_are_read_in_part_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let response = [(1.0, 0.5); 40];
        let moos = "0.0 A p 1.5\n0.1 B p X=1,Y=2\n%% c\n0.2 A p 2\n".repeat(20);
        let mut random = Pcg64Mcg::seed_from_u64(3);
        for (name, bytes) in [
            ("log.bin", dataflash::log(&response)),
            ("log.tlog", telemetry::log(&response, Version::One, 1)),
            ("log.TLOG", telemetry::log(&response, Version::Two, 2)),
            ("log.alog", moos.into_bytes()),
            ("log.ulg", ulog::log(&response)),
        ] {
            let path = folder.path().join(name);
            let kind = LogKind::of(&path).unwrap();
            for number in 0..300 {
                let bytes = match number {
                    0 => bytes.clone(),
                    _ => hostile::mutated(&bytes, &mut random),
                };
                let longest = bytes.len() as u64;
                std::fs::write(&path, bytes).unwrap();
                let Ok(log) = LogSource::open(&path, kind) else {
                    continue;
                };
                let topics = log.topics().into_iter();
                let requests: Vec<Request> = topics.flat_map(|it| it.requests).collect();
                let mut count = 0_u64;
                let mut take = |signal: usize, _, _| {
                    assert!(signal < requests.len());
                    count += 1;
                    true
                };
                log.read(&requests, &mut take, &|_| {}).unwrap();
                assert!(count <= 4 * longest, "{name} {number}");
            }
        }
    }

    #[test]
    fn numbers_of_every_letter_are_read() {
        // Letters of all widths in one message; values by hand, the half by IEEE 754: 0x3555 is 0.333251953125.
        let mut bytes = dataflash::format(
            90,
            "ALL",
            "QbBhHiIqfdcCeELg",
            "TimeUS,b,B,h,H,i,I,q,f,d,c,C,e,E,L,g",
            60,
        );
        let mut message = vec![0xa3, 0x95, 90];
        message.extend(7_u64.to_le_bytes());
        message.extend([0xff, 0xff]);
        message.extend((-2_i16).to_le_bytes());
        message.extend(65_535_u16.to_le_bytes());
        message.extend((-3_i32).to_le_bytes());
        message.extend(4_000_000_000_u32.to_le_bytes());
        message.extend((-4_i64).to_le_bytes());
        message.extend(0.5_f32.to_le_bytes());
        message.extend(0.25_f64.to_le_bytes());
        message.extend((-150_i16).to_le_bytes());
        message.extend(150_u16.to_le_bytes());
        message.extend((-250_i32).to_le_bytes());
        message.extend(250_u32.to_le_bytes());
        message.extend(525_000_000_i32.to_le_bytes());
        message.extend(0x3555_u16.to_le_bytes());
        bytes.extend(message);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.bin");
        std::fs::write(&path, bytes).unwrap();
        let log = LogSource::open(&path, LogKind::of(&path).unwrap()).unwrap();
        let mut values = vec![None; 15];
        let mut take = |signal: usize, stamp: i64, value| {
            assert_eq!(stamp, 7000);
            values[signal] = value;
            true
        };
        let requests = log.topics().remove(0).requests;
        log.read(&requests, &mut take, &|_| {}).unwrap();
        let expected = [
            -1.0,
            255.0,
            -2.0,
            65_535.0,
            -3.0,
            4e9,
            -4.0,
            0.5,
            0.25,
            -1.5,
            1.5,
            -2.5,
            2.5,
            52.5,
            0.333_251_953_125,
        ];
        assert_eq!(values, expected.map(Some));
    }
}
