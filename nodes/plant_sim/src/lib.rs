//! The node `plant_sim`: the vehicle simulated tick by tick, its sensors, and their messages.
//!
//! - `node`: DDS to core and back; [`main`]. `lockstep`, `answers`: when a tick may be flown.
//! - `core`: messages in, messages out, one tick at a time: [`Plant`], [`Observation`], [`Instruments`].
//! - [`PlantParameters`]: the declared parameters; `settings`: the same as the models' own types.
//! - `sensors`: [`gyro`], accelerometers, [`pressure_cell`], [`plane_signal`], their errors and their volts.
//! - `odometry`, `messages`: the state in ROS frames (REP 103, REP 105), and as messages. [`robot_description`]: the vehicle's URDF.
//!
//! The equations of motion are those of [`planesman_vehicle`].

mod answers;
mod core;
mod description;
mod error;
mod lockstep;
mod messages;
mod node;
mod odometry;
mod parameters;
mod sensors;
mod settings;

pub use core::{Facts, Instruments, Observation, Plant, vehicle};
pub use description::of as robot_description;
pub use error::Error;
pub use node::main;
pub use parameters::PlantParameters;
pub use sensors::{gyro, plane_signal, pressure_cell, specific_force};
pub use settings::derivatives;
