//! The dive by the wall clock: faster than it, with stamps of its own or the machine's, and kept
//! running until somebody stops it.

use crate::recorded;
use crate::stage;
use std::path::Path;

use planesman::run_folder::RunFolder;
use planesman_flight::flight::Flight;
use planesman_flight::nodes::NODES;
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, VehicleState};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_node::{ExitReport, Next, Qos};
use stage::{LOOK, Process, Received, Signal, Stage, eventually, scenario};

/// The sampling time, ns.
const TICK: i64 = 50_000_000;
/// 2026-01-01, ns: before any clock that runs this test.
const THIS_YEAR: i64 = 1_767_225_600_000_000_000;

fn flight(out: &str) -> Flight {
    let flight = Flight::read(&Path::new(out).join("bag")).unwrap();
    assert_eq!(flight.truncated, None);
    flight
}

fn states(out: &str) -> Vec<VehicleState> {
    recorded::messages(&Path::new(out).join("bag"), "/auv/state").unwrap()
}

fn stamps(out: &str) -> Vec<i64> {
    let stamp = |state: &VehicleState| state.header.stamp.nanos();
    states(out).iter().map(stamp).collect()
}

/// The bag holds everything that the nodes sent, topic by topic.
fn assert_nothing_lost(out: &str, flight: &Flight) {
    let run = RunFolder::open(Path::new(out)).unwrap();
    for node in NODES {
        let text = std::fs::read(run.exit_report(node)).unwrap();
        let report: ExitReport = serde_json::from_slice(&text).unwrap();
        for (topic, number) in report.published {
            let recorded = flight.counts.get(&topic).copied().unwrap_or(0);
            assert_eq!(recorded, number, "{topic}");
        }
    }
}

#[test]
fn eight_times_faster_than_the_clock_nothing_is_lost() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(16.0, "  sysid: {start: 2.0}\n"));
    let out = stage.path("out");
    let outcome = stage
        .run(&["dive", &file, "--factor", "8", "--out", &out])
        .success();
    let flight = flight(&out);
    let expected: Vec<i64> = (0..320).map(|k| k * TICK).collect();
    assert_eq!(stamps(&out), expected);
    assert_nothing_lost(&out, &flight);

    // One answer of the actuator for each state, in order; the last may come after the end.
    let motions =
        recorded::messages::<PlaneMotion>(&Path::new(&out).join("bag"), "/auv/plane_motion");
    let answered = motions
        .unwrap()
        .iter()
        .map(|motion| motion.header.stamp.nanos())
        .collect::<Vec<_>>();
    assert!(expected.starts_with(&answered), "{answered:?}");
    assert!(answered.len() + 1 >= expected.len(), "{}", answered.len());

    // A busy machine may be late with an answer; such ticks are flagged and reported.
    let is_held = |state: &&VehicleState| state.planes_source == VehicleState::PLANES_HELD;
    let held = states(&out).iter().filter(is_held).count();
    let line = format!("Note: {held} ticks were flown without an answer of the actuator\n");
    assert!(
        held == 0 || outcome.stdout.contains(&line),
        "{}",
        outcome.stdout
    );
}

#[test]
fn stamps_begin_at_zero_with_sim_time_and_are_the_machines_without() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(1.0, "  sysid: {start: 0.0}\n"));
    let fly = |pace: &[&str], name: &str| {
        let out = stage.path(name);
        let arguments = [&["dive", &file, "--out", &out], pace].concat();
        stage.run(&arguments).success();
        (flight(&out), stamps(&out))
    };
    let (simulated, stamps) = fly(&["--sim-time"], "simulated");
    let expected: Vec<i64> = (0..20).map(|k| k * TICK).collect();
    assert_eq!(stamps, expected);
    assert_eq!(simulated.counts["/clock"], 20);

    let (machine, stamps) = fly(&["--factor", "1"], "machine");
    // A busy machine may miss ticks; the stamps then stay the machine's, a whole number of ticks apart.
    assert!(stamps[0] > THIS_YEAR);
    assert_eq!(stamps.len(), 20);
    for pair in stamps.windows(2) {
        let step = pair[1] - pair[0];
        assert!(step > 0 && step % TICK == 0, "{stamps:?}");
    }
    assert!(!machine.counts.contains_key("/clock"));
}

/// The operator is the actuator here, over a link that takes two ticks.
#[test]
fn an_answer_within_the_delay_budget_is_flown_late_and_flagged() {
    let stage = Stage::new();
    // Slow, so that a busy machine answers within the tick.
    let slow = ["factor:=0.2", "delay_budget:=2"];
    let _plant = stage.node("plant_sim", &slow);
    let operator = stage.operator();
    let motions = operator
        .rt
        .publisher::<PlaneMotion>("plane_motion", Qos::reliable(10))
        .unwrap();
    let late = operator.state("a tick flown on an older answer", |state| {
        let mut motion = PlaneMotion {
            duration: Duration::from_nanos(TICK),
            dive_planes: vec![0.1, 0.1],
            ..PlaneMotion::default()
        };
        motion.header.stamp = Time::from_nanos(state.header.stamp.nanos() - 2 * TICK);
        motions.publish(&motion);
        state.planes_source == VehicleState::PLANES_LATE
    });
    assert_eq!(late.dive_planes, 0.1);
    operator.status(
        "/auv/plant_sim: vehicle",
        "using an answer that is 2 ticks old",
    );
}

/// Keeps a dive of one second running, tells `stop` to stop it once it has flown on for long,
/// and expects everything to be in order.
fn kept_running_until(stop: impl FnOnce(&Process)) {
    let stage = Stage::new();
    let text = scenario(1.0, "  recorder: {flush_interval: 0.1}\n");
    let file = stage.file("short.yaml", text);
    let out = stage.path("out");
    let mut launcher = stage.start(&[
        "dive",
        &file,
        "--factor",
        "8",
        "--keep-running",
        "--out",
        &out,
    ]);
    let bag = Path::new(&out).join("bag");
    eventually("a flight longer than its scenario", || {
        let states = recorded::messages::<VehicleState>(&bag, "/auv/state")?;
        (states.len() > 60).then_some(())
    });
    assert!(launcher.is_running());
    let nodes = launcher.nodes();
    stop(&launcher);
    let outcome = launcher.finish().success();
    assert!(outcome.stdout.contains("the bag is closed"), "{outcome:#?}");
    assert_eq!(outcome.complaints(), [""; 0]);
    for (name, pid) in nodes {
        assert!(!stage::runs(pid), "{name} is left behind");
    }
    assert_nothing_lost(&out, &flight(&out));
    assert!(Path::new(&out).join("report.html").is_file());
}

#[test]
fn a_kept_loop_runs_until_ctrl_c_and_is_then_reported() {
    kept_running_until(Process::press_ctrl_c);
}

#[test]
fn a_kept_loop_ends_as_well_when_asked_to_terminate() {
    kept_running_until(|launcher| launcher.signal(Signal::TERM));
}

/// The operator makes the time here.
#[test]
fn time_from_clock_is_flown_by_and_a_jump_of_it_is_not_flown_through() {
    let stage = Stage::new();
    let _plant = stage.node("plant_sim", &["time:=external", "use_sim_time:=true"]);
    let operator = stage.operator();
    let clock = operator
        .rt
        .publisher::<Clock>("/clock", Qos::reliable(10))
        .unwrap();
    let mut time = 0;
    // Goes on from there until a state has the new time, and returns the stamps of all states on the way.
    let mut fly = |from: i64| -> Vec<i64> {
        time = from;
        let mut stamps = Vec::new();
        eventually("a state of the new time", || {
            time += TICK;
            let clock_says = Time::from_nanos(time);
            clock.publish(&Clock { clock: clock_says });
            if let Next::Event(Received::State(state)) = operator.rt.next(LOOK) {
                stamps.push(state.header.stamp.nanos());
            }
            stamps
                .last()
                .is_some_and(|last| *last >= from)
                .then_some(())
        });
        stamps
    };
    let (first, second) = (100_000_000_000, 200_000_000_000);
    fly(first);
    let stamps = fly(second);
    let between: Vec<&i64> = stamps
        .iter()
        .filter(|at| (first + second) / 2 < **at && **at < second)
        .collect();
    assert!(between.is_empty(), "{between:?}");
}

#[test]
fn a_vehicle_alone_ends_when_its_duration_is_flown_if_a_launch_file_asks_for_it() {
    let stage = Stage::new();
    let parameters = ["duration:=0.5", "end_when_flown:=true"];
    let outcome = stage.node("plant_sim", &parameters).finish().success();
    assert!(outcome.stderr.contains("done: 10 ticks"), "{outcome:#?}");
}
