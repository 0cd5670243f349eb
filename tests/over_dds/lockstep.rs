//! In lockstep no wall clock enters the data: two dives give the same bytes, and so does the
//! loop in one process.
//!
//! Each message of the loop carries its stamp, so the set of a topic's payloads is its whole
//! course. A set, because a state that a busy machine leaves without all answers for a second is said
//! again, and answered again, with the same bytes: the one thing that wall time may add.

use crate::recorded;
use crate::stage;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use planesman_bag::{BagReader, Order};
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use stage::{LONG_WORK, Received, Stage, scenario};

/// Topics that carry wall time by their nature, and are none of the vehicle's course:
/// health reports go out every second of wall time, log lines when something is worth one, and
/// parameter events tell when somebody changed one.
const OF_WALL_TIME: [&str; 3] = ["/diagnostics", "/rosout", "/parameter_events"];

/// The messages of the loop in one process: all but the answers that keep processes in step.
const COMPOSED: [&str; 16] = [
    "/auv/control_state",
    "/auv/daq",
    "/auv/depth_pressure",
    "/auv/dha_state",
    "/auv/imu",
    "/auv/model",
    "/auv/odom",
    "/auv/plane_command",
    "/auv/plane_motion",
    "/auv/planes",
    "/auv/robot_description",
    "/auv/speed_pressure",
    "/auv/state",
    "/clock",
    "/tf",
    "/tf_static",
];

/// A dive that is over soon, with every noise on and a model identified.
const DIVE: &str = "  plant_sim: {speed: 0.36576}
  depth_controller:
    depth_setpoint: 0.5
    identification: {signal: prbs, amplitude: 0.0349, period: 1.0}
  sysid: {start: 2.0}
";

/// The payloads of each topic that carries no wall time.
type Course = BTreeMap<String, BTreeSet<Vec<u8>>>;

fn course(bag: &str) -> Course {
    let bag = BagReader::open(Path::new(bag)).unwrap();
    assert!(bag.completeness().is_whole());
    let mut course = Course::new();
    for message in bag.messages(Order::File) {
        let message = message.unwrap();
        if !OF_WALL_TIME.contains(&message.topic.name.as_str()) {
            let payloads = course.entry(message.topic.name.clone()).or_default();
            let mut payload = message.payload.to_vec();
            // On its way a payload is filled up to whole words (RTPS 2.3, 9.4.1); in one
            // process nothing is on its way.
            payload.resize(payload.len().next_multiple_of(4), 0);
            payloads.insert(payload);
        }
    }
    course
}

fn assert_same(one: &Course, other: &Course, topics: &[&str]) {
    for topic in topics {
        let (one, other) = (&one[*topic], &other[*topic]);
        assert_eq!(one.len(), other.len(), "messages of {topic}");
        let differing = one.difference(other).count();
        assert_eq!(differing, 0, "payloads of {topic} that differ");
    }
}

#[test]
fn two_dives_in_lockstep_and_the_loop_in_one_process_agree_bit_for_bit() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(15.0, DIVE));
    let fly = |name: &str| {
        let out = stage.path(name);
        stage
            .run(&["dive", &file, "--lockstep", "--out", &out])
            .success();
        course(&format!("{out}/bag"))
    };
    let (first, second) = (fly("first"), fly("second"));
    assert_eq!(first, second);
    let bags = ["first", "second"].map(|name| stage.path(name) + "/bag");
    stage.run(&["bag", "diff", &bags[0], &bags[1]]).success();
    // Which of two publishers of /auv/tick_answer came first is the recorder's.
    let hashes = |bag: &str| {
        let printed = stage
            .run(&["bag", "info", bag, "--sha256"])
            .success()
            .stdout;
        let of_loop = |line: &&str| {
            let topic = line.split(' ').nth(1).unwrap_or_default();
            !["/rosout", "/diagnostics", "/parameter_events"].contains(&topic)
        };
        let lines: Vec<String> = printed.lines().filter(of_loop).map(str::to_owned).collect();
        lines
    };
    assert_eq!(hashes(&bags[0]), hashes(&bags[1]));
    assert_eq!(first["/auv/state"].len(), 300);
    assert!(first["/auv/model"].len() > 10);
    // The identifier's and the recorder's, for each tick.
    assert_eq!(first["/auv/tick_answer"].len(), 600);

    let out = stage.path("composed.mcap");
    stage.run(&["sim", &file, "--out", &out]).success();
    let composed = course(&out);
    assert_eq!(
        composed.keys().map(String::as_str).collect::<Vec<_>>(),
        COMPOSED
    );
    assert_same(&composed, &first, &COMPOSED);
    // As a user of continuous integration has it.
    let compare = ["bag", "diff", &out, &bags[0], "--ignore", "tick_answer"];
    stage.run(&compare).success();
    plays_its_part(&stage, &bags[0]);
}

/// The depth cell of 1988 ends above the depth that is flown to.
#[test]
fn a_saturated_sensor_is_a_warning_with_its_range() {
    let stage = Stage::new();
    let out = stage.path("deep");
    let deep = "  depth_controller: {depth_setpoint: 0.914}\n";
    // Diagnostics go out once a second of the machine's time, in which lockstep flies minutes.
    let file = stage.file("deep.yaml", scenario(900.0, deep));
    stage
        .run(&["dive", &file, "--lockstep", "--out", &out])
        .success();
    let bag = format!("{out}/bag");
    let arrays: Vec<DiagnosticArray> = recorded::messages(Path::new(&bag), "/diagnostics").unwrap();
    let of_sensors = arrays.iter().flat_map(|it| &it.status);
    let told: Vec<(u8, &str)> = of_sensors
        .filter(|it| it.name == "/auv/plant_sim: sensors")
        .map(|it| (it.level, it.message.as_str()))
        .collect();
    let depth = " to 0.827 m of water over the port";
    let warns = |it: &&(u8, &str)| it.0 == DiagnosticStatus::WARN && it.1.contains(depth);
    assert!(told.iter().any(|it| warns(&it)), "{told:?}");
}

/// Each node gives the recorded answers to the recorded inputs; with a gain changed by a millionth of a millionth the controller does not.
fn plays_its_part(stage: &Stage, bag: &str) {
    let play = |through: &str, more: &[&str]| {
        let out = stage.path(&format!("{through}{}.mcap", more.len()));
        let play = ["bag", "play", bag, "--lockstep", "--through", through];
        stage.run(&[&play[..], &["--out", &out], more].concat())
    };
    for through in ["controller", "actuator", "sysid"] {
        let outcome = play(through, &[]).success();
        assert!(outcome.stdout.contains("300 ticks played."), "{outcome:#?}");
    }
    let outcome = play("controller", &["-p", "depth.p:=0.820209973754"]);
    assert_eq!(outcome.status.code(), Some(4), "{outcome:#?}");
    let first =
        "first difference: /auv/plane_command field dive_planes at stamp 0.000000000 (message 1)";
    assert!(outcome.stdout.contains(first), "{outcome:#?}");
}

/// The estimator waits for its instruments, which come on topics of their own in any order; the identified model acts
/// at a stamp, not when it arrives.
#[test]
fn on_the_instruments_with_adaptive_gains_processes_and_composition_agree_bit_for_bit() {
    let stage = Stage::new();
    let dive = "  plant_sim:
    speed: 0.6096
    environment: {bottom: 1.0}
    sensors:
      dvl: {rate: 5.0, range: 0.8, dropout: 0.1}
      magnetometer: {rate: 10.0}
      gps: {rate: 1.0}
      usbl: {rate: 0.5, delay: 1.3, outlier: 0.2}
      attitude: {enabled: true}
  depth_controller:
    depth_setpoint: 0.5
    feedback: {source: kalman, speed: 0.6096}
    gains: {source: adaptive}
    identification: {signal: prbs, amplitude: 0.0349, period: 1.0}
  sysid: {start: 2.0}
";
    let file = stage.file("instruments.yaml", scenario(15.0, dive));
    let (out, mcap) = (stage.path("flown"), stage.path("composed.mcap"));
    stage
        .run(&["dive", &file, "--lockstep", "--out", &out])
        .success();
    stage.run(&["sim", &file, "--out", &mcap]).success();
    let (flown, composed) = (course(&format!("{out}/bag")), course(&mcap));
    assert_eq!(composed["/auv/estimate"].len(), 300);
    assert_same(
        &composed,
        &flown,
        &[
            "/auv/estimate",
            "/auv/control_state",
            "/auv/plane_command",
            "/auv/state",
            "/auv/imu",
            "/auv/dvl",
            "/auv/dvl_water",
            "/auv/altitude",
            "/auv/magnetic_field",
            "/auv/gps",
            "/auv/usbl",
            "/tf_static",
        ],
    );
}

#[test]
fn another_seed_gives_other_noise_and_the_same_truth() {
    let stage = Stage::new();
    let fly = |seed: u32| {
        let text = format!(
            "seed: {seed}\n{}",
            scenario(2.0, "  depth_controller: {mode: \"off\"}")
        );
        let file = stage.file(&format!("{seed}.yaml"), text);
        let out = stage.path(&format!("{seed}.mcap"));
        stage.run(&["sim", &file, "--out", &out]).success();
        course(&out)
    };
    let (one, two) = (fly(1), fly(2));
    assert_same(&one, &two, &["/auv/state", "/auv/odom"]);
    assert!(one["/auv/imu"].is_disjoint(&two["/auv/imu"]));
}

#[test]
fn a_dive_of_more_ticks_than_a_writer_keeps_samples_comes_to_its_end() {
    let stage = Stage::new();
    // 8,192 samples are kept for who has not acknowledged them; a dive has 20 ticks a second.
    let file = stage.file("long.yaml", scenario(420.0, "  sysid: {start: 1.0}\n"));
    let dive = stage.start(&["dive", &file, "--lockstep", "--verbose"]);
    let outcome = dive.finish_within(LONG_WORK).success();
    assert!(outcome.stdout.contains("Flew 420.0 s"), "{outcome:#?}");
}

/// The thrusters are commanded on a topic of their own, which a tick waits for too.
#[test]
fn with_thrusters_processes_and_composition_agree_bit_for_bit() {
    let stage = Stage::new();
    let text = include_str!("../../launch-scripts/scenarios/bluerov2.yaml");
    let file = stage.file(
        "short.yaml",
        text.replace("duration: 90.0", "duration: 6.0"),
    );
    let (out, mcap) = (stage.path("flown"), stage.path("composed.mcap"));
    stage
        .run(&["dive", &file, "--lockstep", "--out", &out])
        .success();
    stage.run(&["sim", &file, "--out", &mcap]).success();
    let (flown, composed) = (course(&format!("{out}/bag")), course(&mcap));
    assert_eq!(composed["/auv/thruster_command"].len(), 120);
    for topic in composed.keys() {
        assert_same(&composed, &flown, &[topic]);
    }
}

/// Not the actuator, which has nothing to answer, is missing, but who commands it; and a member says what it lacks itself.
#[test]
fn a_tick_that_waits_names_the_root_of_the_chain() {
    let stage = Stage::new();
    let operator = stage.operator();
    let told = |what: &str| {
        operator.until(what, |received| {
            let Received::Diagnostics(array) = received else {
                return None;
            };
            let mut messages = array.status.iter().map(|it| &it.message);
            messages.any(|it| it.contains(what)).then_some(())
        });
    };
    let members = "lockstep.members:=[sysid]";
    let _plant = stage.node("plant_sim", &["time:=lockstep", members]);
    told("waiting for the controller: nobody publishes plane_command, sysid");
    let _sysid = stage.node("sysid", &["answer:=true"]);
    told("each tick waits for plane_motion, but no node publishes it");
    let _actuator = stage.node("dha_actuator", &["lockstep:=true"]);
    told("waiting for the controller: nobody publishes plane_command");
    let _controller = stage.node("depth_controller", &["lockstep:=true"]);
    operator.state("a tick", |state| state.header.stamp.nanos() > 0);
}
