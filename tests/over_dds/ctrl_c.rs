//! One Ctrl-C ends a dive, whatever becomes of its nodes, and says which of them does not listen.

use crate::stage;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

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
    let launcher = stage.start(&["dive", "--keep-running", "--verbose", "--out", &out]);
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

/// A flight at a terminal of its own, which `script` makes, behind these commands; and the terminal closed in flight.
fn at_a_terminal_that_is_closed(
    stage: &Stage,
    before: &str,
    arguments: &str,
    out: &str,
    flies: &str,
) {
    let program = env!("CARGO_BIN_EXE_planesman");
    let command = format!("exec {before} {program} {arguments} --out out");
    // Whether SIGHUP is ignored is inherited: a suite that runs under nohup must not decide it here.
    let mut script = Command::new("env")
        .args(["--default-signal=HUP", "script"])
        .args(["--quiet", "--command", &command, "/dev/null"])
        .current_dir(stage.path(""))
        .envs(stage.variables())
        .stdin(Stdio::piped())
        .stdout(File::create(stage.path("terminal")).unwrap())
        .spawn()
        .unwrap();
    eventually("a flight", || {
        let said = std::fs::read(stage.path(out)).unwrap_or_default();
        String::from_utf8_lossy(&said).contains(flies).then_some(())
    });
    script.kill().unwrap();
    script.wait().unwrap();
}

#[test]
fn a_dive_that_is_interrupted_before_its_end_has_a_report_and_a_status_that_is_not_0() {
    let stage = Stage::new();
    let operator = stage.operator();
    let file = stage.file("long.yaml", stage::scenario(3600.0, ""));
    let out = stage.path("out");
    let launcher = stage.start(&["dive", &file, "--factor", "4", "--out", &out]);
    operator.state("a flight", |state| {
        state.header.stamp.nanos() > 2_000_000_000
    });
    launcher.press_ctrl_c();
    let outcome = launcher.finish();
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    let complaint = outcome.complaints().join("\n");
    assert!(complaint.contains("of 72000 ticks"), "{complaint}");
    assert!(outcome.stdout.contains("Page: "), "{outcome:#?}");
    assert!(Path::new(&out).join("bag/metadata.yaml").exists());
    assert!(Path::new(&out).join("report.html").exists());
}

/// Ticks of a flight whose simulation leaves its range after some, and the dive's end.
#[test]
fn a_vehicle_that_cannot_go_on_ends_the_dive_with_its_reason_and_what_was_flown() {
    let stage = Stage::new();
    let file = stage.file(
        "secant.yaml",
        "description: A law that is linear where it is none\nduration: 60.0\nparameters:\n  \
         plant_sim: {pitch_damping: secant, speed: 2.5}\n  depth_controller: {mode: open_loop, identification.signal: square, \
         identification.amplitude: 0.3, identification.period: 20.0}\n",
    );
    let out = stage.path("out");
    let outcome = stage.run(&["dive", &file, "--out", &out]);
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    let complaint = outcome.complaints().join("\n");
    for part in [
        "the node plant_sim",
        "the simulation stopped at tick",
        "pitch_damping 'secant'",
    ] {
        assert!(complaint.contains(part), "{complaint}");
    }
    assert!(outcome.stdout.contains("Page: "), "{outcome:#?}");
    assert!(Path::new(&out).join("bag/metadata.yaml").exists());
}

#[test]
fn a_closed_terminal_ends_a_dive_as_ctrl_c_does() {
    let stage = Stage::new();
    at_a_terminal_that_is_closed(&stage, "", "dive --keep-running", "terminal", "s  depth");
    let out = stage.path("out");
    eventually("the report", || {
        Path::new(&out).join("report.html").exists().then_some(())
    });
    assert!(Path::new(&out).join("bag/metadata.yaml").exists());
    assert!(!Path::new(&out).join("failed.txt").exists());
}

#[test]
fn under_nohup_a_dive_goes_on_when_its_terminal_is_closed() {
    let stage = Stage::new();
    at_a_terminal_that_is_closed(
        &stage,
        "nohup",
        "dive --lockstep --verbose",
        "nohup.out",
        "diving",
    );
    let said = stage.path("nohup.out");
    eventually("the end of the flight", || {
        let said = std::fs::read_to_string(&said).unwrap_or_default();
        said.contains("Page: ").then_some(())
    });
    let said = std::fs::read_to_string(said).unwrap();
    assert!(said.contains("Flew 90.0 s"), "{said}");
}

#[test]
fn a_folder_moved_or_removed_in_flight_is_the_reason_that_is_given() {
    let stage = Stage::new();
    for remove in [false, true] {
        let out = stage.path("out");
        let launcher = stage.start(&["dive", "--keep-running", "--verbose", "--out", &out]);
        eventually("a flight", || {
            launcher.stdout().contains("diving").then_some(())
        });
        match remove {
            true => std::fs::remove_dir_all(&out).unwrap(),
            false => std::fs::rename(&out, stage.path("elsewhere")).unwrap(),
        }
        // Nobody has to ask: the recorder finds out at its next flush.
        let outcome = launcher.finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let complaint = outcome.complaints().join("\n");
        assert!(complaint.contains("was moved or removed"), "{complaint}");
    }
}

#[test]
fn ctrl_c_ends_a_dive_that_writes_its_report_too() {
    let stage = Stage::new();
    let out = stage.path("out");
    let launcher = stage.start(&["dive", "--lockstep", "--verbose", "--out", &out]);
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
