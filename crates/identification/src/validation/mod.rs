//! Validation of a model.
//!
//! - [`residuals`]: whether the residuals are white and uncorrelated with the input;
//! - [`identifiability`]: whether the record determines all parameters;
//! - [`order_search`]: the order and the delay of the model.

pub mod identifiability;
pub mod order_search;
pub mod residuals;
