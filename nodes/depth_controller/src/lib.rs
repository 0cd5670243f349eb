//! Classical control of depth, pitch, roll, course and speed: depth PD to a pitch command, pitch P with
//! rate feedback to the dive planes, and the report's three regulators beside them (Brunner, *Experimental
//! Verification of AUV Performance*, NPS thesis, March 1988, ch. II and program T6).
//!
//! - [`depth_loop`]: depth error to pitch command.
//! - [`pitch_loop`]: pitch error and rate to plane angle.
//! - [`angle_loop`]: roll error to bow-plane differential, course error to rudder.
//! - [`speed_loop`]: speed to thrust.
//! - [`limits`]: ±45° of pitch command, ±30° of plane; rate limits.
//! - [`integral`], [`lag`]: what the report's loops do without: integral shares, a filter, fading.
//! - [`autopilot`]: both dive loops as built, switched between modes without a bump.
//! - [`allocation`]: one angle to bow and stern planes.
//! - [`feedback`]: what the loops are told of the vehicle.
//! - [`setpoint`]: whose word counts, limited and rate-limited.
//! - [`estimator`]: pitch, depth rate and the gyro's zero from what can be measured.
//! - [`gains`]: gains that follow the vehicle: by its speed, by its identified model.
//! - [`manoeuvre`], [`runs`]: test signals added to the plane command; the report's runs.
//! - [`goal`]: a manoeuvre that an action client has asked for.
//! - [`safety`]: the envelope, the fault that stays, the reaction.
//! - [`schedule`]: way-depths over time or distance.
//! - [`parameters`]: every tunable, its default, unit and source.
//! - [`core`]: a vehicle state in, a plane command out.
//! - [`design`]: the loops on paper: gains, stability, step responses.

pub mod allocation;
pub mod angle_loop;
pub mod autopilot;
pub mod core;
pub mod depth_loop;
pub mod design;
pub mod estimator;
pub mod feedback;
pub mod gains;
pub mod goal;
pub mod integral;
pub mod lag;
pub mod limits;
pub mod manoeuvre;
pub mod node;
pub mod parameters;
pub mod pitch_loop;
pub mod runs;
pub mod safety;
pub mod schedule;
pub mod setpoint;
pub mod speed_loop;
pub mod waiting;

pub use crate::core::{Controller, Quantity};
pub use depth_loop::DepthLoop;
pub use limits::{Limit, LimitError};
pub use parameters::declarations;
pub use pitch_loop::PitchLoop;
