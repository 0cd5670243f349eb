//! The node's time: the machine's, or `/clock` when `use_sim_time` is set.

use std::{
    cell::Cell,
    time::{SystemTime, UNIX_EPOCH},
};

use planesman_msgs::builtin_interfaces::msg::Time;

/// Where the node's time comes from.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    pub(crate) simulated: Cell<bool>,
    /// Whether `/clock` is subscribed to; it stays so once it is.
    pub(crate) followed: Cell<bool>,
    /// The newest `/clock`, ns; 0 until one has come.
    pub(crate) latest: Cell<i64>,
}

impl Clock {
    /// The node's time. Simulated time is 0 until the first `/clock`, as in `rclcpp`.
    pub(crate) fn now(&self) -> Time {
        if self.simulated.get() {
            Time::from_nanos(self.latest.get())
        } else {
            wall()
        }
    }
}

/// The machine's time since 1970.
pub(crate) fn wall() -> Time {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    Time::from_nanos(i64::try_from(now.as_nanos()).unwrap_or(i64::MAX))
}
