//! Whether a model deserves trust.
//!
//! - [`residuals`]: is what the model leaves over white, and unrelated to the input?
//! - [`identifiability`]: can the record tell the parameters apart at all?
//! - [`order_search`]: which order and delay does the record ask for?

pub mod identifiability;
pub mod order_search;
pub mod residuals;
