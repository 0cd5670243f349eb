//! The vehicle simulated tick by tick, its sensors, and their messages.
//!
//! - `core`: messages in, messages out, tick by tick: [`Plant`], [`Observation`], [`Instruments`], [`Pose`].
//! - [`PlantParameters`]: the declared parameters; `settings`: the same in the models' types.
//! - [`Answers`]: the answers that a tick waits for or uses.
//! - [`VehicleModel`]: the vehicle, of the vertical plane or with six degrees of freedom, and its equations.
//! - `sensors`: [`gyro`], accelerometers, [`pressure_cell`], [`plane_signal`], with their errors and voltages.
//! - `odometry`, `frames`, `messages`, `navigation_messages`: the state in ROS frames (REP 103, REP 105) and as messages.
//!   [`robot_description`]: URDF of the vehicle. [`Outline`]: the vehicle as lines.
//!
//! [`planesman_vehicle`] has the equations of motion.

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
