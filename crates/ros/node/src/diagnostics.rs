//! A node's status on `/diagnostics`: writing and reading.
//!
//! Each node has a status `<full name>: connections` with one key-value pair per topic: `pub /auv/state` has the value
//! `readers=2 published=400 refused=0 dropped=0`, `sub /auv/plane_command` has `writers=1 received=400 refused=0`. Nodes can add further statuses.

use planesman_msgs::{
    diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue},
    std_msgs::msg::Header,
};

use crate::{
    endpoint::{Direction, Endpoint, Matched},
    shared::Shared,
};

/// End of the name of the status that lists the connections.
const CONNECTIONS: &str = ": connections";

/// Level of a status, as in `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Works.
    Ok,
    /// The function works, but needs attention.
    Warn,
    /// Does not work.
    Error,
    /// Not reported yet.
    Stale,
}

impl From<Level> for u8 {
    fn from(level: Level) -> Self {
        match level {
            Level::Ok => DiagnosticStatus::OK,
            Level::Warn => DiagnosticStatus::WARN,
            Level::Error => DiagnosticStatus::ERROR,
            Level::Stale => DiagnosticStatus::STALE,
        }
    }
}

/// One topic of a node in its diagnostics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// Whether the node publishes or subscribes.
    pub direction: Direction,
    /// Absolute name of the topic.
    pub topic: String,
    /// Number of matched readers or writers.
    pub peers: usize,
    /// Number of messages sent or received.
    pub messages: u64,
    /// Number of messages refused because of their content.
    pub refused: u64,
    /// Number of messages that could not be sent.
    pub dropped: u64,
}

impl Connection {
    fn of(endpoint: &Endpoint, matched: &Matched) -> Self {
        Self {
            direction: endpoint.direction,
            topic: endpoint.topic.clone(),
            peers: endpoint.peers(matched),
            messages: endpoint.passed.get(),
            refused: endpoint.refused.get(),
            dropped: endpoint.dropped.get(),
        }
    }

    fn to_pair(&self) -> KeyValue {
        let Self {
            topic,
            peers,
            messages,
            refused,
            dropped,
            ..
        } = self;
        match self.direction {
            Direction::Publisher => KeyValue {
                key: format!("pub {topic}"),
                value: format!(
                    "readers={peers} published={messages} refused={refused} dropped={dropped}"
                ),
            },
            Direction::Subscription => KeyValue {
                key: format!("sub {topic}"),
                value: format!("writers={peers} received={messages} refused={refused}"),
            },
        }
    }

    fn from_pair(pair: &KeyValue) -> Option<Self> {
        let (direction, topic) = match pair.key.split_once(' ')? {
            ("pub", topic) => (Direction::Publisher, topic),
            ("sub", topic) => (Direction::Subscription, topic),
            _ => return None,
        };
        let number = |names: [&str; 2]| -> Option<u64> {
            pair.value
                .split(' ')
                .filter_map(|entry| entry.split_once('='))
                .find(|(name, _)| names.contains(name))
                .and_then(|(_, number)| number.parse().ok())
        };
        Some(Self {
            direction,
            topic: topic.to_owned(),
            peers: usize::try_from(number(["readers", "writers"])?).ok()?,
            messages: number(["published", "received"])?,
            refused: number(["refused", ""])?,
            dropped: number(["dropped", ""]).unwrap_or(0),
        })
    }
}

/// A node's topics in its diagnostics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connections {
    /// The node's full name.
    pub node: String,
    /// Its topics.
    pub list: Vec<Connection>,
}

impl Connections {
    /// The connections in a node's diagnostics; `None` without such a status.
    #[must_use]
    pub fn from_diagnostics(array: &DiagnosticArray) -> Option<Self> {
        array.status.iter().find_map(|status| {
            Some(Self {
                node: status.name.strip_suffix(CONNECTIONS)?.to_owned(),
                list: status
                    .values
                    .iter()
                    .filter_map(Connection::from_pair)
                    .collect(),
            })
        })
    }

    /// The connection of `topic` in this direction.
    #[must_use]
    pub fn find(&self, direction: Direction, topic: &str) -> Option<&Connection> {
        self.list
            .iter()
            .find(|c| c.direction == direction && c.topic == topic)
    }
}

/// The node's present connections.
pub(crate) fn connections(shared: &Shared) -> Connections {
    let participant = shared.participant();
    let matched = participant.as_ref().map(Matched::with).unwrap_or_default();
    let list = shared
        .endpoints
        .borrow()
        .iter()
        .map(|endpoint| Connection::of(endpoint, &matched))
        .collect();
    Connections {
        node: shared.names.full(),
        list,
    }
}

/// The node's complete diagnostics message.
pub(crate) fn array(shared: &Shared) -> DiagnosticArray {
    let Connections { node, list } = connections(shared);
    let shared_topics = topics_of_others_too(shared);
    for topic in &shared_topics {
        shared.complain(
            topic,
            "another node publishes on this topic too, but only one publisher is allowed",
        );
    }
    let mut status = vec![connections_status(&node, &list, &shared_topics)];
    status.extend(shared.statuses.borrow().values().cloned());
    DiagnosticArray {
        header: Header {
            stamp: shared.clock.now(),
            frame_id: String::new(),
        },
        status,
    }
}

/// Number of messages that the node has published and received, without messages about nodes themselves.
pub(crate) fn messages(shared: &Shared) -> u64 {
    let endpoints = shared.endpoints.borrow();
    let of_the_loop = |topic: &str| !["/diagnostics", "/rosout"].contains(&topic);
    let counted = endpoints.iter().filter(|it| of_the_loop(&it.topic));
    counted.map(|endpoint| endpoint.passed.get()).sum()
}

/// Topics with other publishers on which this node should be the only one.
fn topics_of_others_too(shared: &Shared) -> Vec<String> {
    let Some(participant) = shared.participant() else {
        return Vec::new();
    };
    let endpoints = shared.endpoints.borrow();
    let sole = endpoints.iter().filter(|endpoint| endpoint.sole.get());
    sole.filter(|endpoint| endpoint.others(&participant) > 0)
        .map(|endpoint| endpoint.topic.clone())
        .collect()
}

fn connections_status(
    node: &str,
    connections: &[Connection],
    shared_topics: &[String],
) -> DiagnosticStatus {
    let total = |count: fn(&Connection) -> u64| connections.iter().map(count).sum::<u64>();
    let (refused, dropped) = (total(|c| c.refused), total(|c| c.dropped));
    let (level, message) = if !shared_topics.is_empty() {
        let topics = shared_topics.join(", ");
        (
            Level::Error,
            format!("another node publishes here too: {topics}"),
        )
    } else if refused + dropped > 0 {
        (
            Level::Warn,
            format!("{refused} messages refused, {dropped} dropped"),
        )
    } else {
        (Level::Ok, "ok".to_owned())
    };
    DiagnosticStatus {
        level: level.into(),
        name: format!("{node}{CONNECTIONS}"),
        message,
        hardware_id: node.to_owned(),
        values: connections.iter().map(Connection::to_pair).collect(),
    }
}

/// Sets one of the node's own statuses.
pub(crate) fn status(
    node: &str,
    name: &str,
    level: Level,
    message: &str,
    values: &[(&str, String)],
) -> DiagnosticStatus {
    DiagnosticStatus {
        level: level.into(),
        name: format!("{node}: {name}"),
        message: message.to_owned(),
        hardware_id: node.to_owned(),
        values: values
            .iter()
            .map(|(key, value)| KeyValue {
                key: (*key).to_owned(),
                value: value.clone(),
            })
            .collect(),
    }
}

/// Sets the status `name` of the node; a change of level is published soon.
pub(crate) fn set_status(
    shared: &Shared,
    name: &str,
    level: Level,
    message: &str,
    values: &[(&str, String)],
) {
    let new = status(&shared.names.full(), name, level, message, values);
    let level = new.level;
    let old = shared.statuses.borrow_mut().insert(name.to_owned(), new);
    if old.is_none_or(|old| old.level != level) {
        shared.request_diagnostics();
    }
}

/// Publishes how much network traffic the middleware has refused: `now` in total, `before` when last published.
pub(crate) fn set_refusals<const N: usize>(
    shared: &Shared,
    before: [(&str, u64); N],
    now: [(&str, u64); N],
) {
    let (level, message) = if before == now {
        (Level::Ok, "running")
    } else {
        (Level::Warn, "malformed or excessive traffic was refused")
    };
    let values = now.map(|(what, count)| (what, count.to_string()));
    set_status(shared, "middleware", level, message, &values);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_read_back_as_they_were_told() {
        let list = vec![
            Connection {
                direction: Direction::Publisher,
                topic: "/auv/state".to_owned(),
                peers: 2,
                messages: 400,
                refused: 1,
                dropped: 3,
            },
            Connection {
                direction: Direction::Subscription,
                topic: "/auv/plane_motion".to_owned(),
                peers: 1,
                messages: 399,
                refused: 0,
                dropped: 0,
            },
        ];
        let status = connections_status("/auv/plant_sim", &list, &[]);
        assert_eq!(status.level, DiagnosticStatus::WARN);
        let array = DiagnosticArray {
            status: vec![DiagnosticStatus::default(), status],
            ..DiagnosticArray::default()
        };
        let read = Connections::from_diagnostics(&array).expect("written");
        assert_eq!(read.node, "/auv/plant_sim");
        assert_eq!(read.list, list);
        assert!(read.find(Direction::Subscription, "/auv/state").is_none());
        let both = connections_status("/auv/plant_sim", &list, &["/auv/state".to_owned()]);
        assert_eq!(both.level, DiagnosticStatus::ERROR);
        assert!(both.message.ends_with("/auv/state"), "{}", both.message);
    }
}
