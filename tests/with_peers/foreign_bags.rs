//! Foreign readers read what the main job has recorded: `rosbags` and `mcap`, from Python, find what the nodes
//! say they sent and what our own reader finds, also in the bag of a recorder that was killed.
//!
//! Where `.venv` is absent these tests pass, saying what they skipped (tests/README.md).

use crate::foreign;
use crate::stage;
use std::{collections::BTreeMap, fs, path::Path};

use foreign::{Python, full_name};
use planesman::run_folder::RunFolder;
use planesman_bag::BagReader;
use planesman_flight::nodes::NODES;
use planesman_node::ExitReport;
use serde_json::Value;
use stage::{Stage, eventually, scenario};

/// Messages by topic.
type Counts = BTreeMap<String, u64>;

/// The result of a foreign reader.
fn found(report: &Value) -> Counts {
    let topics = report["topics"].as_object().unwrap();
    let count = |topic: &Value| topic["count"].as_u64().unwrap();
    topics
        .iter()
        .map(|(name, topic)| (name.clone(), count(topic)))
        .collect()
}

/// The result of our own reader.
fn ours(bag: &BagReader) -> Counts {
    let count =
        |topic: &planesman_bag::reader::TopicCount| (topic.topic.name.clone(), topic.messages);
    bag.topics().iter().map(count).collect()
}

/// The exit reports of the nodes.
fn published(run: &RunFolder) -> Counts {
    let mut sum = Counts::new();
    for node in NODES {
        let report = fs::read(run.exit_report(node)).unwrap();
        let report: ExitReport = serde_json::from_slice(&report).unwrap();
        for (topic, count) in report.published {
            *sum.entry(topic).or_default() += count;
        }
    }
    sum
}

#[test]
fn a_dives_bag_is_read_by_rosbags_and_mcap_with_every_message_that_was_sent() {
    let Some(python) = Python::find() else { return };
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(5.0, "  sysid: {start: 0.0}\n"));
    let out = stage.path("out");
    stage.run(&["dive", &file, "--out", &out]).success();
    let run = RunFolder::open(Path::new(&out)).unwrap();

    let report = python.read_bag(&[&run.bag()]);
    assert_eq!(report["closed"], true);
    let bag = BagReader::open(&run.bag()).unwrap();
    assert!(bag.completeness().is_whole());
    let found = found(&report);
    assert_eq!(found, ours(&bag));
    let published = published(&run);
    assert!(published.len() >= 14, "{published:?}");
    for (topic, count) in published {
        assert_eq!(found.get(&topic), Some(&count), "{topic}");
    }
    assert_eq!(found["/auv/state"], 100);

    // Each computes the type hash from the definition in the bag, and decodes by it.
    for topic in planesman_msgs::loop_topics::ALL {
        let name = full_name(topic.name);
        if let Some(read) = report["topics"].get(&name) {
            assert_eq!(read["type"], topic.info.type_name, "{name}");
            assert_eq!(read["type_hash"], topic.info.type_hash, "{name}");
        }
    }
    let first = &report["topics"]["/auv/state"]["values"][0];
    assert_eq!(first["depth"], 0.0);
    assert_eq!(first["surge"], 0.3048);
}

#[test]
fn a_killed_recorders_bag_gives_mcap_as_much_as_it_gives_us() {
    let Some(python) = Python::find() else { return };
    let stage = Stage::new();
    let out = stage.path("bag");
    let output = format!("output:={out}");
    let recorder = stage.node(
        "recorder",
        &[&output, "flush_interval:=0.2", "chunk_size:=4096"],
    );
    let _plant = stage.node("plant_sim", &["factor:=10.0"]);
    eventually("two hundred messages in the file", || {
        let bag = BagReader::open(Path::new(&out)).ok()?;
        (bag.message_count() > 200).then_some(())
    });
    recorder.kill();

    let bag = BagReader::open(Path::new(&out)).unwrap();
    assert!(!bag.completeness().is_whole());
    let (file, _) = bag.files().next().unwrap();
    let report = python.read_bag(&[Path::new("--mcap-only"), file]);
    assert_eq!(report["closed"], false);
    assert_eq!(found(&report), ours(&bag));

    // Cut within what it had flushed, each still gives the chunks before the cut.
    let bytes = fs::read(file).unwrap();
    let cut = stage.file("cut.mcap", &bytes[..bytes.len() * 2 / 3]);
    let less = BagReader::open(Path::new(&cut)).unwrap();
    assert!(less.message_count() > 0 && less.message_count() < bag.message_count());
    let report = python.read_bag(&[Path::new("--mcap-only"), Path::new(&cut)]);
    assert_eq!(found(&report), ours(&less));
}
