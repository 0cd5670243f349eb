//! Validation of a model.
//!
//! - [`residuals`]: whether the residuals are white and uncorrelated with the input;
//! - [`identifiability`]: whether the record determines all parameters.

pub mod identifiability;
pub mod nonlinearity;
pub mod residuals;
