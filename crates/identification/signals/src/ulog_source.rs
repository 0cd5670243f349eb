//! Samples from a PX4 log (ULog, `.ulg`).
//!
//! A topic is what PX4 calls a message; its second instance is `NAME_1`, and so on. Stamps are those of the messages, since the
//! vehicle's start. A log that is cut off, as one is after a crash, is read up to the cut; where one is
//! damaged, it is read on behind.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use planesman_text::did_you_mean;

use crate::error::{Result, SourceError, listed, size};
use crate::request::{Reading, Request, Role, Take, distinct};
use crate::signal::Signal;
use crate::ulog::{Formats, Message, Messages, Place};

/// The field with the time, microseconds.
const STAMP: &str = "timestamp";

/// Fields of a topic, and topics, that are listed at most.
const FIELDS: usize = 1000;
const TOPICS: usize = 1000;

/// The interval of progress reports, in messages.
const PROGRESS_INTERVAL: u64 = 4096;

/// A log.
#[derive(Clone, Debug)]
pub struct UlogSource {
    path: PathBuf,
    bytes: u64,
    /// Fields by topic.
    topics: BTreeMap<String, Vec<String>>,
}

impl UlogSource {
    /// Reads the topics of the log at `path`.
    ///
    /// # Errors
    /// A line with the path: no file, no log, no message.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.display();
        let mut source = Self {
            path: path.to_owned(),
            bytes: size(path)?,
            topics: BTreeMap::new(),
        };
        let mut topics: BTreeMap<String, Vec<String>> = BTreeMap::new();
        source.each(&mut |data| {
            if !data.is_first || topics.len() >= TOPICS || topics.contains_key(data.topic) {
                return true;
            }
            let numbers = data.formats.numbers(data.format, FIELDS).into_iter();
            let names = numbers.map(|it| it.0).filter(|name| name != STAMP);
            topics.insert(data.topic.to_owned(), names.collect());
            true
        })?;
        if topics.is_empty() {
            return Err(SourceError::Data(format!(
                "{name}: the log holds no message"
            )));
        }
        source.topics = topics;
        Ok(source)
    }

    /// Its name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its size.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Its topics with the names of their fields.
    #[must_use]
    pub fn topics(&self) -> &BTreeMap<String, Vec<String>> {
        &self.topics
    }

    /// Requests for every field of a topic.
    #[must_use]
    pub fn requests(&self, topic: &str) -> Vec<Request> {
        let fields = self.topics.get(topic).into_iter().flatten();
        let request = |field: &String| Request {
            name: format!("{topic}:{field}"),
            role: Role::Output,
        };
        fields.map(request).collect()
    }

    /// Calls `take` with all data until it returns false.
    fn each(&self, take: &mut dyn FnMut(&Data<'_>) -> bool) -> Result<Told> {
        let name = self.path.display();
        let unreadable = SourceError::unreadable(&self.path);
        let file = File::open(&self.path).map_err(unreadable)?;
        let Some(mut messages) = Messages::of(file).map_err(unreadable)? else {
            return Err(SourceError::Data(format!("{name} is no ULog")));
        };
        let mut formats = Formats::default();
        // By number: topic, format, and whether its data has come.
        let mut subscriptions: BTreeMap<u16, (String, String, bool)> = BTreeMap::new();
        let mut told = Told::default();
        loop {
            let position = messages.position();
            match messages.next() {
                Ok(Some(Message::Format(text))) => formats.take(text),
                Ok(Some(Message::Subscription {
                    id,
                    instance,
                    format,
                })) => {
                    let format = String::from_utf8_lossy(format).into_owned();
                    let topic = match instance {
                        0 => format.clone(),
                        instance => format!("{format}_{instance}"),
                    };
                    subscriptions.insert(id, (topic, format, true));
                }
                Ok(Some(Message::Data { id, body })) => {
                    let Some((topic, format, is_first)) = subscriptions.get_mut(&id) else {
                        continue;
                    };
                    let data = Data {
                        id,
                        topic,
                        format,
                        formats: &formats,
                        is_first: std::mem::take(is_first),
                        body,
                        position,
                    };
                    if !take(&data) {
                        break;
                    }
                }
                Ok(Some(Message::Dropout(milliseconds))) => {
                    told.dropouts += 1;
                    told.lost += u64::from(milliseconds);
                }
                Ok(Some(Message::Other)) => {}
                Ok(None) => break,
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                    told.is_cut = true;
                    break;
                }
                Err(error) => return Err(unreadable(error)),
            }
        }
        told.damaged = messages.damaged;
        Ok(told)
    }

    /// The topic and the field of a request.
    fn find(&self, request: &Request) -> Result<(String, String)> {
        let signal: Signal = request.name.parse()?;
        let names = || self.topics.keys().map(String::as_str);
        let Some((topic, fields)) = self.topics.iter().find(|(name, _)| signal.is_on(name)) else {
            return Err(SourceError::Request(format!(
                "{signal}: the log has no such topic; it has {}{}",
                listed(names()),
                did_you_mean(signal.topic(), names())
            )));
        };
        let field = signal.path().to_string();
        if !fields.contains(&field) {
            let fields = || fields.iter().map(String::as_str);
            return Err(SourceError::Request(format!(
                "{signal}: {topic} has no field '{field}'; it has {}{}",
                listed(fields()),
                did_you_mean(&field, fields())
            )));
        }
        Ok((topic.clone(), field))
    }

    /// Hands every sample of the signals to `take`.
    ///
    /// # Errors
    /// A signal that is not there, or a log that cannot be read.
    pub fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let places: Vec<_> = requests
            .iter()
            .map(|request| self.find(request))
            .collect::<Result<_>>()?;
        distinct(requests, &places)?;
        // By subscription: where the stamp is, and each signal with its place.
        let mut plans: BTreeMap<u16, Plan> = BTreeMap::new();
        let mut messages = 0_u64;
        let told = self.each(&mut |data| {
            messages += 1;
            if messages.is_multiple_of(PROGRESS_INTERVAL) {
                progress(data.position);
            }
            if data.is_first {
                plans.insert(data.id, Plan::of(data, &places));
            }
            let Some(plan) = plans.get(&data.id) else {
                return true;
            };
            let microseconds = plan.stamp.and_then(|it| it.microseconds(data.body));
            let stamp = microseconds.and_then(|it| i64::try_from(it).ok()?.checked_mul(1000));
            let Some(stamp) = stamp else { return true };
            let mut more = true;
            for (signal, place) in &plan.signals {
                more &= take(*signal, stamp, place.read(data.body));
            }
            more
        })?;
        let mut notes = Vec::new();
        if told.is_cut {
            notes.push("the log is cut off".to_owned());
        }
        if told.damaged > 0 {
            notes.push(format!(
                "the log is damaged: {} bytes are of no message and are passed over",
                told.damaged
            ));
        }
        if told.dropouts > 0 {
            notes.push(format!(
                "the logger dropped messages {} times, for {:.3} s in all",
                told.dropouts,
                told.lost as f64 * 1e-3
            ));
        }
        Ok(Reading {
            stamps: "of the messages, since the vehicle's start".to_owned(),
            notes,
            ..Reading::default()
        })
    }
}

/// Data of a subscription.
struct Data<'a> {
    /// Its number.
    id: u16,
    topic: &'a str,
    format: &'a str,
    formats: &'a Formats,
    /// Nothing of it has come before.
    is_first: bool,
    body: &'a [u8],
    /// Where it stands in the file.
    position: u64,
}

/// What a log says beside its data.
#[derive(Default)]
struct Told {
    is_cut: bool,
    /// Bytes of no message.
    damaged: u64,
    dropouts: u64,
    /// ms.
    lost: u64,
}

/// How data of a subscription is read.
struct Plan {
    stamp: Option<Place>,
    signals: Vec<(usize, Place)>,
}

impl Plan {
    /// The places of those signals that are on its topic.
    fn of(data: &Data<'_>, places: &[(String, String)]) -> Self {
        let numbers: BTreeMap<String, Place> = data
            .formats
            .numbers(data.format, FIELDS)
            .into_iter()
            .collect();
        let here = places.iter().enumerate();
        let here = here.filter(|(_, (topic, _))| topic == data.topic);
        Self {
            stamp: numbers.get(STAMP).copied(),
            signals: here
                .filter_map(|(signal, (_, field))| Some((signal, *numbers.get(field)?)))
                .collect(),
        }
    }
}
