//! Nodes that know nothing of `tick_answer` in a loop in lockstep: those of `launch-scripts/examples`, in rclpy, and an actuator on
//! Cyclone DDS.

use std::collections::BTreeMap;
use std::path::Path;

use planesman_bag::{BagReader, Order};
use planesman_msgs::planesman_msgs::msg::{MotionEstimate, VehicleState};

use crate::foreign::{CYCLONE, RCLPY, Running, root};
use crate::recorded;
use crate::stage::{Process, Signal, Stage};

/// An example of the package, in the stage's domain and the loop's namespace.
fn example(stage: &Stage, name: &str, arguments: &[&str]) -> Running {
    let mut command = RCLPY.node(
        &root().join("launch-scripts/examples").join(name),
        stage.domain(),
    );
    command.args(["--ros-args", "-r", "__ns:=/auv"]);
    for argument in arguments {
        command.args(["-p", argument]);
    }
    Running::of(command)
}

fn recorder(stage: &Stage) -> (Process, String) {
    let bag = stage.path("bag");
    let output = format!("output:={bag}");
    let parameters = [&output, "answer:=true", "use_sim_time:=true"];
    (stage.node("recorder", &parameters), bag)
}

/// The payloads of each topic of the loop; what was said again at once is there once.
type Messages = BTreeMap<String, Vec<Vec<u8>>>;

fn loop_messages(bag: &Path) -> Messages {
    let bag = BagReader::open(bag).unwrap();
    let mut topics = Messages::new();
    let is_of_the_loop = |name: &str| {
        let of_one_process = ["/rosout", "/diagnostics", "/parameter_events"];
        !of_one_process.contains(&name) && !name.ends_with("tick_answer")
    };
    for message in bag.messages_of(|it| is_of_the_loop(&it.name), Order::File) {
        let message = message.unwrap();
        let payloads = topics.entry(message.topic.name.clone()).or_default();
        let payload = message.payload;
        if payloads.last() != Some(&payload) {
            payloads.push(payload);
        }
    }
    topics
}

/// The vehicle, which ends after ten seconds.
fn vehicle(stage: &Stage, gates: &str) -> Process {
    let parameters = [
        "time:=lockstep",
        "duration:=10.0",
        "end_when_flown:=true",
        "lockstep.members:=[recorder]",
        gates,
    ];
    stage.node("plant_sim", &parameters)
}

/// Ten seconds with a controller, an actuator and an estimator of one's own.
fn flight() -> Messages {
    let stage = Stage::with(RCLPY.middleware);
    let (recorder, bag) = recorder(&stage);
    let _own = [
        example(&stage, "own_actuator.py", &[]),
        example(&stage, "own_estimator.py", &[]),
        example(
            &stage,
            "own_controller.py",
            &["depth:=0.914", "feedback:=estimate"],
        ),
    ];
    vehicle(&stage, "lockstep.gates:=[estimate]")
        .finish()
        .success();
    recorder.signal(Signal::INT);
    recorder.finish().success();
    let states: Vec<VehicleState> = recorded::messages(Path::new(&bag), "/auv/state").unwrap();
    let last = states.last().unwrap();
    assert!(last.depth > 0.2 && last.dive_planes != 0.0, "{last:?}");
    let estimates: Vec<MotionEstimate> =
        recorded::messages(Path::new(&bag), "/auv/estimate").unwrap();
    let estimate = estimates.last().unwrap();
    assert_eq!(estimate.header.stamp, last.header.stamp, "the tick waited");
    assert!((estimate.depth - last.depth).abs() < 0.05, "{estimate:?}");
    loop_messages(Path::new(&bag))
}

/// Whether both flights have the same messages.
fn are_the_same(first: &Messages, second: &Messages) {
    assert_eq!(first.len(), second.len());
    for (topic, messages) in first {
        // The recorder misses what a node publishes before that node has found it.
        let (less, more) = match second[topic].len() < messages.len() {
            true => (&second[topic], messages),
            false => (messages, &second[topic]),
        };
        assert!(less.len() > 150 || less == more, "{topic}: {}", less.len());
        assert!(more.ends_with(less), "{topic}");
    }
    assert_eq!(first["/auv/state"].len(), 200);
}

#[test]
fn a_loop_with_a_controller_an_actuator_and_an_estimator_in_rclpy_is_the_same_in_each_run() {
    let Some(_) = RCLPY.found() else { return };
    let [first, second] = [flight(), flight()];
    for topic in ["/auv/estimate", "/auv/plane_command", "/auv/planes"] {
        assert!(first.contains_key(topic), "{topic}");
    }
    are_the_same(&first, &second);
}

#[test]
fn a_loop_with_an_actuator_on_cyclone_dds_is_the_same_in_each_run() {
    let Some(python) = CYCLONE.found() else {
        return;
    };
    let flight = || {
        let stage = Stage::with(python.middleware);
        let (recorder, bag) = recorder(&stage);
        let ours = [
            "lockstep:=true",
            "use_sim_time:=true",
            "depth_setpoint:=1.0",
        ];
        let _controller = stage.node("depth_controller", &ours);
        let arguments = ["--rate", "0.2", "--timeout", "120"];
        let _actuator = python.start("peer_actuator.py", stage.domain(), &arguments);
        vehicle(&stage, "lockstep.gates:=[planes]")
            .finish()
            .success();
        recorder.signal(Signal::INT);
        recorder.finish().success();
        let states: Vec<VehicleState> = recorded::messages(Path::new(&bag), "/auv/state").unwrap();
        assert!(states.last().unwrap().depth > 0.05);
        loop_messages(Path::new(&bag))
    };
    are_the_same(&flight(), &flight());
}

#[test]
fn a_vehicle_in_rclpy_is_dived_by_our_controller_and_actuator() {
    let Some(_) = RCLPY.found() else { return };
    let stage = Stage::with(RCLPY.middleware);
    let (recorder, bag) = recorder(&stage);
    let ours = ["lockstep:=true", "use_sim_time:=true"];
    let _nodes = [
        stage.node("dha_actuator", &ours),
        stage.node(
            "depth_controller",
            &[&ours[..], &["depth_setpoint:=0.914"]].concat(),
        ),
    ];
    // It ends when it has flown: 1200 ticks.
    assert_eq!(
        example(&stage, "own_plant.py", &["duration:=60.0"]).next(),
        None
    );
    recorder.signal(Signal::INT);
    recorder.finish().success();
    let states: Vec<VehicleState> = recorded::messages(Path::new(&bag), "/auv/state").unwrap();
    let last = states.last().unwrap();
    assert!(last.header.stamp.nanos() >= 1190 * 50_000_000, "{last:?}");
    assert!((last.depth - 0.914).abs() < 0.05, "{last:?}");
}
