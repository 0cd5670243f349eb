#![doc = include_str!("../README.md")]
//!
//! Everything below a package's name is generated at build time from the definition files of this
//! folder: `msg/`, `srv/` and `action/` are the package `planesman_msgs`, which colcon builds from the same
//! files; `standard/` holds the standard packages as of ROS 2 Jazzy. `package/kind/Name` is found at
//! `planesman_msgs::package::kind::Name`.
//!
//! Each message is a plain struct with the ROS field names, and implements [`Message`]: its names on DDS,
//! its schema text, its type hash, and the check that all its numbers are finite; and [`Field`]: its fields by their names. Bounds of sequences and
//! strings (`T[<=1]`) are not kept in the Rust types: whoever fills such a field minds its bound.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub mod cdr;
pub mod description;
mod field;
mod finite;
pub mod loop_topics;
mod registry;
mod time;

pub use field::Field;
pub use registry::{JsonError, TypeInfo, registry, type_info};

/// A ROS message.
pub trait Message:
    Serialize + DeserializeOwned + Clone + Default + PartialEq + Debug + Send + 'static
{
    /// The ROS name, `planesman_msgs/msg/VehicleState`.
    const TYPE_NAME: &'static str;
    /// The name DDS endpoints announce, `planesman_msgs::msg::dds_::VehicleState_`.
    const DDS_TYPE_NAME: &'static str;
    /// The `ros2msg` schema text: the definition and those it refers to.
    const DEFINITION: &'static str;
    /// The type hash, `RIHS01_` and 64 hexadecimal digits (REP-2011).
    const TYPE_HASH: &'static str;

    /// The path of the first field that is NaN or infinite, such as `dive_planes[3]`.
    fn first_non_finite(&self) -> Option<String>;
}

/// A ROS service.
pub trait Service: Send + 'static {
    /// The request of the client.
    type Request: Message;
    /// The response of the server.
    type Response: Message;
    /// The ROS name, `std_srvs/srv/SetBool`.
    const TYPE_NAME: &'static str;
    /// The hash of the service as a whole.
    const TYPE_HASH: &'static str;
    /// The name the request topic's endpoints announce.
    const REQUEST_DDS_TYPE_NAME: &'static str = Self::Request::DDS_TYPE_NAME;
    /// The name the response topic's endpoints announce.
    const RESPONSE_DDS_TYPE_NAME: &'static str = Self::Response::DDS_TYPE_NAME;
}

/// A ROS action.
pub trait Action: Send + 'static {
    /// The request.
    type Goal: Message;
    /// The result.
    type Result: Message;
    /// How it goes.
    type Feedback: Message;
    /// The service that takes goals.
    type SendGoal: Service;
    /// The service that gives results.
    type GetResult: Service;
    /// The message that carries feedback and names its goal.
    type FeedbackMessage: Message;
    /// The ROS name, `planesman_msgs/action/Manoeuvre`.
    const TYPE_NAME: &'static str;
    /// The hash of the action as a whole.
    const TYPE_HASH: &'static str;
}

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
