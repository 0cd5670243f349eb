//! Nodes that are alive, by discovery and by diagnostics.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_node::{Connections, Direction, claim};
use serde_json::{Value, json};

/// Maximum number of nodes and statuses shown: a hostile peer can create any number.
const MAX_NODES: usize = 500;
const MAX_STATUSES: usize = 2000;
/// Largest total text of all statuses, bytes: about a hundred times the text of one vehicle.
const MAX_TEXT: usize = 4 << 20;

/// Time without diagnostics after which a node counts as silent; nodes send them every second.
const SILENCE_TIMEOUT: Duration = Duration::from_millis(2500);

/// Largest text of a foreign node, bytes.
pub(crate) const LONGEST_TEXT: usize = 4096;

/// A foreign node's text, cut at [`LONGEST_TEXT`].
pub(crate) fn bounded(text: &str) -> &str {
    match text.char_indices().find(|(at, _)| *at >= LONGEST_TEXT) {
        Some((at, _)) => &text[..at],
        None => text,
    }
}

#[derive(Default)]
struct Node {
    /// Whether discovery lists the node now.
    discovered: bool,
    /// Time at which discovery dropped the node.
    gone: Option<Instant>,
    /// Time at which the node's last diagnostics arrived.
    heard: Option<Instant>,
    connections: Option<Connections>,
    /// Message rate of each of the node's topics, 1/s.
    rates: BTreeMap<String, f64>,
}

/// All nodes and statuses seen so far.
#[derive(Default)]
pub(crate) struct Nodes {
    nodes: BTreeMap<String, Node>,
    statuses: BTreeMap<String, (Instant, DiagnosticStatus)>,
    /// Total length of the texts of all statuses, bytes.
    text: usize,
}

impl Nodes {
    /// Updates the nodes from discovery's names; returns the nodes that are new or have returned.
    pub(crate) fn discovered(&mut self, names: &[String], now: Instant) -> Vec<String> {
        for (name, node) in &mut self.nodes {
            if node.discovered && names.binary_search(name).is_err() {
                node.discovered = false;
                node.gone = Some(now);
            }
        }
        let mut new = Vec::new();
        for name in names {
            if self.nodes.len() >= MAX_NODES && !self.nodes.contains_key(name) {
                continue;
            }
            let node = self.nodes.entry(name.clone()).or_default();
            if !node.discovered {
                new.push(name.clone());
            }
            node.discovered = true;
            node.gone = None;
        }
        new
    }

    /// Updates a node from its diagnostics.
    pub(crate) fn heard(&mut self, array: &DiagnosticArray, now: Instant) {
        if let Some(connections) = Connections::from_diagnostics(array)
            && (self.nodes.len() < MAX_NODES || self.nodes.contains_key(&connections.node))
        {
            let node = self.nodes.entry(connections.node.clone()).or_default();
            if let (Some(before), Some(heard)) = (&node.connections, node.heard) {
                let seconds = now.duration_since(heard).as_secs_f64();
                // Diagnostics that come soon after the last ones count too few messages for a rate.
                if seconds > 0.5 {
                    node.rates = rates(before, &connections, seconds);
                    (node.heard, node.connections) = (Some(now), Some(connections));
                }
            } else {
                (node.heard, node.connections) = (Some(now), Some(connections));
            }
        }
        for status in &array.status {
            let before = self.statuses.get(&status.name);
            let is_new = before.is_none();
            let text = self.text - before.map_or(0, |(_, it)| text_of(it)) + text_of(status);
            if text <= MAX_TEXT && !(is_new && self.statuses.len() >= MAX_STATUSES) {
                self.text = text;
                let status = status.clone();
                self.statuses.insert(status.name.clone(), (now, status));
            }
        }
    }

    /// Message rate of each topic as counted by its publishers, 1/s.
    pub(crate) fn topic_rates(&self) -> BTreeMap<&str, f64> {
        let mut rates: BTreeMap<&str, f64> = BTreeMap::new();
        for (topic, rate) in self.nodes.values().flat_map(|node| &node.rates) {
            *rates.entry(topic).or_default() += rate;
        }
        rates
    }

    /// Number of warnings and of errors in the statuses of the namespace's nodes that are not silent.
    pub(crate) fn levels(&self, namespace: &str, now: Instant) -> [usize; 2] {
        let prefix = format!("{namespace}/");
        let within = self.statuses.iter().filter(|(name, (heard, _))| {
            name.starts_with(&prefix) && now.duration_since(*heard) < SILENCE_TIMEOUT
        });
        let levels: Vec<u8> = within.map(|(_, (_, status))| status.level).collect();
        [
            levels
                .iter()
                .filter(|it| **it == DiagnosticStatus::WARN)
                .count(),
            levels
                .iter()
                .filter(|it| **it >= DiagnosticStatus::ERROR)
                .count(),
        ]
    }

    /// The nodes for the page.
    pub(crate) fn told(&self, now: Instant) -> Value {
        let node = |(name, node): (&String, &Node)| {
            let age = node.heard.map(|heard| now.duration_since(heard));
            let state = match age {
                _ if node.gone.is_some() => "gone",
                Some(age) if age >= SILENCE_TIMEOUT => "silent",
                _ => "alive",
            };
            let list = node.connections.as_ref().map(|it| it.list.as_slice());
            let list = list.unwrap_or_default();
            let sum = |count: fn(&planesman_node::Connection) -> u64| {
                list.iter().map(count).fold(0, u64::saturating_add)
            };
            json!({
                "name": bounded(name),
                "state": state,
                "for": match state {
                    "gone" => node.gone.map(|gone| now.duration_since(gone).as_secs()),
                    "silent" => age.map(|age| age.as_secs()),
                    _ => None,
                },
                "published": list.iter().any(|it| it.direction == Direction::Publisher)
                    .then(|| rounded(node.rates.values().sum())),
                "refused": sum(|it| it.refused),
                "dropped": sum(|it| it.dropped),
            })
        };
        self.nodes.iter().map(node).collect()
    }

    /// The statuses for the page.
    pub(crate) fn told_statuses(&self, now: Instant) -> Value {
        let status = |(name, (heard, status)): (&String, &(Instant, DiagnosticStatus))| {
            let is_connections = name.ends_with(": connections");
            let values = status
                .values
                .iter()
                .take(if is_connections { 0 } else { 50 });
            let values: Vec<_> = values
                .map(|pair| [bounded(&pair.key), bounded(&pair.value)])
                .collect();
            json!({
                "name": bounded(name),
                "level": status.level,
                "message": bounded(&status.message),
                "stale": now.duration_since(*heard) >= SILENCE_TIMEOUT,
                "values": values,
            })
        };
        // By claims programs agree with each other; middleware that runs is nothing for an operator.
        let is_told = |(name, (_, status)): &(&String, &(Instant, DiagnosticStatus))| {
            let is_sound = status.level == DiagnosticStatus::OK;
            !(claim::is_status(name) || is_sound && name.ends_with(": middleware"))
        };
        self.statuses.iter().filter(is_told).map(status).collect()
    }

    /// A value of a status, such as `bag` in `/auv/recorder: bag`.
    pub(crate) fn value(&self, status: &str, key: &str) -> Option<&str> {
        let (_, status) = self.statuses.get(status)?;
        let pair = status.values.iter().find(|pair| pair.key == key)?;
        Some(&pair.value)
    }
}

/// Length of a status's text, bytes.
fn text_of(status: &DiagnosticStatus) -> usize {
    let values = status.values.iter();
    let values = values.map(|it| it.key.len() + it.value.len());
    status.name.len() + status.message.len() + status.hardware_id.len() + values.sum::<usize>()
}

fn rates(before: &Connections, now: &Connections, seconds: f64) -> BTreeMap<String, f64> {
    let published = now
        .list
        .iter()
        .filter(|it| it.direction == Direction::Publisher);
    let rate = |it: &planesman_node::Connection| {
        let earlier = before.find(Direction::Publisher, &it.topic)?.messages;
        Some((
            it.topic.clone(),
            it.messages.checked_sub(earlier)? as f64 / seconds,
        ))
    };
    published.filter_map(rate).collect()
}

/// A rate rounded to 0.1.
pub(crate) fn rounded(rate: f64) -> f64 {
    (rate * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::diagnostic_msgs::msg::KeyValue;

    fn diagnostics(published: u64) -> DiagnosticArray {
        DiagnosticArray {
            status: vec![DiagnosticStatus {
                level: DiagnosticStatus::WARN,
                name: "/auv/plant_sim: connections".to_owned(),
                values: vec![KeyValue {
                    key: "pub /auv/state".to_owned(),
                    value: format!("readers=1 published={published} refused=0 dropped=2"),
                }],
                ..DiagnosticStatus::default()
            }],
            ..DiagnosticArray::default()
        }
    }

    #[test]
    fn a_node_is_alive_then_silent_then_gone_and_alive_again() {
        let begin = Instant::now();
        let at = |seconds: u64| begin + Duration::from_secs(seconds);
        let mut nodes = Nodes::default();
        let names = ["/auv/plant_sim".to_owned()];
        assert_eq!(nodes.discovered(&names, at(0)), names);
        nodes.heard(&diagnostics(100), at(0));
        nodes.heard(&diagnostics(120), at(1));
        assert_eq!(nodes.topic_rates()["/auv/state"], 20.0);
        assert_eq!(nodes.levels("/auv", at(1)), [1, 0]);
        assert_eq!(nodes.told(at(1))[0]["state"], "alive");
        assert_eq!(nodes.told(at(1))[0]["dropped"], 2);
        assert!(nodes.discovered(&names, at(4)).is_empty());
        assert_eq!(nodes.told(at(4))[0]["state"], "silent");
        assert_eq!(nodes.levels("/auv", at(4)), [0, 0]);
        nodes.discovered(&[], at(6));
        assert_eq!(nodes.told(at(9))[0]["state"], "gone");
        assert_eq!(nodes.told(at(9))[0]["for"], 3);
        assert_eq!(nodes.discovered(&names, at(10)), names);
        nodes.heard(&diagnostics(5), at(10));
        assert_eq!(nodes.told(at(10))[0]["state"], "alive");
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        let text = "ü".repeat(LONGEST_TEXT);
        assert_eq!(bounded(&text).len(), LONGEST_TEXT);
        assert_eq!(bounded("short"), "short");
    }
}
