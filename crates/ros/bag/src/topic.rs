//! A recorded topic: an MCAP channel with its schema.

use std::sync::Arc;

use crate::OfferedQos;

/// A bag's data on a topic beside its messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// The full name: `/auv/state`.
    pub name: String,
    /// The kind of its messages.
    pub kind: Arc<TopicKind>,
}

/// The type and the QoS of the messages of a topic. Topics of one kind share it: a bag of a million
/// topics of one type holds that type once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicKind {
    /// The ROS type: `planesman_msgs/msg/VehicleState`; empty if the file names none.
    pub type_name: String,
    /// The type's definition with all it depends on, so that a reader needs no ROS install.
    pub definition: String,
    /// How [`definition`](Self::definition) is written: `ros2msg`, `ros2idl`, or empty.
    pub definition_encoding: String,
    /// How payloads are encoded: `cdr`.
    pub message_encoding: String,
    /// The type hash (`RIHS01_` and 64 hex digits); empty if the file has none.
    pub type_hash: String,
    /// The QoS that the publishers offered.
    pub offered_qos: Vec<OfferedQos>,
}
