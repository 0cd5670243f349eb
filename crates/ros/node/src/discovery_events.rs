//! Logs discovery events in `rclcpp`'s words: incompatible QoS of a peer, a reader that does not acknowledge.

use std::{cell::RefCell, collections::HashSet};

use rustdds::{
    DomainParticipantStatusEvent as Event, GUID,
    qos::{QosPolicies, QosPolicyId},
};

use crate::shared::Shared;

/// Maximum number of pairs remembered; beyond this number all pairs are logged again.
const MAX_PAIRS: usize = 1000;

/// Logs each event once per pair of endpoints.
#[derive(Default)]
pub(crate) struct DiscoveryEvents {
    told: RefCell<HashSet<(GUID, GUID)>>,
}

impl DiscoveryEvents {
    pub(crate) fn log(&self, shared: &Shared, event: &Event) {
        match event {
            Event::RemoteReaderQosIncompatible {
                local_writer,
                remote_reader,
                requested_qos,
                offered_qos,
            } if self.is_new(*local_writer, *remote_reader) => {
                if let Some(topic) = topic_of_reader(shared, *remote_reader) {
                    log::warn!(
                        "New subscription discovered on topic '{topic}', requesting incompatible QoS. No messages will be sent to it. \
                         Last incompatible policy: {}",
                        last_policy(offered_qos, requested_qos)
                    );
                }
            }
            Event::RemoteWriterQosIncompatible {
                local_reader,
                remote_writer,
                requested_qos,
                offered_qos,
            } if self.is_new(*local_reader, *remote_writer) => {
                if let Some(topic) = topic_of_writer(shared, *remote_writer) {
                    log::warn!(
                        "New publisher discovered on topic '{topic}', offering incompatible QoS. No messages will be received from it. \
                         Last incompatible policy: {}",
                        last_policy(offered_qos, requested_qos)
                    );
                }
            }
            Event::RemoteReaderLostSamples {
                remote_reader,
                count,
                ..
            } => {
                if let Some(topic) = topic_of_reader(shared, *remote_reader) {
                    let text = format!(
                        "the subscription {} does not acknowledge messages and has lost {count} of them",
                        gid(*remote_reader)
                    );
                    shared.warn(&topic, &text);
                }
            }
            _ => {}
        }
    }

    fn is_new(&self, local: GUID, remote: GUID) -> bool {
        let mut told = self.told.borrow_mut();
        if told.len() >= MAX_PAIRS {
            told.clear();
        }
        told.insert((local, remote))
    }
}

/// Name of the policy in rclcpp.
fn last_policy(offered: &QosPolicies, requested: &QosPolicies) -> String {
    let policy = match offered.compliance_failure_wrt(requested) {
        Some(QosPolicyId::Durability) => "DURABILITY",
        Some(QosPolicyId::Deadline) => "DEADLINE",
        Some(QosPolicyId::Liveliness) => "LIVELINESS",
        Some(QosPolicyId::Reliability) => "RELIABILITY",
        Some(QosPolicyId::Lifespan) => "LIFESPAN",
        _ => return "UNKNOWN".to_owned(),
    };
    format!("{policy}_QOS_POLICY")
}

/// ROS topic of another node's reader; `None` for services.
fn topic_of_reader(shared: &Shared, reader: GUID) -> Option<String> {
    let found = shared
        .participant()?
        .discovered_readers_where(|known| known.reader_proxy.remote_reader_guid == reader)
        .pop()?;
    ros_topic(found.subscription_topic_data.topic_name())
}

/// ROS topic of another node's writer; `None` for services.
fn topic_of_writer(shared: &Shared, writer: GUID) -> Option<String> {
    let found = shared
        .participant()?
        .discovered_writers_where(|known| known.writer_proxy.remote_writer_guid == writer)
        .pop()?;
    ros_topic(&found.publication_topic_data.topic_name)
}

fn ros_topic(dds_topic: &str) -> Option<String> {
    dds_topic.strip_prefix("rt").map(str::to_owned)
}

/// GID of an endpoint in the form of `ros2 topic info --verbose`.
fn gid(endpoint: GUID) -> String {
    let bytes = endpoint.to_bytes().map(|byte| format!("{byte:02x}"));
    bytes.join(".")
}
