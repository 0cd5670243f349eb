//! Samples from a bag with any message types, decoded by its schemas.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use planesman_bag::reader::Messages;
use planesman_bag::{BagReader, Limits, Message, Order, Topic};
use planesman_decode::path::Step;
use planesman_decode::{Decoder, FieldPath, Types, Values, is_called};
use planesman_record::Input;
use planesman_text::{did_you_mean, setting};

use crate::bag_types::types;
use crate::error::{Result, SourceError, listed};
use crate::identity::Identity;
use crate::publishers::{Publishers, Senders};
use crate::request::{Clock, PROGRESS_INTERVAL, Reading, Request, Role, Take, distinct};
use crate::signal::Signal;
use crate::source::Source;
use crate::stamps::{self, Stamps};

/// Messages with more bytes report their progress.
const LARGE_MESSAGE: usize = 1 << 20;

/// For the choice of the clock: messages of a topic and in total whose stamps are examined, and bytes of the bag searched for them.
const STAMPS: u64 = 200;
const ALL_STAMPS: usize = 5000;
const STAMP_BYTES: u64 = 16 << 20;

/// Messages searched for the names of a list's elements, and names stored.
const NAMED_IN: usize = 10_000;
const MOST_NAMES: usize = 1000;

/// Messages searched to list names, and elements of a list distinguished by name.
const NAMED_FIRST: usize = 500;
const MOST_ELEMENTS: usize = 16;

/// An open bag, and the requested clock.
#[derive(Debug)]
pub(crate) struct BagSource {
    bag: BagReader,
    clock: Option<Clock>,
}

impl BagSource {
    /// Opens a bag: a folder, its metadata, one file, or several. At most `most_unpacked` decompressed bytes of chunks are read from each file.
    ///
    /// # Errors
    /// Like [`BagReader::open`].
    pub(crate) fn open(
        paths: &[PathBuf],
        clock: Option<Clock>,
        most_unpacked: Option<u64>,
    ) -> Result<Self> {
        let limits = Limits::unpacked(most_unpacked);
        let bag = match paths {
            [path] => BagReader::open_within(path, limits)?,
            paths => BagReader::open_all(paths, limits)?,
        };
        Ok(Self { bag, clock })
    }

    /// The messages of the requested topics, with the types in which the signals were found.
    fn messages<'a>(&'a self, wanted: &'a [RequestedSignal], order: Order) -> Messages<'a> {
        self.bag
            .messages_of(|topic| wanted.iter().any(|it| it.is_on(topic)), order)
    }

    /// The requested clock. Without a request, this is the messages' own clock if all have usable stamps, else the recorder's clock with the reason. Also
    /// returns the stamps that were seen.
    fn chosen(&self, wanted: &[RequestedSignal]) -> Result<(Clock, Option<String>, Vec<Stamps>)> {
        let without = wanted.iter().find(|it| !it.has_stamp);
        match (self.clock, without) {
            (Some(Clock::Header), Some(wanted)) => Err(SourceError::Request(format!(
                "{}: messages of type {} have no stamp; with {} all signals use the recorder's time",
                wanted.topic,
                wanted.type_name,
                setting("stamp", "log")
            ))),
            (Some(Clock::Log), _) => Ok((Clock::Log, None, Vec::new())),
            (Some(Clock::Header), None) => Ok((Clock::Header, None, self.first_stamps(wanted)?)),
            (None, Some(_)) => Ok((Clock::Log, None, Vec::new())),
            (None, None) => {
                let mut stamps = self.first_stamps(wanted)?;
                let reason = stamps::unfit(&mut stamps);
                let clock = match reason {
                    Some(_) => Clock::Log,
                    None => Clock::Header,
                };
                Ok((clock, reason, stamps))
            }
        }
    }

    /// The stamps of the first messages.
    fn first_stamps(&self, wanted: &[RequestedSignal]) -> Result<Vec<Stamps>> {
        let mut plans = Plans::new(&self.bag, wanted, Clock::Log);
        let mut messages = self.messages(wanted, Order::File);
        for _ in 0..ALL_STAMPS {
            let Some(Ok(message)) = messages.next() else {
                break;
            };
            plans.read(&message, &mut |_, _, _| true)?;
            if plans.stamps.iter().all(|it| it.messages() >= STAMPS)
                || messages.bytes_read() > STAMP_BYTES
            {
                break;
            }
        }
        Ok(plans.stamps)
    }
}

/// Passes the messages to `take` until it returns false; returns the reason why no more messages can be read.
///
/// # Errors
/// Errors of `take`.
pub fn each_message(
    mut messages: Messages<'_>,
    progress: &dyn Fn(u64),
    mut take: impl FnMut(&Message) -> Result<bool>,
) -> Result<Option<String>> {
    let mut count = 0_u64;
    while let Some(message) = messages.next() {
        let message = match message {
            Ok(message) => message,
            Err(error) => return Ok(Some(error.to_string())),
        };
        count += 1;
        let is_large = message.payload.len() > LARGE_MESSAGE;
        if is_large || count.is_multiple_of(PROGRESS_INTERVAL) {
            progress(messages.bytes_read());
        }
        if !take(&message)? {
            break;
        }
    }
    Ok(None)
}

impl Source for BagSource {
    fn name(&self) -> String {
        self.bag.path().display().to_string()
    }

    fn bytes(&self) -> u64 {
        self.bag.files().map(|(_, bytes)| bytes).sum()
    }

    fn bag(&self) -> Option<&BagReader> {
        Some(&self.bag)
    }

    /// Reads file by file in their stored order.
    fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        let wanted = requests
            .iter()
            .map(|request| RequestedSignal::find(&self.bag, request))
            .collect::<Result<Vec<_>>>()?;
        let places = wanted.iter();
        let places: Vec<_> = places
            .map(|it| (&it.topic, &it.path, it.publisher))
            .collect();
        distinct(requests, &places)?;
        let (clock, reason, seen) = self.chosen(&wanted)?;
        let mut reading = Reading {
            stamps: match clock {
                Clock::Header => "of the messages' headers",
                Clock::Log => "of the recorder",
            }
            .to_owned(),
            ..Reading::default()
        };
        let messages = self.messages(&wanted, Order::LogTime);
        let mut plans = Plans::new(&self.bag, &wanted, clock);
        for (stamps, seen) in plans.stamps.iter_mut().zip(&seen) {
            *stamps = seen.anew();
        }
        let mut is_empty = true;
        let broken = each_message(messages, progress, |message| {
            is_empty = false;
            plans.read(message, take)
        })?;
        reading.notes.extend(broken);
        for plan in &plans.list {
            plan.judge(&mut reading)?;
        }
        let found = plans.identities.iter().zip(&plans.senders);
        for (wanted, (identity, senders)) in wanted.iter().zip(found) {
            reading.notes.extend(identity.judge(&wanted.signal)?);
            senders.judge(&wanted.signal, wanted.publisher)?;
        }
        let unfit = match self.clock {
            None => stamps::unfit(&mut plans.stamps),
            Some(_) => stamps::unusable_stamps_reason(&plans.stamps),
        };
        match (unfit, reason) {
            (_, Some(reason)) => reading.notes.push(format!(
                "{reason}, so the recorder's time is used for all signals"
            )),
            (Some(reason), None) if clock == Clock::Header => {
                return Err(SourceError::Data(format!(
                    "{reason}; with {} all signals use the recorder's time",
                    setting("stamp", "log")
                )));
            }
            (_, None) => {
                let latencies = stamps::latencies(&mut plans.stamps);
                reading.notes.extend(stamps::lag(&latencies, clock));
                reading.latencies.extend(latencies);
            }
        }
        let notes = (plans.stamps.iter())
            .filter_map(|it| Some(format!("{}: {}", it.topic, it.note(clock)?)));
        reading.notes.extend(notes);
        if is_empty && let [note] = &reading.notes[..] {
            return Err(SourceError::Data(note.clone()));
        }
        (reading.notes).extend(self.bag.renamed().map(str::to_owned));
        if !self.bag.completeness().is_whole() {
            reading
                .notes
                .push(format!("the bag is {}", self.bag.completeness()));
        }
        Ok(reading)
    }
}

/// A signal and its topic.
struct RequestedSignal {
    signal: Signal,
    topic: String,
    type_name: String,
    path: FieldPath,
    role: Role,
    /// The chosen publisher if there are several, counted from 1.
    publisher: Option<usize>,
    has_stamp: bool,
}

impl RequestedSignal {
    /// Whether the messages of this topic contain the signal. Messages of another type on the same topic do not count.
    fn is_on(&self, topic: &Topic) -> bool {
        topic.name == self.topic && topic.kind.type_name == self.type_name
    }

    fn find(bag: &BagReader, request: &Request) -> Result<Self> {
        let signal: Signal = request.name.parse()?;
        let (path, publisher) = Publishers::chosen(signal.path());
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
                similar_signal(bag, &signal)
            )));
        };
        if found.iter().any(|it| it.name != topic.name) {
            return Err(SourceError::Request(format!(
                "{signal}: several topics match: {}. Write the full name of one of them",
                sorted(found.iter().map(|it| it.name.as_str()))
            )));
        }
        // Of several types on the topic, the first that has the signal.
        let readers = found.iter().map(|topic| {
            let types = types(bag, topic)?;
            let decoder = Decoder::compile(&types, std::slice::from_ref(&path))
                .map_err(|error| SourceError::Data(format!("{}: {error}", topic.name)))?;
            Ok((topic, types, decoder))
        });
        let mut readers: Vec<Result<_>> = readers.collect();
        let place = readers.iter().position(Result::is_ok).unwrap_or(0);
        let (topic, types, decoder) = readers.swap_remove(place)?;
        if let Some(names) = types.names_of(&path) {
            let count = first_count(bag, &topic.name, &decoder);
            let known = names_in(bag, &topic.name, &types, &path, None, 1);
            let example = match known.first() {
                Some(name) => path.with(Step::Named(name.clone())),
                None => path.with(Step::Index(0)),
            };
            return Err(SourceError::Request(format!(
                "{signal}: the field is a list of {}numbers, one for each '{names}' ({}); choose one number by name or index: {}:{example}",
                count.map_or_else(String::new, |count| format!("{count} ")),
                sorted(known.iter().map(String::as_str)),
                signal.topic()
            )));
        }
        for (list, name) in path.named() {
            let known = names_in(bag, &topic.name, &types, &list, Some(name), NAMED_IN);
            if !known.iter().any(|it| it == name) {
                return Err(SourceError::Request(format!(
                    "{signal}: there is no '{name}'; there are {}{}",
                    sorted(known.iter().map(String::as_str)),
                    did_you_mean(name, known.iter().map(String::as_str))
                )));
            }
        }
        Ok(Self {
            topic: topic.name.clone(),
            type_name: topic.kind.type_name.clone(),
            path,
            role: request.role,
            publisher,
            has_stamp: types.stamp().is_some(),
            signal,
        })
    }
}

/// The count of numbers in the first readable message of a topic.
fn first_count(bag: &BagReader, topic: &str, decoder: &Decoder) -> Option<usize> {
    let mut values = Values::default();
    let mut messages = bag
        .messages_of(|it| it.name == topic, Order::File)
        .flatten();
    let first = messages.find(|it| decoder.read(&it.payload, &mut values).is_ok());
    first.map(|_| values.list(0).len())
}

/// The names of a list's elements in the first messages of a topic, which may differ from message to message; stops at the message that
/// contains the name sought.
fn names_in(
    bag: &BagReader,
    topic: &str,
    types: &Types,
    list: &FieldPath,
    wanted: Option<&str>,
    most: usize,
) -> Vec<String> {
    let Some(decoder) = Decoder::of_names(types, list) else {
        return Vec::new();
    };
    let mut values = Values::default();
    let mut known: Vec<String> = Vec::new();
    let messages = bag.messages_of(|it| it.name == topic, Order::File);
    for message in messages.flatten().take(most) {
        if decoder.read(&message.payload, &mut values).is_err() {
            continue;
        }
        for name in values.names() {
            if known.len() < MOST_NAMES && !known.contains(name) {
                known.push(name.clone());
            }
        }
        let is_known = |wanted: &str| values.names().iter().any(|it| is_called(it, wanted));
        if wanted.is_some_and(is_known) {
            known.extend(wanted.map(str::to_owned));
            break;
        }
    }
    known
}

/// The numbers at `paths` in a topic's messages; elements of lists are selected by these names: `transforms[base_link]` instead of
/// `transforms[0]`.
#[must_use]
pub fn by_name(
    bag: &BagReader,
    topic: &Topic,
    types: &Types,
    paths: Vec<FieldPath>,
) -> Vec<FieldPath> {
    let mut lists: BTreeMap<FieldPath, Vec<String>> = BTreeMap::new();
    let mut named = Vec::new();
    for path in paths {
        let is_within = |it: &usize| matches!(path.steps[*it], Step::Index(_));
        let Some(at) = (0..path.steps.len().saturating_sub(1)).find(is_within) else {
            named.push(path);
            continue;
        };
        let list = path.first(at);
        let names = lists.entry(list.clone()).or_insert_with(|| {
            let all = names_in(bag, &topic.name, types, &list, None, NAMED_FIRST);
            short_names(&all)
        });
        match (&path.steps[at], names.len()) {
            (_, 0) => named.push(path),
            (_, count) if count > MOST_ELEMENTS => named.push(path),
            (Step::Index(0), _) => named.extend(names.iter().map(|it| path.choosing(at + 1, it))),
            _ => {}
        }
    }
    named
}

/// Names without their frames where these are not needed to distinguish them; empty if an element has no name.
fn short_names(names: &[String]) -> Vec<String> {
    let last = |name: &String| name.rsplit("->").next().unwrap_or_default().to_owned();
    let short = names.iter().map(|name| {
        let same = names.iter().filter(|it| last(it) == last(name)).count();
        if same == 1 { last(name) } else { name.clone() }
    });
    let short: Vec<String> = short.collect();
    match short.iter().any(String::is_empty) {
        true => Vec::new(),
        false => short,
    }
}

/// The topic that was probably meant; if the name has no leading `/`, topics are compared by the end of their name.
fn similar_signal(bag: &BagReader, signal: &Signal) -> String {
    let parts = signal.topic().split('/').count();
    let names = bag.topics().iter().map(|it| it.topic.name.as_str());
    let ends = names.map(|name| match name.rmatch_indices('/').nth(parts - 1) {
        Some((slash, _)) if !signal.topic().starts_with('/') => &name[slash + 1..],
        _ => name,
    });
    did_you_mean(signal.topic(), ends)
}

/// The names of a bag's topics; only the first if there are many.
#[must_use]
pub fn topics(bag: &BagReader) -> String {
    let names = sorted(bag.topics().iter().map(|it| it.topic.name.as_str()));
    match bag.omitted() {
        0 => names,
        more => format!("{names}, and {more} more"),
    }
}

/// The first of many names, in order.
fn sorted<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    match names.is_empty() {
        true => "none".to_owned(),
        false => listed(names),
    }
}

/// Reading plans for the messages of the requested topics, and the findings so far.
struct Plans<'w> {
    bag: &'w BagReader,
    wanted: &'w [RequestedSignal],
    clock: Clock,
    list: Vec<Plan>,
    /// Stamps by topic; the plans of all files of the bag share them.
    stamps: Vec<Stamps>,
    /// Publishers by topic; the plans of all files of the bag share them.
    publishers: Vec<Publishers>,
    /// By signal.
    identities: Vec<Identity>,
    senders: Vec<Senders>,
}

impl<'w> Plans<'w> {
    fn new(bag: &'w BagReader, wanted: &'w [RequestedSignal], clock: Clock) -> Self {
        let mut topics: Vec<&str> = wanted.iter().map(|it| it.topic.as_str()).collect();
        topics.sort_unstable();
        topics.dedup();
        Self {
            bag,
            wanted,
            clock,
            list: Vec::new(),
            publishers: vec![Publishers::default(); topics.len()],
            stamps: topics.into_iter().map(Stamps::of).collect(),
            identities: wanted.iter().map(|_| Identity::default()).collect(),
            senders: vec![Senders::default(); wanted.len()],
        }
    }

    /// Reads a message; returns whether more messages are needed.
    fn read(&mut self, message: &Message, take: &mut Take<'_>) -> Result<bool> {
        let known = self.list.iter();
        let mut known = known.map(|it| &it.topic);
        let place = match known.position(|it| Arc::ptr_eq(it, &message.topic)) {
            Some(place) => place,
            None => {
                let topic = &message.topic;
                let stamps = self.stamps.iter().position(|it| it.topic == topic.name);
                let Some(stamps) = stamps else {
                    return Ok(true);
                };
                let plan = Plan::of(self.bag, topic, self.wanted, stamps)?;
                self.list.push(plan);
                self.list.len() - 1
            }
        };
        let plan = &mut self.list[place];
        let publishers = &mut self.publishers[plan.stamps];
        let publisher = publishers.of(message.channel, message.sequence, message.log_time);
        let mut seen = TopicMessages {
            stamps: &mut self.stamps[plan.stamps],
            identities: &mut self.identities,
            senders: &mut self.senders,
        };
        Ok(plan.read(message, publisher, self.clock, &mut seen, take))
    }
}

/// The findings about the messages of a topic.
struct TopicMessages<'a> {
    stamps: &'a mut Stamps,
    identities: &'a mut [Identity],
    senders: &'a mut [Senders],
}

/// The names of all of this many first messages are examined, then of every n-th one: publishers seldom alternate with a period of seven.
const LOOKED_AT: u64 = 4096;
const LOOK_EVERY: u64 = 7;

/// Reading plan for the messages of one topic in one file.
struct Plan {
    topic: Arc<Topic>,
    decoder: Decoder,
    /// The decoder together with the names that identify the numbers.
    of_identities: Decoder,
    values: Values,
    /// Index of the topic's stamps.
    stamps: usize,
    /// The signals on this topic, in the order of the decoder's paths; seconds and nanoseconds follow.
    signals: Vec<(usize, Role, Option<usize>)>,
    has_stamp: bool,
    messages: u64,
    refused: u64,
    reason: String,
}

impl Plan {
    fn of(
        bag: &BagReader,
        topic: &Arc<Topic>,
        wanted: &[RequestedSignal],
        stamps: usize,
    ) -> Result<Self> {
        let types = types(bag, topic)?;
        let here = || wanted.iter().enumerate().filter(|(_, it)| it.is_on(topic));
        let mut paths: Vec<FieldPath> = here().map(|(_, it)| it.path.clone()).collect();
        let stamp = types.stamp();
        if let Some(stamp) = &stamp {
            paths.extend(["sec", "nanosec"].map(|name| stamp.field(name)));
        }
        let refuse = |error| SourceError::Data(format!("{}: {error}", topic.name));
        Ok(Self {
            topic: Arc::clone(topic),
            decoder: Decoder::compile(&types, &paths).map_err(refuse)?,
            of_identities: Decoder::compile_with_identities(&types, &paths).map_err(refuse)?,
            stamps,
            values: Values::default(),
            signals: here()
                .map(|(signal, it)| (signal, it.role, it.publisher))
                .collect(),
            has_stamp: stamp.is_some(),
            messages: 0,
            refused: 0,
            reason: String::new(),
        })
    }

    /// Returns whether more messages are needed.
    fn read(
        &mut self,
        message: &Message,
        publisher: usize,
        clock: Clock,
        seen: &mut TopicMessages<'_>,
        take: &mut Take<'_>,
    ) -> bool {
        self.messages += 1;
        let values = &mut self.values;
        let looks = self.messages <= LOOKED_AT || self.messages.is_multiple_of(LOOK_EVERY);
        let decoder = match looks {
            true => &self.of_identities,
            false => &self.decoder,
        };
        if let Err(error) = decoder.read(&message.payload, values) {
            self.refuse(error.to_string());
            return true;
        }
        let own = match self.has_stamp {
            true => values.nanoseconds(self.signals.len()),
            false => None,
        };
        let is_filled = seen.stamps.take(own, message.log_time);
        let stamp = match clock {
            Clock::Log => Some(message.log_time),
            Clock::Header if !is_filled => return true,
            Clock::Header => own,
        };
        let Some(stamp) = stamp else {
            self.refuse("the stamp is out of range".to_owned());
            return true;
        };
        let mut more = true;
        for (index, (signal, role, chosen)) in self.signals.iter().enumerate() {
            let list = values.list(index);
            if !list.is_empty() {
                seen.senders[*signal].take(publisher);
            }
            if chosen.is_some_and(|it| it != publisher) {
                continue;
            }
            if looks && !list.is_empty() {
                seen.identities[*signal].take(decoder, index, values);
            }
            more &= take(*signal, stamp, number(list, *role));
        }
        more
    }

    fn refuse(&mut self, reason: String) {
        if self.refused == 0 {
            self.reason = reason;
        }
        self.refused += 1;
    }

    /// Notes messages that could not be read.
    ///
    /// # Errors
    /// If no message could be read.
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

/// The value of a number or list for a role.
fn number(list: &[f64], role: Role) -> Option<f64> {
    match role {
        Role::Input => Input::through(list).map(|input| input.mean),
        Role::Output => list.first().copied(),
    }
}
