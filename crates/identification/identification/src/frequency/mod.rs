//! The frequency response of records, without a model.
//!
//! - `windows`: tapers, and which lengths of them a record holds.
//! - `response`: spectra, response, coherence and errors at each frequency, composed of several window lengths.
//! - `measured`: that of a record, the band in which its coherence holds, and rows beside a model.
//!
//! A transfer function is fitted to it by [`FrequencyDomain`](crate::estimators::FrequencyDomain).

mod measured;
mod response;
mod windows;

pub use measured::{COHERENCE, MeasuredResponse, Row};
pub(crate) use measured::{band, rows};
pub(crate) use response::DECIBEL;
pub use response::{Columns, Point, Settings, Spectra};
pub use windows::Windows;
