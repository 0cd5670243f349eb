//! `planesman bag info`: a bag's contents, and the published messages that it lacks.
//!
//! A bag alone knows only what its recorder missed. The bag of a dive lies beside the accounts that the nodes left of what
//! they published; it is held against those.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::Result;
use planesman_bag::{BagInfo, BagReader, Order, is_bag_file};
use sha2::{Digest as _, Sha256};

use crate::run_folder::{Loss, RunFolder};
use planesman_flight::flight::recorded;
use planesman_flight::nodes::NODES;
use planesman_pages::flights::Count;

/// Prints what the bag at `path` holds and lacks.
///
/// # Errors
/// When there is no bag that can be read.
pub fn info(path: &Path) -> Result<()> {
    let bag = BagReader::open(path)?;
    planesman_console::out!("{}", BagInfo::of(&bag))?;
    if let Some(run) = run_of(path) {
        let silent = NODES
            .iter()
            .filter(|node| !run.exit_report(node).is_file())
            .copied();
        let silent: Vec<&str> = silent.collect();
        let counts = run.counts(&recorded(&bag), &run.scenario()?)?;
        planesman_console::out!("{}", lack(&counts, &silent))?;
    }
    Ok(())
}

/// Topics that carry wall time, whatever the loop does.
const OF_WALL_TIME: [&str; 3] = ["/diagnostics", "/parameter_events", "/rosout"];

/// Prints the SHA-256 of each topic's payloads, in the order in which they were recorded, each filled up with zeros to whole words
/// as it is on its way (RTPS 2.3, 9.4.1); then one of the lines of all topics without wall time.
///
/// # Errors
/// When there is no bag that can be read, or not all of it.
pub fn hashes(path: &Path) -> Result<()> {
    let bag = BagReader::open(path)?;
    let mut topics: BTreeMap<String, Sha256> = BTreeMap::new();
    for message in bag.messages(Order::File) {
        let message = message?;
        let hash = topics.entry(message.topic.name.clone()).or_default();
        hash.update(&message.payload);
        hash.update(&[0; 3][..message.payload.len().wrapping_neg() % 4]);
    }
    let mut of_loop = Sha256::new();
    for (name, hash) in topics {
        let line = format!("{:x} {}\n", hash.finalize(), planesman_text::shown(&name));
        planesman_console::out!("{}", line.trim_end())?;
        if !OF_WALL_TIME.contains(&name.as_str()) {
            of_loop.update(line);
        }
    }
    planesman_console::out!(
        "{:x} all but {}",
        of_loop.finalize(),
        OF_WALL_TIME.join(", ")
    )?;
    Ok(())
}

/// The dive whose whole bag is at `path`.
fn run_of(path: &Path) -> Option<RunFolder> {
    let path = fs::canonicalize(path).ok()?;
    let bag = if path.is_dir() { &path } else { path.parent()? };
    let is_one_file_of_it = is_bag_file(&path);
    let run = RunFolder::open(bag.parent()?).ok()?;
    (!is_one_file_of_it && run.bag() == bag).then_some(run)
}

/// The published messages that are not in the bag; the `silent` nodes left no exit report.
fn lack(counts: &BTreeMap<String, Count>, silent: &[&str]) -> String {
    let published: u64 = counts.values().filter_map(|count| count.published).sum();
    let mut said = match Loss::of(counts) {
        Some(loss) => loss.to_string(),
        None if published == 0 => "published unknown: no node left an exit report".to_owned(),
        None => format!("published {published}, all of which it holds"),
    };
    if published > 0 && !silent.is_empty() {
        said += &format!("\nno exit report of {}", silent.join(", "));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_bag_lacks_is_reported_by_topic_and_who_said_nothing_is_named() {
        let count = |published, recorded| Count {
            published,
            recorded,
        };
        let whole = BTreeMap::from([
            ("/a".to_owned(), count(Some(3), 3)),
            ("/b".to_owned(), count(None, 7)),
        ]);
        assert_eq!(lack(&whole, &[]), "published 3, all of which it holds");
        let mut holed = whole;
        holed.insert("/c".to_owned(), count(Some(10), 8));
        assert_eq!(
            lack(&holed, &["sysid"]),
            "the bag lacks 2 of 13 messages that were published: /c 2 of 10\nno exit report of sysid"
        );
        assert!(lack(&BTreeMap::new(), &NODES).contains("unknown"));
    }
}
