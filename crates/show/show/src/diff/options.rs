//! What counts as a difference, and why recordings cannot be compared.

use planesman_signals::SourceError;
use planesman_text::setting;

use crate::diff::rules::{Rule, RuleError, Tolerance};

/// A column of a table of a flight, and the signal of a bag (`TOPIC:FIELD`) that it holds; a `-` before it changes its sign.
pub type ColumnOf<'a> = (&'a str, &'a str);

/// What counts as a difference.
#[derive(Clone, Debug, Default)]
pub struct Options<'a> {
    /// Absolute tolerances of fields.
    pub tolerances: Vec<Tolerance>,
    /// Topics and fields that are not compared.
    pub ignored: Vec<Rule>,
    /// Compare the topics of wall time ([`WALL_TIME`]) too.
    pub all: bool,
    /// Pair the messages of a topic by their number, not by their stamps.
    pub by_index: bool,
    /// The only topics that are compared; all where it is empty.
    pub only: Vec<String>,
    /// Bytes that the chunks of each file of a bag may unpack to in all; `None` without a limit.
    pub most_unpacked: Option<u64>,
    /// What the columns of a table are in a bag.
    pub columns: &'a [ColumnOf<'a>],
}

/// Topics that hold wall time by their nature, and nothing that a loop computes. They are counted, and not compared unless that is asked for.
pub const WALL_TIME: [&str; 3] = ["/diagnostics", "/rosout", "/parameter_events"];

/// Payload bytes that may wait for their partner.
pub(crate) const WAITING: usize = 1 << 30;

/// Why recordings cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// One cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A rule of a topic or field that neither has.
    #[error(transparent)]
    Rule(#[from] RuleError),
    /// No message is compared: a test would pass on nothing.
    #[error(
        "there is nothing to compare: no topic that is not left out has a message (planesman bag info lists them)"
    )]
    Nothing,
    /// Messages of one topic lie too far apart in the two files.
    #[error(
        "the recordings hold their messages in so different an order that {} MiB wait for their partner; leave large topics out ({})",
        WAITING >> 20, setting("ignore", "TOPIC")
    )]
    Apart,
}

impl From<planesman_bag::ReadError> for DiffError {
    fn from(error: planesman_bag::ReadError) -> Self {
        Self::Source(error.into())
    }
}
