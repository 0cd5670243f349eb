//! The node's time: the machine's, or `/clock` when `use_sim_time` is set.

use std::{
    cell::Cell,
    rc::Rc,
    time::{SystemTime, UNIX_EPOCH},
};

use planesman_msgs::{builtin_interfaces::msg::Time, rosgraph_msgs::msg::Clock as ClockMessage};

use crate::{
    endpoint::Direction,
    qos::Qos,
    shared::{Shared, types_of},
    subscription::{non_finite, pump},
};

/// Where the node's time comes from.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    simulated: Cell<bool>,
    /// Whether `/clock` is subscribed to; it stays so once it is.
    followed: Cell<bool>,
    /// The newest `/clock`, ns; 0 until one has come.
    latest: Cell<i64>,
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

/// Takes the node's time from `/clock`, subscribed to now if need be, or from the machine.
///
/// The middleware's own `/clock` subscription has another type and never receives anything.
pub(crate) fn set_source(shared: &Rc<Shared>, simulated: bool) -> anyhow::Result<()> {
    shared.clock.simulated.set(simulated);
    if !simulated || shared.clock.followed.get() {
        return Ok(());
    }
    let topic = shared.topic_name("/clock")?;
    let types = types_of::<ClockMessage>();
    let (endpoint, dds) = shared.endpoint(Direction::Subscription, &topic, types, Qos::sensor())?;
    let reader = shared.with_node(|node| node.create_subscription::<ClockMessage>(&dds, None))?;
    shared.clock.followed.set(true);
    let state = Rc::clone(shared);
    shared.spawn(async move {
        let ours = Rc::clone(&state);
        let tick = async move |message: ClockMessage, _: &_| {
            ours.clock.latest.set(message.clock.nanos());
        };
        pump(state, endpoint, reader.async_stream(), non_finite, tick).await;
    });
    Ok(())
}

/// The machine's time since 1970.
pub(crate) fn wall() -> Time {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    Time::from_nanos(i64::try_from(now.as_nanos()).unwrap_or(i64::MAX))
}
