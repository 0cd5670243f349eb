//! Typed reading and writing of this project's message types.

use std::sync::Arc;

use planesman_msgs::{self as msgs, TypeInfo, cdr};

use crate::{BagWriter, Message, OfferedQos, Topic, TopicId, TopicKind, WriteError};

impl Topic {
    /// The topic `name` with messages of type `M` and the QoS `qos`.
    #[must_use]
    pub fn of<M: msgs::Message>(name: impl Into<String>, qos: OfferedQos) -> Self {
        Self::of_type(&TypeInfo::of::<M>(), name, qos)
    }

    /// The topic `name` with messages of a type known at run time and the QoS `qos`.
    #[must_use]
    pub fn of_type(info: &TypeInfo, name: impl Into<String>, qos: OfferedQos) -> Self {
        Self {
            name: name.into(),
            kind: Arc::new(TopicKind {
                type_name: info.type_name.to_owned(),
                definition: info.definition.to_owned(),
                definition_encoding: "ros2msg".to_owned(),
                message_encoding: "cdr".to_owned(),
                type_hash: info.type_hash.to_owned(),
                offered_qos: vec![qos],
            }),
        }
    }
}

impl BagWriter {
    /// Writes a message with `log_time` (ns) as time of reception and of publication.
    ///
    /// # Errors
    /// [`WriteError::WrongType`] if the topic has another type; the errors of [`write_raw`](Self::write_raw).
    pub fn write<M: msgs::Message>(
        &mut self,
        topic: TopicId,
        message: &M,
        log_time: i64,
    ) -> Result<(), WriteError> {
        let carried = self.topic(topic)?;
        if carried.kind.type_name != M::TYPE_NAME {
            return Err(WriteError::WrongType {
                name: carried.name.clone(),
                expected: carried.kind.type_name.clone(),
                given: M::TYPE_NAME.to_owned(),
            });
        }
        self.write_raw(topic, &cdr::to_bytes(message), log_time, log_time)
    }
}

impl Message {
    /// Decodes the payload as an `M`.
    ///
    /// # Errors
    /// The payload is not exactly one `M`. The topic's type name is not checked; a caller that reads several types checks it first.
    pub fn decode<M: msgs::Message>(&self) -> Result<M, cdr::Error> {
        cdr::from_bytes(&self.payload)
    }
}
