//! `planesman bag info`: the contents of a bag and its missing messages; `planesman bag diff`: the differences between two recordings.
//!
//! A bag alone shows only the messages that its recorder missed. In the folder of a dive the nodes also leave exit reports with the number of
//! messages that they published; the bag's counts are compared with those.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use planesman_bag::{BagInfo, BagReader, Order, is_bag_file};
use sha2::{Digest as _, Sha256};

use crate::arguments::page_file;
use crate::run_folder::{Loss, RunFolder};
use planesman_console::{Format, print_wrapped};
use planesman_decode::{StampDecoder, Values};
use planesman_flight::flight::recorded;
use planesman_flight::nodes::NODES;
use planesman_flight::sink::{COLUMNS, write_text};
use planesman_show::diff::{
    CanonicalOrder, ColumnOf, Comparison, Options, Rule, Tolerance, WALL_TIME, diff, histories,
    stamp_decoder,
};
use planesman_show::pages::flights::Count;

/// Prints the contents of the bag at `path`, and which messages are missing.
///
/// # Errors
/// There is no readable bag at `path`.
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

/// Prints the SHA-256 of each topic's payloads in the order of their stamps (without stamps: as recorded). Each payload is padded with zeros
/// to whole words, as in transit (RTPS 2.3, 9.4.1). The last hash is over the lines of all topics that have no wall time.
///
/// # Errors
/// There is no readable bag at `path`, or part of it cannot be read.
pub fn hashes(path: &Path) -> Result<()> {
    let bag = BagReader::open(path)?;
    let mut values = Values::default();
    let mut topics: BTreeMap<String, TopicHash> = BTreeMap::new();
    for message in bag.messages(Order::File) {
        let message = message?;
        let topic = topics.entry(message.topic.name.clone()).or_insert_with(|| {
            let types = planesman_signals::types(&bag, &message.topic).ok();
            TopicHash {
                stamp: types.as_ref().and_then(stamp_decoder),
                ..TopicHash::default()
            }
        });
        let decoder = topic.stamp.as_ref();
        let stamp = decoder.and_then(|it| it.read(&message.payload, &mut values));
        match stamp {
            Some(stamp) => (topic.order).push(stamp, message.payload, digest(&mut topic.hash)),
            None => digest(&mut topic.hash)(&message.payload),
        }
    }
    let mut of_loop = Sha256::new();
    for (name, topic) in topics {
        let TopicHash {
            order, mut hash, ..
        } = topic;
        order.end(digest(&mut hash));
        let line = format!("{:x} {}\n", hash.finalize(), planesman_text::shown(&name));
        planesman_console::out!("{}", line.trim_end())?;
        if !WALL_TIME.contains(&name.as_str()) {
            of_loop.update(line);
        }
    }
    planesman_console::out!("{:x} all but {}", of_loop.finalize(), WALL_TIME.join(", "))?;
    Ok(())
}

/// Running hash of one topic.
#[derive(Default)]
struct TopicHash {
    stamp: Option<StampDecoder>,
    order: CanonicalOrder,
    hash: Sha256,
}

/// A callback that adds payloads to a hash.
fn digest(hash: &mut Sha256) -> impl FnMut(&[u8]) + '_ {
    |payload| {
        hash.update(payload);
        hash.update(&[0; 3][..payload.len().wrapping_neg() % 4]);
    }
}

/// The folder of the dive that recorded the bag at `path`, if that is the dive's complete bag.
fn run_of(path: &Path) -> Option<RunFolder> {
    let path = fs::canonicalize(path).ok()?;
    let bag = if path.is_dir() { &path } else { path.parent()? };
    let is_one_file_of_it = is_bag_file(&path);
    let run = RunFolder::open(bag.parent()?).ok()?;
    (!is_one_file_of_it && run.bag() == bag).then_some(run)
}

/// The published messages that are missing in the bag. `silent`: nodes without an exit report.
fn lack(counts: &BTreeMap<String, Count>, silent: &[&str]) -> String {
    let published: u64 = counts.values().filter_map(|count| count.published).sum();
    let mut said = match Loss::of(counts) {
        Some(loss) => loss.to_string(),
        None if published == 0 => {
            "number of published messages unknown: no node left an exit report".to_owned()
        }
        None => format!("published {published}, all in the bag"),
    };
    if published > 0 && !silent.is_empty() {
        said += &format!("\nno exit report from {}", silent.join(", "));
    }
    said
}

/// The two recordings, and rules for what counts as a difference.
#[derive(Args)]
pub struct DiffArgs {
    /// A bag folder, a metadata.yaml, an .mcap or .db3 file, or a table as `planesman sim --out x.csv` writes it
    a: PathBuf,
    /// The other recording
    b: PathBuf,
    #[command(flatten)]
    rules: RuleArgs,
    /// Pair the messages of a topic by their index instead of by their stamps
    #[arg(long)]
    by_index: bool,
    /// Limit of the unpacked size of each file, MB: a small file can unpack to thousands of times its size
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    most_unpacked: Option<u32>,
    /// Write an HTML page with the differing fields over time
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    html: Option<PathBuf>,
    /// Format of the table of topics [default: table, with the first difference]
    #[arg(long, value_parser = crate::arguments::format())]
    format: Option<Format>,
}

/// Rules for what counts as a difference.
#[derive(Args, Clone)]
pub struct RuleArgs {
    /// Tolerance of a field's numbers, such as state:depth=1e-9; * matches any characters of a topic, COLUMN=VALUE is for tables
    #[arg(long, value_name = "TOPIC:FIELD=VALUE", value_parser = str::parse::<Tolerance>)]
    tolerance: Vec<Tolerance>,
    /// Do not compare this topic or field; its differences are only counted
    #[arg(long, value_name = "TOPIC[:FIELD]", value_parser = str::parse::<Rule>)]
    ignore: Vec<Rule>,
    /// Also compare /diagnostics, /rosout and /parameter_events, which contain wall-clock time
    #[arg(long)]
    all: bool,
}

impl RuleArgs {
    /// The rules of the comparison. `columns`: the columns of a flight's table.
    pub(crate) fn options<'c>(&self, columns: &'c [ColumnOf<'c>]) -> Options<'c> {
        Options {
            tolerances: self.tolerance.clone(),
            ignored: self.ignore.clone(),
            all: self.all,
            columns,
            ..Options::default()
        }
    }
}

/// Compares two recordings and prints where they differ. Returns whether they are equal.
///
/// # Errors
/// A recording that cannot be read, a rule that matches no topic or field, a page that cannot be written.
pub fn compare(args: &DiffArgs) -> Result<bool> {
    let columns: Vec<ColumnOf<'_>> = COLUMNS.iter().map(|it| (it.0, it.1)).collect();
    let mut options = args.rules.options(&columns);
    options.by_index = args.by_index;
    options.most_unpacked = args.most_unpacked.map(|it| u64::from(it) * 1_000_000);
    let working = planesman_console::progress::spinner("messages");
    let found = diff(&args.a, &args.b, &options);
    working.finish_and_clear();
    let found = found?;
    if let Some(path) = &args.html {
        /// Number of fields per topic that are plotted.
        const DRAWN: usize = 3;
        let drawn = histories([&args.a, &args.b], &options, &found, DRAWN)?;
        write_text(path, planesman_show::pages::diff::page(&found, &drawn))?;
    }
    print(&found, args.format)?;
    if let Some(path) = &args.html {
        planesman_console::err!("{}", planesman_console::file_line("Page", path));
    }
    Ok(found.is_equal())
}

/// Prints the first difference and the table; in a machine-readable format only the table.
pub(crate) fn print(found: &Comparison, format: Option<Format>) -> Result<()> {
    if let Some(format @ (Format::Csv | Format::Json | Format::Md)) = format {
        return Ok(planesman_console::print(found.table().text(format))?);
    }
    print_wrapped(format_args!("{}\n", found.headline()))?;
    for remark in found.remarks() {
        print_wrapped(format_args!("{remark}\n"))?;
    }
    let table = found.short_table().text(Format::Table);
    Ok(planesman_console::print(format_args!("\n{table}"))?)
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
        assert_eq!(lack(&whole, &[]), "published 3, all in the bag");
        let mut holed = whole;
        holed.insert("/c".to_owned(), count(Some(10), 8));
        assert_eq!(
            lack(&holed, &["sysid"]),
            "the bag lacks 2 of 13 published messages: /c 2 of 10\nno exit report from sysid"
        );
        assert!(lack(&BTreeMap::new(), &NODES).contains("unknown"));
    }
}
