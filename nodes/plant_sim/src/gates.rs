//! Gates of lockstep: topics of foreign nodes that do not publish `tick_answer`. A message on a gate's topic counts as the answer to a tick.
//!
//! A gate opens once somebody publishes its topic, with messages of any type. If the type contains a stamp, the message with the tick's stamp
//! is the answer; otherwise the first message after the tick's state was sent.

use std::time::{Duration, Instant};

use anyhow::Result;
use planesman_decode::{StampDecoder, Values, schema};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_node::{
    Definition, DefinitionError, Definitions, PublishedTopic, Qos, RawSample, Runtime,
};

/// An event of the gate with this index.
pub(crate) enum GateEvent {
    /// A message arrived.
    Sample(usize, RawSample),
    /// The publisher's node answered with the definition of the type.
    Type(usize, PublishedTopic, Result<Definition, DefinitionError>),
}

/// The gates of a loop.
pub(crate) struct Gates {
    list: Vec<Gate>,
    definitions: Definitions,
    values: Values,
    /// Time at which the last gate opened.
    opened: Option<Instant>,
}

struct Gate {
    /// Absolute name of the topic.
    topic: String,
    state: State,
    /// Stamp of the last message, ns.
    last: Option<i64>,
}

enum State {
    /// The topic has no publisher.
    Unpublished,
    /// The publishers have been requested to send the type's definition.
    Asked,
    /// The topic is subscribed; with a decoder of the messages' stamp, if they have a stamp.
    Open(Option<Box<StampDecoder>>),
}

impl Gates {
    /// Gates for these topics, not opened yet.
    ///
    /// # Errors
    /// A name that violates the ROS naming rules.
    pub(crate) fn new<E: 'static>(rt: &Runtime<E>, topics: &[String]) -> Result<Self> {
        let gate = |topic: &String| {
            Ok(Gate {
                topic: rt.topic_name(topic)?,
                state: State::Unpublished,
                last: None,
            })
        };
        Ok(Self {
            list: topics.iter().map(gate).collect::<Result<_>>()?,
            definitions: Definitions::from_environment(),
            values: Values::default(),
            opened: None,
        })
    }

    /// The topics' absolute names.
    pub(crate) fn topics(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|gate| gate.topic.as_str())
    }

    /// Looks for publishers of the topics whose gates are not open.
    pub(crate) fn discover<E: From<GateEvent> + 'static>(&mut self, rt: &Runtime<E>) {
        let is_unpublished = |gate: &Gate| matches!(gate.state, State::Unpublished);
        if !self.list.iter().any(is_unpublished) {
            return;
        }
        for topic in rt.published_topics() {
            let found =
                (self.list.iter()).position(|it| is_unpublished(it) && it.topic == topic.name);
            let Some(index) = found else { continue };
            match self.definitions.local(&topic) {
                Ok(definition) => self.open(rt, index, &topic, Ok(definition)),
                Err(_) => {
                    if let Some(gate) = self.list.get_mut(index) {
                        gate.state = State::Asked;
                    }
                    let finding = self.definitions.find(rt, &topic);
                    rt.when_done(
                        async move { GateEvent::Type(index, topic, finding.await).into() },
                    );
                }
            }
        }
    }

    /// Handles an event; returns the gate's topic if the event answers the tick. `now`: stamp of the tick, ns; `sent`: wall-clock time at which its
    /// state was published.
    pub(crate) fn on<E: From<GateEvent> + 'static>(
        &mut self,
        rt: &Runtime<E>,
        event: GateEvent,
        now: i64,
        sent: &Time,
    ) -> Option<&str> {
        match event {
            GateEvent::Sample(index, sample) => self.answered_by(index, &sample, now, sent),
            GateEvent::Type(index, topic, definition) => {
                self.open(rt, index, &topic, definition);
                None
            }
        }
    }

    /// Subscribes to a gate's topic with the QoS of its publishers. A foreign publisher may be refused; the gate then stays closed.
    fn open<E: From<GateEvent> + 'static>(
        &mut self,
        rt: &Runtime<E>,
        index: usize,
        topic: &PublishedTopic,
        definition: Result<Definition, DefinitionError>,
    ) {
        let Some(gate) = self.list.get_mut(index) else {
            return;
        };
        let types = definition.map_err(|e| e.to_string()).and_then(|it| {
            schema::read(&topic.type_name, "ros2msg", &it.text).map_err(|e| e.to_string())
        });
        let stamp = match &types {
            Ok(types) => StampDecoder::of(types).map(Box::new),
            Err(reason) => {
                log::warn!(
                    "gate {}: unknown type {}: {reason}",
                    topic.name,
                    topic.type_name
                );
                None
            }
        };
        let qos = match topic.offers.iter().all(|it| it.reliable) {
            true => Qos::reliable(100),
            false => Qos::sensor(),
        };
        let hash = topic.type_hash.as_deref();
        let event = move |sample| GateEvent::Sample(index, sample).into();
        if let Err(refusal) = rt.subscribe_raw(&topic.name, &topic.type_name, hash, qos, event) {
            log::error!("gate {}: cannot subscribe: {refusal}", topic.name);
            return;
        }
        log::info!(
            "gate {}: each tick ends with {}",
            topic.name,
            match stamp {
                Some(_) => "the message with the stamp of the tick",
                None =>
                    "the first message after the state of the tick (because the messages have no stamp)",
            }
        );
        gate.state = State::Open(stamp);
        self.opened = Some(Instant::now());
    }

    /// Whether all gates have been open for this time, so that their publishers also know the subscription.
    pub(crate) fn are_open_for(&self, time: Duration) -> bool {
        let all = self
            .list
            .iter()
            .all(|it| matches!(it.state, State::Open(_)));
        all && self.opened.is_none_or(|at| at.elapsed() >= time)
    }

    fn answered_by(
        &mut self,
        index: usize,
        sample: &RawSample,
        now: i64,
        sent: &Time,
    ) -> Option<&str> {
        let gate = self.list.get_mut(index)?;
        let State::Open(stamp) = &gate.state else {
            return None;
        };
        let answers = match stamp {
            None => sample.received.nanos() >= sent.nanos(),
            Some(decoder) => {
                gate.last = decoder.read(&sample.bytes, &mut self.values);
                gate.last == Some(now)
            }
        };
        answers.then_some(gate.topic.as_str())
    }

    /// The reason why the gate of this topic has not answered; `None` if the topic is not a gate.
    pub(crate) fn reason(&self, topic: &str) -> Option<String> {
        let gate = self.list.iter().find(|it| it.topic == topic)?;
        Some(match (&gate.state, gate.last) {
            (State::Unpublished, _) => format!("{topic}, which nobody publishes"),
            (State::Asked, _) => format!("{topic}, whose type is not known yet"),
            (State::Open(Some(_)), Some(last)) => {
                format!(
                    "{topic}, whose last message has the stamp {:.9} s",
                    last as f64 * 1e-9
                )
            }
            (State::Open(_), _) => topic.to_owned(),
        })
    }

    /// The gates that the first tick waits for.
    pub(crate) fn closed(&self) -> Vec<String> {
        let closed = self
            .list
            .iter()
            .filter(|it| !matches!(it.state, State::Open(_)));
        closed.filter_map(|it| self.reason(&it.topic)).collect()
    }
}
