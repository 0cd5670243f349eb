//! Topics published by other participants, from discovery.

use std::collections::{BTreeMap, BTreeSet};

use rustdds::{
    DomainParticipant, GUID, RTPSEntity as _,
    discovery::DiscoveredWriterData,
    qos::policy::{Durability, Reliability},
};

use crate::endpoint::announced_hash;

/// First bytes of the identities of a participant's endpoints.
pub(crate) type ParticipantId = [u8; 12];

/// A topic of one type published by other participants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublishedTopic {
    /// Absolute name.
    pub name: String,
    /// Type, such as `std_msgs/msg/Float64`.
    pub type_name: String,
    /// Type hash announced by the first publisher that announces one.
    pub type_hash: Option<String>,
    /// QoS of each publisher.
    pub offers: Vec<Offer>,
    /// The publishers' participants.
    participants: Vec<ParticipantId>,
}

/// QoS of a publisher, as far as discovery transmits it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offer {
    /// Whether lost samples are retransmitted.
    pub reliable: bool,
    /// Whether late joiners receive earlier samples.
    pub latched: bool,
}

/// Topics published by others, sorted by name and type.
pub(crate) fn published_topics(participant: &DomainParticipant) -> Vec<PublishedTopic> {
    let own = participant.guid().prefix;
    let writers = participant.discovered_writers_where(|writer| {
        let data = &writer.publication_topic_data;
        data.topic_name.starts_with("rt/") && data.key.prefix != own
    });
    let mut topics: BTreeMap<(String, String), PublishedTopic> = BTreeMap::new();
    for writer in &writers {
        let data = &writer.publication_topic_data;
        let name = data.topic_name.trim_start_matches("rt");
        let Some(type_name) = ros_type(&data.type_name) else {
            continue;
        };
        let topic = topics
            .entry((name.to_owned(), type_name.clone()))
            .or_insert_with(|| PublishedTopic {
                name: name.to_owned(),
                type_name,
                type_hash: None,
                offers: Vec::new(),
                participants: Vec::new(),
            });
        topic.offers.push(offer(writer));
        topic.type_hash = topic.type_hash.take().or_else(|| announced_hash(writer));
        topic.participants.extend(prefix(data.key));
    }
    topics.into_values().collect()
}

pub(crate) fn prefix(endpoint: GUID) -> Option<ParticipantId> {
    endpoint.to_bytes().first_chunk().copied()
}

/// The nodes that publish on the DDS topic, sorted: the nodes that serve parameters in the writers' participants, and an unnamed node for each
/// participant without such a node.
pub(crate) fn publishing_nodes(participant: &DomainParticipant, topic: &str) -> Vec<String> {
    let own = participant.guid().prefix;
    let writers = participant.discovered_writers_where(|writer| {
        let data = &writer.publication_topic_data;
        data.topic_name == topic && data.key.prefix != own
    });
    let homes: BTreeSet<ParticipantId> = writers
        .iter()
        .filter_map(|it| prefix(it.publication_topic_data.key))
        .collect();
    let named = |home: &ParticipantId| {
        let ending = "/get_parameters";
        let served = services(participant, ending, |id| id == home);
        let nodes = served.iter().filter_map(|it| it.strip_suffix(ending));
        let names: Vec<&str> = nodes.collect();
        match names.is_empty() {
            true => "a node that has no parameter services".to_owned(),
            false => names.join(" or "),
        }
    };
    let mut nodes: Vec<String> = homes.iter().map(named).collect();
    nodes.sort();
    nodes
}

/// Whether the participant has a writer on the DDS topic.
pub(crate) fn writes(participant: &DomainParticipant, topic: &str, other: ParticipantId) -> bool {
    let writers = participant.discovered_writers_where(|writer| {
        let data = &writer.publication_topic_data;
        data.topic_name == topic && prefix(data.key) == Some(other)
    });
    !writers.is_empty()
}

/// The participants that contain a node with this full name: the participants that serve its parameters.
pub(crate) fn homes_of(participant: &DomainParticipant, node: &str) -> Vec<ParticipantId> {
    let topic = format!("rq{node}/get_parametersRequest");
    let servers = participant
        .discovered_readers_where(|reader| *reader.subscription_topic_data.topic_name() == topic);
    let homes = servers.iter().map(|it| it.reader_proxy.remote_reader_guid);
    homes.filter_map(prefix).collect()
}

/// Whether both participants contain a node with the same full name.
pub(crate) fn have_a_name_in_common(
    participant: &DomainParticipant,
    one: ParticipantId,
    other: ParticipantId,
) -> bool {
    let nodes = |id| services(participant, "/get_parameters", |home| *home == id);
    let others = nodes(other);
    nodes(one).iter().any(|node| others.contains(node))
}

fn offer(writer: &DiscoveredWriterData) -> Offer {
    let data = &writer.publication_topic_data;
    Offer {
        // A writer that announces none is reliable, DDS' default.
        reliable: !matches!(data.reliability, Some(Reliability::BestEffort)),
        latched: data
            .durability
            .is_some_and(|it| it >= Durability::TransientLocal),
    }
}

/// Services by which the nodes of a topic's publishers describe their types; may include services of other nodes in the same process.
pub(crate) fn describers(participant: &DomainParticipant, topic: &PublishedTopic) -> Vec<String> {
    services(participant, "/get_type_description", |prefix| {
        topic.participants.contains(prefix)
    })
}

/// Services of other participants whose names end with `ending`, sorted.
pub(crate) fn services_of_others(participant: &DomainParticipant, ending: &str) -> Vec<String> {
    let own = prefix(participant.guid());
    services(participant, ending, |prefix| Some(*prefix) != own)
}

fn services(
    participant: &DomainParticipant,
    ending: &str,
    of: impl Fn(&ParticipantId) -> bool,
) -> Vec<String> {
    let ending = format!("{ending}Request");
    let readers = participant.discovered_readers_where(|reader| {
        let name = reader.subscription_topic_data.topic_name();
        name.starts_with("rq/")
            && name.ends_with(&ending)
            && prefix(reader.reader_proxy.remote_reader_guid).is_some_and(|prefix| of(&prefix))
    });
    let names = readers.iter().filter_map(|reader| {
        let name = reader.subscription_topic_data.topic_name();
        let name = name.strip_prefix("rq")?.strip_suffix("Request")?;
        Some(name.to_owned())
    });
    let mut names: Vec<String> = names.collect();
    names.sort();
    names.dedup();
    names
}

/// ROS name of a DDS type such as `std_msgs::msg::dds_::Float64_`; `None` for a type that is not of ROS.
fn ros_type(dds_type: &str) -> Option<String> {
    let parts: Vec<&str> = dds_type.split("::").collect();
    match parts[..] {
        [package, kind @ ("msg" | "srv" | "action"), "dds_", name]
            // Anybody announces types: one with a slash in its name is not ROS's.
            if !package.contains('/') && !name.contains('/') =>
        {
            Some(format!("{package}/{kind}/{}", name.strip_suffix('_')?))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::ros_type;

    #[test]
    fn types_have_ros_names() {
        for (dds, ros) in [
            (
                "std_msgs::msg::dds_::Float64_",
                Some("std_msgs/msg/Float64"),
            ),
            ("a::srv::dds_::B_Event_", Some("a/srv/B_Event")),
            ("a/b::msg::dds_::C_", None),
            ("a::msg::dds_::b/C_", None),
            (
                "a::action::dds_::B_FeedbackMessage_",
                Some("a/action/B_FeedbackMessage"),
            ),
            ("std_msgs::msg::dds_::Float64", None),
            ("HelloWorld", None),
            ("", None),
        ] {
            assert_eq!(ros_type(dds).as_deref(), ros, "{dds}");
        }
    }
}
