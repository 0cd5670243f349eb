//! Reasons why numbers do not form a record.

use thiserror::Error;

/// The rule that a record violates.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordError {
    /// A sampling interval that is not positive.
    #[error("sampling interval {0} s refused: it must be positive and finite")]
    SampleTime(f64),
    /// There is no output.
    #[error("a record needs an output")]
    NoOutput,
    /// Names and lists do not match.
    #[error("segment {segment} has {lists} lists for {signals} signals")]
    Lists {
        /// The segment's number.
        segment: usize,
        /// Lists of numbers.
        lists: usize,
        /// Names.
        signals: usize,
    },
    /// A signal is longer or shorter than the first output.
    #[error(
        "segment {segment}: {signal} has {samples} samples, but the first output has {expected}"
    )]
    Length {
        /// The segment's number.
        segment: usize,
        /// The signal's name.
        signal: String,
        /// Its samples.
        samples: usize,
        /// Samples of the first output.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("segment {segment}: {signal} is not finite at sample {sample}")]
    NotFinite {
        /// The segment's number.
        segment: usize,
        /// The signal's name.
        signal: String,
        /// The sample's number in the segment.
        sample: usize,
    },
}
