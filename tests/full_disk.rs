//! A disk that takes no more ends a flight with an error that names it. Here a limit on the size of files stands for
//! the disk: alone in its file, since it holds for everything that this process starts.
#![allow(clippy::unwrap_used)]

mod stage;

use planesman::run_folder::RunFolder;
use planesman_bag::BagReader;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use stage::{Stage, scenario};

#[test]
fn a_disk_that_takes_no_more_is_named_at_once_and_at_the_end() {
    let now = getrlimit(Resource::Fsize);
    let small = Rlimit {
        current: Some(300_000),
        maximum: now.maximum,
    };
    setrlimit(Resource::Fsize, small).unwrap();
    let stage = Stage::new();
    let text = scenario(
        3600.0,
        "  recorder: {flush_interval: 0.1, chunk_size: 65536}\n",
    );
    let file = stage.file("long.yaml", text);
    let out = stage.path("out");
    let outcome = stage.run(&["dive", &file, "--out", &out]);
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    let complaints = outcome.complaints();
    let last = complaints.last().unwrap();
    for part in ["the recorder has stopped", "bag_0.mcap", "File too large"] {
        assert!(last.contains(part), "{last}");
    }
    let run = RunFolder::open(std::path::Path::new(&out)).unwrap();
    let log = std::fs::read_to_string(run.log("recorder")).unwrap();
    assert!(log.contains("recording has stopped"), "{log}");
    // What was flushed before is readable, and says that it is not whole.
    let bag = BagReader::open(&run.bag()).unwrap();
    assert!(!bag.completeness().is_whole());
    assert!(bag.message_count() > 1000, "{}", bag.message_count());
}
