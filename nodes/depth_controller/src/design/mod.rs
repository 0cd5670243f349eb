//! The loops designed on paper, as in Brunner (NPS thesis, 1988, ch. II): linear, without limits.
//!
//! - [`axis`]: one axis of the vehicle as a damped inertia, under proportional and rate feedback.
//! - [`pitch`]: that axis in pitch, the inner loop of the dive.
//! - [`depth`]: the outer loop: stability, critical speed, closed loop.
//! - [`roll`]: that axis in roll.
//! - [`course`]: that axis in yaw.
//! - [`step`]: the response to a step.
//! - [`dive_loop`]: the whole dive: any vehicle, an actuator with dead time; margins.
//! - [`placement`]: gains for poles.
//! - [`optimise`]: gains for a range of speeds.
//!
//! Angles of the report's loops are dive-positive here, as in program T6. Every equation is homogeneous, so any consistent
//! units will do; the constants are the report's, in feet, pounds-force and seconds.

pub mod axis;
pub mod course;
pub mod depth;
pub mod dive_loop;
pub mod optimise;
pub mod pitch;
pub mod placement;
pub mod roll;
pub mod step;
