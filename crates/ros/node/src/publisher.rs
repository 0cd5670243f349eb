//! Publishers.

use std::rc::{Rc, Weak};

use planesman_msgs::Message;

use crate::{
    endpoint::{Endpoint, Matched, count},
    service::Bytes,
    shared::Shared,
};

/// Sends messages of one type on one topic. Clones send through the same writer.
pub struct Publisher<M: Message> {
    pub(crate) shared: Rc<Shared>,
    pub(crate) endpoint: Rc<Endpoint>,
    pub(crate) writer: Weak<ros2_client::Publisher<M>>,
}

impl<M: Message> Clone for Publisher<M> {
    fn clone(&self) -> Self {
        Self {
            shared: Rc::clone(&self.shared),
            endpoint: Rc::clone(&self.endpoint),
            writer: Weak::clone(&self.writer),
        }
    }
}

impl<M: Message> Publisher<M> {
    /// Sends `message`, and says whether it went out.
    ///
    /// It does not go out when it holds a number that is not finite, or when the network takes
    /// nothing any more. Both are counted, logged (not too often) and shown in the diagnostics. A reader
    /// that does not acknowledge loses the oldest messages, and is named in the log. The call waits 5 ms at most.
    pub fn publish(&self, message: &M) -> bool {
        let topic = &self.endpoint.topic;
        if let Some(field) = message.first_non_finite() {
            count(&self.endpoint.refused);
            self.shared
                .warn(topic, &format!("not published: {field} is not finite"));
            return false;
        }
        let Some(writer) = self.writer.upgrade() else {
            return false; // The node is shutting down.
        };
        match writer.publish(message.clone()) {
            Ok(()) => {
                count(&self.endpoint.passed);
                true
            }
            Err(error) => {
                count(&self.endpoint.dropped);
                self.shared.warn(topic, &format!("not published: {error}"));
                false
            }
        }
    }

    /// The topic's absolute name after remapping.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.endpoint.topic
    }

    /// The number of matched readers of other nodes.
    #[must_use]
    pub fn readers(&self) -> usize {
        self.shared.participant().map_or(0, |participant| {
            self.endpoint.peers(&Matched::with(&participant))
        })
    }

    /// Nobody else is to publish here: whoever does shows as an error in the diagnostics and the log.
    #[must_use]
    pub fn sole(self) -> Self {
        self.endpoint.sole.set(true);
        self
    }

    /// The number of other nodes' publishers on the topic.
    #[must_use]
    pub fn others(&self) -> usize {
        self.shared
            .participant()
            .map_or(0, |participant| self.endpoint.others(&participant))
    }

    /// The number of messages sent.
    #[must_use]
    pub fn published(&self) -> u64 {
        self.endpoint.passed.get()
    }
}

/// Sends payloads as they are, for playing what was recorded.
pub struct RawPublisher {
    pub(crate) shared: Rc<Shared>,
    pub(crate) endpoint: Rc<Endpoint>,
    pub(crate) writer: Weak<ros2_client::Publisher<Bytes>>,
}

impl RawPublisher {
    /// Sends a CDR payload in little endian, with its four bytes of encapsulation, and says whether it went out. One in another encoding
    /// does not.
    pub fn publish(&self, payload: &[u8]) -> bool {
        let topic = &self.endpoint.topic;
        if !payload.starts_with(&[0, 1]) {
            count(&self.endpoint.refused);
            self.shared
                .warn(topic, "not published: it is not CDR in little endian");
            return false;
        }
        let Some(writer) = self.writer.upgrade() else {
            return false; // The node is shutting down.
        };
        match writer.publish(Bytes::raw(payload)) {
            Ok(()) => {
                count(&self.endpoint.passed);
                true
            }
            Err(error) => {
                count(&self.endpoint.dropped);
                self.shared.warn(topic, &format!("not published: {error}"));
                false
            }
        }
    }
}
