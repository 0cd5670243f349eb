//! Subscriptions: every sample is validated before the node receives it.

use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

use futures::{Stream, StreamExt as _};
use planesman_msgs::Message;
use ros2_client::{Gid, MessageInfo, ReadError};
use rustdds::GUID;

use crate::{
    discovered::{ParticipantId, homes_of, prefix},
    endpoint::{Endpoint, count},
    shared::Shared,
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
    futures::pin_mut!(samples);
    while let Some(sample) = samples.next().await {
        let judged = match sample {
            Err(error) => Err(error.to_string()),
            Ok((message, info)) => match objection_to(info.publisher_gid()) {
                Some(objection) => Err(objection),
                None => match reason_against(&message, &info) {
                    Some(reason) => Err(reason),
                    None => Ok((message, info)),
                },
            },
        };
        match judged {
            Ok((message, info)) => {
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
            if homes.contains(&sender) {
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
