//! G. W. Scott, *Digital Hydraulic Actuator Study, Phase III Final Report*, IBM 66-L03-005, November 1966: bench, numbers and figures, recomputed.
//! The actuator itself is in [`planesman_hydraulics`].
//!
//! - [`Surrogate`], [`Case`], [`DigitalLoop`], [`AnalogLoop`], [`Gains`]: missile, autopilots and loops.
//! - [`procedure`], [`tables`]: the tests of Sections III and IV, and the rows of their tables.
//! - [`flight_control`]: the linear model of Section V, and the full model under sinusoids.
//! - [`REPORT`]: numbers and figures.

mod analog_loop;
mod autopilot;
mod book;
mod case;
mod digital_loop;
mod figures;
pub mod flight_control;
mod missile;
pub mod procedure;
pub mod tables;

pub use analog_loop::AnalogLoop;
pub use autopilot::{Gains, PULSE};
pub use book::{book, recomputed};
pub use case::{Case, RateSignal};
pub use digital_loop::{DigitalLoop, Start};
pub use figures::figures;
pub use missile::{Surrogate, Yaw, YawPlant};

/// Description of the report.
pub const REPORT: crate::book::Report = crate::book::Report {
    name: "IBM 1966",
    citation: "G. W. Scott, Digital Hydraulic Actuator Study, Phase III Final Report, IBM 66-L03-005, November 1966.",
    book,
    names: || crate::book::Names::parse(include_str!("../../data/ibm_1966/names.json")),
    recomputed,
    procedure: None,
    figures,
};
