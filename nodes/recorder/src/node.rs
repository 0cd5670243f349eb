//! The node: records every topic of the loop, undecoded, into a bag.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Result;
use planesman_bag::writer::{BagWriter, TopicId, WriteError};
use planesman_msgs::cdr;
use planesman_msgs::planesman_msgs::msg::{TickAnswer, VehicleState};
use planesman_node::{Level, Next, NodeSpec, Publisher, Qos, RawSample, Runtime, args};

use crate::loop_topics::{self, Delivery, LoopTopic};
use crate::names;
use crate::parameters::writer_options;

/// Time between two looks for what is to be flushed.
const PERIOD: Duration = Duration::from_millis(100);
/// Without a sample for so long nothing more is on its way.
const SILENCE: Duration = Duration::from_millis(50);
/// Longest that others who go on talking are listened to at the end.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Time for which the error is on `/diagnostics` before the node ends.
const REPORTING: Duration = Duration::from_secs(2);

/// The status of the bag; an error means that nothing more is recorded.
pub const BAG: &str = "bag";

enum Event {
    /// A sample of the topic with this index.
    Sample(usize, RawSample),
    /// Time to flush what has waited long enough.
    Look,
    /// Nothing of this node changes while it runs.
    Parameters,
}

/// Runs the node with its command-line arguments until it is asked to stop.
#[must_use]
pub fn main(args: Vec<String>) -> ExitCode {
    planesman_node::exit_code("recorder", || run(args))
}

fn run(args: Vec<String>) -> Result<()> {
    let (rt, parameters) = Runtime::start(
        NodeSpec {
            name: "recorder",
            namespace: "/auv",
            validate: |parameters| {
                writer_options(parameters)
                    .map(drop)
                    .map_err(|error| error.to_string())
            },
            on_parameters: |_| Event::Parameters,
        },
        args::only(args)?,
    )?;
    let output = match parameters.output.as_str() {
        "" => PathBuf::from("bags").join(format!("planesman_{}", names::utc_now())),
        path => PathBuf::from(path),
    };
    let options = writer_options(&parameters)?;
    let mut node = Node {
        writer: BagWriter::create(&output, options)?,
        topics: Vec::new(),
        state: None,
        answer: parameters
            .answer
            .then(|| rt.publisher("tick_answer", Qos::reliable(100)))
            .transpose()?,
        unfit: 0,
        failed: None,
    };
    let mut selected = loop_topics::selected(&parameters.topics)?;
    if node.answer.is_some() || parameters.reliable_sensors {
        selected
            .iter_mut()
            .for_each(|topic| *topic = topic.without_loss());
    }
    for (index, topic) in selected.iter().enumerate() {
        node.subscribe(&rt, index, topic)?;
    }
    log::info!(
        "recording {} topics into {}",
        selected.len(),
        output.display()
    );
    drop(rt.every(PERIOD, || Event::Look));
    loop {
        match rt.next(PERIOD) {
            Next::Event(event) => node.on(&rt, event),
            Next::Stop => break,
            Next::Nothing => {}
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
    let outcome = rt.shutdown();
    let bag = node.writer.close()?;
    log::info!("bag closed: {} messages", bag.message_count);
    outcome
}

struct Node {
    writer: BagWriter,
    /// By subscription; known to the bag from the first sample on.
    topics: Vec<(LoopTopic, Option<TopicId>)>,
    /// The subscription whose samples begin a tick.
    state: Option<usize>,
    answer: Option<Publisher<TickAnswer>>,
    /// Messages kept at another time than they came with, or not at all.
    unfit: u64,
    /// Since when the bag takes nothing more.
    failed: Option<Instant>,
}

impl Node {
    fn subscribe(&mut self, rt: &Runtime<Event>, index: usize, topic: &LoopTopic) -> Result<()> {
        let qos = match topic.delivery {
            Delivery::BestEffort => Qos::record(),
            Delivery::Reliable => Qos::record_reliable(),
            Delivery::Latched => Qos::record_latched(),
        };
        rt.subscribe_raw(
            topic.name,
            topic.info.type_name,
            Some(topic.info.type_hash),
            qos,
            move |sample| Event::Sample(index, sample),
        )?;
        if topic.name == "state" {
            self.state = Some(index);
        }
        self.topics.push((*topic, None));
        Ok(())
    }

    fn on(&mut self, rt: &Runtime<Event>, event: Event) {
        match event {
            Event::Sample(index, sample) => {
                if self.is_own(rt, index, &sample) {
                    return;
                }
                let outcome = self.record(rt, index, &sample);
                self.note(rt, outcome);
                if self.state == Some(index) {
                    self.answer(rt, &sample);
                }
            }
            Event::Look => {
                let outcome = self.writer.flush_if_due();
                self.note(rt, outcome);
            }
            Event::Parameters => {}
        }
    }

    /// A bag has no times before its epoch: what claims one, as a `/clock` may, is kept at its beginning.
    fn record(
        &mut self,
        rt: &Runtime<Event>,
        index: usize,
        sample: &RawSample,
    ) -> Result<(), WriteError> {
        let Some((topic, id)) = self.topics.get_mut(index) else {
            return Ok(());
        };
        let id = match *id {
            Some(id) => id,
            None => *id.insert(self.writer.add_topic(&topic.in_bag(&sample.topic))?),
        };
        let received = rt.now().nanos();
        let published = sample.published.as_ref().map_or(received, |t| t.nanos());
        if received.min(published) < 0 {
            self.unfit += 1;
        }
        self.writer
            .write_raw(id, &sample.bytes, received.max(0), published.max(0))
    }

    /// A file that cannot be written ends the recording: an error is reported, once. Whatever else one message
    /// is refused for, the others are recorded.
    fn note(&mut self, rt: &Runtime<Event>, outcome: Result<(), WriteError>) {
        if self.failed.is_some() {
            return;
        }
        match outcome {
            Err(error @ WriteError::Failed { .. }) => {
                self.failed = Some(Instant::now());
                log::error!("recording has stopped: {error}");
                rt.set_status(BAG, Level::Error, &error.to_string(), &[]);
                return;
            }
            Err(error) => {
                if self.unfit == 0 {
                    log::warn!("message not recorded: {error}; further ones are only counted");
                }
                self.unfit += 1;
            }
            Ok(()) => {}
        }
        let health = self.writer.health();
        let (level, message) = match self.unfit {
            0 => (Level::Ok, "recording".to_owned()),
            n => (
                Level::Warn,
                format!("recording; {n} messages not recorded: invalid time, or refused"),
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
                ("lost", health.dropped().to_string()),
                ("unfit", self.unfit.to_string()),
            ],
        );
    }

    /// Whether it is an answer of its own: it has been recorded.
    fn is_own(&self, rt: &Runtime<Event>, index: usize, sample: &RawSample) -> bool {
        self.answer.is_some()
            && self.topics[index].0.name == "tick_answer"
            && cdr::from_bytes::<TickAnswer>(&sample.bytes)
                .is_ok_and(|answer| answer.member == bare_name(&rt.full_name()))
    }

    /// Where multicast comes back on the interface a node receives its own messages, elsewhere not: its answers are
    /// written to the bag directly.
    fn record_own(&mut self, rt: &Runtime<Event>, message: &TickAnswer) {
        let Some(index) = self
            .topics
            .iter()
            .position(|(t, _)| t.name == "tick_answer")
        else {
            return;
        };
        let sample = RawSample {
            topic: self
                .answer
                .as_ref()
                .map_or_else(String::new, |a| a.topic().to_owned()),
            bytes: cdr::to_bytes(message),
            published: None,
            received: rt.now(),
            sequence: 0,
        };
        let outcome = self.record(rt, index, &sample);
        self.note(rt, outcome);
    }

    fn answer(&mut self, rt: &Runtime<Event>, sample: &RawSample) {
        let Some(answer) = &self.answer else {
            return;
        };
        if self.failed.is_some() {
            return; // What is not in the bag is not answered for.
        }
        match cdr::from_bytes::<VehicleState>(&sample.bytes) {
            Ok(state) => {
                let message = TickAnswer {
                    header: state.header,
                    member: bare_name(&rt.full_name()),
                };
                answer.publish(&message);
                self.record_own(rt, &message)
            }
            Err(error) => log::warn!("cannot answer a state: {error}"),
        }
    }
}

fn bare_name(full: &str) -> String {
    full.rsplit('/').next().unwrap_or(full).to_owned()
}
