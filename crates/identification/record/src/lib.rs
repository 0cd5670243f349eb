#![doc = include_str!("../README.md")]
//!
//! - [`Record`], [`Segment`], [`Run`]: the numbers, their parts without a gap, and one input with one output.
//! - [`Input`]: mean and first moment of an input between two instants.
//! - [`filter()`], [`StraightLine`]: a difference equation from rest, a trend.
//! - [`noise()`], [`with_noise`]: white noise for simulated records, the same in every program.

mod error;
mod filter;
mod input;
mod noise;
mod record;
mod straight_line;

pub use error::RecordError;
pub use filter::filter;
pub use input::Input;
pub use noise::{noise, with_noise};
pub use record::{LONGEST_PAST, Record, Run, Segment};
pub use straight_line::StraightLine;
