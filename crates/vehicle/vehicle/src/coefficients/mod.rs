//! Coefficients from a vehicle's geometry, by the methods of Brunner 1988.
//!
//! Each file contains one method; the functions use SI units, with angles in rad.
//!
//! - [`geometry`]: the data of a vehicle for these methods, from its file.
//! - [`mod@reference`]: conversion to and from nondimensional coefficients.
//! - [`displacement`]: volume, displaced weight, prismatic coefficient.
//! - [`inertia`]: moments of inertia of a box in air.
//! - [`added_mass`]: added mass of a row of square blocks.
//! - [`lift`]: lift slopes of hull and fins, and the resulting coefficients.
//! - [`munk`]: the moment of an ellipsoid in an ideal fluid.
//! - [`damping`]: viscous damping of a rotating plate, and its linearisations.
//! - [`restoring`]: the static moment of weight and buoyancy.
//! - [`drag`]: friction and pressure drag (Tables 5 and 6).
//! - [`power`]: power for a drag, jets behind screws, forces of deflected jets, induced drag.
//! - [`swing`]: moments of inertia from a swing test, with their uncertainty.
//! - [`table`]: comparison of all methods with the coefficients of the vehicle's file.

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
