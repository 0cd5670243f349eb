//! Options and errors of a comparison.

use planesman_signals::SourceError;
use planesman_text::setting;

use crate::diff::rules::{Rule, RuleError, Tolerance};

/// A column of a flight's table, and the bag's signal (`TOPIC:FIELD`) with the same values; a `-` before the signal changes its sign.
pub type ColumnOf<'a> = (&'a str, &'a str);

/// Options of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Options<'a> {
    /// Absolute tolerances of fields.
    pub tolerances: Vec<Tolerance>,
    /// Topics and fields to ignore.
    pub ignored: Vec<Rule>,
    /// Also compare the topics with wall time ([`WALL_TIME`]).
    pub all: bool,
    /// Pair the messages of a topic by index instead of by stamp.
    pub by_index: bool,
    /// The only topics to compare; all if empty.
    pub only: Vec<String>,
    /// Largest total size of a bag file's chunks after unpacking, bytes; `None` without a limit.
    pub most_unpacked: Option<u64>,
    /// The bag's signals for the columns of a table.
    pub columns: &'a [ColumnOf<'a>],
}

/// Topics that contain wall time and no results of a loop. These topics are counted, and compared only on request.
pub const WALL_TIME: [&str; 3] = ["/diagnostics", "/rosout", "/parameter_events"];

/// Largest size of payloads waiting for their partner, bytes.
pub(crate) const WAITING: usize = 1 << 30;

/// Errors of a comparison.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// A recording cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A rule matches no topic or field of either recording.
    #[error(transparent)]
    Rule(#[from] RuleError),
    /// No message is compared; without this error an empty comparison would count as equal.
    #[error(
        "nothing to compare: all topics that are not ignored are empty (planesman bag info lists all topics)"
    )]
    Nothing,
    /// The messages of one topic are too far apart in the two files.
    #[error(
        "the order of messages differs too much. {} MiB of messages wait for their equal messages of the other recording. Ignore large topics with {}",
        WAITING >> 20, setting("ignore", "TOPIC")
    )]
    Apart,
}

impl From<planesman_bag::ReadError> for DiffError {
    fn from(error: planesman_bag::ReadError) -> Self {
        Self::Source(error.into())
    }
}
