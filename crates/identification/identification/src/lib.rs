#![doc = include_str!("../README.md")]
//!
//! - [`Record`], [`Structure`], [`Problem`]: the data, the unknowns, and both together.
//! - [`estimators`]: least squares, ARMAX, output error, recursions, a vehicle's own equations, a Kalman filter, two stages in a closed loop. All
//!   implement the same trait.
//! - [`frequency`]: frequency responses with coherence and errors, of several inputs and in closed loops.
//! - [`RecursiveLeastSquares`], [`Triangle`]: least squares in square-root form, row by row and at once.
//! - [`Model`], [`Readout`], [`Reading`], [`continuous`]: poles, gains and responses, with standard errors.
//! - [`selection`]: order, delay and kind of model, by cross-validation or by information criteria.
//! - [`several`]: several inputs to one output, with a transfer function for each.
//! - [`static_curve`]: static curves before or after linear dynamics.
//! - [`validation`]: residual tests, identifiability.
//! - [`analysis`]: a complete analysis of one record, with a verdict in plain words.
//! - [`GivenModel`], [`Judgement`]: a model from any source on a record: simulation, predictions, residual tests.
//!
//! Sources: Ljung, *System Identification*, 2nd ed., 1999; Brunner (NPS thesis, 1988), ch. V.

pub mod analysis;
mod batch;
#[cfg(test)]
#[path = "../tests/identification/common/mod.rs"]
mod common;
mod comparison;
mod conversion;
mod error;
pub mod estimators;
mod fit;
mod free_motion;
pub mod frequency;
mod model;
mod prediction;
mod readout;
mod regression;
mod rls;
mod scale;
pub mod selection;
pub mod several;
mod states;
pub mod static_curve;
mod structure;
mod uncertainty;
pub mod validation;

pub use batch::{Triangle, least_squares};
pub use comparison::{GivenModel, Judgement};
pub use conversion::{Continuous, continuous, pitch_equation};
pub use error::IdentificationError;
pub use fit::{FitRange, fit, simulated};
pub use model::Model;
pub use planesman_parallel::{Stop, on_all_cores, stop_point, until_stopped};
pub use planesman_record::{
    Input, LONGEST_PAST, Record, RecordError, Run, Segment, StraightLine, filter, noise, with_noise,
};
pub use readout::{PHYSICAL, Readout};
pub use regression::{Shape, rows};
pub use rls::RecursiveLeastSquares;
pub use structure::{InitialState, Layout, PART, Problem, Structure};
pub use uncertainty::{Reading, SIGMAS_95, SIGMAS_99, Uncertain};

// The unit tests share the integration tests' record, which names the crate.
#[cfg(test)]
extern crate self as planesman_identification;
