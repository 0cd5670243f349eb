//! Six coupled degrees of freedom: a vehicle that sways, rolls and yaws as it dives.
//!
//! [`equations`](State) has the complete equations of motion in Fossen's vector form: rigid body and added mass with their Coriolis forces,
//! a centre of gravity off the origin, damping by matrices, coefficients and strips, fins in the local flow, propellers and thrusters,
//! currents and waves. [`Vehicle::forces`] returns each term of the right-hand side.
//!
//! Axes forward, starboard, keel; the fixed frame is north, east, down; SI units. The vertical plane of [`crate::State`] is the special
//! case without sway, roll and yaw, with held surge.

mod batch;
mod body;
mod boundaries;
pub mod coefficients;
mod damping;
mod editable;
mod equations;
pub mod exchange;
mod file;
mod fins;
mod hull;
mod inertia;
mod lanes;
mod plane;
pub mod propulsion;
pub mod rotation;
mod scaled;
mod simulate;
mod steady;
mod tick;
mod torpedo;
mod vehicle;
mod water;

pub use batch::Batch;
pub use body::BoxBody;
pub use damping::{CrossFlow, Damping};
pub use editable::{Change, EditableFile, Number};
pub use equations::{Forces, State};
pub use file::{FileError, built_in, load, parse};
pub(crate) use file::{built_in_text, is_of_six_degrees};
pub use fins::{Fin, Section};
pub use hull::Hull;
pub use inertia::{Matrix6, RigidBody, about_origin, ellipsoid};
pub use lanes::{Lanes, Real, Six, Three};
pub use simulate::{Accurate, Diverged, Simulation, runge_kutta};
pub use steady::{Turn, growth, steady_turn, steady_turns};
pub use tick::{Commands, Conditions, Tick, Unmoved};
pub use torpedo::{NoTorpedo, Torpedo};
pub use vehicle::{Parts, Unphysical, Vehicle};
pub use water::{GRAVITY, Sea, Water, Wave};
