//! QoS offered by a topic's publishers, as stored by rosbag2.
//!
//! Since metadata version 9 (Jazzy) the policies are stored as words, in two places: as YAML text in the channel's `offered_qos_profiles`, and
//! as a YAML list in `metadata.yaml`. `ros2 bag play` publishes with these policies.

use serde::{Deserialize, Serialize};

/// A duration in the form of `rmw_time_t`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// Whole seconds.
    pub sec: u64,
    /// Nanoseconds in addition to the seconds.
    pub nsec: u64,
}

impl Span {
    /// `RMW_DURATION_INFINITE`: no deadline, no expiry.
    pub const INFINITE: Self = Self {
        sec: 9_223_372_036,
        nsec: 854_775_807,
    };
}

/// The number of samples that a publisher keeps for late or slow readers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum History {
    /// The middleware's default.
    SystemDefault,
    /// The newest `depth` samples.
    KeepLast,
    /// Keeps every sample, as far as resources allow.
    KeepAll,
    /// Not announced.
    Unknown,
}

/// Whether lost samples are retransmitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reliability {
    /// The middleware's default.
    SystemDefault,
    /// Retransmitted until acknowledged.
    Reliable,
    /// Sent once.
    BestEffort,
    /// Not announced.
    Unknown,
    /// The policy that matches most endpoints.
    BestAvailable,
}

/// Whether a late-joining reader receives earlier samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Durability {
    /// The middleware's default.
    SystemDefault,
    /// Late-joining readers receive the history.
    TransientLocal,
    /// Late-joining readers receive only later samples.
    Volatile,
    /// Not announced.
    Unknown,
    /// The policy that matches most endpoints.
    BestAvailable,
}

/// The way in which a publisher asserts its liveliness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Liveliness {
    /// The middleware's default.
    SystemDefault,
    /// The publisher's process asserts liveliness.
    Automatic,
    /// The publisher asserts liveliness for each topic.
    ManualByTopic,
    /// Not announced.
    Unknown,
    /// The policy that matches most endpoints.
    BestAvailable,
}

/// QoS of one publisher. The fields are in the order of rosbag2.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OfferedQos {
    /// History policy.
    pub history: History,
    /// History depth, for [`History::KeepLast`].
    pub depth: u64,
    /// Reliability policy.
    pub reliability: Reliability,
    /// Durability policy.
    pub durability: Durability,
    /// Promised longest time between samples.
    pub deadline: Span,
    /// Age at which a sample expires.
    pub lifespan: Span,
    /// Liveliness policy.
    pub liveliness: Liveliness,
    /// Longest time between two assertions of liveliness.
    pub liveliness_lease_duration: Span,
    /// Whether the DDS topic name lacks the prefix `rt/`.
    pub avoid_ros_namespace_conventions: bool,
}

impl OfferedQos {
    /// ROS 2's default QoS: reliable, volatile, the last `depth` samples.
    #[must_use]
    pub fn reliable(depth: u64) -> Self {
        Self {
            history: History::KeepLast,
            depth,
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
            deadline: Span::INFINITE,
            lifespan: Span::INFINITE,
            liveliness: Liveliness::Automatic,
            liveliness_lease_duration: Span::INFINITE,
            avoid_ros_namespace_conventions: false,
        }
    }

    /// QoS of sensor data: best effort.
    #[must_use]
    pub fn best_effort(depth: u64) -> Self {
        Self {
            reliability: Reliability::BestEffort,
            ..Self::reliable(depth)
        }
    }

    /// The QoS with transient-local durability.
    #[must_use]
    pub fn transient_local(self) -> Self {
        Self {
            durability: Durability::TransientLocal,
            ..self
        }
    }
}

/// Text for a channel's `offered_qos_profiles`.
pub(crate) fn to_text(offers: &[OfferedQos]) -> Result<String, serde_yaml_ng::Error> {
    Ok(serde_yaml_ng::to_string(offers)?.trim_end().to_owned())
}

/// Largest text that is parsed, bytes: QoS of seven hundred publishers. Parsing YAML takes up to a hundred times its size in memory.
const LONGEST: usize = 256 << 10;

/// Parses a channel's `offered_qos_profiles`; returns an empty list for an older format (numbers instead of words) or a text that is too large.
pub(crate) fn from_text(text: &str) -> Vec<OfferedQos> {
    if text.len() > LONGEST {
        return Vec::new();
    }
    planesman_text::yaml::from_str(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offer_is_written_as_jazzy_writes_it() {
        let text = to_text(&[OfferedQos::best_effort(5).transient_local()]).expect("plain data");
        assert_eq!(
            text,
            "- history: keep_last\n  depth: 5\n  reliability: best_effort\n  \
             durability: transient_local\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  \
             lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: automatic\n  \
             liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
             avoid_ros_namespace_conventions: false"
        );
        assert_eq!(
            from_text(&text),
            [OfferedQos::best_effort(5).transient_local()]
        );
    }

    #[test]
    fn an_offer_in_numbers_or_nonsense_is_no_offer() {
        assert_eq!(from_text("- history: 1\n  depth: 10"), []);
        assert_eq!(from_text(": : :"), []);
        assert_eq!(from_text(""), []);
    }
}
