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

/// Publishes messages of one type on one topic. Clones use the same writer.
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

    /// Publishes `message`; returns whether it was sent.
    ///
    /// A message is not sent if it contains a number that is not finite, or if the network accepts no more data. Both are counted, logged (with
    /// limited frequency) and shown in the diagnostics. A reader that does not acknowledge loses the oldest messages and is named in the log. The
    /// call blocks for at most 5 ms.
    pub fn publish(&self, message: &M) -> bool {
        match message.first_non_finite() {
            Some(field) => self.writer.refuse(&format!("{field} is not finite")),
            None => self.writer.send(Bytes::of(message)),
        }
    }

    /// Absolute name of the topic, after remapping.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.writer.endpoint.topic
    }

    /// Number of matched readers of other nodes.
    #[must_use]
    pub fn readers(&self) -> usize {
        self.writer.shared.participant().map_or(0, |participant| {
            self.writer.endpoint.peers(&Matched::with(&participant))
        })
    }

    /// Declares that no other node may publish here; others are reported as an error in the diagnostics and the log.
    #[must_use]
    pub fn sole(self) -> Self {
        self.writer.endpoint.sole.set(true);
        self
    }

    /// Number of other nodes' publishers on the topic.
    #[must_use]
    pub fn others(&self) -> usize {
        self.writer
            .shared
            .participant()
            .map_or(0, |participant| self.writer.endpoint.others(&participant))
    }

    /// Number of messages sent.
    #[must_use]
    pub fn published(&self) -> u64 {
        self.writer.endpoint.passed.get()
    }
}

/// Publishes payloads unchanged, to play recorded messages. Clones use the same writer.
#[derive(Clone)]
pub struct RawPublisher {
    pub(crate) shared: Rc<Shared>,
    pub(crate) endpoint: Rc<Endpoint>,
    pub(crate) writer: Weak<ros2_client::Publisher<Bytes>>,
}

impl RawPublisher {
    /// Publishes a little-endian CDR payload with its four bytes of encapsulation; returns whether it was sent. Other encodings are refused.
    pub fn publish(&self, payload: &[u8]) -> bool {
        match payload.starts_with(&[0, 1]) {
            true => self.send(Bytes::raw(payload)),
            false => self.refuse("the payload is not little-endian CDR"),
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
