//! Subscriptions: every sample is validated before the node receives it.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet, VecDeque},
    rc::Rc,
    time::{Duration, Instant},
};

use futures::{Stream, StreamExt as _};
use planesman_msgs::{Message, loop_topics};
use ros2_client::{Gid, MessageInfo, ReadError};
use rustdds::GUID;

use crate::{
    discovered::{ParticipantId, have_a_name_in_common, homes_of, prefix, writes},
    endpoint::{Endpoint, count},
    shared::{STOPPED, Shared},
};

/// Hands the samples of one reader on as they come, until the node shuts down.
///
/// Refused, with the topic and the reason in the log, are what cannot be decoded, what
/// `reason_against` objects to, and what comes from a writer of another type.
pub(crate) async fn pump<M>(
    shared: Rc<Shared>,
    endpoint: Rc<Endpoint>,
    samples: impl Stream<Item = Result<(M, MessageInfo), ReadError>>,
    reason_against: impl Fn(&M, &MessageInfo) -> Option<String>,
    mut deliver: impl AsyncFnMut(M, &MessageInfo),
) {
    let mut objections: BTreeMap<Gid, String> = BTreeMap::new();
    let mut objection_to = |writer: Gid| -> Option<String> {
        if let Some(known) = objections.get(&writer) {
            return Some(known.clone()).filter(|objection| !objection.is_empty());
        }
        let found = endpoint.objection_to(writer, &shared.participant()?)?;
        objections.insert(writer, found.clone());
        Some(found).filter(|objection| !objection.is_empty())
    };
    let mut followed = Followed::default();
    let owner = owner_of(&shared.names.namespace, &endpoint.topic);
    // Participants that had that node: one that has ended its flight is not a stranger. And when they were last looked for, since a rival
    // speaks hundreds of times a second.
    let mut homes: BTreeSet<ParticipantId> = BTreeSet::new();
    let mut looked: Option<Instant> = None;
    // Of nodes that may have come in place of one that has died.
    let mut waiting: VecDeque<(M, MessageInfo)> = VecDeque::new();
    let mut passage_of = |writer: Gid| -> Passage {
        let Some(sender) = prefix(GUID::from(writer)) else {
            return Passage::Free;
        };
        let Some(silence) = endpoint.follows_one else {
            shared.heard(sender);
            return Passage::Free;
        };
        let participant = shared.participant();
        let participant = participant.as_ref();
        // The node whose topic it is goes before whoever came first.
        if let (Some(owner), Some(it)) = (&owner, participant)
            && !homes.contains(&sender)
            && homes.len() < Followed::MAX_RIVALS
            && looked.is_none_or(|at| at.elapsed() > LOOK)
        {
            looked = Some(Instant::now());
            homes.extend(homes_of(it, owner));
        }
        if let Some((first, _)) = followed.first
            && homes.contains(&sender)
            && !homes.contains(&first)
        {
            followed.first = Some((sender, Instant::now()));
        }
        let publishes = |id| participant.is_some_and(|it| writes(it, &endpoint.dds_topic(), id));
        let doubles = |id| {
            shared.hears(id) && participant.is_some_and(|it| have_a_name_in_common(it, id, sender))
        };
        followed.passes(sender, Instant::now(), silence, publishes, doubles)
    };
    futures::pin_mut!(samples);
    while let Some(sample) = samples.next().await {
        let judged = match sample {
            Err(error) => Err(error.to_string()),
            Ok((message, info)) => match objection_to(info.publisher_gid())
                .or_else(|| reason_against(&message, &info))
            {
                Some(reason) => Err(reason),
                // Asked last: a message that is refused makes its publisher nobody to follow.
                None => match passage_of(info.publisher_gid()) {
                    Passage::Free => Ok((message, info)),
                    Passage::Undecided if waiting.len() < MAX_WAITING => {
                        waiting.push_back((message, info));
                        continue;
                    }
                    _ => Err("another node publishes here, and came first".to_owned()),
                },
            },
        };
        match judged {
            Ok((message, info)) => {
                let sender = |info: &MessageInfo| prefix(GUID::from(info.publisher_gid()));
                for (before, of) in waiting.drain(..) {
                    if sender(&of) == sender(&info) {
                        count(&endpoint.passed);
                        deliver(before, &of).await;
                    } else {
                        count(&endpoint.refused);
                    }
                }
                count(&endpoint.passed);
                deliver(message, &info).await;
            }
            Err(reason) => {
                count(&endpoint.refused);
                shared.warn(&endpoint.topic, &format!("a message is refused: {reason}"));
            }
        }
    }
}

/// The full name of the node that publishes a topic in the loop of that namespace.
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

/// Time between two looks for the participants of a node.
const LOOK: Duration = Duration::from_millis(100);

/// Messages that wait for a decision.
const MAX_WAITING: usize = 100;

/// Whether a message passes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Passage {
    Free,
    /// It may come in place of one that has died, or of one that stands and is still heard elsewhere.
    Undecided,
    Refused,
}

/// The participant that is followed.
#[derive(Default)]
struct Followed {
    /// The one that was heard first, and when it was last heard.
    first: Option<(ParticipantId, Instant)>,
    /// Those that spoke beside it.
    rivals: BTreeSet<ParticipantId>,
}

impl Followed {
    /// In a silence of less nobody else is heard.
    const BRIEF: Duration = Duration::from_secs(1);
    /// Largest number of rivals that are known.
    const MAX_RIVALS: usize = 100;

    /// How a message of `sender` passes: of the one that was heard first; of others once that is silent, of its rivals
    /// and of one that `doubles` it once it has been for so long. It is followed again when it goes on, unless it no longer
    /// `publishes`.
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

/// Whose messages speak for which node.
pub(crate) struct Speakers {
    shared: Rc<Shared>,
    /// The nodes that were found in a sender's participant.
    known: RefCell<BTreeMap<String, ParticipantId>>,
}

impl Speakers {
    pub(crate) fn new(shared: &Rc<Shared>) -> Self {
        Self {
            shared: Rc::clone(shared),
            known: RefCell::default(),
        }
    }

    /// Why a message that speaks for these nodes must not pass: one of them is in another participant than its writer.
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
            "it speaks for {node}, which is in another participant"
        ))
    }
}

/// Why a message must not pass: the first number in it that is not finite.
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
