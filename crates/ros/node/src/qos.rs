//! Quality of service of ROS conventions.

use std::time::Duration;

use planesman_msgs::loop_topics::{Delivery, LoopTopic};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};

/// Longest time that a reliable `publish` waits for space in the send window: short enough not to block the event loop noticeably, long enough
/// for acknowledgements in transit.
const LONGEST_WAIT: Duration = Duration::from_millis(5);

/// Quality of service offered by a publisher, or requested by a subscription.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    reliable: bool,
    latched: bool,
    depth: usize,
    /// Time of silence of the followed publisher after which another one is accepted; `None`: all are accepted.
    follows_one: Option<Duration>,
}

impl Qos {
    /// Sensor data: best effort, depth 5 (`rmw_qos_profile_sensor_data`).
    #[must_use]
    pub fn sensor() -> Self {
        Self {
            reliable: false,
            latched: false,
            depth: 5,
            follows_one: None,
        }
    }

    /// Commands and states that must arrive: reliable, history of `depth`.
    #[must_use]
    pub fn reliable(depth: usize) -> Self {
        Self {
            reliable: true,
            latched: false,
            depth,
            follows_one: None,
        }
    }

    /// Data that late joiners need: reliable, transient local, history of `depth`. For small and rare data: the middleware trims the history only
    /// every few seconds.
    #[must_use]
    pub fn latched(depth: usize) -> Self {
        Self {
            reliable: true,
            latched: true,
            depth,
            follows_one: None,
        }
    }

    /// QoS of the publishers of a topic of the loop.
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

    /// Requests queued at a server (`rmw_qos_profile_parameters`): enough that one client's requests do not soon displace another's.
    pub(crate) fn requests() -> Self {
        Self::reliable(1000)
    }

    /// A reader of everything from any publisher: best effort matches all, and 10 000 samples wait for a slow disk. (KEEP_ALL would keep 64 and lose
    /// the rest.)
    #[must_use]
    pub fn record() -> Self {
        Self {
            reliable: false,
            latched: false,
            depth: 10_000,
            follows_one: None,
        }
    }

    /// Like [`Qos::record`], for reliable publishers: no message is lost in transit either.
    #[must_use]
    pub fn record_reliable() -> Self {
        Self::reliable(10_000)
    }

    /// Like [`Qos::record_reliable`], including earlier messages of a transient-local publisher.
    #[must_use]
    pub fn record_latched() -> Self {
        Self::latched(10_000)
    }

    /// For a subscription: follows the first publisher, and refuses others until that one has been silent for 1 s. So the nodes of two loops that
    /// meet during a flight stay with their own loop.
    #[must_use]
    pub fn of_one_publisher(self) -> Self {
        self.of_one_publisher_until(Duration::ZERO)
    }

    /// Like [`Qos::of_one_publisher`]; a publisher refused before is accepted after this time of silence.
    #[must_use]
    pub fn of_one_publisher_until(self, silence: Duration) -> Self {
        Self {
            follows_one: Some(silence),
            ..self
        }
    }

    /// Time of silence of the followed publisher after which another one is accepted; `None` if all are accepted.
    pub(crate) fn follows_one(self) -> Option<Duration> {
        self.follows_one
    }

    /// Whether lost samples are retransmitted.
    pub(crate) fn is_reliable(self) -> bool {
        self.reliable
    }

    /// Whether late joiners receive earlier samples.
    pub(crate) fn is_latched(self) -> bool {
        self.latched
    }

    /// This QoS with these policies.
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

    /// QoS of the middleware for a writer that fails at once when there is no space.
    pub(crate) fn impatient_profile(self) -> QosProfile {
        QosProfile {
            reliability: Reliability::Reliable {
                when_full: WhenFull::Fail,
            },
            ..self.profile()
        }
    }

    /// QoS of the middleware.
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
