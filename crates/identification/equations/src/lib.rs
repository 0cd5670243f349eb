//! User-defined state equations, fitted to samples at their original stamps.
//!
//! ```text
//! EquationsFile -> Equations;   Equations + [Run] -> fit -> EquationsFit
//! ```

mod chains;
mod determined;
mod error;
mod expression;
mod file;
mod fit;
mod model;
mod named;
mod problem;
mod simulation;
mod transfer;

pub use determined::Undetermined;
pub use error::EquationsError;
pub use expression::ExpressionError;
pub use file::{EquationsFile, Initial, Output, Parameter, Sought, State, text_of};
pub use fit::{EquationsFit, EstimatedParameter, OutputFit, fit};
pub use model::{Equations, Unknown};
pub use named::Named;
pub use simulation::{Between, Run, Track};
pub use transfer::{TransferFit, TransferOptions, fit_transfer};

#[cfg(test)]
mod tests;
