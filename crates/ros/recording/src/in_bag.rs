//! Topics of the loop as stored in a bag.

use planesman_bag::{OfferedQos, Topic};
use planesman_msgs::loop_topics::{Delivery, LoopTopic};

/// The topic as stored in a bag, with its full name (`/auv/state`) and the publishers' QoS.
#[must_use]
pub fn in_bag(topic: &LoopTopic, full_name: &str) -> Topic {
    let offered = match topic.delivery {
        Delivery::BestEffort => OfferedQos::best_effort(topic.depth),
        Delivery::Reliable => OfferedQos::reliable(topic.depth),
        Delivery::Latched => OfferedQos::reliable(topic.depth).transient_local(),
    };
    Topic::of_type(&topic.info, full_name, offered)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::loop_topics::named;

    #[test]
    fn the_bag_tells_what_was_offered() {
        let topic = in_bag(named("state").expect("known"), "/auv/state");
        assert_eq!(topic.name, "/auv/state");
        assert_eq!(topic.kind.type_name, "planesman_msgs/msg/VehicleState");
        assert_eq!(topic.kind.offered_qos, [OfferedQos::reliable(100)]);
    }
}
