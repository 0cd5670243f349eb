//! The recorder's parameters: folder, compression, flush interval, topics. The parameters in `record` and `storage` have the names of rosbag2's
//! recorder.
//!
//! All of these parameters can be set only at the start.

use std::time::Duration;

use planesman_bag::WriterOptions;
use planesman_parameters::{Choice, Parameters};

use crate::selection::{NoRegex, Record, Selection};
use planesman_msgs::loop_topics::{self, UnknownTopic};

/// Parameters of `recorder`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct RecorderParameters {
    /// Folder of the bag, which must not exist; empty: bags/planesman_TIME.
    #[parameter(default = "", read_only)]
    pub output: String,
    /// Topics of the loop to record, by their names in the loop ('state', '/tf'); empty: all. Other topics: record.
    #[parameter(default = Vec::new(), read_only)]
    pub topics: Vec<String>,
    /// Compression of the chunks: none, or zstd at its default level.
    #[parameter(default = Compression::Zstd, read_only)]
    pub compression: Compression,
    /// Size before compression at which a chunk is written to the file; rosbag2's default.
    #[parameter(default = 768 * 1024, unit = "B", range = 1024..=64 * 1024 * 1024, read_only)]
    pub chunk_size: u64,
    /// Longest time a message stays in memory; a killed recorder loses at most this, a power cut what the system has not
    /// written yet (see fsync).
    #[parameter(default = 1.0, unit = "s", range = 0.0..=3600.0, read_only)]
    pub flush_interval: f64,
    /// Whether each flush waits until the disk has the messages, so that a power cut loses no more than a killed recorder does.
    #[parameter(default = false, read_only)]
    pub fsync: bool,
    /// Whether the sensors' topics are subscribed reliably, so that no message is lost; needs plant_sim's
    /// reliable_sensors. Always as a member of lockstep.
    #[parameter(default = false, read_only)]
    pub reliable_sensors: bool,
    /// Whether each tick is answered once its state is recorded, as a member of lockstep.
    #[parameter(default = false, read_only)]
    pub answer: bool,
    /// `record.*`.
    pub record: Record,
    /// `storage.*`.
    pub storage: Storage,
}

/// The parameters `storage.*`: how the bag is split, and the snapshot mode.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Storage {
    /// Size at which the bag's next file begins; 0: one file.
    #[parameter(default = 0, unit = "B", range = 0.0..=1e15, read_only)]
    pub max_bagfile_size: u64,
    /// Time after which the bag's next file begins; 0: one file.
    #[parameter(default = 0, unit = "s", range = 0.0..=1e9, read_only)]
    pub max_bagfile_duration: u64,
    /// Keep the latest messages in memory, and write them only when the service snapshot is called.
    #[parameter(default = false, read_only)]
    pub snapshot_mode: bool,
    /// Messages that wait in memory for the disk, at least 33554432; a larger one is not recorded. In snapshot mode, also the
    /// payloads that are kept.
    #[parameter(default = 100 * 1024 * 1024, unit = "B", range = 1.0..=1e12, read_only)]
    pub max_cache_size: u64,
}

/// Compression of the bag's chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum Compression {
    /// No compression.
    None,
    /// Zstandard at its default level.
    Zstd,
}

/// Invalid parameters of a recorder.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A topic that the loop does not have.
    #[error(transparent)]
    Topic(#[from] UnknownTopic),
    /// The flush interval is not a valid duration.
    #[error("flush_interval: {0}")]
    FlushInterval(std::time::TryFromFloatSecsError),
    /// An invalid regular expression.
    #[error(transparent)]
    Regex(#[from] NoRegex),
}

/// The writer's options with these values.
///
/// # Errors
/// A topic that is not of the loop, an invalid flush interval, or an invalid regular expression.
pub fn writer_options(parameters: &RecorderParameters) -> Result<WriterOptions, Error> {
    loop_topics::selected(&parameters.topics)?;
    Selection::new(&parameters.record, str::to_owned)?;
    let given = |value: u64| (value > 0).then_some(value);
    Ok(WriterOptions {
        compression: match parameters.compression {
            Compression::None => planesman_bag::Compression::None,
            Compression::Zstd => planesman_bag::Compression::Zstd,
        },
        chunk_size: parameters.chunk_size,
        flush_interval: Some(
            Duration::try_from_secs_f64(parameters.flush_interval).map_err(Error::FlushInterval)?,
        ),
        max_file_size: given(parameters.storage.max_bagfile_size),
        max_file_duration: given(parameters.storage.max_bagfile_duration).map(Duration::from_secs),
        fsync: parameters.fsync,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Value;

    fn with(name: &str, value: Value) -> Result<WriterOptions, String> {
        RecorderParameters::default()
            .with(&[(name, value)])
            .map_err(|refusal| refusal.to_string())
            .and_then(|parameters| writer_options(&parameters).map_err(|error| error.to_string()))
    }

    #[test]
    fn the_defaults_are_the_bags_own() {
        let options = writer_options(&RecorderParameters::default()).expect("valid");
        let defaults = WriterOptions::default();
        assert_eq!(options.compression, defaults.compression);
        assert_eq!(options.chunk_size, defaults.chunk_size);
        assert_eq!(options.flush_interval, defaults.flush_interval);
        assert_eq!(options.max_file_size, defaults.max_file_size);
        assert_eq!(options.max_file_duration, defaults.max_file_duration);
    }

    #[test]
    fn values_reach_the_writer() {
        let none = with("compression", "none".into()).expect("valid");
        assert_eq!(none.compression, planesman_bag::Compression::None);
        let small = with("chunk_size", Value::Integer(4096)).expect("valid");
        assert_eq!(small.chunk_size, 4096);
        let fast = with("flush_interval", 0.25.into()).expect("valid");
        assert_eq!(fast.flush_interval, Some(Duration::from_millis(250)));
    }

    #[test]
    fn bad_values_are_refused_by_name_and_rule() {
        for (name, value, rule) in [
            ("compression", Value::from("gzip"), "none, zstd"),
            ("chunk_size", Value::Integer(-1), "[1024, 67108864] B"),
            ("flush_interval", Value::Double(f64::NAN), "finite"),
            ("flush_interval", Value::Double(-1.0), "[0, 3600] s"),
            (
                "topics",
                Value::StringArray(vec!["stat".to_owned()]),
                "'stat'",
            ),
            ("record.regex", Value::from("("), "not a regular expression"),
        ] {
            let refusal = with(name, value).expect_err("refused");
            assert!(refusal.contains(rule), "{name}: {refusal}");
        }
    }
}
