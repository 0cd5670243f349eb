//! Subscriptions: every sample is validated before the node receives it.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet, VecDeque},
    rc::Rc,
    time::{Duration, Instant},
};

use futures::{StreamExt as _, future::LocalBoxFuture};
use planesman_msgs::{Message, cdr, loop_topics};
use ros2_client::{Gid, MessageInfo, Subscription};
use rustdds::{GUID, Topic};

use crate::{
    discovered::{ParticipantId, have_a_name_in_common, homes_of, prefix, writes},
    endpoint::{Endpoint, count},
    error::Result,
    raw::WholePayload,
    receive_limits::{Gate, LargeMessage},
    shared::{STOPPED, Shared},
};

/// A received, undecoded message.
pub(crate) struct Unread {
    /// CDR payload with its 4-byte encapsulation header.
    pub(crate) payload: Vec<u8>,
    /// Guard of a large message.
    pub(crate) large: Option<LargeMessage>,
}

impl Unread {
    /// The reason why the payload is not such a message.
    /// The reason why the payload is not such a message.
    pub(crate) fn message<M: Message>(&self) -> Result<M, String> {
        cdr::from_bytes(&self.payload).map_err(|error| error.to_string())
    }
}

/// Passes a message on to the node.
pub(crate) type Delivery = LocalBoxFuture<'static, ()>;

/// Decodes a message, or returns the reason to refuse it.
pub(crate) type Read = Box<dyn Fn(Unread, &MessageInfo) -> Result<Delivery, String>>;

/// Opens a reader of the topic, and passes its messages on until the node shuts down. Large messages pass through the gate.
///
/// The reader handles bytes only, so that the middleware's code is compiled once instead of once per message type.
///
/// # Errors
/// An error of the middleware.
pub(crate) fn start(
    shared: &Rc<Shared>,
    endpoint: Rc<Endpoint>,
    topic: &Topic,
    gate: Option<Rc<Gate>>,
    read: Read,
) -> Result<()> {
    let reader = shared.with_node(|node| node.create_subscription(topic, None))?;
    shared.spawn(forward_samples(
        Rc::clone(shared),
        endpoint,
        reader,
        gate,
        read,
    ));
    Ok(())
}

/// Refuses messages from a writer of another type, and messages that `read` refuses; logs the topic and the reason.
async fn forward_samples(
    shared: Rc<Shared>,
    endpoint: Rc<Endpoint>,
    reader: Subscription<Vec<u8>>,
    gate: Option<Rc<Gate>>,
    read: Read,
) {
    let samples = reader.async_stream_seed(WholePayload).boxed_local();
    let size = |sample: &Result<(Vec<u8>, _), _>| sample.as_ref().map_or(0, |(it, _)| it.len());
    let mut samples = match &gate {
        Some(gate) => gate.guard(samples, size).boxed_local(),
        None => samples.map(|sample| (sample, None)).boxed_local(),
    };
    let mut publishers = Publishers::new(&shared, &endpoint);
    // Of nodes that may have come in place of one that has died.
    let mut waiting: VecDeque<(Delivery, MessageInfo)> = VecDeque::new();
    while let Some((sample, large)) = samples.next().await {
        let judged = match sample {
            Err(error) => Err(error.to_string()),
            Ok((payload, info)) => match publishers.objection_to(info.publisher_gid()) {
                Some(objection) => Err(objection),
                None => read(Unread { payload, large }, &info).map(|delivery| (delivery, info)),
            },
        };
        // Asked last: a message that is refused makes its publisher nobody to follow.
        let judged = match judged {
            Err(reason) => Err(reason),
            Ok((delivery, info)) => match publishers.passage_of(info.publisher_gid()) {
                Passage::Free => Ok((delivery, info)),
                Passage::Undecided if waiting.len() < MAX_WAITING => {
                    waiting.push_back((delivery, info));
                    continue;
                }
                _ => Err(
                    "message refused, because another node was the first publisher of this topic"
                        .to_owned(),
                ),
            },
        };
        match judged {
            Ok((delivery, info)) => {
                let sender = |info: &MessageInfo| prefix(GUID::from(info.publisher_gid()));
                for (before, of) in waiting.drain(..) {
                    if sender(&of) == sender(&info) {
                        count(&endpoint.passed);
                        before.await;
                    } else {
                        count(&endpoint.refused);
                    }
                }
                count(&endpoint.passed);
                delivery.await;
            }
            Err(reason) => {
                count(&endpoint.refused);
                shared.warn(&endpoint.topic, &format!("message refused: {reason}"));
            }
        }
    }
}

/// The publishers of a topic, for one subscription.
struct Publishers<'a> {
    shared: &'a Shared,
    endpoint: &'a Endpoint,
    /// Objection to each writer; empty if there is no objection.
    objections: BTreeMap<Gid, String>,
    followed: Followed,
    /// The node that owns the topic.
    owner: Option<String>,
    /// Participants that contained that node; such a participant is not foreign even after its flight.
    homes: BTreeSet<ParticipantId>,
    /// When they were last looked for, since a foreign node may send hundreds of messages a second.
    looked: Option<Instant>,
}

impl<'a> Publishers<'a> {
    fn new(shared: &'a Shared, endpoint: &'a Endpoint) -> Self {
        Self {
            shared,
            endpoint,
            objections: BTreeMap::new(),
            followed: Followed::default(),
            owner: owner_of(&shared.names.namespace, &endpoint.topic),
            homes: BTreeSet::new(),
            looked: None,
        }
    }

    fn objection_to(&mut self, writer: Gid) -> Option<String> {
        let known = match self.objections.get(&writer) {
            Some(known) => known.clone(),
            None => {
                let participant = self.shared.participant()?;
                let found = self.endpoint.objection_to(writer, &participant)?;
                self.objections.insert(writer, found.clone());
                found
            }
        };
        Some(known).filter(|objection| !objection.is_empty())
    }

    fn passage_of(&mut self, writer: Gid) -> Passage {
        let Some(sender) = prefix(GUID::from(writer)) else {
            return Passage::Free;
        };
        let Some(silence) = self.endpoint.follows_one else {
            self.shared.heard(sender);
            return Passage::Free;
        };
        let participant = self.shared.participant();
        let participant = participant.as_ref();
        // The node whose topic it is goes before whoever came first.
        if let (Some(owner), Some(it)) = (&self.owner, participant)
            && !self.homes.contains(&sender)
            && self.homes.len() < Followed::MAX_RIVALS
            && self.looked.is_none_or(|at| at.elapsed() > LOOK)
        {
            self.looked = Some(Instant::now());
            self.homes.extend(homes_of(it, owner));
        }
        if let Some((first, _)) = self.followed.first
            && self.homes.contains(&sender)
            && !self.homes.contains(&first)
        {
            self.followed.first = Some((sender, Instant::now()));
        }
        let publishes =
            |id| participant.is_some_and(|it| writes(it, &self.endpoint.dds_topic(), id));
        let doubles = |id| {
            self.shared.hears(id)
                && participant.is_some_and(|it| have_a_name_in_common(it, id, sender))
        };
        self.followed
            .passes(sender, Instant::now(), silence, publishes, doubles)
    }
}

/// Full name of the node that publishes a topic in the loop of this namespace.
fn owner_of(namespace: &str, topic: &str) -> Option<String> {
    let inside = topic.strip_prefix(namespace.trim_end_matches('/'));
    let name = inside.map_or(topic, |it| it.trim_start_matches('/'));
    let node = match name {
        "plane_command" | "thruster_command" | "control_state" | "estimate" => "depth_controller",
        "plane_motion" | "planes" => "dha_actuator",
        "model" => "sysid",
        name if name.starts_with("dha_state") => "dha_actuator",
        name => loop_topics::named(name).map(|_| "plant_sim")?,
    };
    Some(format!("{}/{node}", namespace.trim_end_matches('/')))
}

/// Interval of looking for a node's participants.
const LOOK: Duration = Duration::from_millis(100);

/// Maximum number of messages waiting for a decision.
const MAX_WAITING: usize = 100;

/// Whether a message passes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Passage {
    Free,
    /// Undecided: the sender may replace a dead publisher, or one that is paused and still alive.
    Undecided,
    Refused,
}

/// The participant that is followed.
#[derive(Default)]
struct Followed {
    /// The first publisher, and the time of its last message.
    first: Option<(ParticipantId, Instant)>,
    /// Other publishers refused so far.
    rivals: BTreeSet<ParticipantId>,
}

impl Followed {
    /// Time of silence below which no other publisher is accepted.
    const BRIEF: Duration = Duration::from_secs(1);
    /// Maximum number of other publishers remembered.
    const MAX_RIVALS: usize = 100;

    /// Whether a message of `sender` passes. The first publisher passes. Others pass once it has been silent; rivals, and a sender that `doubles` it,
    /// only after a longer silence. The first publisher is followed again when it continues, unless it no longer `publishes`.
    fn passes(
        &mut self,
        sender: ParticipantId,
        now: Instant,
        silence: Duration,
        publishes: impl FnOnce(ParticipantId) -> bool,
        doubles: impl FnOnce(ParticipantId) -> bool,
    ) -> Passage {
        if let Some((first, heard)) = self.first.filter(|(first, _)| *first != sender) {
            let silent = now.duration_since(heard);
            if silent < Self::BRIEF {
                if self.rivals.len() < Self::MAX_RIVALS {
                    self.rivals.insert(sender);
                }
                return Passage::Refused;
            }
            // A node of the same name that comes while the one followed stands is another loop's, not its successor.
            if silent < silence && self.rivals.contains(&sender) {
                return Passage::Refused;
            }
            if silent < silence && doubles(first) {
                return match silent < STOPPED + Self::BRIEF {
                    true => Passage::Undecided,
                    false => Passage::Refused,
                };
            }
            if publishes(first) {
                return Passage::Free;
            }
        }
        self.first = Some((sender, now));
        Passage::Free
    }
}

/// Checks that messages about nodes come from those nodes.
pub(crate) struct Speakers {
    shared: Rc<Shared>,
    /// Participants in which the nodes were found.
    known: RefCell<BTreeMap<String, ParticipantId>>,
}

impl Speakers {
    pub(crate) fn new(shared: &Rc<Shared>) -> Self {
        Self {
            shared: Rc::clone(shared),
            known: RefCell::default(),
        }
    }

    /// Reason to refuse a message about these nodes: one of them is in another participant than the writer.
    pub(crate) fn reason_against(&self, writer: Gid, nodes: &[String]) -> Option<String> {
        let sender = prefix(GUID::from(writer))?;
        let is_another = |node: &&String| {
            if self.known.borrow().get(*node) == Some(&sender) {
                return false;
            }
            let participant = self.shared.participant();
            let homes = participant.map(|it| homes_of(&it, node));
            let homes = homes.unwrap_or_default();
            // The node of that name that was heard first speaks for it as long as it is there: another machine's may come.
            let known = self.known.borrow().get(*node).copied();
            let is_taken = known.is_some_and(|it| homes.contains(&it));
            if homes.contains(&sender) && !is_taken {
                self.known.borrow_mut().insert((*node).clone(), sender);
                return false;
            }
            !homes.is_empty()
        };
        let node = nodes.iter().find(is_another)?;
        Some(format!(
            "the message is about the node {node}, which does not belong to the sender"
        ))
    }
}

/// Reason to refuse a message: the first number that is not finite.
pub(crate) fn non_finite<M: Message>(message: &M) -> Option<String> {
    let field = message.first_non_finite()?;
    Some(format!("{field} is not finite"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_came_first_is_heard_and_another_only_in_its_silence() {
        let began = Instant::now();
        let at = |seconds: f64| began + Duration::from_secs_f64(seconds);
        let [first, other] = [[1; 12], [2; 12]];
        let mut followed = Followed::default();
        let mut passes = |sender, seconds, there| {
            let passage = followed.passes(sender, at(seconds), Duration::ZERO, |_| there, |_| true);
            passage == Passage::Free
        };
        assert!(passes(first, 0.0, true));
        assert!(!passes(other, 0.9, true), "the first goes on");
        assert!(passes(first, 0.95, true));
        assert!(!passes(other, 1.9, true), "it was heard 0.95 s ago");
        assert!(passes(other, 2.0, true), "the first is silent");
        assert!(passes(first, 2.5, true), "it is followed again");
        assert!(!passes(other, 2.6, true));
        assert!(passes(other, 4.0, false), "the first has gone");
        assert!(!passes(first, 4.5, true), "the other came first now");
    }
    #[test]
    fn one_that_stands_is_not_replaced_by_a_node_of_its_name() {
        let began = Instant::now();
        let at = |seconds: f64| began + Duration::from_secs_f64(seconds);
        let long = Duration::from_secs(10);
        let [first, other] = [[1; 12], [2; 12]];
        for doubles in [true, false] {
            let mut followed = Followed::default();
            let mut passes =
                |sender, seconds| followed.passes(sender, at(seconds), long, |_| true, |_| doubles);
            let (free, refused) = (Passage::Free, Passage::Refused);
            let or_free = |doubled| if doubles { doubled } else { free };
            assert_eq!(passes(first, 0.0), free);
            assert_eq!(passes(other, 1.5), or_free(Passage::Undecided));
            assert_eq!(passes(other, 2.9), or_free(Passage::Undecided));
            assert_eq!(
                passes(other, 3.1),
                or_free(refused),
                "the first is still heard"
            );
            assert_eq!(passes(other, 9.9), or_free(refused));
            assert_eq!(passes(other, 10.1), free);
        }
    }
}
