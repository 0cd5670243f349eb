//! The study's bench: the actuator in a simulated flight control (IBM 66-L03-005, Sections II to IV).
//!
//! - [`missile`]: the yaw plant, a surrogate of the lost one.
//! - [`autopilot`]: the digital autopilot.
//! - [`digital_loop`]: autopilot, pulse logic, hydraulics and missile.

pub mod autopilot;
pub mod digital_loop;
pub mod missile;
