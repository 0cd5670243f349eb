//! Reads both recordings at the same time, each in its own thread, and merges their messages.

use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use crate::diff::comparison::{Comparing, Comparison};
use crate::diff::options::{DiffError, Options, WAITING};
use crate::diff::pairing::Key;
use crate::diff::recording::{self, Item, Recording};

/// Compares the recordings at two paths, bags or tables.
///
/// # Errors
/// A recording that cannot be opened, or a rule that matches nothing in either. A recording that breaks off is compared up to there, with a note.
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
    /// Notes from the recording's end.
    notes: Vec<String>,
}

/// Compares the messages of both readers; the next message is always taken from the reader that lags in time.
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
