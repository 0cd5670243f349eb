#![doc = include_str!("../README.md")]
//!
//! Control of depth, pitch, roll, heading and speed, after Brunner (*Experimental Verification of AUV Performance*,
//! NPS thesis, March 1988, ch. II and program T6).
//!
//! - [`Controller`]: takes a vehicle state, returns a plane command (`core`), with its [`ControllerParameters`].
//! - `loops`: all loops at a tick; `answer`: their terms as messages. [`DepthLoop`], [`PitchLoop`], `autopilot`: the dive loops, with
//!   integrals, filters and bumpless transfer.
//! - `angle_loop`, `speed_loop`: roll, heading, speed. `allocation`: one angle for bow and stern planes.
//! - `hover`: place, depth and heading by thrusters. `guidance`: way-points by line of sight, turning circle and zig-zag.
//! - `setpoint`, `schedule`, `manoeuvre`, `runs`, `goal`: setpoints and test signals.
//! - [`Source`], `estimator`: pitch, depth rate and gyro bias from the instruments.
//! - [`gains`]: fixed, scheduled over speed, or adapted to an identified model.
//! - [`Fault`], `safety`: the envelope and the reaction to leaving it.
//! - [`design`]: margins, pole placement and optimisation of the dive loops.

mod allocation;
mod angle_loop;
mod answer;
mod autopilot;
mod core;
mod depth_loop;
pub mod design;
mod error;
mod estimator;
mod fault;
mod feedback;
pub mod gains;
mod goal;
mod guidance;
mod hover;
mod integral;
mod lag;
mod limits;
mod loops;
mod manoeuvre;
pub mod parameters;
mod pitch_loop;
mod runs;
mod safety;
mod schedule;
mod setpoint;
mod speed_loop;

pub use crate::core::Controller;
pub use answer::Answer;
pub use autopilot::Mode;
pub use depth_loop::DepthLoop;
pub use error::{Error, ManoeuvreError, ParameterError, ScheduleError};
pub use estimator::Source;
pub use fault::Fault;
pub use guidance::Turning;
pub use integral::{AntiWindup, Integral, Strategy};
pub use limits::{Limit, LimitError};
pub use parameters::ControllerParameters;
pub use pitch_loop::PitchLoop;
pub use setpoint::Quantity;
