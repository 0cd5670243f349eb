//! Answers on their way: to a client not yet known to listen, or one whose middleware has no room.
//!
//! A client asks as soon as it knows of us. Our writer may be matched with its reader a little later; what is written
//! before that is lost. So the first answer to a client waits for it. And a client that acknowledges nothing fills the
//! send window; an answer then waits for room. The node goes on meanwhile: one task looks after all that wait, at
//! most [`MOST`].

use std::{cell::RefCell, collections::VecDeque, rc::Rc, time::Duration};

use ros2_client::{RmwRequestId, error::WriteError};
use rustdds::GUID;
use smol::Timer;

use crate::shared::Shared;

/// Time between two looks, and how many there are for an answer.
const LOOK: Duration = Duration::from_millis(10);
const LOOKS: u32 = 500;

/// Answers that wait; a further one is not sent.
const MOST: usize = 100;

/// An attempt to send an answer, again if there was no room.
type Send = Box<dyn FnMut() -> Result<(), WriteError<()>>>;

/// One that waits.
struct Waiting {
    /// The service's name, and the DDS topic that its answers go by.
    service: String,
    replies: String,
    client: GUID,
    /// Whether the client is known to listen.
    heard: bool,
    looks: u32,
    send: Send,
}

/// All that wait, oldest first.
#[derive(Default)]
pub(crate) struct Answers {
    waiting: RefCell<VecDeque<Waiting>>,
}

/// Sends an answer of the service `name` to whoever asked `request`: now, or as soon as who asked is known to listen and
/// there is room, or never, which is told. `send` must not wait.
pub(crate) fn answer(
    shared: &Rc<Shared>,
    name: &str,
    request: RmwRequestId,
    mut send: impl FnMut() -> Result<(), WriteError<()>> + 'static,
) {
    let client = GUID::from(request.writer_gid);
    let heard = shared.is_heard_by(client);
    if heard {
        match send() {
            Err(WriteError::WouldBlock { .. }) => {}
            outcome => return told(shared, name, outcome),
        }
    }
    let waiting = Waiting {
        service: name.to_owned(),
        replies: format!("rr{name}Reply"),
        client,
        heard,
        looks: 0,
        send: Box::new(send),
    };
    let mut all = shared.answers.waiting.borrow_mut();
    if all.len() >= MOST {
        let text =
            format!("no answer sent: {MOST} others wait for clients that do not take theirs");
        return shared.warn(name, &text);
    }
    all.push_back(waiting);
    if all.len() == 1 {
        let ours = Rc::clone(shared);
        shared.spawn(async move {
            while !ours.answers.waiting.borrow().is_empty() {
                Timer::after(LOOK).await;
                look(&ours);
            }
        });
    }
}

/// Sends what can be sent now.
fn look(shared: &Rc<Shared>) {
    let mut all = shared.answers.waiting.take();
    if all.iter().any(|waiting| !waiting.heard)
        && let Some(participant) = shared.participant()
    {
        let readers = participant.discovered_readers();
        for waiting in all.iter_mut().filter(|waiting| !waiting.heard) {
            waiting.heard = readers.iter().any(|reader| {
                let guid = reader.reader_proxy.remote_reader_guid;
                guid.prefix == waiting.client.prefix
                    && *reader.subscription_topic_data.topic_name() == waiting.replies
                    && participant.is_matched_with(guid)
            });
        }
    }
    let mut full: Vec<String> = Vec::new();
    all.retain_mut(|waiting| {
        waiting.looks += 1;
        let last = waiting.looks >= LOOKS;
        if !(waiting.heard || last) || full.contains(&waiting.service) {
            return !last;
        }
        if waiting.heard {
            shared.heard_by(waiting.client);
        }
        match (waiting.send)() {
            Err(WriteError::WouldBlock { .. }) if !last => {
                full.push(waiting.service.clone());
                true
            }
            outcome => {
                told(shared, &waiting.service, outcome);
                false
            }
        }
    });
    // None has come in meanwhile: nothing here waits.
    shared.answers.waiting.borrow_mut().extend(all);
}

fn told(shared: &Shared, service: &str, outcome: Result<(), WriteError<()>>) {
    if let Err(error) = outcome {
        shared.warn(service, &format!("no answer sent: {error}"));
    }
}
