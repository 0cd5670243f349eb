//! The node: records the topics of the loop, or the selected topics, into a bag without decoding them.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use planesman_bag::qos::{History, OfferedQos};
use planesman_bag::writer::{BagWriter, TopicId, WriteError};
use planesman_bag::{Topic, TopicKind};
use planesman_msgs::cdr;
use planesman_msgs::planesman_msgs::msg::{TickAnswer, VehicleState};
use planesman_msgs::rosbag2_interfaces::srv::{
    IsPaused, IsPausedResponse, Pause, PauseResponse, Resume, ResumeResponse, Snapshot,
    SnapshotResponse, SplitBagfile, SplitBagfileResponse,
};
use planesman_node::{
    Definition, DefinitionError, Definitions, Domain, Level, Losses, Next, NodeSpec, Offer,
    PublishedTopic, Publisher, Qos, RawSample, ReceiveLimits, Responder, Runtime, args,
};

use crate::ring::{Kept, Ring};
use planesman_msgs::loop_topics::{self, Delivery, LoopTopic, OPTIONAL_SENSORS};
use planesman_recording::in_bag;
use planesman_recording::names;
use planesman_recording::parameters::{RecorderParameters, writer_options};
use planesman_recording::selection::Selection;

/// Interval of flushing, and of looking for topics.
const PERIOD: Duration = Duration::from_millis(100);
/// Interval of looking for publishers of awaited topics.
const AWAITING_PERIOD: Duration = Duration::from_millis(500);
/// Time without a sample after which no more is expected.
const SILENCE: Duration = Duration::from_millis(50);
/// Time for which a loop's publisher must be silent before another publisher of its topic is recorded; longer than the wait for a vehicle
/// that has ended.
const OUTLASTED: Duration = Duration::from_secs(10);
/// Longest time at the end in which nodes that keep publishing are still recorded.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Time for which the error is published on `/diagnostics` before the node ends.
const REPORTING: Duration = Duration::from_secs(2);
/// Maximum number of topics considered: a hostile peer can create any number.
const MOST_TOPICS: usize = 10_000;
/// Maximum number of warnings about single topics.
const MOST_WARNINGS: usize = 100;
/// Largest size of a vehicle state that is answered, bytes; the answer repeats the state's header.
const LARGEST_STATE: usize = 64 << 10;
/// Minimum size of the queue of messages waiting for the disk, bytes.
const LEAST_CACHE: u64 = 32 << 20;
/// Maximum number of QoS offers per topic in the bag.
const MOST_OFFERS: usize = 100;

/// Name of the bag's diagnostic status; level error means that recording has stopped.
pub const BAG: &str = "bag";

enum Event {
    /// A sample of the topic with this index.
    Sample(usize, RawSample),
    /// Timer event: flushes messages that have waited long enough, and looks for topics.
    Poll,
    /// The publisher's node answered with the definition of a topic's type.
    Described(PublishedTopic, Result<Definition, DefinitionError>),
    Pause(Responder<Pause>),
    Resume(Responder<Resume>),
    IsPaused(Responder<IsPaused>),
    Split(Responder<SplitBagfile>),
    Snapshot(Responder<Snapshot>),
    /// A parameter event; no parameter of this node can change while it runs.
    Parameters,
}

/// Runs the node with its command-line arguments until it is requested to stop.
#[must_use]
pub fn main(args: Vec<OsString>) -> ExitCode {
    planesman_node::exit_code("recorder", || run(args))
}

fn run(args: Vec<OsString>) -> Result<()> {
    let (rt, parameters) = Runtime::with_receive_limits(
        Domain::from_environment()?,
        NodeSpec {
            name: "recorder",
            namespace: "/auv",
            validate: |parameters| Ok(writer_options(parameters).map(drop)?),
            on_parameters: |_| Event::Parameters,
        },
        args::only(args)?,
        |parameters: &RecorderParameters| {
            let cache = parameters.storage.max_cache_size.max(LEAST_CACHE);
            ReceiveLimits::any(usize::try_from(cache).unwrap_or(usize::MAX))
        },
    )?;
    let output = match parameters.output.as_str() {
        "" => PathBuf::from("bags").join(format!("planesman_{}", names::utc_now())),
        path => PathBuf::from(path),
    };
    let options = writer_options(&parameters)?;
    // A name that is none, as in a list of names of elsewhere, names no topic.
    let expand = |name: &str| rt.topic_name(name).unwrap_or_else(|_| name.to_owned());
    let storage = &parameters.storage;
    let mut node = Node {
        writer: BagWriter::create(&output, options)?,
        topics: Vec::new(),
        awaited: Vec::new(),
        looked: Instant::now(),
        selection: Selection::new(&parameters.record, expand)?,
        types: BTreeMap::new(),
        warned: BTreeSet::new(),
        definitions: Definitions::from_environment(),
        paused: parameters.record.start_paused,
        ring: storage
            .snapshot_mode
            .then(|| Ring::new(storage.max_cache_size)),
        state: None,
        answer: parameters
            .answer
            .then(|| rt.loop_publisher("tick_answer"))
            .transpose()?,
        unfit: 0,
        failed: None,
    };
    node.subscribe_loop(&rt, &parameters)?;
    serve(&rt, node.ring.is_some())?;
    if node.selection.asks() {
        log::info!("recording the selected topics into {}", output.display());
        node.discover(&rt);
    } else {
        let number = node.topics.len() + node.awaited.len();
        log::info!("recording {number} topics into {}", output.display());
    }
    drop(rt.every(PERIOD, || Event::Poll));
    loop {
        match rt.next(Duration::MAX) {
            Next::Event(event) => node.on(&rt, event),
            Next::Stop => break,
            Next::Timeout => {}
        }
        if node.failed.is_some_and(|at| at.elapsed() > REPORTING) {
            break;
        }
    }
    // Messages sent before the request to stop belong in the bag.
    let deadline = Instant::now() + LAST_WORDS;
    while let Next::Event(event) = rt.next(SILENCE)
        && Instant::now() < deadline
    {
        node.on(&rt, event);
    }
    for (topic, missing) in node.account_for_losses() {
        log::warn!("{missing} messages of {topic} lost");
    }
    node.tell_status(&rt);
    let outcome = rt.shutdown();
    let bag = node.writer.close()?;
    log::info!("bag closed: {} messages", bag.message_count);
    Ok(outcome?)
}

/// A discovered topic in the form that the bag stores.
#[must_use]
pub fn published_topic(published: &PublishedTopic, definition: Definition) -> Topic {
    let has_text = !definition.text.is_empty();
    let kind = TopicKind {
        type_name: published.type_name.clone(),
        definition: definition.text,
        definition_encoding: if has_text { "ros2msg" } else { "" }.to_owned(),
        message_encoding: "cdr".to_owned(),
        type_hash: definition.type_hash,
        offered_qos: published
            .offers
            .iter()
            .take(MOST_OFFERS)
            .map(offered)
            .collect(),
    };
    Topic {
        name: published.name.clone(),
        kind: Arc::new(kind),
    }
}

/// Serves the services of rosbag2's recorder.
fn serve(rt: &Runtime<Event>, takes_snapshots: bool) -> Result<()> {
    rt.serve("~/pause", |_, responder| Event::Pause(responder))?;
    rt.serve("~/resume", |_, responder| Event::Resume(responder))?;
    rt.serve("~/is_paused", |_, responder| Event::IsPaused(responder))?;
    rt.serve("~/split_bagfile", |_, responder| Event::Split(responder))?;
    if takes_snapshots {
        rt.serve("~/snapshot", |_, responder| Event::Snapshot(responder))?;
    }
    Ok(())
}

/// A subscribed topic.
struct Recorded {
    /// Absolute name of the topic.
    name: String,
    kind: Arc<TopicKind>,
    /// Id in the bag, from the first message on.
    id: Option<TopicId>,
    losses: Losses,
}

struct Node {
    writer: BagWriter,
    /// Topics, by subscription index.
    topics: Vec<Recorded>,
    /// Topics of the loop that are subscribed to once somebody publishes them.
    awaited: Vec<LoopTopic>,
    /// Time of the last search for publishers of these topics.
    looked: Instant,
    selection: Selection,
    /// Type of each topic that is or will be recorded.
    types: BTreeMap<String, String>,
    /// Warnings already logged about topics that are not recorded.
    warned: BTreeSet<String>,
    definitions: Definitions,
    /// Whether recording is paused until `~/resume`.
    paused: bool,
    /// In snapshot mode, the messages that `~/snapshot` writes.
    ring: Option<Ring>,
    /// Index of the subscription whose messages begin a tick.
    state: Option<usize>,
    answer: Option<Publisher<TickAnswer>>,
    /// Number of messages stored with a corrected time, or not stored.
    unfit: u64,
    /// Time at which writing to the bag failed.
    failed: Option<Instant>,
}

impl Node {
    /// Subscribes to the loop's topics before anybody publishes them: without a selection to all of them, with a selection to those that must not
    /// lose a message.
    fn subscribe_loop(
        &mut self,
        rt: &Runtime<Event>,
        parameters: &RecorderParameters,
    ) -> Result<()> {
        let without_loss = parameters.answer || parameters.reliable_sensors;
        if self.selection.asks() && !without_loss {
            return Ok(());
        }
        for topic in loop_topics::selected(&parameters.topics)? {
            let topic = if without_loss {
                topic.without_loss()
            } else {
                topic
            };
            let name = rt.topic_name(topic.name)?;
            if !self.selection.takes(&name, topic.info.type_name) {
                continue;
            }
            self.types
                .insert(name.clone(), topic.info.type_name.to_owned());
            // Tools warn of topics that nobody publishes. In lockstep the first message counts, and so does that of a clock that is followed.
            let is_awaited = is_on_request(&topic) && !parameters.answer;
            match is_awaited && !(topic.name == "/clock" && rt.is_time_simulated()) {
                true => self.awaited.push(topic),
                false => self.subscribe_to_loop(rt, topic)?,
            }
        }
        if self.answer.is_some() && self.state.is_none() {
            bail!(
                "parameter 'answer': the recorder answers a tick once it has recorded the message of the topic 'state', which is not selected. Add 'state' to the selection"
            );
        }
        Ok(())
    }

    fn subscribe_to_loop(&mut self, rt: &Runtime<Event>, topic: LoopTopic) -> Result<()> {
        if topic.name == "state" {
            self.state = Some(self.topics.len());
        }
        let qos = match topic.delivery {
            Delivery::BestEffort => Qos::record(),
            Delivery::Reliable => Qos::record_reliable(),
            Delivery::Latched => Qos::record_latched(),
        };
        let qos = match topic.is_of_one_node() {
            true => qos.of_one_publisher_until(OUTLASTED),
            false => qos,
        };
        let name = rt.topic_name(topic.name)?;
        self.subscribe(rt, in_bag(&topic, &name), qos)
    }

    fn subscribe(&mut self, rt: &Runtime<Event>, topic: Topic, qos: Qos) -> Result<()> {
        let Topic { name, kind } = topic;
        let (index, hash) = (self.topics.len(), Some(kind.type_hash.as_str()));
        rt.subscribe_raw(
            &name,
            &kind.type_name,
            hash.filter(|hash| !hash.is_empty()),
            qos,
            move |sample| Event::Sample(index, sample),
        )?;
        self.topics.push(Recorded {
            name,
            kind,
            id: None,
            losses: Losses::default(),
        });
        Ok(())
    }

    /// Looks for topics that are selected or awaited and not recorded yet.
    fn discover(&mut self, rt: &Runtime<Event>) {
        let awaits = !self.awaited.is_empty() && self.looked.elapsed() > AWAITING_PERIOD;
        if !self.selection.asks() && !awaits {
            return;
        }
        self.looked = Instant::now();
        let published = rt.published_topics();
        let is_published = |topic: &mut LoopTopic| {
            let name = rt.topic_name(topic.name).unwrap_or_default();
            published
                .iter()
                .any(|it| it.name == name && it.type_name == topic.info.type_name)
        };
        let found: Vec<LoopTopic> = self.awaited.extract_if(.., is_published).collect();
        for topic in found {
            if let Err(error) = self.subscribe_to_loop(rt, topic) {
                log::error!("cannot record '{}': {error:#}", topic.name);
            }
        }
        if !self.selection.asks() {
            return;
        }
        for topic in published {
            let (name, type_name) = (&topic.name, &topic.type_name);
            if !self.selection.takes(name, type_name) {
                continue;
            }
            let unfit = match self.types.get(name) {
                Some(known) if known == type_name => continue,
                Some(known) => Some(format!(
                    "'{name}' is also published as {type_name}; only its messages of type {known} are recorded"
                )),
                None => (self.types.len() >= MOST_TOPICS).then(|| {
                    format!("the limit of {MOST_TOPICS} topics is reached: topics discovered later are not recorded")
                }),
            };
            if let Some(reason) = unfit {
                if self.warned.len() < MOST_WARNINGS && self.warned.insert(reason.clone()) {
                    log::warn!("{reason}");
                }
                continue;
            }
            self.types.insert(name.clone(), type_name.clone());
            match self.definitions.local(&topic) {
                Ok(definition) => self.subscribe_published(rt, &topic, definition),
                Err(_) => {
                    let finding = self.definitions.find(rt, &topic);
                    rt.when_done(async { Event::Described(topic, finding.await) });
                }
            }
        }
    }

    /// Subscribes to a topic with the QoS of its publishers.
    fn subscribe_published(
        &mut self,
        rt: &Runtime<Event>,
        published: &PublishedTopic,
        definition: Definition,
    ) {
        let all = |offers: fn(&Offer) -> bool| published.offers.iter().all(offers);
        let qos = match (all(|it| it.reliable), all(|it| it.latched)) {
            (true, true) => Qos::record_latched(),
            (true, false) => Qos::record_reliable(),
            (false, _) => Qos::record(),
        };
        let topic = published_topic(published, definition);
        match self.subscribe(rt, topic, qos) {
            Ok(()) => log::info!("Subscribed to topic '{}'", published.name),
            Err(error) => log::error!("cannot record '{}': {error:#}", published.name),
        }
    }

    fn on(&mut self, rt: &Runtime<Event>, event: Event) {
        match event {
            Event::Sample(index, sample) => {
                if self.is_own(rt, &sample) {
                    return;
                }
                let is_state = self.state == Some(index) && sample.bytes.len() <= LARGEST_STATE;
                let state = is_state.then(|| sample.bytes.clone());
                self.take(rt, index, sample);
                if let Some(state) = state {
                    self.answer(rt, &state);
                }
            }
            Event::Poll => {
                let outcome = self.writer.flush_if_due();
                self.note(rt, outcome);
                self.tell_status(rt);
                self.discover(rt);
            }
            Event::Described(topic, outcome) => {
                let definition = outcome.unwrap_or_else(|reason| {
                    log::warn!(
                        "'{}' is recorded without the definition of its type {}, so that tools may not read it: {reason}",
                        topic.name,
                        topic.type_name
                    );
                    Definition {
                        type_hash: topic.type_hash.clone().unwrap_or_default(),
                        ..Definition::default()
                    }
                });
                self.subscribe_published(rt, &topic, definition);
            }
            Event::Pause(responder) => {
                self.set_paused(rt, true);
                responder.answer(PauseResponse::default());
            }
            Event::Resume(responder) => {
                self.set_paused(rt, false);
                responder.answer(ResumeResponse::default());
            }
            Event::IsPaused(responder) => responder.answer(IsPausedResponse {
                paused: self.paused,
            }),
            Event::Split(responder) => {
                let outcome = self.writer.split();
                if let Ok(true) = outcome {
                    log::info!(
                        "recording into the next file, {}",
                        self.writer.file().display()
                    );
                }
                self.note(rt, outcome.map(drop));
                responder.answer(SplitBagfileResponse::default());
            }
            Event::Snapshot(responder) => {
                let success = self.take_snapshot(rt);
                responder.answer(SnapshotResponse { success });
            }
            Event::Parameters => {}
        }
    }

    fn set_paused(&mut self, rt: &Runtime<Event>, paused: bool) {
        if self.paused != paused {
            self.paused = paused;
            log::info!("{} recording", if paused { "pausing" } else { "resuming" });
            self.tell_status(rt);
        }
    }

    /// Writes the messages in memory to the bag; returns whether all of them were written.
    fn take_snapshot(&mut self, rt: &Runtime<Event>) -> bool {
        let kept = self.ring.as_mut().map(Ring::take).unwrap_or_default();
        log::info!("snapshot of {} messages written", kept.len());
        let mut is_written = true;
        for Kept {
            index,
            sample,
            received,
        } in kept
        {
            let outcome = self.record(index, &sample, received);
            is_written &= outcome.is_ok();
            self.note(rt, outcome);
        }
        let outcome = self.writer.flush();
        is_written &= outcome.is_ok();
        self.note(rt, outcome);
        is_written
    }

    /// Records a sample, keeps it in memory, or only counts it.
    fn take(&mut self, rt: &Runtime<Event>, index: usize, sample: RawSample) {
        let received = rt.now().nanos();
        if let Some(topic) = self.topics.get_mut(index)
            && sample.sequence > 0
        {
            topic.losses.received(sample.publisher, sample.sequence);
        }
        if self.paused {
            return;
        }
        let outcome = match &mut self.ring {
            Some(ring) => {
                ring.keep(Kept {
                    index,
                    sample,
                    received,
                });
                Ok(())
            }
            None => self.record(index, &sample, received),
        };
        self.note(rt, outcome);
    }

    /// Writes a sample. A bag has no times before the epoch: a message with such a time, as `/clock` may have, is stored at time 0.
    fn record(
        &mut self,
        index: usize,
        sample: &RawSample,
        received: i64,
    ) -> Result<(), WriteError> {
        let Some(topic) = self.topics.get_mut(index) else {
            return Ok(());
        };
        let id = match topic.id {
            Some(id) => id,
            None => *topic.id.insert(self.writer.add_topic(&Topic {
                name: topic.name.clone(),
                kind: Arc::clone(&topic.kind),
            })?),
        };
        let published = sample.published.as_ref().map_or(received, |t| t.nanos());
        if received.min(published) < 0 {
            self.unfit += 1;
        }
        self.writer
            .write_raw(id, &sample.bytes, received.max(0), published.max(0))
    }

    /// Notes in the bag and in the log how many messages of each topic are missing.
    fn account_for_losses(&mut self) -> Vec<(String, u64)> {
        let mut lost = Vec::new();
        for topic in &self.topics {
            if let (Some(id), missing @ 1..) = (topic.id, topic.losses.missing()) {
                self.writer.note_dropped(id, missing);
                lost.push((topic.name.clone(), missing));
            }
        }
        lost
    }

    /// Handles the result of a write. If the file cannot be written, recording ends with an error, logged once; if a single message is refused,
    /// recording continues.
    fn note(&mut self, rt: &Runtime<Event>, outcome: Result<(), WriteError>) {
        if self.failed.is_some() {
            return;
        }
        match outcome {
            Err(error @ WriteError::Failed { .. }) => {
                self.failed = Some(Instant::now());
                log::error!("recording has stopped: {error}");
                rt.set_status(BAG, Level::Error, &error.to_string(), &[]);
            }
            Err(error) => {
                if self.unfit == 0 {
                    log::warn!(
                        "message not recorded: {error}. Further such messages are only counted"
                    );
                }
                self.unfit += 1;
            }
            Ok(()) => {}
        }
    }

    /// Publishes the status of the recording, until it has failed.
    fn tell_status(&self, rt: &Runtime<Event>) {
        if self.failed.is_some() {
            return;
        }
        let health = self.writer.health();
        let lost: u64 = self.topics.iter().map(|it| it.losses.missing()).sum();
        let (level, message) = match self.unfit {
            0 if self.paused => (Level::Ok, "paused".to_owned()),
            0 => (Level::Ok, "recording".to_owned()),
            n => (
                Level::Warn,
                format!(
                    "recording; {n} messages were not recorded, because their time is invalid or they were refused"
                ),
            ),
        };
        rt.set_status(
            BAG,
            level,
            &message,
            &[
                ("file", self.writer.file().display().to_string()),
                ("bytes", health.bytes.to_string()),
                ("messages", health.messages().to_string()),
                ("lost", lost.to_string()),
                ("unfit", self.unfit.to_string()),
            ],
        );
    }

    /// Whether the sample is this node's own answer, which was recorded directly.
    fn is_own(&self, rt: &Runtime<Event>, sample: &RawSample) -> bool {
        self.answer
            .as_ref()
            .is_some_and(|answer| answer.topic() == sample.topic)
            && cdr::from_bytes::<TickAnswer>(&sample.bytes)
                .is_ok_and(|answer| answer.member == bare_name(&rt.full_name()))
    }

    /// Writes this node's answers directly to the bag: it receives its own messages only where multicast loops back on the interface.
    fn record_own(&mut self, rt: &Runtime<Event>, topic: String, message: &TickAnswer) {
        let Some(index) = self.topics.iter().position(|it| it.name == topic) else {
            return;
        };
        let sample = RawSample {
            topic,
            bytes: cdr::to_bytes(message),
            published: None,
            received: rt.now(),
            sequence: 0,
            publisher: [0; 16],
        };
        self.take(rt, index, sample);
    }

    fn answer(&mut self, rt: &Runtime<Event>, state: &[u8]) {
        let Some(answer) = &self.answer else {
            return;
        };
        if self.failed.is_some() {
            return; // What is not in the bag is not answered for.
        }
        match cdr::from_bytes::<VehicleState>(state) {
            Ok(state) => {
                let message = TickAnswer {
                    header: state.header,
                    member: bare_name(&rt.full_name()),
                };
                answer.publish(&message);
                let topic = answer.topic().to_owned();
                self.record_own(rt, topic, &message);
            }
            Err(error) => log::warn!("cannot answer a state: {error}"),
        }
    }
}

/// Whether no node publishes the topic in a usual loop in real time. Setpoints do not count, because the first one matters.
fn is_on_request(topic: &LoopTopic) -> bool {
    let on_request = [
        "/clock",
        "tick_answer",
        "estimate",
        "thruster_command",
        "thruster_setpoints",
    ];
    on_request.contains(&topic.name)
        || topic.name.starts_with("dha_state_")
        || OPTIONAL_SENSORS.contains(&topic.name)
}

/// A publisher's QoS in the form that the bag stores; discovery does not transmit the history.
fn offered(offer: &Offer) -> OfferedQos {
    let qos = match offer.reliable {
        true => OfferedQos::reliable(0),
        false => OfferedQos::best_effort(0),
    };
    let qos = OfferedQos {
        history: History::Unknown,
        ..qos
    };
    match offer.latched {
        true => qos.transient_local(),
        false => qos,
    }
}

fn bare_name(full: &str) -> String {
    full.rsplit('/').next().unwrap_or(full).to_owned()
}
