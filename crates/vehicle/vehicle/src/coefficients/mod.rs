//! From a vehicle's geometry to its coefficients, by the methods of Brunner 1988.
//!
//! Each file holds one method; the functions take and give SI units, angles in rad.
//!
//! - [`geometry`]: what the methods need to know of a vehicle, from its file.
//! - [`mod@reference`]: what makes coefficients nondimensional, and back.
//! - [`displacement`]: volume, displaced weight, prismatic coefficient.
//! - [`inertia`]: moments of inertia of a box in air.
//! - [`added_mass`]: added mass of a row of square blocks.
//! - [`lift`]: lift slopes of hull and fins, and the coefficients they make.
//! - [`munk`]: the moment of an ellipsoid in an ideal fluid.
//! - [`damping`]: viscous damping of a turning plate, and its linearisations.
//! - [`restoring`]: the static moment of weight and buoyancy.
//! - [`drag`]: friction and pressure drag (Tables 5 and 6).
//! - [`power`]: power against drag, jets behind screws, forces of deflected jets, induced drag.
//! - [`swing`]: moments of inertia from a swing test, with their uncertainty.
//! - [`table`]: all methods beside the coefficients of the vehicle's file.

pub mod added_mass;
pub mod damping;
pub mod displacement;
pub mod drag;
pub mod geometry;
pub mod inertia;
pub mod lift;
pub mod munk;
pub mod power;
pub mod reference;
pub mod restoring;
pub mod swing;
pub mod table;

pub use geometry::Geometry;
pub use table::Table;
