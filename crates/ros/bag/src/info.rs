//! Text summary of a bag, as printed by `planesman bag info`.

use std::{collections::BTreeMap, fmt, path::PathBuf};

use crate::{BagReader, Completeness, Topic, reader::TopicCount};

/// Summary of a bag.
#[derive(Clone, Debug, PartialEq)]
pub struct BagInfo {
    /// Path that was opened.
    pub path: PathBuf,
    /// Number of `.mcap` or `.db3` files.
    pub files: usize,
    /// Total size of the files, bytes.
    pub bytes: u64,
    /// First log time, ns; `None` without messages.
    pub start: Option<i64>,
    /// Time from the first to the last log time, s.
    pub duration: f64,
    /// Number of messages on all topics.
    pub messages: u64,
    /// Number of messages that the recorder reported as lost.
    pub dropped: u64,
    /// Lost messages by topic.
    pub dropped_by_topic: BTreeMap<String, u64>,
    /// All topics by name, without omitted topics.
    pub topics: Vec<TopicCount>,
    /// Number of topics omitted because of the memory limit.
    pub omitted: u64,
    /// Whether later messages may be missing.
    pub completeness: Completeness,
    /// Files listed in the metadata that do not exist.
    pub renamed: Option<String>,
}

impl BagInfo {
    /// Makes the summary of an open bag.
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
        writeln!(f, "status    {}", self.completeness)?;
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
            write!(
                f,
                "\n  and {} more topics (not counted, because of the memory limit)",
                self.omitted
            )?;
        }
        Ok(())
    }
}

/// Size printed in a suitable unit.
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
