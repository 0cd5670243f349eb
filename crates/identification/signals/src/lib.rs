#![doc = include_str!("../README.md")]
//!
//! ```text
//! Source (bag, CSV table, log, columns) -> Resampler -> Record        messages -> LiveGrid -> Aligner -> Sample
//! ```
//! - [`Signal`]: `TOPIC:FIELD`, one number of a message.
//! - [`Source`]: samples of any signals, streamed. [`open`] reads files, [`ColumnSource`] columns in memory.
//! - [`Meter`], [`Timing`]: rate, jitter, gaps and duplicates of stamps.
//! - [`Resampler`], [`read_record`]: samples on a grid, in the form of a `planesman_record` record.
//! - [`read_samples`]: samples at their original stamps, without a grid.
//! - [`prepare`]: outliers, segments by excitation, trends and inserted zeros, each a [`Step`] with a sentence on the result.
//! - [`LiveGrid`], [`Aligner`]: resampling of samples as they arrive, with inputs and outputs paired by stamp.
//!
//! Internally `clock` makes a continuous time from stamps that go back, and `gridder` resamples.

mod ahead;
mod align;
mod alog;
mod bag_source;
mod bag_types;
mod binary;
mod channel;
mod clock;
mod column_source;
mod csv_cell;
mod csv_form;
mod csv_heading;
mod csv_long;
mod csv_serial;
mod csv_source;
mod csv_time;
mod dataflash;
mod decimation;
mod error;
mod gridder;
mod identity;
mod inspection;
mod joined_tables;
mod live_grid;
mod log_message;
mod log_source;
mod mavlink;
mod mixture;
mod open;
mod prefilter;
mod preparation;
mod prepared_record;
mod publishers;
mod quantile;
mod repeats;
mod request;
mod resample;
mod samples;
mod sieve;
mod signal;
mod source;
mod spread;
mod stamps;
mod time_unit;
mod timing;
mod ulog;
mod unit_name;
mod unwrap;

pub use align::{Aligner, MAX_REPEATS, Offer, Sample, WINDOW};
pub use bag_source::{by_name, each_message, topics};
pub use bag_types::types;
pub use channel::{Change, Channel, Method, Timing, hertz};
pub use column_source::ColumnSource;
pub use csv_source::{CsvSource, TableTime};
pub use error::SourceError;
pub use inspection::{StampFindings, StampInspection, ValueInspection};
pub use live_grid::{GridSample, LiveGrid};
pub use log_source::{LogKind, LogSource};
pub use mixture::Mixture;
pub use open::{Data, TABLES, is_data, is_record, is_table, open};
pub use prefilter::{Band, unreachable};
pub use preparation::{
    Outliers, Preparation, SegmentChoice, Step, StepName, Trend, prepare, without_dynamics,
};
pub use prepared_record::{PreparedRecord, SourceOfRecord, read_record};
pub use publishers::{Publishers, Senders};
pub use request::{Clock, Reading, Request, Role, Take};
pub use resample::{GridError, MAX_NUMBERS, ORDER, Options, PRELUDE, Resampled, Resampler};
pub use samples::{Stretches, read_samples};
pub use signal::{LARGEST, Signal, SignalError};
pub use source::{KeptSource, Source, SourceTopic};
pub use stamps::Stamps;
pub use time_unit::TimeUnit;
pub use timing::Meter;
pub use unwrap::Unwrap;
