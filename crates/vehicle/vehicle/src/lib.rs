#![doc = include_str!("../README.md")]
//!
//! - `dynamics`: the equations of the vertical plane: [`State`], [`GeneralisedForce`]; `vehicle`: [`Vehicle`], its [`Derivatives`].
//! - `energy`: the most kinetic energy that planes and speed can give.
//! - `axis`, `propulsion`: roll and yaw, one axis each: [`Axis`]; thrust and drag: [`Propulsion`].
//! - `body`, `tick`, `motion`: the whole [`Body`] integrated over a tick; [`Motion`] of the vertical plane alone.
//! - `attitude`, `planes`: rotations: [`Attitude`]; the plane angle over a tick: [`PlanePath`].
//! - `environment`, `depth_limits`, `seaway`, `tether`: what surrounds the vehicle. [`Variant`]: parts of it left out.
//! - `trim`: [`LevelFlight`]; [`linearised`]: linear models about it, [`transfer`]: their transfer functions, and [`pitch`]: its pitch equation alone.
//! - [`vehicle_file`], [`identified`]: vehicles from YAML, from an identified model; [`coefficients`]: from geometry.
//!
//! Depth is positive down, pitch positive bow up, plane angles positive dive.

mod attitude;
mod axis;
mod body;
pub mod coefficients;
mod depth_limits;
mod dynamics;
mod energy;
mod environment;
pub mod heave;
pub mod identified;
pub mod linearised;
mod motion;
mod normal;
pub mod pitch;
mod planes;
mod positive;
mod propulsion;
mod seaway;
pub mod six_dof;
mod steps;
mod tether;
mod tick;
pub mod transfer;
mod trim;
mod variant;
mod vehicle;
pub mod vehicle_file;

pub use attitude::{Angle, Attitude, Rotation};
pub use axis::{Axis, AxisState};
pub use body::{Body, BodyMotion, Drive, Inputs};
pub use depth_limits::{Boundary, Contact, DepthLimits};
pub use dynamics::{GeneralisedForce, InverseInertia, Restoring, Slope, Slopes, State};
pub use environment::{Environment, SURFACE};
pub use motion::{Diverged, Motion};
pub use normal::standard_normal;
pub use planes::{MotionError, PlanePath};
pub use propulsion::Propulsion;
pub use seaway::{Seaway, ShapingFilter, Waves};
pub use tether::Tether;
pub use tick::Acceleration;
pub use trim::LevelFlight;
pub use variant::{BRUNNER_SECANT_RATE, BRUNNER_VISCOUS_DAMPING, PitchDamping, Variant};
pub use vehicle::{Coefficients, Derivatives, PlaneArms, Port, Vehicle};
