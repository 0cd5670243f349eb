//! One Ctrl-C ends a dive, whatever becomes of its nodes, and says which of them does not listen.
#![allow(clippy::unwrap_used)]

mod stage;

use std::path::Path;
use std::process::Command;

use stage::{Stage, eventually, freeze};

#[test]
fn one_ctrl_c_ends_a_dive_with_a_frozen_vehicle_and_names_it() {
    ends_with_a_frozen("plant_sim");
}

#[test]
fn one_ctrl_c_ends_a_dive_with_a_frozen_identifier_and_names_it() {
    ends_with_a_frozen("sysid");
}

fn ends_with_a_frozen(node: &str) {
    let stage = Stage::new();
    let out = stage.path("out");
    let launcher = stage.start(&["dive", "--keep-running", "--out", &out]);
    eventually("a flight", || {
        launcher.stdout().contains("diving").then_some(())
    });
    let nodes = launcher.nodes();
    freeze(nodes[node]);
    launcher.press_ctrl_c();
    let outcome = launcher.finish();
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    let complaint = outcome.complaints().join("\n");
    assert!(complaint.contains(node), "{complaint}");
    for (name, pid) in nodes {
        assert!(!stage::runs(pid), "{name} is left behind");
    }
}

#[test]
fn ctrl_c_ends_a_dive_that_writes_its_report_too() {
    let stage = Stage::new();
    let out = stage.path("out");
    let launcher = stage.start(&["dive", "--lockstep", "--out", &out]);
    eventually("the dive's folder", || {
        Path::new(&out).join("log").exists().then_some(())
    });
    // The page goes into a pipe that nobody reads: it is never written.
    let page = Path::new(&out).join("report.html");
    assert!(
        Command::new("mkfifo")
            .arg(&page)
            .status()
            .unwrap()
            .success()
    );
    eventually("the end of the flight", || {
        launcher.stdout().contains("Flew").then_some(())
    });
    launcher.press_ctrl_c();
    let outcome = launcher.finish();
    assert_eq!(outcome.status.code(), Some(130), "{outcome:#?}");
    assert!(Path::new(&out).join("bag/metadata.yaml").exists());
}
