//! The loop's topics: message types and QoS.
//!
//! This is the table of ARCHITECTURE.md's picture. The nodes open their publishers by it, the recorder subscribes by it, and
//! a bag has its QoS, so that `ros2 bag play` offers the same. Names are relative to the vehicle's namespace unless they begin
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

/// How a topic's publishers deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// Each sample once: sensors, whose next sample is worth more than a lost one.
    BestEffort,
    /// Until it has arrived: states and commands.
    Reliable,
    /// Until it has arrived, and to late joiners too: facts.
    Latched,
}

/// A topic of the loop.
#[derive(Clone, Copy, Debug)]
pub struct LoopTopic {
    /// Its name, relative to the vehicle's namespace unless it begins with a slash.
    pub name: &'static str,
    /// Its type.
    pub info: TypeInfo,
    /// How it is delivered.
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

    /// The topic where nothing may be lost, as in lockstep: everything is delivered until it has arrived.
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

    /// Whether one node of the loop alone publishes it. What comes of a second one is of another loop.
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

/// The sensors of `plant_sim` that are off unless their parameters ask for them: only then are their topics published.
pub const OPTIONAL_SENSORS: [&str; 6] = [
    "dvl",
    "dvl_water",
    "altitude",
    "magnetic_field",
    "gps",
    "usbl",
];

/// Every topic of the loop, publisher by publisher.
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

/// The topic of that name, relative as it stands in [`ALL`].
#[must_use]
pub fn named(name: &str) -> Option<&'static LoopTopic> {
    ALL.iter().find(|topic| topic.name == name)
}

/// Something that takes messages by topic.
pub trait Sink {
    /// Why it does not.
    type Error;

    /// Takes one message of `topic`, of the name that it has in [`ALL`].
    ///
    /// # Errors
    /// When it cannot be kept.
    fn put<M: Message>(
        &mut self,
        topic: &str,
        stamp: &Time,
        message: &M,
    ) -> Result<(), Self::Error>;
}

/// A name that no topic of the loop has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("topic '{name}' is not of the loop; its topics are {}", ALL.iter().map(|topic| topic.name).collect::<Vec<_>>().join(", "))]
pub struct UnknownTopic {
    /// The name given.
    pub name: String,
}

/// The topics of these names, in the order of [`ALL`]; all of them if no name is given.
///
/// # Errors
/// The first name that no topic has.
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
