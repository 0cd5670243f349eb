//! Classical depth and pitch control: depth PD to a pitch command, pitch P with rate
//! feedback to the dive planes (Brunner, *Experimental Verification of AUV Performance*,
//! NPS thesis, March 1988, ch. II and program T6).
//!
//! - [`depth_loop`]: depth error to pitch command.
//! - [`pitch_loop`]: pitch error and rate to plane angle.
//! - [`limits`]: ±45° of pitch command, ±30° of plane.
//! - [`estimator`]: pitch, depth rate and the gyro's zero from what can be measured.
//! - [`gains`]: gains that follow the vehicle: by its speed, by its identified model.
//! - [`manoeuvre`]: test signals added to the plane command.
//! - [`schedule`]: depth setpoints over time.
//! - [`parameters`]: every tunable, its default, unit and source.
//! - [`core`]: a vehicle state in, a plane command out.
//! - [`design`]: the loops on paper: gains, stability, step responses.
//! - [`t6`]: the report's program of the depth controller.
//! - [`book`]: the report's numbers on the controllers, computed again.

pub mod book;
pub mod core;
pub mod depth_loop;
pub mod design;
pub mod estimator;
pub mod gains;
pub mod limits;
pub mod manoeuvre;
pub mod node;
pub mod parameters;
pub mod pitch_loop;
pub mod schedule;
pub mod t6;
