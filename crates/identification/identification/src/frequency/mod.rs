//! The frequency response of records, without a model.
//!
//! - `windows`: tapers, and their lengths for a record.
//! - `response`: spectra, response, coherence and errors at each frequency, combined from several window lengths.
//! - `measured`: the response of a record, the band of sufficient coherence, and rows together with a model.
//!
//! [`FrequencyDomain`](crate::estimators::FrequencyDomain) fits a transfer function to the response.

mod measured;
mod response;
mod windows;

pub use measured::{COHERENCE, MeasuredResponse, Row};
pub(crate) use measured::{band, rows};
pub(crate) use response::DECIBEL;
pub use response::{Columns, Point, Settings, Spectra};
pub use windows::Windows;
