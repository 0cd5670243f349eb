//! The vehicle simulated tick by tick, its sensors, and their messages.
//!
//! - `core`: messages in, messages out, one tick at a time: [`Plant`], [`Observation`], [`Instruments`], [`Pose`].
//! - [`PlantParameters`]: the declared parameters; `settings`: the same as the models' own types.
//! - [`Answers`]: what a tick is flown on, and when it is over.
//! - [`VehicleModel`]: the vehicle, of the plane or of six degrees, and its equations.
//! - `sensors`: [`gyro`], accelerometers, [`pressure_cell`], [`plane_signal`], their errors and their volts.
//! - `odometry`, `frames`, `messages`, `navigation_messages`: the state in ROS frames (REP 103, REP 105), and as messages. [`robot_description`]: the vehicle's URDF. [`Outline`]: the same as lines.
//!
//! The equations of motion are those of [`planesman_vehicle`].

mod answers;
mod core;
mod craft;
mod description;
mod error;
mod frames;
mod messages;
mod navigation_messages;
mod odometry;
mod outline;
mod parameters;
mod sensors;
mod settings;

pub use answers::{Answers, THE_ACTUATOR};
pub use core::{Observation, Plant, Pose, StaticMessages};
pub use craft::VehicleModel;
pub use description::robot_description;
pub use error::Error;
pub use messages::Instruments;
pub use navigation_messages::NavigationMessages;
pub use outline::Outline;
pub use parameters::{PlantParameters, TimeSource};
pub use sensors::{gyro, plane_signal, pressure_cell, specific_force};
pub use settings::derivatives;
