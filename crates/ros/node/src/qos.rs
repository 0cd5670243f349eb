//! Quality of service as ROS conventions have it.

use std::time::Duration;

use planesman_msgs::loop_topics::{Delivery, LoopTopic};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};

/// Longest that a reliable `publish` waits for room in the send window, s: short enough
/// that an event loop never seems frozen, long enough for acknowledgements on their way.
const LONGEST_WAIT: Duration = Duration::from_millis(5);

/// The quality of service that a publisher offers, or a subscription requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    reliable: bool,
    latched: bool,
    depth: usize,
    /// How long the publisher that is followed must be silent for another to be heard.
    follows_one: Option<Duration>,
}

impl Qos {
    /// Sensor data: best effort, the newest 5 kept (`rmw_qos_profile_sensor_data`).
    #[must_use]
    pub fn sensor() -> Self {
        Self {
            reliable: false,
            latched: false,
            depth: 5,
            follows_one: None,
        }
    }

    /// Commands and states that must arrive: reliable, `depth` kept.
    #[must_use]
    pub fn reliable(depth: usize) -> Self {
        Self {
            reliable: true,
            latched: false,
            depth,
            follows_one: None,
        }
    }

    /// Facts that late joiners need: reliable, transient local, `depth` kept. For small
    /// and rare data: the middleware trims the history only every few seconds.
    #[must_use]
    pub fn latched(depth: usize) -> Self {
        Self {
            reliable: true,
            latched: true,
            depth,
            follows_one: None,
        }
    }

    /// What the publishers of a topic of the loop offer.
    #[must_use]
    pub fn of(topic: &LoopTopic) -> Self {
        let depth = usize::try_from(topic.depth).unwrap_or(usize::MAX);
        match topic.delivery {
            Delivery::BestEffort => Self {
                depth,
                ..Self::sensor()
            },
            Delivery::Reliable => Self::reliable(depth),
            Delivery::Latched => Self::latched(depth),
        }
    }

    /// Requests that wait for their turn at a server (`rmw_qos_profile_parameters`): so many that one client's do not soon
    /// push another's out.
    pub(crate) fn requests() -> Self {
        Self::reliable(1000)
    }

    /// A reader that wants everything from anybody: best effort matches every publisher,
    /// and 10000 samples wait for a slow disk. (KEEP_ALL would hold 64 and lose the rest.)
    #[must_use]
    pub fn record() -> Self {
        Self {
            reliable: false,
            latched: false,
            depth: 10_000,
            follows_one: None,
        }
    }

    /// As [`Qos::record`], for publishers that offer reliable delivery: nothing is lost
    /// on the way either.
    #[must_use]
    pub fn record_reliable() -> Self {
        Self::reliable(10_000)
    }

    /// As [`Qos::record_reliable`], with what a latched publisher sent before we came.
    #[must_use]
    pub fn record_latched() -> Self {
        Self::latched(10_000)
    }

    /// Of a subscription: whoever publishes first is followed, and another is refused until that one has been silent for 1 s. Nodes
    /// of two loops that meet in flight so stay with their own.
    #[must_use]
    pub fn of_one_publisher(self) -> Self {
        self.of_one_publisher_until(Duration::ZERO)
    }

    /// As [`Qos::of_one_publisher`], and one that spoke beside it is heard once it has been silent for so long.
    #[must_use]
    pub fn of_one_publisher_until(self, silence: Duration) -> Self {
        Self {
            follows_one: Some(silence),
            ..self
        }
    }

    /// How long the publisher that is followed must be silent for another to be heard; `None` where all are.
    pub(crate) fn follows_one(self) -> Option<Duration> {
        self.follows_one
    }

    /// Whether lost samples are sent again.
    pub(crate) fn is_reliable(self) -> bool {
        self.reliable
    }

    /// Whether late joiners get earlier samples.
    pub(crate) fn is_latched(self) -> bool {
        self.latched
    }

    /// The same with these policies.
    pub(crate) fn with(self, reliable: bool, latched: bool, depth: usize) -> Self {
        Self {
            reliable,
            latched,
            depth,
            ..self
        }
    }

    /// The history depth.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// The same as the middleware's type, for a writer that fails at once when there is no room.
    pub(crate) fn impatient_profile(self) -> QosProfile {
        QosProfile {
            reliability: Reliability::Reliable {
                when_full: WhenFull::Fail,
            },
            ..self.profile()
        }
    }

    /// The same as the middleware's type.
    pub(crate) fn profile(self) -> QosProfile {
        QosProfile {
            reliability: if self.reliable {
                Reliability::Reliable {
                    when_full: WhenFull::Wait(LONGEST_WAIT),
                }
            } else {
                Reliability::BestEffort
            },
            durability: if self.latched {
                Durability::TransientLocal
            } else {
                Durability::Volatile
            },
            history: History::KeepLast { depth: self.depth },
            ..QosProfile::default()
        }
    }
}
