//! Source of the node's time: the machine, or `/clock`.

use crate::error::Result;
use std::{rc::Rc, sync::Arc};

use futures::FutureExt as _;
use planesman_msgs::rosgraph_msgs::msg::Clock;

use crate::{
    endpoint::Direction,
    qos::Qos,
    shared::{Shared, types_of},
    subscription::{self, Unread, non_finite},
};

/// Sets the time source to `/clock`, subscribing if necessary, or to the machine.
///
/// The middleware's own `/clock` subscription has another type and never receives anything.
pub(crate) fn set_source(shared: &Rc<Shared>, simulated: bool) -> Result<()> {
    shared.clock.set_simulated(simulated);
    if !simulated || shared.follows_clock.get() {
        return Ok(());
    }
    let topic = shared.topic_name("/clock")?;
    let types = types_of::<Clock>();
    let (endpoint, dds) = shared.endpoint(
        Direction::Subscription,
        &topic,
        types,
        Qos::sensor().of_one_publisher(),
    )?;
    let clock = Arc::clone(&shared.clock);
    let read = move |it: Unread, _: &_| {
        let message: Clock = it.message()?;
        if let Some(reason) = non_finite(&message) {
            return Err(reason);
        }
        let clock = Arc::clone(&clock);
        Ok(async move { clock.on_clock(&message.clock) }.boxed_local())
    };
    subscription::start(shared, endpoint, &dds, None, Box::new(read))?;
    shared.follows_clock.set(true);
    Ok(())
}
