//! Where the node's clock gets its time: the machine, or `/clock`.

use crate::error::Result;
use std::rc::Rc;

use planesman_msgs::rosgraph_msgs::msg::Clock;

use crate::{
    endpoint::Direction,
    qos::Qos,
    shared::{Shared, types_of},
    subscription::{non_finite, pump},
};

/// Takes the node's time from `/clock`, subscribed to now if need be, or from the machine.
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
    let reader = shared.with_node(|node| node.create_subscription::<Clock>(&dds, None))?;
    shared.follows_clock.set(true);
    let state = Rc::clone(shared);
    shared.spawn(async move {
        let ours = Rc::clone(&state);
        let tick = async move |message: Clock, _: &_| ours.clock.on_clock(&message.clock);
        let reason_against = |message: &Clock, _: &_| non_finite(message);
        pump(state, endpoint, reader.async_stream(), reason_against, tick).await;
    });
    Ok(())
}
