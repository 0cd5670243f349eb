//! A publisher or subscription of the node: description, counters, peers.

use std::cell::Cell;
use std::time::Duration;

use ros2_client::Gid;
use rustdds::{
    DomainParticipant, GUID, QosPolicies, RTPSEntity as _,
    discovery::{DiscoveredReaderData, DiscoveredWriterData},
};

use crate::qos::Qos;

/// Direction of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// Publishes.
    Publisher,
    /// Subscribes.
    Subscription,
}

/// Names of a topic's type in ROS and in DDS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TypeNames {
    /// `planesman_msgs/msg/VehicleState`
    pub(crate) ros: String,
    /// `planesman_msgs::msg::dds_::VehicleState_`
    pub(crate) dds: String,
    /// `RIHS01_...`; `None` for types that are only recorded.
    pub(crate) hash: Option<String>,
}

/// A publisher or subscription with its counters.
#[derive(Debug)]
pub(crate) struct Endpoint {
    pub(crate) direction: Direction,
    /// Absolute ROS name.
    pub(crate) topic: String,
    pub(crate) types: TypeNames,
    qos: QosPolicies,
    /// Number of messages passed to the middleware, or to the node.
    pub(crate) passed: Cell<u64>,
    /// Number of messages refused because of their content, or not decodable.
    pub(crate) refused: Cell<u64>,
    /// Number of messages for which the middleware had no space.
    pub(crate) dropped: Cell<u64>,
    /// Whether other publishers are reported as errors.
    pub(crate) sole: Cell<bool>,
    /// For a subscription that follows one publisher: time of silence after which another one is accepted.
    pub(crate) follows_one: Option<Duration>,
}

impl Endpoint {
    pub(crate) fn new(direction: Direction, topic: &str, types: TypeNames, qos: Qos) -> Self {
        Self {
            direction,
            topic: topic.to_owned(),
            types,
            qos: qos.profile().into(),
            passed: Cell::new(0),
            refused: Cell::new(0),
            dropped: Cell::new(0),
            sole: Cell::new(false),
            follows_one: qos.follows_one(),
        }
    }

    /// DDS name of the topic, such as `rt/auv/state`.
    pub(crate) fn dds_topic(&self) -> String {
        format!("rt{}", self.topic)
    }

    /// Number of matched endpoints of other participants, with the same topic and type and compatible QoS.
    pub(crate) fn peers(&self, matched: &Matched) -> usize {
        let topic = self.dds_topic();
        match self.direction {
            Direction::Publisher => matched
                .readers
                .iter()
                .map(|reader| &reader.subscription_topic_data)
                .filter(|reader| {
                    *reader.topic_name() == topic
                        && *reader.type_name() == self.types.dds
                        && self.qos.compliance_failure_wrt(&reader.qos()).is_none()
                })
                .count(),
            Direction::Subscription => matched
                .writers
                .iter()
                .map(|writer| &writer.publication_topic_data)
                .filter(|writer| {
                    writer.topic_name == topic
                        && writer.type_name == self.types.dds
                        && writer.qos().compliance_failure_wrt(&self.qos).is_none()
                })
                .count(),
        }
    }

    /// Number of writers on the topic, of any type, that are not of `participant`.
    pub(crate) fn others(&self, participant: &DomainParticipant) -> usize {
        let (topic, own) = (self.dds_topic(), participant.guid().prefix);
        participant
            .discovered_writers_where(|writer| {
                let writer = &writer.publication_topic_data;
                writer.topic_name == topic && writer.key.prefix != own
            })
            .len()
    }

    /// Type mismatch of the writer `gid`, empty if the types match; `None` while the writer is not discovered. The middleware matches by topic only.
    pub(crate) fn objection_to(&self, gid: Gid, participant: &DomainParticipant) -> Option<String> {
        let guid = GUID::from(gid);
        let writer = participant
            .discovered_writers_where(|writer| writer.publication_topic_data.key == guid)
            .pop()?;
        let theirs = &writer.publication_topic_data.type_name;
        if *theirs != self.types.dds {
            let reason = format!("a publisher has the type {theirs}, not {}", self.types.dds);
            return Some(reason);
        }
        let objection = match (announced_hash(&writer), &self.types.hash) {
            (Some(theirs), Some(ours)) if theirs != *ours => format!(
                "a publisher uses another version of {} ({theirs}; this node has {ours})",
                self.types.ros
            ),
            _ => String::new(),
        };
        Some(objection)
    }
}

/// Endpoints of others matched with this participant's. Read once for all endpoints, since the middleware searches everything it has
/// discovered.
#[derive(Default)]
pub(crate) struct Matched {
    readers: Vec<DiscoveredReaderData>,
    writers: Vec<DiscoveredWriterData>,
}

impl Matched {
    pub(crate) fn with(participant: &DomainParticipant) -> Self {
        Self {
            readers: participant.discovered_readers_where(|reader| {
                participant.matches_with(reader.reader_proxy.remote_reader_guid) > 0
            }),
            writers: participant.discovered_writers_where(|writer| {
                participant.matches_with(writer.writer_proxy.remote_writer_guid) > 0
            }),
        }
    }
}

/// The `typehash=RIHS01_...;` in a writer's user data.
pub(crate) fn announced_hash(writer: &DiscoveredWriterData) -> Option<String> {
    let text = String::from_utf8_lossy(&writer.user_data);
    let (_, rest) = text.split_once("typehash=")?;
    let (hash, _) = rest.split_once(';')?;
    Some(hash.to_owned())
}

/// Increments a counter.
pub(crate) fn count(counter: &Cell<u64>) {
    counter.set(counter.get().saturating_add(1));
}
