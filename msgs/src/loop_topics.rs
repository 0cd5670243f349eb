//! The loop's topics: message types and QoS.
//!
//! This is the table behind the picture in ARCHITECTURE.md. The nodes create their publishers and the recorder its subscriptions from this table;
//! a bag stores its QoS, so that `ros2 bag play` offers the same. Names are relative to the vehicle's namespace unless they begin
//! with a slash.

use crate::{
    Message, TypeInfo,
    builtin_interfaces::msg::Time,
    diagnostic_msgs::msg::DiagnosticArray,
    geometry_msgs::msg::{PoseWithCovarianceStamped, TwistWithCovarianceStamped},
    nav_msgs::msg::Odometry,
    planesman_msgs::msg::{
        ControlState, DaqSample, DhaState, ModelEstimate, MotionEstimate, PlaneCommand,
        PlaneMotion, ThrusterCommand, TickAnswer, VehicleState,
    },
    rcl_interfaces::msg::{Log, ParameterEvent},
    rosgraph_msgs::msg::Clock,
    sensor_msgs::msg::{FluidPressure, Imu, JointState, MagneticField, NavSatFix, Range},
    std_msgs::msg::{Float64, Float64MultiArray, String as Text},
    tf2_msgs::msg::TFMessage,
};

/// The QoS of a topic's publishers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// Best effort: each sample is sent once. For sensors, where the next sample is worth more than a lost one.
    BestEffort,
    /// Reliable: each sample is sent until it has arrived. For states and commands.
    Reliable,
    /// Reliable and transient local: late subscribers receive the last samples too. For facts that seldom change.
    Latched,
}

/// A topic of the loop.
#[derive(Clone, Copy, Debug)]
pub struct LoopTopic {
    /// The name, relative to the vehicle's namespace unless it begins with a slash.
    pub name: &'static str,
    /// The message type.
    pub info: TypeInfo,
    /// The QoS of its publishers.
    pub delivery: Delivery,
    /// The history depth of its publishers.
    pub depth: u64,
}

impl LoopTopic {
    const fn of<M: Message>(name: &'static str, delivery: Delivery, depth: u64) -> Self {
        Self {
            name,
            info: TypeInfo::of::<M>(),
            delivery,
            depth,
        }
    }

    /// The same topic with reliable publishers, for flights in which no sample may be lost, such as in lockstep.
    #[must_use]
    pub fn without_loss(self) -> Self {
        match self.delivery {
            Delivery::BestEffort => Self {
                delivery: Delivery::Reliable,
                depth: 100,
                ..self
            },
            Delivery::Reliable | Delivery::Latched => self,
        }
    }

    /// Whether only one node of the loop publishes this topic. A second publisher then belongs to another loop.
    #[must_use]
    pub fn is_of_one_node(&self) -> bool {
        let of_many = [
            "thruster_setpoints",
            "tick_answer",
            "/tf",
            "/tf_static",
            "/diagnostics",
            "/rosout",
            "/parameter_events",
        ];
        !of_many.contains(&self.name) && !self.name.ends_with("_setpoint")
    }
}

/// The topics of sensors of `plant_sim` that are published only if a parameter switches the sensor on.
pub const OPTIONAL_SENSORS: [&str; 6] = [
    "dvl",
    "dvl_water",
    "altitude",
    "magnetic_field",
    "gps",
    "usbl",
];

/// Every topic of the loop, in order of publisher.
pub const ALL: &[LoopTopic] = {
    use Delivery::{BestEffort, Latched, Reliable};
    &[
        // plant_sim
        LoopTopic::of::<Clock>("/clock", Reliable, 100),
        LoopTopic::of::<VehicleState>("state", Reliable, 100),
        LoopTopic::of::<Odometry>("odom", Reliable, 100),
        LoopTopic::of::<TFMessage>("/tf", Reliable, 100),
        LoopTopic::of::<TFMessage>("/tf_static", Latched, 1),
        LoopTopic::of::<Text>("robot_description", Latched, 1),
        LoopTopic::of::<Imu>("imu", BestEffort, 5),
        LoopTopic::of::<FluidPressure>("depth_pressure", BestEffort, 5),
        LoopTopic::of::<FluidPressure>("speed_pressure", BestEffort, 5),
        LoopTopic::of::<DaqSample>("daq", BestEffort, 5),
        LoopTopic::of::<TwistWithCovarianceStamped>("dvl", BestEffort, 5),
        LoopTopic::of::<TwistWithCovarianceStamped>("dvl_water", BestEffort, 5),
        LoopTopic::of::<Range>("altitude", BestEffort, 5),
        LoopTopic::of::<MagneticField>("magnetic_field", BestEffort, 5),
        LoopTopic::of::<NavSatFix>("gps", BestEffort, 5),
        LoopTopic::of::<PoseWithCovarianceStamped>("usbl", BestEffort, 5),
        // the operator
        LoopTopic::of::<Float64>("depth_setpoint", Reliable, 10),
        LoopTopic::of::<Float64>("pitch_setpoint", Reliable, 10),
        LoopTopic::of::<Float64>("heading_setpoint", Reliable, 10),
        LoopTopic::of::<Float64>("speed_setpoint", Reliable, 10),
        LoopTopic::of::<Float64MultiArray>("thruster_setpoints", Reliable, 10),
        // depth_controller
        LoopTopic::of::<PlaneCommand>("plane_command", Reliable, 100),
        LoopTopic::of::<ThrusterCommand>("thruster_command", Reliable, 100),
        LoopTopic::of::<ControlState>("control_state", Reliable, 100),
        LoopTopic::of::<MotionEstimate>("estimate", Reliable, 100),
        // dha_actuator
        LoopTopic::of::<PlaneMotion>("plane_motion", Reliable, 100),
        LoopTopic::of::<JointState>("planes", Reliable, 100),
        LoopTopic::of::<DhaState>("dha_state", Reliable, 100),
        LoopTopic::of::<DhaState>("dha_state_stern", Reliable, 100),
        LoopTopic::of::<DhaState>("dha_state_roll", Reliable, 100),
        LoopTopic::of::<DhaState>("dha_state_rudder", Reliable, 100),
        // sysid
        LoopTopic::of::<ModelEstimate>("model", Reliable, 100),
        // all
        LoopTopic::of::<TickAnswer>("tick_answer", Reliable, 100),
        LoopTopic::of::<DiagnosticArray>("/diagnostics", Reliable, 10),
        LoopTopic::of::<ParameterEvent>("/parameter_events", Reliable, 100),
        LoopTopic::of::<Log>("/rosout", Latched, 1000),
    ]
};

/// The topic with this name, as written in [`ALL`].
#[must_use]
pub fn named(name: &str) -> Option<&'static LoopTopic> {
    ALL.iter().find(|topic| topic.name == name)
}

/// A receiver of messages with their topics, such as a bag.
pub trait Sink {
    /// The error of a message that cannot be stored.
    type Error;

    /// Stores one message of `topic`; the name is written as in [`ALL`].
    ///
    /// # Errors
    /// The message cannot be stored.
    fn put<M: Message>(
        &mut self,
        topic: &str,
        stamp: &Time,
        message: &M,
    ) -> Result<(), Self::Error>;
}

/// The error for an unknown topic name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown topic '{name}'; topics of the loop: {}", ALL.iter().map(|topic| topic.name).collect::<Vec<_>>().join(", "))]
pub struct UnknownTopic {
    /// The unknown name.
    pub name: String,
}

/// The topics with these names, in the order of [`ALL`]; all topics if `names` is empty.
///
/// # Errors
/// The first unknown name.
pub fn selected(names: &[String]) -> Result<Vec<LoopTopic>, UnknownTopic> {
    if let Some(unknown) = names.iter().find(|name| named(name).is_none()) {
        return Err(UnknownTopic {
            name: unknown.clone(),
        });
    }
    Ok(ALL
        .iter()
        .filter(|topic| names.is_empty() || names.iter().any(|name| name == topic.name))
        .copied()
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(topics: &[LoopTopic]) -> Vec<&str> {
        topics.iter().map(|topic| topic.name).collect()
    }

    #[test]
    fn no_topic_stands_twice_in_the_table() {
        let mut seen = names(ALL);
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), ALL.len());
    }

    #[test]
    fn all_topics_are_selected_by_naming_none() {
        let selected = selected(&[]).expect("all");
        assert_eq!(names(&selected), names(ALL));
    }

    #[test]
    fn without_loss_every_topic_is_reliable() {
        for topic in ALL {
            let kept = topic.without_loss();
            assert_ne!(kept.delivery, Delivery::BestEffort, "{}", topic.name);
            if topic.delivery != Delivery::BestEffort {
                let qos = |it: &LoopTopic| (it.delivery, it.depth);
                assert_eq!(qos(&kept), qos(topic), "{}", topic.name);
            }
        }
    }

    #[test]
    fn a_selection_keeps_the_tables_order_and_takes_each_once() {
        let wanted = ["plane_motion", "state", "state"].map(str::to_owned);
        let selected = selected(&wanted).expect("known");
        assert_eq!(names(&selected), ["state", "plane_motion"]);
    }

    #[test]
    fn an_unknown_topic_is_refused_with_the_known_ones() {
        let refusal = selected(&["stat".to_owned()])
            .expect_err("there is none")
            .to_string();
        assert!(refusal.contains("'stat'"), "{refusal}");
        assert!(refusal.contains("plane_motion"), "{refusal}");
    }
}
