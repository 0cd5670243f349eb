//! Machines whose clock is wrong: before 1970, past the end of ROS 2's stamps in 2038, or set in flight. Debian's `faketime` gives
//! the processes such a clock; their monotonic clock stays right.

use crate::faked;
use crate::stage;
use std::path::Path;

use planesman::run_folder::RunFolder;
use planesman_flight::flight::Flight;

use stage::{Outcome, Process, Stage, eventually, scenario};

/// Vehicle time of a flight, s, and its ticks.
const SECONDS: f64 = 10.0;
const TICKS: u64 = 200;

/// A dive on a clock of which `time`, as faketime writes it, says what it shows.
fn dive(stage: &Stage, library: &str, time: &str, pace: &[&str]) -> Process {
    let flight = stage.file("flight.yaml", scenario(SECONDS, "  sysid: {start: 1.0}\n"));
    let variables = faked::variables(stage, library, time);
    let variables = variables
        .each_ref()
        .map(|(name, value)| (*name, value.as_str()));
    stage.start_as(
        &[&["dive", &flight, "--out", "run"], pace].concat(),
        &variables,
    )
}

fn ends(time: &str, pace: &[&str]) -> Option<(Stage, Outcome)> {
    let library = faked::library()?;
    let stage = Stage::new();
    let outcome = dive(&stage, &library, time, pace).finish();
    Some((stage, outcome))
}

fn ticks(stage: &Stage) -> u64 {
    let run = RunFolder::open(Path::new(&stage.path("run"))).unwrap();
    Flight::read(&run.bag()).unwrap().counts["/auv/state"]
}

#[test]
fn a_clock_before_1970_is_refused_in_a_sentence() {
    let Some((_, outcome)) = ends("@1969-12-30 00:00:00", &[]) else {
        return;
    };
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    let sentence =
        "planesman: this machine's clock is before 1970, where DDS timestamps begin: set it";
    assert!(outcome.stderr.contains(sentence), "{outcome:#?}");
    assert!(!outcome.stderr.contains("panicked"), "{outcome:#?}");
}

#[test]
fn a_clock_beyond_the_middlewares_timestamps_is_refused_in_a_sentence() {
    for time in ["@2262-05-01 00:00:00", "@2555-01-01 00:00:00"] {
        let Some((_, outcome)) = ends(time, &[]) else {
            return;
        };
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let sentence = "planesman: this machine's clock is past 2262-04-11";
        assert!(outcome.stderr.contains(sentence), "{outcome:#?}");
    }
}

#[test]
fn a_flight_by_the_machines_time_ends_with_the_reason_where_stamps_end() {
    // Five seconds before, in a flight of ten.
    let Some((_, outcome)) = ends("@2038-01-19 03:14:02", &["--factor", "1"]) else {
        return;
    };
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
    assert!(
        outcome.stderr.contains("the end of ROS 2 stamps"),
        "{outcome:#?}"
    );
}

#[test]
fn after_2038_a_flight_in_simulated_time_is_as_ever() {
    let Some((stage, outcome)) = ends("@2050-01-01 00:00:00", &[]) else {
        return;
    };
    outcome.success();
    assert_eq!(ticks(&stage), TICKS);
}

#[test]
fn a_clock_that_is_set_in_flight_is_told_and_every_tick_is_flown() {
    let Some(library) = faked::library() else {
        return;
    };
    let stage = Stage::new();
    let operator = stage.operator();
    let dive = dive(&stage, &library, "+0", &["--factor", "1"]);
    let log = Path::new(&stage.path("run")).join("log/plant_sim.log");
    let told = |what: &str| {
        let text = std::fs::read_to_string(&log).unwrap_or_default();
        text.contains(what).then_some(())
    };
    operator.state("a flight", |_| true);
    stage.file("clock", "+3600\n");
    eventually("a word on the jump", || told("clock was set forward"));
    stage.file("clock", "+0\n");
    eventually("a word on the way back", || {
        told("the clock was set back by")
    });
    dive.finish().success();
    assert_eq!(ticks(&stage), TICKS);
}
