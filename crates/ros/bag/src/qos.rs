//! The QoS that a topic's publishers offered, as rosbag2 keeps it.
//!
//! Since metadata version 9 (Jazzy) the policies are words, and a bag holds the list twice: as
//! YAML text in the channel's `offered_qos_profiles`, and as a YAML list in `metadata.yaml`.
//! `ros2 bag play` publishes with what it finds there.

use serde::{Deserialize, Serialize};

/// A span of time as `rmw_time_t` counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// Whole seconds.
    pub sec: u64,
    /// Nanoseconds beyond the seconds.
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
    /// Every sample, as far as resources go.
    KeepAll,
    /// Not announced.
    Unknown,
}

/// Whether lost samples are sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reliability {
    /// The middleware's default.
    SystemDefault,
    /// Sent again until acknowledged.
    Reliable,
    /// Sent once.
    BestEffort,
    /// Not announced.
    Unknown,
    /// Whatever matches most endpoints.
    BestAvailable,
}

/// Whether a reader that joins late gets the samples of before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Durability {
    /// The middleware's default.
    SystemDefault,
    /// Late readers get the history.
    TransientLocal,
    /// Late readers get what comes after.
    Volatile,
    /// Not announced.
    Unknown,
    /// Whatever matches most endpoints.
    BestAvailable,
}

/// How a publisher shows that it lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Liveliness {
    /// The middleware's default.
    SystemDefault,
    /// By its process.
    Automatic,
    /// By each topic.
    ManualByTopic,
    /// Not announced.
    Unknown,
    /// Whatever matches most endpoints.
    BestAvailable,
}

/// One publisher's offer. The fields stand in the order rosbag2 writes them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OfferedQos {
    /// How samples are kept.
    pub history: History,
    /// How many are kept, for [`History::KeepLast`].
    pub depth: u64,
    /// Whether losses are repaired.
    pub reliability: Reliability,
    /// Whether late readers get the history.
    pub durability: Durability,
    /// The longest time between samples that was promised.
    pub deadline: Span,
    /// The age at which a sample expires.
    pub lifespan: Span,
    /// How the publisher shows that it lives.
    pub liveliness: Liveliness,
    /// How often it must show it.
    pub liveliness_lease_duration: Span,
    /// Whether the topic has no `rt/` before its DDS name.
    pub avoid_ros_namespace_conventions: bool,
}

impl OfferedQos {
    /// ROS 2's default offer: reliable, volatile, the last `depth` samples.
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

    /// The sensor-data offer: each sample sent once.
    #[must_use]
    pub fn best_effort(depth: u64) -> Self {
        Self {
            reliability: Reliability::BestEffort,
            ..Self::reliable(depth)
        }
    }

    /// The same offer, with the history for readers that join late.
    #[must_use]
    pub fn transient_local(self) -> Self {
        Self {
            durability: Durability::TransientLocal,
            ..self
        }
    }
}

/// The text of a channel's `offered_qos_profiles`.
pub(crate) fn to_text(offers: &[OfferedQos]) -> Result<String, serde_yaml_ng::Error> {
    Ok(serde_yaml_ng::to_string(offers)?.trim_end().to_owned())
}

/// The longest text of offers taken, bytes: seven hundred publishers' worth. YAML takes up to a hundred times its
/// text while it is read.
const LONGEST: usize = 256 << 10;

/// The offers in a channel's `offered_qos_profiles`; none when the text is of an older form
/// (numbers for words) or beyond all measure, which says nothing that a reader of payloads needs.
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
