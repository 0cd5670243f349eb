//! Processes killed with SIGKILL in mid-dive: what remains readable, who says so, and how
//! the loop goes on when they come back.

use crate::recorded;
use crate::stage;
use std::path::Path;

use planesman_bag::BagReader;
use planesman_flight::flight::Flight;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use stage::{Operator, Process, Received, Signal, Stage, eventually, scenario};

/// The sampling time, ns.
const TICK: i64 = 50_000_000;

/// Far away, so that the planes stay busy (m).
const DEEP: &str = "depth_setpoint:=50.0";
/// By the vehicle's clock a loop that stands is not silent.
const SIM_TIME: &str = "use_sim_time:=true";

fn stamp(state: &VehicleState) -> i64 {
    state.header.stamp.nanos()
}

/// How many states a bag holds as it is now.
fn states_in(bag: &Path) -> Option<usize> {
    Some(recorded::messages::<VehicleState>(bag, "/auv/state")?.len())
}

#[test]
fn a_killed_recorder_leaves_a_bag_readable_as_far_as_it_was_flushed() {
    let stage = Stage::new();
    let text = scenario(
        3600.0,
        "  recorder: {flush_interval: 0.1, chunk_size: 65536}\n",
    );
    let file = stage.file("long.yaml", text);
    let out = stage.path("out");
    let launcher = stage.start(&["dive", &file, "--out", &out]);
    let bag = Path::new(&out).join("bag");
    let flushed = eventually("two hundred states in the file", || {
        states_in(&bag).filter(|states| *states >= 200)
    });
    let nodes = launcher.nodes();
    assert_eq!(nodes.len(), 5, "{nodes:?}");
    stage::kill(nodes["recorder"]);

    let outcome = launcher.finish();
    assert_eq!(outcome.status.code(), Some(1));
    let first = outcome.complaints()[0];
    assert!(
        first.contains("the node recorder stopped by itself (signal: 9"),
        "{first}"
    );
    for (name, pid) in &nodes {
        assert!(!stage::runs(*pid), "{name} is left behind");
    }

    let reader = BagReader::open(&bag).unwrap();
    assert!(!reader.completeness().is_whole());
    let flight = Flight::read(&bag).unwrap();
    assert!(flight.truncated.is_some());
    let states = recorded::messages(&bag, "/auv/state").unwrap();
    let mut stamps: Vec<i64> = states.iter().map(stamp).collect();
    stamps.dedup();
    assert!(stamps.len() >= flushed);
    let without_gap = (0..).map(|k| k * TICK).zip(&stamps).all(|(k, s)| k == *s);
    assert!(without_gap, "{stamps:?}");

    let failed = std::fs::read_to_string(Path::new(&out).join("failed.txt")).unwrap();
    assert!(failed.contains("the node recorder stopped"), "{failed}");

    // What is there is still reported, as what it is.
    let report = stage.run(&["report", &out]).success();
    assert!(
        report.stdout.contains("The bag is incomplete"),
        "{}",
        report.stdout
    );
}

#[test]
fn a_killed_controller_halts_the_lockstep_loop_and_another_resumes_it() {
    let stage = Stage::new();
    let _plant = stage.node("plant_sim", &["time:=lockstep"]);
    let _actuator = stage.node("dha_actuator", &["lockstep:=true", SIM_TIME]);
    let controller = stage.node("depth_controller", &[DEEP, SIM_TIME]);
    let operator = stage.operator();
    let early = operator.state("some ticks", |state| stamp(state) > 20 * TICK);
    controller.kill();

    // The vehicle stands, and says for whom it waits.
    let vehicle = "/auv/plant_sim: vehicle";
    let mut last = early;
    let level = operator.until("a vehicle that waits", |received| {
        if let Received::State(state) = &received {
            last = state.clone();
        }
        let status = received.status(vehicle)?;
        // Until its lease is over it counts as a publisher, and the actuator as the one that does not answer.
        (status.message.starts_with("waiting for the ")).then_some(status.level)
    });
    assert_eq!(level, DiagnosticStatus::WARN);

    // The state it stands at comes again, the same; then time goes on where it stood.
    let _controller = stage.node("depth_controller", &[DEEP, SIM_TIME]);
    let mut next = last.clone();
    while stamp(&next) < stamp(&last) + 20 * TICK {
        let state = operator.state("the loop's going on", |_| true);
        if stamp(&state) == stamp(&next) {
            assert_eq!(state, next, "a state said again");
        } else {
            assert_eq!(stamp(&state), stamp(&next) + TICK, "a tick left out");
            assert_eq!(state.planes_source, VehicleState::PLANES_ANSWERED);
            next = state;
        }
    }
}

/// Plant, actuator and controller in real time, flying.
fn in_real_time(stage: &Stage) -> (Process, Process, Process, Operator) {
    let plant = stage.node("plant_sim", &["time:=real"]);
    let actuator = stage.node("dha_actuator", &[]);
    let controller = stage.node("depth_controller", &[DEEP]);
    let operator = stage.operator();
    operator.state("planes that move", |state| {
        state.planes_source == VehicleState::PLANES_ANSWERED && state.dive_planes > 0.2
    });
    (plant, actuator, controller, operator)
}

#[test]
fn a_killed_actuator_leaves_the_planes_where_they_are_and_the_state_says_so() {
    let stage = Stage::new();
    let (_plant, actuator, _controller, operator) = in_real_time(&stage);
    actuator.kill();
    // A busy machine makes the vehicle hold its planes for a tick or two as well.
    let mut in_a_row = 0;
    let mut last = VehicleState::default();
    let held = operator.state("planes held for good", |state| {
        let goes_on = state.planes_source == VehicleState::PLANES_HELD
            && stamp(state) == stamp(&last) + TICK
            && state.dive_planes == last.dive_planes;
        in_a_row = if goes_on { in_a_row + 1 } else { 0 };
        last = state.clone();
        in_a_row == 40
    });

    // Another one begins with its ram at rest in the middle.
    let _actuator = stage.node("dha_actuator", &[]);
    let answered = operator.state("planes that are answered for again", |state| {
        state.planes_source == VehicleState::PLANES_ANSWERED
    });
    assert!(answered.dive_planes < held.dive_planes, "{answered:?}");
}

#[test]
fn without_a_controller_the_actuator_asks_for_neutral_planes_and_says_why() {
    let stage = Stage::new();
    let (_plant, _actuator, controller, operator) = in_real_time(&stage);
    controller.kill();
    let actuator = "/auv/dha_actuator: actuator";
    let stale = operator.until("neutral planes asked for", |received| match received {
        Received::Actuator(state) if state.command_stale => Some(state),
        _ => None,
    });
    assert_eq!(stale.commanded_angle, 0.0);
    let level = operator.status(actuator, "plane command stale: planes neutral");
    assert_eq!(level, DiagnosticStatus::ERROR);
    // The vehicle flies on with answered planes, which come to neutral within a few quanta.
    operator.state("neutral planes", |state| {
        state.planes_source == VehicleState::PLANES_ANSWERED && state.dive_planes.abs() < 0.02
    });

    let _controller = stage.node("depth_controller", &[DEEP]);
    operator.until(
        "commands that are followed again",
        |received| match received {
            Received::Actuator(state) if !state.command_stale && state.commanded_angle > 0.2 => {
                Some(())
            }
            _ => None,
        },
    );
    let level = operator.status(actuator, "following");
    assert_eq!(level, DiagnosticStatus::OK);
}

#[test]
fn a_killed_vehicle_that_comes_back_at_time_zero_is_identified_anew_and_counted() {
    let stage = Stage::new();
    let fast = ["time:=real", "factor:=4.0"];
    let plant = stage.node("plant_sim", &fast);
    let _actuator = stage.node("dha_actuator", &[SIM_TIME]);
    let square = ["identification.signal:=square", "mode:=open_loop", SIM_TIME];
    let _controller = stage.node("depth_controller", &square);
    let _sysid = stage.node("sysid", &[SIM_TIME]);
    let operator = stage.operator();
    let learnt = |restarts: &str, least: u64| {
        operator.until("rows learnt from", |received| {
            let status = received.status("/auv/sysid: model")?;
            let value = |key: &str| status.values.iter().find(|pair| pair.key == key);
            let rows: u64 = value("rows")?.value.parse().ok()?;
            (value("restarts")?.value == restarts && rows >= least).then_some(rows)
        })
    };
    // Far more than it learns between two reports.
    let before = learnt("0", 400);
    plant.kill();
    let _plant = stage.node("plant_sim", &fast);
    assert!(learnt("1", 1) < before);
    learnt("1", 60);
}

#[test]
fn a_killed_launcher_takes_its_nodes_with_it_and_the_bag_is_closed() {
    let stage = Stage::new();
    let file = stage.file(
        "long.yaml",
        scenario(3600.0, "  recorder: {flush_interval: 0.1}\n"),
    );
    let out = stage.path("out");
    let launcher = stage.start(&["dive", &file, "--factor", "4", "--out", &out]);
    let bag = Path::new(&out).join("bag");
    eventually("states in the file", || {
        states_in(&bag).filter(|states| *states >= 20)
    });
    let nodes = launcher.nodes();
    assert_eq!(nodes.len(), 5, "{nodes:?}");
    launcher.signal(Signal::KILL);
    assert!(!launcher.finish().status.success());
    for (name, pid) in nodes {
        eventually(&format!("the end of {name}"), || {
            (!stage::runs(pid)).then_some(())
        });
    }
    let reader = BagReader::open(&bag).unwrap();
    assert!(
        reader.completeness().is_whole(),
        "{}",
        reader.completeness()
    );
}
