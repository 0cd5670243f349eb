//! Gates of lockstep: topics of nodes that know nothing of `tick_answer`, whose message for a tick is their answer to it.
//!
//! A gate is opened once somebody publishes the topic. Its messages are of any type. Where the type's definition gives them a stamp,
//! the one with the tick's stamp answers; of others the first one that has come since the tick's state was sent.

use std::time::{Duration, Instant};

use anyhow::Result;
use planesman_decode::{StampDecoder, Values, schema};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_node::{
    Definition, DefinitionError, Definitions, PublishedTopic, Qos, RawSample, Runtime,
};

/// What happens at a gate, by its place in the list.
pub(crate) enum GateEvent {
    /// A message has come through it.
    Sample(usize, RawSample),
    /// What nodes of its publishers say of its type.
    Type(usize, PublishedTopic, Result<Definition, DefinitionError>),
}

/// The gates of a loop.
pub(crate) struct Gates {
    list: Vec<Gate>,
    definitions: Definitions,
    values: Values,
    /// When the last one was opened.
    opened: Option<Instant>,
}

struct Gate {
    /// The topic's absolute name.
    topic: String,
    state: State,
    /// The stamp of its last message, ns.
    last: Option<i64>,
}

enum State {
    /// Nobody publishes it.
    Unpublished,
    /// Its publishers are asked for the type's definition.
    Asked,
    /// Subscribed to, with what reads the stamp of its messages if they have one.
    Open(Option<Box<StampDecoder>>),
}

impl Gates {
    /// Of these topics, none opened yet.
    ///
    /// # Errors
    /// A name that breaks ROS's rules.
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

    /// Looks for publishers of those that are not open.
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

    /// The topic of the gate that `event` answers the tick at `now` (ns) by, whose state was sent at `sent`, by the machine's clock.
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

    /// Subscribes to a gate as its publishers offer it. They may be anybody, so a refusal leaves the gate as it was.
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
                    "gate {}: the type {} is not known: {reason}",
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
            log::error!("gate {}: not subscribed to: {refusal}", topic.name);
            return;
        }
        log::info!(
            "gate {}: a tick ends with {}",
            topic.name,
            match stamp {
                Some(_) => "the message that bears its stamp",
                None => "the first message after its state, since the messages have no stamp",
            }
        );
        gate.state = State::Open(stamp);
        self.opened = Some(Instant::now());
    }

    /// Whether all have been open for so long: their publishers, too, then know of it.
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

    /// Why the gate of that topic has not answered; `None` of what is no gate.
    pub(crate) fn reason(&self, topic: &str) -> Option<String> {
        let gate = self.list.iter().find(|it| it.topic == topic)?;
        Some(match (&gate.state, gate.last) {
            (State::Unpublished, _) => format!("{topic}, which nobody publishes"),
            (State::Asked, _) => format!("{topic}, whose type is being asked for"),
            (State::Open(Some(_)), Some(last)) => {
                format!(
                    "{topic}, whose last message bears the stamp {:.9}",
                    last as f64 * 1e-9
                )
            }
            (State::Open(_), _) => topic.to_owned(),
        })
    }

    /// What the first tick waits for.
    pub(crate) fn closed(&self) -> Vec<String> {
        let closed = self
            .list
            .iter()
            .filter(|it| !matches!(it.state, State::Open(_)));
        closed.filter_map(|it| self.reason(&it.topic)).collect()
    }
}
