//! A bag's summary as text: the output of `planesman bag info`.

use std::{collections::BTreeMap, fmt, path::PathBuf};

use crate::{BagReader, Completeness, Topic, reader::TopicCount};

/// The contents of a bag, in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct BagInfo {
    /// The path that was opened.
    pub path: PathBuf,
    /// Its `.mcap` files.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// The first log time, in nanoseconds; `None` without messages.
    pub start: Option<i64>,
    /// From the first log time to the last, in seconds.
    pub duration: f64,
    /// Messages on all topics.
    pub messages: u64,
    /// Messages that the recorder knew to be lost.
    pub dropped: u64,
    /// Those on each topic.
    pub dropped_by_topic: BTreeMap<String, u64>,
    /// Every topic, by name, but for the omitted.
    pub topics: Vec<TopicCount>,
    /// Topics for which there was no room.
    pub omitted: u64,
    /// Whether later messages may be missing.
    pub completeness: Completeness,
    /// What the metadata names that is not there.
    pub renamed: Option<String>,
}

impl BagInfo {
    /// The summary of an open bag.
    #[must_use]
    pub fn of(bag: &BagReader) -> Self {
        let mut topics = bag.topics().to_vec();
        topics.sort_by(|a, b| a.topic.name.cmp(&b.topic.name));
        Self {
            path: bag.path().to_owned(),
            files: bag.files().count(),
            bytes: bag.files().map(|(_, bytes)| bytes).sum(),
            start: bag.span().map(|(first, _)| first),
            duration: bag.span().map_or(0.0, |(first, last)| {
                last.saturating_sub(first) as f64 * 1e-9
            }),
            messages: bag.message_count(),
            dropped: bag.dropped(),
            dropped_by_topic: bag
                .dropped_by_topic()
                .map(|(topic, count)| (topic.to_owned(), count))
                .collect(),
            topics,
            omitted: bag.omitted(),
            completeness: bag.completeness().clone(),
            renamed: bag.renamed().map(str::to_owned),
        }
    }
}

impl fmt::Display for BagInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "bag       {}", self.path.display())?;
        writeln!(f, "complete  {}", self.completeness)?;
        if let Some(renamed) = &self.renamed {
            writeln!(f, "note      {renamed}")?;
        }
        let plural = if self.files == 1 { "" } else { "s" };
        writeln!(
            f,
            "size      {} in {} file{plural}",
            Bytes(self.bytes),
            self.files
        )?;
        if let Some(start) = self.start {
            writeln!(f, "start     {:.3} s", start as f64 * 1e-9)?;
        }
        writeln!(f, "duration  {:.3} s", self.duration)?;
        write!(f, "messages  {}", self.messages)?;
        if self.dropped > 0 {
            write!(f, ", and {} lost while recording", self.dropped)?;
        }
        let wide = |part: fn(&Topic) -> &str| {
            let lengths = self.topics.iter().map(|it| part(&it.topic).len());
            lengths.max().unwrap_or(0)
        };
        let name = wide(|topic| &topic.name);
        let type_name = wide(|topic| &topic.kind.type_name);
        for TopicCount { topic, messages } in &self.topics {
            write!(
                f,
                "\n  {:name$}  {:type_name$}  {messages:>8}",
                topic.name, topic.kind.type_name
            )?;
            if let Some(lost) = self.dropped_by_topic.get(&topic.name) {
                write!(f, ", and {lost} lost")?;
            }
        }
        let listed = |name: &str| self.topics.iter().any(|it| it.topic.name == name);
        for (topic, lost) in &self.dropped_by_topic {
            if !listed(topic) {
                write!(f, "\n  {topic}: {lost} lost, none recorded")?;
            }
        }
        if self.omitted > 0 {
            write!(f, "\n  and {} topics more than are listed", self.omitted)?;
        }
        Ok(())
    }
}

/// Bytes in the unit that suits.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 3] = ["KiB", "MiB", "GiB"];
        if self.0 < 1024 {
            return write!(f, "{} bytes", self.0);
        }
        let mut size = self.0 as f64 / 1024.0;
        let mut unit = 0;
        while size >= 1024.0 && unit + 1 < UNITS.len() {
            size /= 1024.0;
            unit += 1;
        }
        write!(f, "{size:.1} {}", UNITS[unit])
    }
}
