//! The frequency response of records, without a model.
//!
//! - `windows`: tapers, and which lengths of them a record holds.
//! - `response`: spectra, response, coherence and errors at each frequency, composed of several window lengths.
//!
//! A transfer function is fitted to it by [`FrequencyDomain`](crate::estimators::FrequencyDomain).

mod response;
mod windows;

pub(crate) use response::DECIBEL;
pub use response::{Columns, Point, Settings, Spectra};
pub use windows::Windows;
