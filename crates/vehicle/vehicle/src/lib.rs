#![doc = include_str!("../README.md")]
//!
//! - `dynamics`: equations of the vertical plane: [`State`], [`GeneralisedForce`]; `vehicle`: [`Vehicle`], its [`Derivatives`].
//! - `energy`: upper bound of the kinetic energy.
//! - `axis`, `propulsion`: roll and yaw as single axes: [`Axis`]; thrust and drag: [`Propulsion`].
//! - `body`, `tick`, `motion`: the whole [`Body`] integrated over a tick; [`Motion`]: the vertical plane alone.
//! - `attitude`, `planes`: rotations: [`Attitude`]; plane angle over a tick: [`PlanePath`].
//! - `environment`, `depth_limits`, `seaway`, `tether`: the surroundings of the vehicle. [`Variant`]: the vehicle with parts of its
//!   equations removed.
//! - `trim`: [`LevelFlight`]; [`linearised`]: linear models about it; [`transfer`]: their transfer functions; [`pitch`]: the pitch equation
//!   alone.
//! - [`vehicle_file`]: vehicles from YAML; [`identified`]: from an identified model; [`coefficients`]: from geometry.
//!
//! Depth is positive down, pitch positive bow up, plane angles positive to dive.

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
