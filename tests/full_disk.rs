//! A disk that takes no more ends a flight with an error that names it. Here a limit on the size of files stands for
//! the disk: alone in its file, since it holds for everything that this process starts.
#![allow(clippy::unwrap_used)]

mod stage;

use std::path::Path;

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
    for part in ["the recorder stopped", "bag_0.mcap", "File too large"] {
        assert!(last.contains(part), "{last}");
    }
    let run = RunFolder::open(Path::new(&out)).unwrap();
    let log = std::fs::read_to_string(run.log("recorder")).unwrap();
    assert!(log.contains("recording has stopped"), "{log}");
    // What was flushed before is readable, and says that it is not whole.
    let bag = BagReader::open(&run.bag()).unwrap();
    assert!(!bag.completeness().is_whole());
    assert!(bag.message_count() > 1000, "{}", bag.message_count());
}

#[test]
fn a_page_or_a_table_that_a_disk_does_not_take_is_named_and_nothing_of_it_is_left() {
    let stage = Stage::new();
    stage.file("short.yaml", scenario(30.0, "  {}"));
    let small = ["bash", "-c", "ulimit -f 16 && exec \"$@\"", "bash"].map(str::to_owned);
    let data = stage.path("data.csv");
    stage.run(&["sim", "short.yaml", "--out", &data]).success();
    let fit = "sysid fit data.csv -i dive_planes -o pitch_rate --order 2 --quiet --html";
    for (command, file) in [
        ("sim short.yaml --out", "flight.csv"),
        ("design analyse --html", "loop.html"),
        ("design locus --vary depth_p --to 2 --html", "locus.html"),
        (fit, "model.html"),
    ] {
        let before = stage.content();
        let file = stage.path(file);
        let arguments: Vec<&str> = command.split(' ').chain([file.as_str()]).collect();
        let outcome = stage.start_at(&small, &arguments, &[]).finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let complaints = outcome.complaints();
        let last = complaints.last().unwrap();
        let says = format!("planesman: cannot write '{file}': File too large");
        assert!(last.contains(&says), "{last}");
        assert_eq!(stage.content(), before, "{command}");
    }
}
