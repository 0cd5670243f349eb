//! Pending answers of services: to a client that is not matched yet, or while the middleware's queue is full.
//!
//! A client may send a request as soon as it has discovered this node. The node's writer may be matched with the client's reader a little later;
//! messages written before the match are lost. So the first answer to a client waits for the match. A client that acknowledges nothing fills the send
//! window; further answers wait for space. The node continues meanwhile: one task handles all waiting answers, at most [`MAX_WAITING`], and
//! [`MAX_WAITING_PER_CLIENT`] per client.

use std::{ops::Range, rc::Rc, time::Duration};

use ros2_client::{RmwRequestId, error::WriteError};
use rustdds::GUID;

use crate::{
    names::{replies_topic, requests_topic},
    shared::Shared,
    waiting::Waiting,
};

/// Interval of retries, and their maximum number per answer.
const POLL_INTERVAL: Duration = Duration::from_millis(10);
const POLLS: u32 = 500;

/// Maximum number of waiting answers, in total and per client; further answers are not sent.
const MAX_WAITING: usize = 100;
const MAX_WAITING_PER_CLIENT: usize = 10;

/// Sends an answer of the service `name` to the client of `request`: now, or once the client is matched and there is space, or never, with a
/// warning. `send` must not block.
pub(crate) fn answer(
    shared: &Rc<Shared>,
    name: &str,
    request: RmwRequestId,
    mut send: impl FnMut() -> Result<(), WriteError<()>> + 'static,
) {
    let client = GUID::from(request.writer_gid);
    let matched = shared.is_matched(client);
    if matched {
        match send() {
            Err(WriteError::WouldBlock { .. }) => {}
            outcome => return check(shared, name, outcome),
        }
    }
    let waiting = Waiting {
        service: name.to_owned(),
        client,
        matched,
        looks: 0,
        send: Box::new(send),
    };
    let mut all = shared.answers.waiting.borrow_mut();
    let of_the_client = all.iter().filter(|other| other.client == client).count();
    if all.len() >= MAX_WAITING || of_the_client >= MAX_WAITING_PER_CLIENT {
        let text = format!(
            "no answer sent: already {of_the_client} answers wait for this client, {} for all clients",
            all.len()
        );
        return shared.warn(name, &text);
    }
    all.push_back(waiting);
    if all.len() == 1 {
        let ours = Rc::clone(shared);
        shared.spawn(async move {
            while !ours.answers.waiting.borrow().is_empty() {
                ours.sleep(POLL_INTERVAL).await;
                look(&ours);
            }
        });
    }
}

/// Sends the answers that can be sent now.
fn look(shared: &Rc<Shared>) {
    let mut all = shared.answers.waiting.take();
    if all.iter().any(|waiting| !waiting.matched) {
        let known = Known::to(shared);
        for waiting in all.iter_mut().filter(|waiting| !waiting.matched) {
            waiting.matched = known.listens(waiting.client, &waiting.service);
        }
    }
    let mut full: Vec<String> = Vec::new();
    all.retain_mut(|waiting| {
        waiting.looks += 1;
        let last = waiting.looks >= POLLS;
        if !(waiting.matched || last) || full.contains(&waiting.service) {
            return !last;
        }
        if waiting.matched {
            shared.set_matched(waiting.client);
        }
        match (waiting.send)() {
            Err(WriteError::WouldBlock { .. }) if !last => {
                full.push(waiting.service.clone());
                true
            }
            outcome => {
                check(shared, &waiting.service, outcome);
                false
            }
        }
    });
    // None has come in meanwhile: nothing here waits.
    shared.answers.waiting.borrow_mut().extend(all);
}

fn check(shared: &Shared, service: &str, outcome: Result<(), WriteError<()>>) {
    if let Err(error) = outcome {
        shared.warn(service, &format!("no answer sent: {error}"));
    }
}

/// Bytes of an identity that identify host and process, in all middlewares tested.
const PROCESS: Range<usize> = 0..8;

/// Present endpoints of services, as DDS topic and identity: readers matched with this node's writers, and writers.
#[derive(Default)]
struct Known {
    readers: Vec<(String, GUID)>,
    writers: Vec<(String, GUID)>,
}

impl Known {
    fn to(shared: &Shared) -> Self {
        let Some(participant) = shared.participant() else {
            return Self::default();
        };
        let readers = participant.discovered_readers_where(|reader| {
            let end = &reader.subscription_topic_data;
            end.topic_name().starts_with("rr/") && participant.matches_with(end.key()) > 0
        });
        let readers = readers.iter().map(|found| &found.subscription_topic_data);
        let writers = participant.discovered_writers_where(|writer| {
            let end = &writer.publication_topic_data;
            end.topic_name.starts_with("rq/")
        });
        let writers = writers.iter().map(|found| &found.publication_topic_data);
        Self {
            readers: readers
                .map(|end| (end.topic_name().clone(), end.key()))
                .collect(),
            writers: writers
                .map(|end| (end.topic_name.clone(), end.key))
                .collect(),
        }
    }

    /// Whether the reader of this client's answers is known. A client identifies itself by that reader (Fast DDS), or by the writer of its requests.
    /// In the second case, each such writer of its process needs a reader of answers, because any reader may belong to the client. In Cyclone DDS's
    /// mapping only [`PROCESS`] identifies the writer; the rest is a number of the client.
    fn listens(&self, client: GUID, service: &str) -> bool {
        let (requests, replies) = (requests_topic(service), replies_topic(service));
        if self.readers.contains(&(replies.clone(), client)) {
            return true;
        }
        let of_the_client = |ends: &[(String, GUID)], topic: &str| {
            let ends = ends.iter().filter(|(name, _)| name == topic);
            ends.filter(|(_, end)| end.to_bytes()[PROCESS] == client.to_bytes()[PROCESS])
                .count()
        };
        let readers = of_the_client(&self.readers, &replies);
        readers > 0 && readers >= of_the_client(&self.writers, &requests)
    }
}

#[cfg(test)]
mod tests {
    use rustdds::GUID;

    use super::Known;

    fn end(participant: u8, key: u8) -> GUID {
        let mut bytes = [participant; 16];
        bytes[15] = key;
        GUID::from_bytes(bytes)
    }

    /// As a client of `rmw_cyclonedds_cpp` is named in its request: the first half from the writer, the second its own.
    #[test]
    fn a_client_of_cyclone_dds_that_numbers_itself_listens_once_its_reader_is_known() {
        let mut client = end(1, 1).to_bytes();
        client[8..].copy_from_slice(&[0xd5; 8]);
        let client = GUID::from_bytes(client);
        let mut known = Known {
            writers: vec![("rq/aRequest".to_owned(), end(1, 1))],
            readers: vec![("rr/aReply".to_owned(), end(2, 2))],
        };
        assert!(!known.listens(client, "/a"), "only another's reader");
        known.readers.push(("rr/aReply".to_owned(), end(1, 2)));
        assert!(known.listens(client, "/a"));
    }

    #[test]
    fn a_client_listens_once_its_own_reader_is_known_and_not_only_an_older_ones() {
        let (requests, replies) = ("rq/aRequest".to_owned(), "rr/aReply".to_owned());
        let mut known = Known {
            writers: vec![(requests.clone(), end(1, 1)), (requests, end(2, 1))],
            readers: vec![("rr/bReply".to_owned(), end(1, 9))],
        };
        assert!(!known.listens(end(1, 1), "/a"));
        known.readers.push((replies.clone(), end(1, 2)));
        assert!(known.listens(end(1, 1), "/a"));
        assert!(!known.listens(end(2, 1), "/a"));
        // A second client of the same process asks; its reader follows.
        known.writers.push(("rq/aRequest".to_owned(), end(1, 3)));
        assert!(!known.listens(end(1, 3), "/a"));
        assert!(known.listens(end(1, 2), "/a"), "named by its reader");
        known.readers.push((replies, end(1, 4)));
        assert!(known.listens(end(1, 3), "/a"));
    }
}
