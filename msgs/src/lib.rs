#![doc = include_str!("../README.md")]
//!
//! The build generates every module with a package's name from the definition files of this
//! folder: `msg/`, `srv/` and `action/` are the package `planesman_msgs`, which colcon builds from the same
//! files; `standard/` holds the standard packages as of ROS 2 Jazzy. `package/kind/Name` is found at
//! `planesman_msgs::package::kind::Name`.
//!
//! Each message is a plain struct with the ROS field names, and implements [`Message`]: its names on DDS,
//! its schema text, its type hash, and the check that all its numbers are finite. Each message also implements [`Field`]: access to its fields by
//! name. The Rust types ignore the bounds of sequences and strings (`T[<=1]`): code that fills such a field must observe its bound.

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
    /// The `ros2msg` schema text: the definition, and the definitions to which it refers.
    const DEFINITION: &'static str;
    /// The type hash, `RIHS01_` and 64 hexadecimal digits (REP-2011).
    const TYPE_HASH: &'static str;

    /// The path of the first field that is NaN or infinite, such as `dive_planes[3]`.
    fn first_non_finite(&self) -> Option<String>;
}

/// A ROS service.
pub trait Service: Send + 'static {
    /// The client's request.
    type Request: Message;
    /// The server's response.
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
    /// The progress of a goal.
    type Feedback: Message;
    /// The service `send_goal`, which accepts or rejects goals.
    type SendGoal: Service;
    /// The service `get_result`, which returns results.
    type GetResult: Service;
    /// The message with the feedback and the identity of its goal.
    type FeedbackMessage: Message;
    /// The ROS name, `planesman_msgs/action/Manoeuvre`.
    const TYPE_NAME: &'static str;
    /// The hash of the action as a whole.
    const TYPE_HASH: &'static str;
}

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
