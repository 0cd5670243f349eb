//! Subscriptions: every sample is validated before the node receives it.

use std::{collections::BTreeMap, rc::Rc};

use futures::{Stream, StreamExt as _};
use planesman_msgs::Message;
use ros2_client::{Gid, MessageInfo, ReadError};

use crate::{
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
    reason_against: impl Fn(&M) -> Option<String>,
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
                None => match reason_against(&message) {
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

/// Why a message must not pass: the first number in it that is not finite.
pub(crate) fn non_finite<M: Message>(message: &M) -> Option<String> {
    let field = message.first_non_finite()?;
    Some(format!("{field} is not finite"))
}
