//! The playback: publishes the inputs tick by tick, and records the outputs in a bag.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use planesman_bag::qos::Durability;
use planesman_bag::{BagReader, BagWriter, Order, Topic, TopicId};
use planesman_decode::{StampDecoder, Values};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_node::{Direction, Next, Publisher, Qos, RawPublisher, RawSample, Runtime};
use planesman_show::diff::stamp_decoder;

use super::plan::{Event, Plan, PlayArgs, START, Started, stamps_of};

/// Time for discovery to settle, and for the last outputs to arrive.
const SETTLING: Duration = Duration::from_millis(500);
/// Queue depth of each topic, messages.
const DEPTH: usize = 1000;
/// Time for a message without a stamp to arrive before the next message is sent.
const PAUSE: Duration = Duration::from_millis(20);

/// Time without an answer after which the inputs of a tick are published again, as the vehicle does in lockstep: the node may have lost its
/// connection for a moment, as on a busy machine, and so have missed them. The nodes of the suite answer what is repeated with the same bytes.
const REPEAT_AFTER: Duration = Duration::from_secs(1);

/// A topic to play.
struct Input {
    name: String,
    publisher: RawPublisher,
    stamp: Option<StampDecoder>,
}

/// A topic that the node publishes.
struct Output {
    topic: Topic,
    id: Option<TopicId>,
    stamp: Option<StampDecoder>,
    /// The last message. After inputs were published again, the same message again counts as their answer.
    last: Vec<u8>,
}

/// The stamps that the node answers.
enum Answers {
    /// Every stamp of the input with this index.
    Each(usize),
    /// Ticks at these stamps, taken from the recorded answers.
    At(BTreeSet<i64>),
}

pub(super) struct Player {
    rt: Runtime<Event>,
    inputs: Vec<Input>,
    outputs: Vec<Output>,
    /// Index of the topic that ends a tick; it comes after the outputs if it is not an output.
    answer: usize,
    answers: Answers,
    /// Publishes `/clock`, if the bag contains no clock.
    clock: Option<Publisher<Clock>>,
    writer: BagWriter,
    values: Values,
    timeout: Duration,
    /// Stamp of the last answered tick.
    answered: Option<i64>,
    is_answered: bool,
    /// Earliest stamp of an answer to the present tick.
    since: i64,
    /// The inputs since the last answer: stamps, places and payloads.
    played: Vec<(i64, usize, Vec<u8>)>,
    /// Whether the node is one of the suite, and so takes repeated inputs.
    repeats: bool,
    has_repeated: bool,
    /// Stamp of the present tick.
    now: i64,
}

fn hash(topic: &Topic) -> Option<&str> {
    Some(topic.kind.type_hash.as_str()).filter(|it| !it.is_empty())
}

/// The topics to play, with their publishers.
fn inputs_of(rt: &Runtime<Event>, plan: &Plan, bag: &BagReader) -> Result<Vec<Input>> {
    let input = |topic: &Topic| {
        let is_latched =
            |it: &planesman_bag::OfferedQos| it.durability == Durability::TransientLocal;
        let qos = match topic.kind.offered_qos.iter().any(is_latched) {
            true => Qos::latched(DEPTH),
            false => Qos::reliable(DEPTH),
        };
        let type_name = &topic.kind.type_name;
        Ok(Input {
            publisher: rt.raw_publisher(&topic.name, type_name, hash(topic), qos)?,
            stamp: stamps_of(bag, topic),
            name: topic.name.clone(),
        })
    };
    plan.inputs.iter().map(input).collect()
}

/// Subscribes to the outputs; reliable for the topic that ends a tick.
fn subscribe(rt: &Runtime<Event>, outputs: &[Output], answer: usize) -> Result<()> {
    for (number, Output { topic, .. }) in outputs.iter().enumerate() {
        let qos = match number == answer {
            true => Qos::record_reliable(),
            false => Qos::record(),
        };
        let event = move |sample| Event::Sample(number, sample);
        rt.subscribe_raw(&topic.name, &topic.kind.type_name, hash(topic), qos, event)?;
    }
    Ok(())
}

impl Player {
    pub(super) fn new(
        rt: Runtime<Event>,
        plan: &Plan,
        topics: Vec<Topic>,
        bag: &BagReader,
        args: &PlayArgs,
        mut writer: BagWriter,
    ) -> Result<Self> {
        let inputs = inputs_of(&rt, plan, bag)?;
        let mut outputs = Vec::new();
        for topic in topics {
            outputs.push(Output {
                id: Some(writer.add_topic(&topic)?),
                stamp: stamps_of(bag, &topic),
                topic,
                last: Vec::new(),
            });
        }
        let place = |answer: &Topic| outputs.iter().position(|it| it.topic.name == answer.name);
        let answer = match &plan.answer {
            None => 0,
            Some(answer) => match place(answer) {
                Some(place) => place,
                None => {
                    let known = planesman_decode::message_types::find(&answer.kind.type_name)?;
                    outputs.push(Output {
                        id: None,
                        stamp: stamp_decoder(&known.types),
                        topic: answer.clone(),
                        last: Vec::new(),
                    });
                    outputs.len() - 1
                }
            },
        };
        subscribe(&rt, &outputs, answer)?;
        let answers = match (plan.tick, &outputs[answer]) {
            (
                None,
                Output {
                    topic,
                    stamp: Some(decoder),
                    ..
                },
            ) => Answers::At(recorded_stamps(bag, topic, decoder)),
            (tick, _) => Answers::Each(tick.unwrap_or_default()),
        };
        let has_clock = plan
            .inputs
            .iter()
            .any(|it| it.kind.type_name == "rosgraph_msgs/msg/Clock");
        let clock = match has_clock {
            true => None,
            false => Some(rt.publisher("/clock", Qos::reliable(DEPTH))?),
        };
        Ok(Self {
            rt,
            inputs,
            outputs,
            answer,
            answers,
            clock,
            writer,
            values: Values::default(),
            timeout: Duration::from_secs_f64(args.timeout),
            answered: None,
            is_answered: false,
            since: i64::MIN,
            played: Vec::new(),
            repeats: args.through.role().is_some(),
            has_repeated: false,
            now: 0,
        })
    }

    /// Waits until the node subscribes to the inputs and publishes the answer.
    pub(super) fn wait_for_node(&mut self, mut child: Option<&mut Started>) -> Result<()> {
        let deadline = Instant::now() + START;
        let answer = self.outputs[self.answer].topic.name.clone();
        let mut settled: Option<(usize, Instant)> = None;
        loop {
            if let Some(child) = child.as_mut() {
                child.check()?;
            }
            let connections = self.rt.connections();
            let answers = connections.find(Direction::Subscription, &answer);
            let inputs = self.inputs.iter().filter(|it| {
                let found = connections.find(Direction::Publisher, &it.name);
                found.is_some_and(|it| it.peers > 0)
            });
            let read = inputs.count();
            let others = answers.map_or(0, |it| it.peers);
            if others > 1 {
                bail!("{others} nodes publish '{answer}', but only one may. Stop the others");
            }
            let is_there = others == 1 && read > 0;
            settled = settled
                .filter(|it| is_there && it.0 == read)
                .or_else(|| is_there.then(|| (read, Instant::now())));
            if settled.is_some_and(|it| it.1.elapsed() > SETTLING) {
                return Ok(());
            }
            if Instant::now() > deadline {
                bail!(
                    "no node publishes '{answer}' and also subscribes to the played topics. Is the node in this domain and namespace? (planesman doctor)"
                );
            }
            match self.rt.next(Duration::from_millis(20)) {
                Next::Stop => bail!("stopped before the first tick"),
                Next::Event(_) | Next::Timeout => {}
            }
        }
    }

    /// Plays all inputs. Returns the number of ticks.
    pub(super) fn play(&mut self, bag: &BagReader, mut child: Option<&mut Started>) -> Result<u64> {
        let names: Vec<String> = self.inputs.iter().map(|it| it.name.clone()).collect();
        let wanted = |it: &Topic| names.contains(&it.name);
        // The stamp whose answer is waited for before the next one is played.
        let mut due: Option<i64> = None;
        let mut ticks = 0;
        for message in bag.messages_of(wanted, Order::File) {
            let message = message?;
            let Some(place) = names.iter().position(|it| *it == message.topic.name) else {
                continue;
            };
            let stamp = self.inputs[place]
                .stamp
                .as_ref()
                .and_then(|it| it.read(&message.payload, &mut self.values));
            if let Some(tick) = due.filter(|tick| stamp.is_none_or(|it| it > *tick)) {
                self.wait_for(tick, child.as_deref_mut())?;
                ticks += 1;
                due = None;
            }
            let begins = match &self.answers {
                Answers::Each(trigger) if place == *trigger => {
                    Some(stamp.unwrap_or(message.log_time))
                }
                Answers::Each(_) => None,
                Answers::At(stamps) => stamp.filter(|it| stamps.contains(it)),
            };
            let is_first = ticks == 0 && due.is_none();
            if let Some(time) = stamp.or(begins).filter(|it| *it > self.now || is_first) {
                self.now = time;
                if let Some(clock) = &self.clock {
                    clock.publish(&Clock {
                        clock: Time::from_nanos(time),
                    });
                }
            }
            let begins = begins.filter(|it| {
                due.is_none() && (stamp.is_none() || self.answered.is_none_or(|done| *it > done))
            });
            if begins.is_some() {
                self.is_answered = false;
                self.since = stamp.unwrap_or(i64::MIN);
            }
            if let Some(stamp) = stamp.filter(|_| self.repeats) {
                self.played.push((stamp, place, message.payload.to_vec()));
            }
            if !self.inputs[place].publisher.publish(&message.payload) {
                bail!("{}: cannot publish a message", message.topic.name);
            }
            match begins {
                Some(tick) if stamp.is_some() => due = Some(tick),
                // Without a stamp nothing tells which messages belong to the same tick.
                Some(tick) => {
                    self.wait_for(tick, child.as_deref_mut())?;
                    ticks += 1;
                }
                None if stamp.is_none() => self.take_for(PAUSE, false)?,
                None => {}
            }
        }
        if let Some(tick) = due {
            self.wait_for(tick, child)?;
            ticks += 1;
        }
        self.take_for(SETTLING, false)?;
        Ok(ticks)
    }

    /// Takes the node's messages until it has answered the tick with this stamp.
    fn wait_for(&mut self, tick: i64, child: Option<&mut Started>) -> Result<()> {
        let begin = Instant::now();
        let deadline = begin + self.timeout;
        let mut repeat = begin + REPEAT_AFTER;
        while !self.is_answered {
            let now = Instant::now();
            if now >= repeat {
                repeat = now + REPEAT_AFTER;
                self.repeat(tick);
            }
            let left = deadline.saturating_duration_since(now);
            if left.is_zero() {
                if let Some(child) = child {
                    child.check()?;
                }
                bail!(
                    "no message on '{}' answered the tick at {}.{:09} s within {} s (--timeout)",
                    self.outputs[self.answer].topic.name,
                    tick.div_euclid(1_000_000_000),
                    tick.rem_euclid(1_000_000_000),
                    self.timeout.as_secs_f64()
                );
            }
            self.take_for(left.min(repeat - now), true)?;
        }
        self.answered = Some(tick);
        self.played.clear();
        Ok(())
    }

    /// Publishes the inputs of a tick again.
    fn repeat(&mut self, tick: i64) {
        for (_, place, payload) in self.played.iter().filter(|it| it.0 == tick) {
            self.inputs[*place].publisher.publish(payload);
        }
        self.has_repeated = true;
    }

    /// Takes one message within a time, or all messages until that time passes without one.
    fn take_for(&mut self, time: Duration, only_one: bool) -> Result<()> {
        loop {
            match self.rt.next(time) {
                Next::Event(Event::Sample(number, sample)) => self.take(number, &sample)?,
                Next::Event(Event::Parameters) => {}
                Next::Stop => bail!("stopped"),
                Next::Timeout => return Ok(()),
            }
            if only_one {
                return Ok(());
            }
        }
    }

    fn take(&mut self, number: usize, sample: &RawSample) -> Result<()> {
        let output = &mut self.outputs[number];
        let is_repeated = self.has_repeated && output.last == sample.bytes[..];
        if self.repeats {
            output.last.clear();
            output.last.extend_from_slice(&sample.bytes);
        }
        if let Some(id) = output.id.filter(|_| !is_repeated) {
            self.writer
                .write_raw(id, &sample.bytes, self.now, self.now)?;
        }
        if number == self.answer {
            let decoder = output.stamp.as_ref();
            let stamp = decoder.and_then(|it| it.read(&sample.bytes, &mut self.values));
            self.is_answered |= stamp.is_none_or(|it| it >= self.since);
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<()> {
        self.writer.close()?;
        Ok(self.rt.shutdown()?)
    }
}

fn recorded_stamps(bag: &BagReader, topic: &Topic, decoder: &StampDecoder) -> BTreeSet<i64> {
    let mut values = Values::default();
    let messages = bag.messages_of(|it| it.name == topic.name, Order::File);
    let stamps = messages
        .map_while(Result::ok)
        .filter_map(|message| decoder.read(&message.payload, &mut values));
    stamps.collect()
}
