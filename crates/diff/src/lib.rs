//! Two recordings compared message by message, each topic for itself.
//!
//! Payloads are compared as bytes first; only those that differ are decoded, by the schema in the bag, and compared field by field.
//! Messages are paired by their own stamps (`pairing`), so that a missing message is missing and no shift of all that follow it.
//! The time at which a recorder received a message is not compared.
//!
//! - [`diff`]: compares; [`Options`]: what counts as a difference.
//! - [`Comparison`], [`TopicResult`], [`FieldResult`], [`First`]: what was found; as text by `text`.
//! - [`histories`]: the fields that differ, over time.
//!
//! Inside: `recording` reads bags and tables alike, `rules` are tolerances and what is ignored.

mod comparison;
mod histories;
mod pairing;
mod recording;
mod rules;
mod text;

use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use planesman_signals::SourceError;

pub use comparison::{Comparison, FieldResult, First, Largest, TopicResult, What};
pub use histories::{History, histories};
pub use recording::stamp_decoder;
pub use rules::{Rule, RuleError, Tolerance};

use comparison::Comparing;
use pairing::{Key, Waiting};
use recording::{Item, Recording};

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
    /// What the columns of a table are in a bag.
    pub columns: &'a [ColumnOf<'a>],
}

/// Topics that hold wall time by their nature, and nothing that a loop computes. They are counted, and not compared unless that is asked for.
pub const WALL_TIME: [&str; 3] = ["/diagnostics", "/rosout", "/parameter_events"];

/// Payload bytes that may wait for their partner.
const WAITING: usize = 1 << 30;

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
        "the recordings hold their messages in so different an order that {} MiB wait for their partner; leave large topics out (--ignore TOPIC)",
        WAITING >> 20
    )]
    Apart,
}

impl From<planesman_bag::ReadError> for DiffError {
    fn from(error: planesman_bag::ReadError) -> Self {
        Self::Source(error.into())
    }
}

/// Compares the recordings at two paths: bags, or tables.
///
/// # Errors
/// One that cannot be opened, or a rule that names what neither has. One that breaks off is compared as far as it goes, and that is noted.
pub fn diff(a: &Path, b: &Path, options: &Options<'_>) -> Result<Comparison, DiffError> {
    let recordings = recording::open([a, b], options)?;
    let mut comparing = Comparing::new(&recordings, options)?;
    thread::scope(|scope| {
        let receivers = [0, 1].map(|side| {
            let (sender, receiver) = sync_channel(BATCHES);
            let recording: &Recording = &recordings[side];
            let wanted = comparing.wanted(side);
            scope.spawn(move || {
                let mut batch = Batch::default();
                let found = recording.read(&|topic| wanted[topic], &mut |item| {
                    batch.bytes += item.payload.len();
                    batch.items.push(item);
                    batch.bytes < BATCH_BYTES && batch.items.len() < BATCH_ITEMS
                        || sender.send(std::mem::take(&mut batch)).is_ok()
                });
                batch.notes = found;
                // It is wanted no more only after an error.
                let _ = sender.send(batch);
            });
            receiver
        });
        merge(&receivers, &mut comparing)
    })?;
    let comparison = comparing.finish();
    let compared = comparison.topics.iter().filter(|it| it.left_out.is_empty());
    match compared.flat_map(|it| it.messages).any(|it| it > 0) {
        true => Ok(comparison),
        false => Err(DiffError::Nothing),
    }
}

const BATCHES: usize = 8;
const BATCH_ITEMS: usize = 1024;
const BATCH_BYTES: usize = 1 << 20;

/// Messages on their way to the comparison.
#[derive(Default)]
struct Batch {
    items: Vec<Item>,
    bytes: usize,
    /// What was found at the recording's end.
    notes: Vec<String>,
}

/// Compares what both readers hand over, always of the one that is behind.
fn merge(receivers: &[Receiver<Batch>; 2], comparing: &mut Comparing<'_>) -> Result<(), DiffError> {
    let mut read = [0_u64; 2];
    let mut has_ended = [false; 2];
    let mut now = [Key::default(); 2];
    while has_ended != [true; 2] {
        let side = match has_ended {
            [true, _] => 1,
            [_, true] => 0,
            _ => usize::from(read[1] < read[0]),
        };
        let Ok(batch) = receivers[side].recv() else {
            has_ended[side] = true;
            comparing.end(side);
            continue;
        };
        for item in batch.items {
            read[side] += comparing.push(side, item, &mut now[side]);
        }
        comparing.note(side, batch.notes);
        if comparing.waiting > WAITING {
            return Err(DiffError::Apart);
        }
    }
    Ok(())
}

/// A message with its place in time.
fn waiting(item: Item, key: Key, number: u64) -> Waiting {
    Waiting {
        key,
        number,
        payload: item.payload,
    }
}
