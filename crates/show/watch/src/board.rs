//! The data of the page: written by the node, read by every open page.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::series::{Cursor, SAMPLES_PER_CHANNEL, Series};

/// Maximum number of log lines kept.
const MAX_LOG_LINES: usize = 2000;
/// Maximum number of samples kept over all channels, 16 bytes each. With more channels than one vehicle has, each channel keeps fewer than
/// [`SAMPLES_PER_CHANNEL`].
const SAMPLES_IN_ALL: usize = 25 * SAMPLES_PER_CHANNEL;
/// Limits of one message to a page: samples, bytes of log lines, bytes of sections. The last item may exceed a limit; further items follow in
/// the next message.
const SAMPLES: usize = 10_000;
const LOG: usize = 1 << 18;
const SECTIONS: usize = 1 << 18;
/// Largest text of a section, bytes; a longer list is cut off.
const LONGEST_SECTION: usize = 1 << 20;

/// A line of `/rosout`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LogLine {
    /// Wall-clock time of arrival, s.
    pub(crate) time: f64,
    pub(crate) level: u8,
    pub(crate) node: String,
    pub(crate) text: String,
}

/// A channel's samples, or the reason why it has none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Channel {
    pub(crate) series: Series,
    pub(crate) refusal: Option<String>,
}

/// A part of the page that is sent as a whole when it changes.
#[derive(Clone, Debug)]
struct Section {
    version: u64,
    value: Arc<Value>,
    /// Length of the section's text, bytes.
    length: usize,
}

/// The data of all pages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Board {
    channels: BTreeMap<String, Channel>,
    sections: BTreeMap<String, Section>,
    version: u64,
    lines: VecDeque<LogLine>,
    /// Number of older lines that were dropped.
    forgotten: u64,
}

/// The board, shared by node and server.
pub(crate) type SharedBoard = Arc<Mutex<Board>>;

/// Locks the board; after a panic of another thread the board is still usable.
pub(crate) fn locked(board: &SharedBoard) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Board {
    /// The channel of this name, created if necessary.
    pub(crate) fn channel(&mut self, name: &str) -> &mut Channel {
        self.make(name);
        self.channels.entry(name.to_owned()).or_default()
    }

    /// Creates a channel if it is missing; the other channels then keep fewer samples.
    fn make(&mut self, name: &str) {
        if self.channels.contains_key(name) {
            return;
        }
        self.channels.insert(name.to_owned(), Channel::default());
        let kept = self.kept();
        for channel in self.channels.values_mut() {
            channel.series.keep(kept);
        }
    }

    /// Number of samples kept per channel.
    fn kept(&self) -> usize {
        SAMPLES_PER_CHANNEL.min(SAMPLES_IN_ALL / self.channels.len().max(1))
    }

    /// Adds a sample to a channel.
    pub(crate) fn push(&mut self, name: &str, time: f64, value: f64) {
        self.make(name);
        let kept = self.kept();
        if let Some(channel) = self.channels.get_mut(name) {
            channel.series.push(time, value, kept);
        }
    }

    /// The reason why a channel has no samples, if known.
    pub(crate) fn refusal(&self, name: &str) -> Option<&str> {
        self.channels.get(name)?.refusal.as_deref()
    }

    /// Removes channels that never had a sample.
    pub(crate) fn forget_empty(&mut self) {
        self.channels.retain(|_, it| !it.series.is_empty());
    }

    /// Restarts the channels of a vehicle that was reset to its initial state at this time, s.
    pub(crate) fn begin_anew(&mut self, time: f64, is_its: impl Fn(&str) -> bool) {
        let channels = self.channels.iter_mut();
        for (_, channel) in channels.filter(|(name, _)| is_its(name)) {
            channel.series.begin_anew(Some(time));
        }
    }

    /// Replaces a section.
    pub(crate) fn put(&mut self, name: &str, mut value: Value) {
        let length = |value: &Value| value.to_string().len();
        let mut whole = length(&value);
        while whole > LONGEST_SECTION {
            let Some(last) = value.as_array_mut().and_then(Vec::pop) else {
                return; // Nobody's description of himself is as long.
            };
            whole -= length(&last);
        }
        if self.sections.get(name).is_some_and(|it| *it.value == value) {
            return;
        }
        self.version += 1;
        let section = Section {
            version: self.version,
            value: Arc::new(value),
            length: whole,
        };
        self.sections.insert(name.to_owned(), section);
    }

    /// The section of that name.
    pub(crate) fn section(&self, name: &str) -> Option<&Value> {
        Some(&*self.sections.get(name)?.value)
    }

    /// Adds a line to the log.
    pub(crate) fn log(&mut self, line: LogLine) {
        if self.lines.len() == MAX_LOG_LINES {
            self.lines.pop_front();
            self.forgotten += 1;
        }
        self.lines.push_back(line);
    }
}

/// State of one page: the data that has been sent to the page.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reader {
    /// The page's channels, each with its number.
    channels: Vec<(usize, String, Cursor, Option<String>)>,
    version: u64,
    lines: u64,
    /// Whether the last message left out some of the new data.
    behind: bool,
}

/// A section in a message.
#[derive(Clone, Debug)]
struct SentUpdate(Arc<Value>);

impl Serialize for SentUpdate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// A message to a page: everything new since the last one.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Message {
    /// Number of the channel, whether it restarts, times and values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    series: Vec<(usize, bool, Vec<f64>, Vec<f64>)>,
    /// Number of the channel, with the reason why the channel has no samples; `None` once it has samples.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    refused: Vec<(usize, Option<String>)>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    sections: BTreeMap<String, SentUpdate>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    log: Vec<LogLine>,
}

impl Message {
    /// Whether the message is empty.
    pub(crate) fn is_empty(&self) -> bool {
        self.series.is_empty()
            && self.refused.is_empty()
            && self.sections.is_empty()
            && self.log.is_empty()
    }
}

impl Reader {
    /// A new page that shows these channels, each with its number.
    pub(crate) fn of(channels: impl Iterator<Item = (usize, String)>) -> Self {
        let channels = channels.map(|(number, name)| (number, name, Cursor::default(), None));
        Self {
            channels: channels.collect(),
            ..Self::default()
        }
    }

    /// Whether the last message left out some of the new data.
    pub(crate) fn is_behind(&self) -> bool {
        self.behind
    }

    /// The next message for this page.
    pub(crate) fn updates(&mut self, board: &Board) -> Message {
        let mut message = Message::default();
        self.behind = false;
        let most = (SAMPLES / self.channels.len().max(1)).max(1);
        for (number, name, cursor, told) in &mut self.channels {
            let Some(channel) = board.channels.get(name) else {
                continue;
            };
            let new = channel.series.since(cursor, most);
            self.behind |= new.times.len() == most;
            if new.restarted || !new.times.is_empty() {
                let one = (*number, new.restarted, new.times, new.values);
                message.series.push(one);
            }
            if *told != channel.refusal {
                told.clone_from(&channel.refusal);
                message.refused.push((*number, channel.refusal.clone()));
            }
        }
        let mut newer: Vec<_> = board.sections.iter().collect();
        newer.retain(|(_, section)| section.version > self.version);
        newer.sort_by_key(|(_, section)| section.version);
        let mut room = SECTIONS;
        for (name, section) in newer {
            if room == 0 {
                self.behind = true;
                break;
            }
            room = room.saturating_sub(section.length);
            let told = SentUpdate(Arc::clone(&section.value));
            message.sections.insert(name.clone(), told);
            self.version = section.version;
        }
        let skipped = usize::try_from(self.lines.saturating_sub(board.forgotten)).unwrap_or(0);
        self.lines = self.lines.max(board.forgotten);
        let mut room = LOG;
        for line in board.lines.iter().skip(skipped) {
            if room == 0 {
                self.behind = true;
                break;
            }
            room = room.saturating_sub(line.node.len() + line.text.len());
            message.log.push(line.clone());
            self.lines += 1;
        }
        message
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_page_is_told_what_is_new_and_nothing_twice() {
        let mut board = Board::default();
        let mut reader = Reader::of([(0, "a".to_owned()), (1, "b".to_owned())].into_iter());
        board.push("b", 1.0, 2.0);
        board.push("elsewhere", 1.0, 2.0);
        board.put("graph", json!({"nodes": 1}));
        board.channel("a").refusal = Some("no such field".to_owned());
        board.log(LogLine {
            time: 0.0,
            level: 20,
            node: "n".to_owned(),
            text: "up".to_owned(),
        });
        let text = serde_json::to_string(&reader.updates(&board)).expect("JSON");
        assert_eq!(
            text,
            r#"{"series":[[1,false,[1.0],[2.0]]],"refused":[[0,"no such field"]],"sections":{"graph":{"nodes":1}},"log":[{"time":0.0,"level":20,"node":"n","text":"up"}]}"#
        );
        board.put("graph", json!({"nodes": 1}));
        assert!(reader.updates(&board).is_empty());
        board.channel("a").refusal = None;
        assert_eq!(reader.updates(&board).refused, [(0, None)]);
    }

    #[test]
    fn many_channels_keep_no_more_in_all_than_a_few_though_nothing_comes_for_them() {
        let mut board = Board::default();
        for k in 0..SAMPLES_PER_CHANNEL {
            board.push("silent from now on", k as f64, 1.0);
        }
        let full = SAMPLES_IN_ALL / SAMPLES_PER_CHANNEL;
        for k in 1..2 * full {
            board.push(&k.to_string(), 0.0, 1.0);
        }
        let series = &board.channels["silent from now on"].series;
        let times = series.since(&mut Cursor::default(), usize::MAX).times;
        assert_eq!(times.len(), SAMPLES_PER_CHANNEL / 2);
        assert_eq!(times.last(), Some(&(SAMPLES_PER_CHANNEL as f64 - 1.0)));
    }

    #[test]
    fn a_message_is_bounded_and_the_next_ones_have_the_rest() {
        let mut board = Board::default();
        let names = || (0..50).map(|k| (k, format!("channel {k}")));
        let mut reader = Reader::of(names());
        for (_, name) in names() {
            for k in 0..1000 {
                board.push(&name, f64::from(k), 1.0 / 3.0);
            }
        }
        let text = "x".repeat(4096);
        for k in 0..MAX_LOG_LINES + 10 {
            board.log(LogLine {
                time: k as f64,
                level: 20,
                node: String::new(),
                text: text.clone(),
            });
        }
        for k in 0..10 {
            board.put(&format!("section {k}"), json!(vec![&text; 1000]));
        }
        let (mut samples, mut lines, mut sections) = (0, 0, BTreeMap::new());
        loop {
            let message = reader.updates(&board);
            let length = serde_json::to_string(&message).expect("JSON").len();
            assert!(length < 50 * SAMPLES + LOG + SECTIONS + LONGEST_SECTION);
            samples += message.series.iter().map(|it| it.2.len()).sum::<usize>();
            lines += message.log.len();
            sections.extend(message.sections);
            if !reader.is_behind() {
                break;
            }
        }
        assert_eq!(
            (samples, lines, sections.len()),
            (50 * 1000, MAX_LOG_LINES, 10)
        );
        // A longer list has lost its end.
        let told = sections["section 9"].0.as_array().expect("a list").len();
        assert!((200..1000).contains(&told), "{told}");
        assert!(reader.updates(&board).is_empty());
    }
}
