//! The main job, as a user starts it: six processes over DDS dive the vehicle three feet
//! and tell what came of it.

use crate::recorded;
use crate::stage;
use std::path::Path;

use planesman::run_folder::RunFolder;
use planesman_bag::BagReader;
use planesman_flight::flight::Flight;
use planesman_flight::nodes::NODES;
use planesman_flight::scenario::Scenario;
use planesman_flight::summary::{POLE_TOLERANCE, Summary};
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_node::ExitReport;
use planesman_testing::content;
use stage::{Stage, scenario};

/// Three feet, m.
const DEPTH: f64 = 0.9144;

#[test]
fn the_main_job_dives_three_feet_and_identifies_the_vehicle() {
    let stage = Stage::new();
    let out = stage.path("dive");
    let outcome = stage.run(&["dive", "--out", &out]).success();
    assert_eq!(outcome.complaints(), [""; 0]);

    let scenario = Scenario::load("dive").unwrap();
    let run = RunFolder::open(Path::new(&out)).unwrap();
    let flight = Flight::read(&run.bag()).unwrap();
    let summary = Summary::new(&flight, &scenario).unwrap();

    the_vehicle_reaches_its_depth(&summary);
    the_dominant_pole_is_identified(&summary);
    the_bag_is_whole(&run, &scenario);
    nothing_is_lost(&run, &flight);
    the_page_needs_nothing_else(&run);
    // The terminal shows the result first, in a screen, and what the bag holds when it is asked.
    let result = summary.conclusions().join(" ") + " All ";
    assert!(outcome.stdout.starts_with(&result), "{outcome:#?}");
    assert!(outcome.stdout.lines().count() <= 16, "{outcome:#?}");
    let told = stage.run(&["report", &out, "--verbose"]).success().stdout;
    assert!(told.contains(&summary.model_lines()), "{told}\n{summary:?}");
}

fn the_vehicle_reaches_its_depth(summary: &Summary) {
    assert_eq!(summary.depth_setpoint, DEPTH);
    let depth = summary.depth.as_ref().unwrap();
    assert!(depth.overshoot <= 0.1, "{depth:?}");
    assert!(depth.steady_error.abs() < 0.01 * DEPTH, "{depth:?}");
    assert!(depth.settling_time.is_some(), "{depth:?}");
    // It is judged until the test signal begins.
    assert_eq!(summary.judged, [0.0, 45.0]);
    assert!(!summary.is_disturbed);
    assert_eq!(summary.held_ticks, 0);
}

fn the_dominant_pole_is_identified(summary: &Summary) {
    let error = summary.pole_error().unwrap();
    assert!(error <= POLE_TOLERANCE, "{error}: {summary:?}");
}

fn the_bag_is_whole(run: &RunFolder, scenario: &Scenario) {
    let bag = BagReader::open(&run.bag()).unwrap();
    assert!(bag.completeness().is_whole(), "{}", bag.completeness());
    assert_eq!(bag.dropped(), 0);
    let states = recorded::messages::<VehicleState>(&run.bag(), "/auv/state").unwrap();
    let mut stamps: Vec<i64> = states.iter().map(|s| s.header.stamp.nanos()).collect();
    stamps.dedup();
    let ticks = i64::try_from(scenario.ticks()).unwrap();
    let expected: Vec<i64> = (0..ticks).map(|k| k * 50_000_000).collect();
    assert_eq!(stamps, expected, "a state for every tick");
}

/// Every node stopped cleanly and counted what it sent, and the bag holds as much, topic by
/// topic.
fn nothing_is_lost(run: &RunFolder, flight: &Flight) {
    let mut sent = std::collections::BTreeMap::<String, u64>::new();
    for node in NODES {
        let text = std::fs::read(run.exit_report(node)).unwrap();
        let report: ExitReport = serde_json::from_slice(&text).unwrap();
        assert_eq!(report.node, format!("/auv/{node}"));
        assert!(report.refused.is_empty(), "{report:?}");
        assert!(report.dropped.is_empty(), "{report:?}");
        for (topic, number) in report.published {
            *sent.entry(topic).or_default() += number;
        }
    }
    assert!(sent.len() >= 14, "{sent:?}");
    for (topic, number) in sent {
        assert_eq!(flight.counts.get(&topic), Some(&number), "{topic}");
    }
}

fn the_page_needs_nothing_else(run: &RunFolder) {
    let page = std::fs::read_to_string(run.page()).unwrap();
    assert!(page.contains("Content-Security-Policy\" content=\"default-src 'none';"));
    let page = content(&page);
    assert_eq!(page.matches("<figure class=\"plot").count(), 7);
    for load in [
        "src=\"",
        "href=\"http",
        "href=\"//",
        "url(",
        "@import",
        "<script src",
    ] {
        assert!(!page.contains(load), "the page loads something: {load}");
    }
    assert!(!page.contains("http://") && !page.contains("https://"));
}

#[test]
fn a_flight_with_a_ram_for_each_pair_of_planes_tells_of_every_ram() {
    let stage = Stage::new();
    let each = scenario(3.0, "  dha_actuator: {groups: each}\n");
    let (file, bag) = (stage.file("each.yaml", each), stage.path("each.mcap"));
    stage.run(&["sim", &file, "--out", &bag]).success();
    let flight = Flight::read(Path::new(&bag)).unwrap();
    let groups: Vec<_> = flight.actuators.keys().map(String::as_str).collect();
    assert_eq!(groups, ["bow", "roll", "rudder", "stern"]);
    assert!(flight.actuators.values().all(|it| it.pressure.len() == 60));
    let summary = Summary::new(&flight, &Scenario::load(&file).unwrap()).unwrap();
    let pulses = |group: &str| flight.actuators[group].pulses;
    assert!(pulses("bow") > 0 && pulses("stern") > 0);
    let all = groups.iter().map(|group| pulses(group)).sum::<u64>();
    assert_eq!(summary.pulses, all);
}
