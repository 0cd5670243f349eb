//! Samples from a bag with any message types, decoded by its schemas.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use planesman_bag::{BagReader, Message, Order, Topic};
use planesman_decode::{Decoder, FieldPath, Types, Values, schema};
use planesman_record::Input;
use planesman_text::did_you_mean;

use crate::error::{Result, SourceError};
use crate::request::{Clock, Reading, Request, Role, Take, distinct};
use crate::signal::Signal;

/// The interval of progress reports, in messages.
const PROGRESS_INTERVAL: u64 = 4096;

/// Messages of a topic of which the delay from stamp to reception is looked at.
const DELAYS: usize = 10_000;

/// A lag between stamp and reception that is reported, s.
const LAG: f64 = 1e-3;

/// Messages in which the names of a list's elements are looked for, and names that are kept.
const NAMED_IN: usize = 10_000;
const MOST_NAMES: usize = 1000;

/// Names that are listed in an error at most.
const LISTED: usize = 20;

/// An open bag, and whose stamps are wanted.
#[derive(Debug)]
pub struct BagSource {
    bag: BagReader,
    clock: Option<Clock>,
}

impl BagSource {
    /// Opens a bag: a folder, its metadata, one file, or several.
    ///
    /// # Errors
    /// As [`BagReader::open`].
    pub fn open(paths: &[PathBuf], clock: Option<Clock>) -> Result<Self> {
        let bag = match paths {
            [path] => BagReader::open(path)?,
            paths => BagReader::open_all(paths)?,
        };
        Ok(Self { bag, clock })
    }

    /// The bag.
    #[must_use]
    pub fn bag(&self) -> &BagReader {
        &self.bag
    }

    /// The requested source of stamps.
    #[must_use]
    pub fn clock(&self) -> Option<Clock> {
        self.clock
    }

    /// The bytes of its files.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bag.files().map(|(_, bytes)| bytes).sum()
    }

    /// Hands every sample of the signals to `take`, file by file as they lie.
    ///
    /// # Errors
    /// A signal that no topic has, or messages of which none can be read.
    pub fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let wanted = requests
            .iter()
            .map(|request| Wanted::find(&self.bag, request))
            .collect::<Result<Vec<_>>>()?;
        let places: Vec<_> = wanted.iter().map(|it| (&it.topic, &it.path)).collect();
        distinct(requests, &places)?;
        let clock = self.chosen(&wanted)?;
        let mut reading = Reading {
            stamps: match clock {
                Clock::Header => "of the messages' headers",
                Clock::Log => "of the recorder",
            }
            .to_owned(),
            ..Reading::default()
        };
        let mut plans: Vec<Plan> = Vec::new();
        let mut messages = self.bag.messages_of(
            |topic| wanted.iter().any(|it| it.topic == topic.name),
            Order::File,
        );
        let mut count = 0_u64;
        while let Some(message) = messages.next() {
            let message = match message {
                Ok(message) => message,
                Err(error) => {
                    reading.notes.push(error.to_string());
                    break;
                }
            };
            count += 1;
            if count.is_multiple_of(PROGRESS_INTERVAL) {
                progress(messages.bytes_read());
            }
            let known = plans
                .iter()
                .position(|it| Arc::ptr_eq(&it.topic, &message.topic));
            let place = match known {
                Some(place) => place,
                None => {
                    plans.push(Plan::of(&message.topic, &wanted, clock)?);
                    plans.len() - 1
                }
            };
            if !plans[place].read(&message, take) {
                break;
            }
        }
        for plan in &mut plans {
            plan.judge(&mut reading)?;
            if let Some(latency) = plan.latency() {
                let known = reading.latencies.entry(plan.topic.name.clone());
                known.or_insert(latency);
            }
        }
        reading.notes.extend(lag(&reading.latencies, clock));
        if count == 0
            && let [note] = &reading.notes[..]
        {
            return Err(SourceError::Data(note.clone()));
        }
        if !self.bag.completeness().is_whole() {
            reading
                .notes
                .push(format!("the bag is {}", self.bag.completeness()));
        }
        Ok(reading)
    }

    /// The clock asked for, or the messages' own if all have one.
    fn chosen(&self, wanted: &[Wanted]) -> Result<Clock> {
        let without = wanted.iter().find(|it| !it.has_stamp);
        match (self.clock, without) {
            (Some(Clock::Header), Some(wanted)) => Err(SourceError::Request(format!(
                "{}: messages of type {} carry no stamp; --stamp log takes the recorder's for all",
                wanted.topic, wanted.type_name
            ))),
            (Some(clock), _) => Ok(clock),
            (None, None) => Ok(Clock::Header),
            (None, Some(_)) => Ok(Clock::Log),
        }
    }
}

/// A signal, and the topic that has it.
struct Wanted {
    topic: String,
    type_name: String,
    path: FieldPath,
    role: Role,
    has_stamp: bool,
}

impl Wanted {
    fn find(bag: &BagReader, request: &Request) -> Result<Self> {
        let signal: Signal = request.name.parse()?;
        let mut found: Vec<&Arc<Topic>> = bag
            .topics()
            .iter()
            .map(|it| &it.topic)
            .filter(|it| signal.is_on(&it.name))
            .collect();
        if found.iter().any(|it| it.name == signal.topic()) {
            found.retain(|it| it.name == signal.topic());
        }
        let Some(topic) = found.first() else {
            return Err(SourceError::Request(format!(
                "{signal}: the bag has no such topic; it has {}{}",
                topics(bag),
                meant(bag, &signal)
            )));
        };
        if found.iter().any(|it| it.name != topic.name) {
            return Err(SourceError::Request(format!(
                "{signal}: several topics are meant: {}; write one in full",
                listed(found.iter().map(|it| it.name.as_str()))
            )));
        }
        let types = types(topic)?;
        let decoder = Decoder::compile(&types, std::slice::from_ref(signal.path()))
            .map_err(|error| SourceError::Data(format!("{}: {error}", topic.name)))?;
        if let Some(names) = types.names_of(signal.path()) {
            let count = first_count(bag, &topic.name, &decoder);
            let known = names_in(bag, &topic.name, &types, signal.path(), None);
            let example = known.first().map_or("0", String::as_str);
            return Err(SourceError::Request(format!(
                "{signal}: it is a list of {}numbers, one for each '{names}' ({}); name one by its name or index, as \
                 {signal}[{example}]",
                count.map_or_else(String::new, |count| format!("{count} ")),
                listed(known.iter().map(String::as_str))
            )));
        }
        if let Some((list, name)) = signal.path().named() {
            let known = names_in(bag, &topic.name, &types, &list, Some(name));
            if !known.iter().any(|it| it == name) {
                return Err(SourceError::Request(format!(
                    "{signal}: there is no '{name}'; there are {}{}",
                    listed(known.iter().map(String::as_str)),
                    did_you_mean(name, known.iter().map(String::as_str))
                )));
            }
        }
        Ok(Self {
            topic: topic.name.clone(),
            type_name: topic.kind.type_name.clone(),
            path: signal.path().clone(),
            role: request.role,
            has_stamp: types.stamp().is_some(),
        })
    }
}

/// How many numbers the first message of a topic that can be read holds.
fn first_count(bag: &BagReader, topic: &str, decoder: &Decoder) -> Option<usize> {
    let mut values = Values::default();
    let mut messages = bag
        .messages_of(|it| it.name == topic, Order::File)
        .flatten();
    let first = messages.find(|it| decoder.read(&it.payload, &mut values).is_ok());
    first.map(|_| values.list(0).len())
}

/// The names of the elements of a list in the first messages of a topic, which need not all have the same: up to the message
/// that has the one looked for.
fn names_in(
    bag: &BagReader,
    topic: &str,
    types: &Types,
    list: &FieldPath,
    wanted: Option<&str>,
) -> Vec<String> {
    let Some(decoder) = Decoder::of_names(types, list) else {
        return Vec::new();
    };
    let mut values = Values::default();
    let mut known: Vec<String> = Vec::new();
    let messages = bag.messages_of(|it| it.name == topic, Order::File);
    for message in messages.flatten().take(NAMED_IN) {
        if decoder.read(&message.payload, &mut values).is_err() {
            continue;
        }
        for name in values.names() {
            if known.len() < MOST_NAMES && !known.contains(name) {
                known.push(name.clone());
            }
        }
        let is_known = |wanted: &str| values.names().iter().any(|it| it == wanted);
        if wanted.is_none_or(is_known) {
            known.extend(wanted.map(str::to_owned));
            break;
        }
    }
    known
}

/// The topic that was probably meant; without a leading `/`, by the end of its name.
fn meant(bag: &BagReader, signal: &Signal) -> String {
    let parts = signal.topic().split('/').count();
    let names = bag.topics().iter().map(|it| it.topic.name.as_str());
    let ends = names.map(|name| match name.rmatch_indices('/').nth(parts - 1) {
        Some((slash, _)) if !signal.topic().starts_with('/') => &name[slash + 1..],
        _ => name,
    });
    did_you_mean(signal.topic(), ends)
}

/// The names of a bag's topics, the first of many.
#[must_use]
pub fn topics(bag: &BagReader) -> String {
    let names = listed(bag.topics().iter().map(|it| it.topic.name.as_str()));
    match bag.omitted() {
        0 => names,
        more => format!("{names}, and {more} more"),
    }
}

/// The first names of many.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    let more = names.len().saturating_sub(LISTED);
    names.truncate(LISTED);
    match (names.is_empty(), more) {
        (true, _) => "none".to_owned(),
        (_, 0) => names.join(", "),
        _ => format!("{} and {more} more", names.join(", ")),
    }
}

/// The types a topic's schema defines.
///
/// # Errors
/// A line naming the topic, when its messages are not CDR or its schema cannot be read.
pub fn types(topic: &Topic) -> Result<Types> {
    let name = &topic.name;
    if topic.kind.message_encoding != "cdr" {
        return Err(SourceError::Data(format!(
            "{name}: messages are encoded as '{}'; cdr is read",
            topic.kind.message_encoding.escape_default()
        )));
    }
    let kind = &topic.kind;
    if kind.definition_encoding.is_empty() && kind.definition.is_empty() {
        return Err(SourceError::Data(format!(
            "{name}: the bag does not hold the definition of {}, as no bag of Humble's sqlite3 storage does; 'ros2 bag \
             convert' to mcap, where that type is installed, adds it",
            kind.type_name
        )));
    }
    schema::read(&kind.type_name, &kind.definition_encoding, &kind.definition)
        .map_err(|error| SourceError::Data(format!("{name}: {}", brief(error.to_string()))))
}

/// A reason that quotes what a file says, which may be long.
fn brief(reason: String) -> String {
    const LONGEST: usize = 300;
    match reason.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} ...", &reason[..end]),
        None => reason,
    }
}

/// How the messages of one topic of one file are read.
struct Plan {
    topic: Arc<Topic>,
    decoder: Decoder,
    values: Values,
    /// The signals on this topic, in the order of the decoder's paths; seconds and nanoseconds follow.
    signals: Vec<(usize, Role)>,
    clock: Clock,
    has_stamp: bool,
    messages: u64,
    /// How long after its own stamp the recorder received a message, ns.
    delays: Vec<i64>,
    refused: u64,
    reason: String,
}

impl Plan {
    fn of(topic: &Arc<Topic>, wanted: &[Wanted], clock: Clock) -> Result<Self> {
        let types = types(topic)?;
        let here = || {
            wanted
                .iter()
                .enumerate()
                .filter(|(_, it)| it.topic == topic.name)
        };
        let mut paths: Vec<FieldPath> = here().map(|(_, it)| it.path.clone()).collect();
        let stamp = types.stamp();
        if let Some(stamp) = &stamp {
            paths.extend(["sec", "nanosec"].map(|name| stamp.field(name)));
        }
        Ok(Self {
            topic: Arc::clone(topic),
            decoder: Decoder::compile(&types, &paths)
                .map_err(|error| SourceError::Data(format!("{}: {error}", topic.name)))?,
            values: Values::default(),
            signals: here().map(|(signal, it)| (signal, it.role)).collect(),
            clock,
            has_stamp: stamp.is_some(),
            messages: 0,
            delays: Vec::new(),
            refused: 0,
            reason: String::new(),
        })
    }

    /// Returns whether more is wanted.
    fn read(&mut self, message: &Message, take: &mut Take<'_>) -> bool {
        self.messages += 1;
        let values = &mut self.values;
        if let Err(error) = self.decoder.read(&message.payload, values) {
            self.refuse(error.to_string());
            return true;
        }
        let own = match self.has_stamp {
            true => nanoseconds(values, self.signals.len()),
            false => None,
        };
        if let Some(own) = own
            && self.delays.len() < DELAYS
        {
            self.delays.push(message.log_time.saturating_sub(own));
        }
        let stamp = match self.clock {
            Clock::Log => Some(message.log_time),
            Clock::Header => own,
        };
        let Some(stamp) = stamp else {
            self.refuse("its stamp is out of range".to_owned());
            return true;
        };
        let mut more = true;
        for (index, (signal, role)) in self.signals.iter().enumerate() {
            more &= take(*signal, stamp, number(values.list(index), *role));
        }
        more
    }

    /// The median time from a message's stamp to its reception, s.
    fn latency(&mut self) -> Option<f64> {
        let middle = self.delays.len().checked_sub(1)? / 2;
        let (_, median, _) = self.delays.select_nth_unstable(middle);
        Some(*median as f64 * 1e-9)
    }

    fn refuse(&mut self, reason: String) {
        if self.refused == 0 {
            self.reason = reason;
        }
        self.refused += 1;
    }

    /// Tells of messages that could not be read.
    ///
    /// # Errors
    /// When none could.
    fn judge(&self, reading: &mut Reading) -> Result<()> {
        if self.refused == 0 {
            return Ok(());
        }
        let note = format!(
            "{}: {} of {} messages cannot be read as {}; the first: {}",
            self.topic.name, self.refused, self.messages, self.topic.kind.type_name, self.reason
        );
        if self.refused == self.messages {
            return Err(SourceError::Data(note));
        }
        reading.notes.push(note);
        Ok(())
    }
}

/// How much later than their stamps the topics' messages were received, and what that means for a model; nothing where all
/// are as late as each other.
fn lag(latencies: &BTreeMap<String, f64>, clock: Clock) -> Option<String> {
    let least = latencies.values().copied().fold(f64::INFINITY, f64::min);
    let most = latencies
        .values()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let (difference, meaning) = match clock {
        Clock::Header => (
            most - least,
            "lie between them; by the stamps of the headers this is no delay of the system",
        ),
        Clock::Log => (
            most.max(most - least),
            "count as delay of the system by the stamps of the recorder",
        ),
    };
    if latencies.is_empty() || difference <= LAG {
        return None;
    }
    let each = latencies.iter();
    let each: Vec<String> = each
        .map(|(topic, latency)| format!("{topic} {:.1} ms", latency * 1e3))
        .collect();
    Some(format!(
        "received after their own stamps (median): {}; {:.1} ms {meaning}",
        each.join(", "),
        difference * 1e3
    ))
}

/// The stamp whose seconds are at `index`, nanoseconds behind.
#[must_use]
pub fn nanoseconds(values: &Values, index: usize) -> Option<i64> {
    let seconds = values.number(index)? as i64;
    let nanoseconds = values.number(index + 1)? as i64;
    seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}

/// The value of a number or list in a role.
fn number(list: &[f64], role: Role) -> Option<f64> {
    match role {
        Role::Input => Input::through(list).map(|input| input.mean),
        Role::Output => list.first().copied(),
    }
}
