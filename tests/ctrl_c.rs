//! One Ctrl-C ends a dive, whatever becomes of its nodes, and says which of them does not listen.
#![allow(clippy::unwrap_used)]

mod stage;

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
