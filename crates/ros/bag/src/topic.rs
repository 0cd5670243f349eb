//! A recorded topic: an MCAP channel with its schema.

use std::sync::Arc;

use crate::OfferedQos;

/// Description of a topic in a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Full name, such as `/auv/state`.
    pub name: String,
    /// Kind of its messages.
    pub kind: Arc<TopicKind>,
}

/// Type and QoS of a topic's messages, shared by topics of the same kind: a bag with a million topics of one type stores the type only once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicKind {
    /// ROS type, such as `planesman_msgs/msg/VehicleState`; empty if the file does not name it.
    pub type_name: String,
    /// Definition of the type and of all types it uses, so that a reader needs no ROS installation.
    pub definition: String,
    /// Format of [`definition`](Self::definition): `ros2msg`, `ros2idl`, or empty.
    pub definition_encoding: String,
    /// Encoding of the payloads: `cdr`.
    pub message_encoding: String,
    /// Type hash (`RIHS01_` and 64 hex digits); empty if unknown.
    pub type_hash: String,
    /// QoS offered by the publishers.
    pub offered_qos: Vec<OfferedQos>,
}
