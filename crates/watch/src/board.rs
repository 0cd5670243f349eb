//! What is known of the domain: written by the node, read by every page that is open.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde_json::Value;

use crate::series::{Cursor, Series};

/// Log lines kept.
const LINES: usize = 2000;
/// Samples of a channel in one message to a page; the next message has the next ones.
const SAMPLES: usize = 20_000;
/// Log lines in one message.
const LINES_AT_ONCE: usize = 500;

/// A line of `/rosout`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Line {
    /// The machine's time at which it came, s.
    pub(crate) time: f64,
    pub(crate) level: u8,
    pub(crate) node: String,
    pub(crate) text: String,
}

/// Why a channel has no samples, if there is a reason, and its samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Channel {
    pub(crate) series: Series,
    pub(crate) refusal: Option<String>,
}

/// A part of the page that is sent whole when it has changed.
#[derive(Clone, Debug)]
struct Section {
    version: u64,
    value: Arc<Value>,
}

/// Everything the pages show.
#[derive(Clone, Debug, Default)]
pub(crate) struct Board {
    channels: BTreeMap<String, Channel>,
    sections: BTreeMap<String, Section>,
    version: u64,
    lines: VecDeque<Line>,
    /// Lines that came before those kept.
    forgotten: u64,
}

/// The board as node and server share it.
pub(crate) type SharedBoard = Arc<Mutex<Board>>;

/// The board for writing or reading; a thread that panicked with it left it whole enough.
pub(crate) fn locked(board: &SharedBoard) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Board {
    /// The channel of that name, which is made if need be.
    pub(crate) fn channel(&mut self, name: &str) -> &mut Channel {
        if !self.channels.contains_key(name) {
            self.channels.insert(name.to_owned(), Channel::default());
        }
        self.channels.entry(name.to_owned()).or_default()
    }

    /// Takes a sample of a channel.
    pub(crate) fn push(&mut self, name: &str, time: f64, value: f64) {
        match self.channels.get_mut(name) {
            Some(channel) => channel.series.push(time, value),
            None => self.channel(name).series.push(time, value),
        }
    }

    /// Begins the channels of a vehicle anew: it was put back to its initial state at that time, s.
    pub(crate) fn begin_anew(&mut self, time: f64, is_its: impl Fn(&str) -> bool) {
        let channels = self.channels.iter_mut();
        for (_, channel) in channels.filter(|(name, _)| is_its(name)) {
            channel.series.begin_anew(Some(time));
        }
    }

    /// Puts up a section in place of what stood there.
    pub(crate) fn put(&mut self, name: &str, value: Value) {
        if self.sections.get(name).is_some_and(|it| *it.value == value) {
            return;
        }
        self.version += 1;
        let section = Section {
            version: self.version,
            value: Arc::new(value),
        };
        self.sections.insert(name.to_owned(), section);
    }

    /// The section of that name.
    pub(crate) fn section(&self, name: &str) -> Option<&Value> {
        Some(&*self.sections.get(name)?.value)
    }

    /// Takes a line of the log.
    pub(crate) fn log(&mut self, line: Line) {
        if self.lines.len() == LINES {
            self.lines.pop_front();
            self.forgotten += 1;
        }
        self.lines.push_back(line);
    }
}

/// What one page has been told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reader {
    channels: Vec<(String, Cursor, Option<String>)>,
    version: u64,
    lines: u64,
}

/// A message to a page: what is new since the last one.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Message {
    /// Number of the channel, whether it begins anew, times and values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    series: Vec<(usize, bool, Vec<f64>, Vec<f64>)>,
    /// Number of the channel, and why it has no samples; nothing once it has.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    refused: Vec<(usize, Option<String>)>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    sections: BTreeMap<String, Value>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    log: Vec<Line>,
}

impl Message {
    /// Whether there is nothing to tell.
    pub(crate) fn is_empty(&self) -> bool {
        self.series.is_empty()
            && self.refused.is_empty()
            && self.sections.is_empty()
            && self.log.is_empty()
    }
}

impl Reader {
    /// A page that shows these channels, and has been told nothing yet.
    pub(crate) fn of(channels: impl Iterator<Item = String>) -> Self {
        Self {
            channels: channels
                .map(|name| (name, Cursor::default(), None))
                .collect(),
            version: 0,
            lines: 0,
        }
    }

    /// What is new for this page.
    pub(crate) fn news(&mut self, board: &Board) -> Message {
        let mut message = Message::default();
        for (index, (name, cursor, told)) in self.channels.iter_mut().enumerate() {
            let Some(channel) = board.channels.get(name) else {
                continue;
            };
            let news = channel.series.since(cursor, SAMPLES);
            if news.restarted || !news.times.is_empty() {
                let one = (index, news.restarted, news.times, news.values);
                message.series.push(one);
            }
            if *told != channel.refusal {
                told.clone_from(&channel.refusal);
                message.refused.push((index, channel.refusal.clone()));
            }
        }
        for (name, section) in &board.sections {
            if section.version > self.version {
                let value = Value::clone(&section.value);
                message.sections.insert(name.clone(), value);
            }
        }
        self.version = board.version;
        let skipped = usize::try_from(self.lines.saturating_sub(board.forgotten)).unwrap_or(0);
        let lines = board.lines.iter().skip(skipped).take(LINES_AT_ONCE);
        message.log = lines.cloned().collect();
        self.lines = self.lines.max(board.forgotten) + message.log.len() as u64;
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
        let mut reader = Reader::of(["a".to_owned(), "b".to_owned()].into_iter());
        board.push("b", 1.0, 2.0);
        board.push("elsewhere", 1.0, 2.0);
        board.put("graph", json!({"nodes": 1}));
        board.channel("a").refusal = Some("no such field".to_owned());
        board.log(Line {
            time: 0.0,
            level: 20,
            node: "n".to_owned(),
            text: "up".to_owned(),
        });
        let text = serde_json::to_string(&reader.news(&board)).expect("JSON");
        assert_eq!(
            text,
            r#"{"series":[[1,false,[1.0],[2.0]]],"refused":[[0,"no such field"]],"sections":{"graph":{"nodes":1}},"log":[{"time":0.0,"level":20,"node":"n","text":"up"}]}"#
        );
        board.put("graph", json!({"nodes": 1}));
        assert!(reader.news(&board).is_empty());
        board.channel("a").refusal = None;
        assert_eq!(reader.news(&board).refused, [(0, None)]);
    }
}
