//! The vehicle, its sensors, and their messages.
//!
//! From the equations outwards:
//!
//! - [`vehicle`]: what a vehicle is; its dimensional derivatives at a speed.
//! - [`vehicle_file`]: vehicles from YAML, and the one built in.
//! - [`identified`]: a vehicle out of an identified model.
//! - [`dynamics`]: the equations of motion.
//! - [`axis`]: roll and course, plants of one axis each.
//! - [`propulsion`]: thrust, drag and power.
//! - [`attitude`]: how the body lies in the fixed frame.
//! - [`planes`]: the plane angle over a tick.
//! - [`body`]: the whole body and what its motion depends on.
//! - [`tick`]: a tick of that motion, step by step.
//! - [`motion`]: a tick of the vertical plane's alone.
//! - [`environment`]: water and gravity.
//! - [`tank`]: surface and bottom, and contact with them.
//! - [`seaway`]: waves, a seeded coloured force.
//! - [`tether`]: a line in tow.
//! - [`variant`]: the vehicle with a part of its equations changed or left out.
//! - [`coefficients`]: from geometry to coefficients, by the report's methods.
//! - [`level_flight`]: the pitch and planes at which a vehicle keeps its depth by itself.
//! - [`linearised`]: the same vehicle about level flight; what identification should find.
//! - [`programs`]: the thesis' simulation programs T2 to T5, as printed.
//! - [`predicted`]: the thesis' predicted transfer functions, as printed and put right.
//! - [`track`]: a recorded manoeuvre, and what is read off it.
//! - [`sensors`]: rate gyros, accelerometers, pressure cells, their errors and their volts.
//! - [`plane_forces`]: the report's estimate of how large the planes had to be.
//! - [`book`]: the report's numbers, recomputed.
//! - [`odometry`]: the state in ROS frames (REP 103, REP 105).
//! - [`parameters`]: the node's declared parameters.
//! - `settings`: the parameters in the models' own types.
//! - `messages`: what the models give, in messages.
//! - [`answers`], [`lockstep`]: the actuator's answers where no tick waits for them, and where it does.
//! - [`core`]: messages in, messages out, one tick at a time.
//!
//! Depth is positive down, pitch bow up, plane angles to dive; SI throughout. No clock and no
//! input or output, but for reading a vehicle file when one is named.

pub mod answers;
pub mod attitude;
pub mod axis;
pub mod body;
pub mod book;
pub mod coefficients;
pub mod core;
pub mod dynamics;
pub mod environment;
pub mod identified;
pub mod level_flight;
pub mod linearised;
pub mod lockstep;
mod messages;
pub mod motion;
pub mod node;
pub mod odometry;
pub mod parameters;
pub mod plane_forces;
pub mod planes;
pub mod predicted;
pub mod programs;
pub mod propulsion;
pub mod seaway;
pub mod sensors;
mod settings;
pub mod tank;
pub mod tether;
pub mod tick;
pub mod track;
pub mod variant;
pub mod vehicle;
pub mod vehicle_file;

pub use dynamics::{Restoring, State};
pub use vehicle::Vehicle;
