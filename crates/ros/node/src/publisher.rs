//! Publishers.

use std::{
    marker::PhantomData,
    rc::{Rc, Weak},
};

use planesman_msgs::Message;

use crate::{
    endpoint::{Endpoint, Matched, count},
    service::Bytes,
    shared::Shared,
};

/// Sends messages of one type on one topic. Clones send through the same writer.
pub struct Publisher<M: Message> {
    writer: RawPublisher,
    of: PhantomData<fn(&M)>,
}

impl<M: Message> Clone for Publisher<M> {
    fn clone(&self) -> Self {
        Self::new(self.writer.clone())
    }
}

impl<M: Message> Publisher<M> {
    pub(crate) fn new(writer: RawPublisher) -> Self {
        let of = PhantomData;
        Self { writer, of }
    }

    pub(crate) fn endpoint(&self) -> &Rc<Endpoint> {
        &self.writer.endpoint
    }

    /// Sends `message`, and says whether it went out.
    ///
    /// It does not go out when it holds a number that is not finite, or when the network takes
    /// nothing any more. Both are counted, logged (not too often) and shown in the diagnostics. A reader
    /// that does not acknowledge loses the oldest messages, and is named in the log. The call waits 5 ms at most.
    pub fn publish(&self, message: &M) -> bool {
        match message.first_non_finite() {
            Some(field) => self.writer.refuse(&format!("{field} is not finite")),
            None => self.writer.send(Bytes::of(message)),
        }
    }

    /// The topic's absolute name after remapping.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.writer.endpoint.topic
    }

    /// The number of matched readers of other nodes.
    #[must_use]
    pub fn readers(&self) -> usize {
        self.writer.shared.participant().map_or(0, |participant| {
            self.writer.endpoint.peers(&Matched::with(&participant))
        })
    }

    /// Nobody else is to publish here: whoever does shows as an error in the diagnostics and the log.
    #[must_use]
    pub fn sole(self) -> Self {
        self.writer.endpoint.sole.set(true);
        self
    }

    /// The number of other nodes' publishers on the topic.
    #[must_use]
    pub fn others(&self) -> usize {
        self.writer
            .shared
            .participant()
            .map_or(0, |participant| self.writer.endpoint.others(&participant))
    }

    /// The number of messages sent.
    #[must_use]
    pub fn published(&self) -> u64 {
        self.writer.endpoint.passed.get()
    }
}

/// Sends payloads as they are, for playing what was recorded. Clones send through the same writer.
#[derive(Clone)]
pub struct RawPublisher {
    pub(crate) shared: Rc<Shared>,
    pub(crate) endpoint: Rc<Endpoint>,
    pub(crate) writer: Weak<ros2_client::Publisher<Bytes>>,
}

impl RawPublisher {
    /// Sends a CDR payload in little endian, with its four bytes of encapsulation, and says whether it went out. One in another encoding
    /// does not.
    pub fn publish(&self, payload: &[u8]) -> bool {
        match payload.starts_with(&[0, 1]) {
            true => self.send(Bytes::raw(payload)),
            false => self.refuse("it is not CDR in little endian"),
        }
    }

    fn send(&self, payload: Bytes) -> bool {
        let Some(writer) = self.writer.upgrade() else {
            return false; // The node is shutting down.
        };
        let sent = writer.publish(payload);
        match sent {
            Ok(()) => count(&self.endpoint.passed),
            Err(ref error) => {
                count(&self.endpoint.dropped);
                self.warn(&error.to_string());
            }
        }
        sent.is_ok()
    }

    fn refuse(&self, reason: &str) -> bool {
        count(&self.endpoint.refused);
        self.warn(reason);
        false
    }

    fn warn(&self, reason: &str) {
        let text = format!("not published: {reason}");
        self.shared.warn(&self.endpoint.topic, &text);
    }
}
