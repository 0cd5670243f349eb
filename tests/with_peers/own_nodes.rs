//! Nodes in rclpy that know nothing of `tick_answer`, those of `launch-scripts/examples`, in a loop in lockstep.

use std::collections::BTreeMap;
use std::path::Path;

use planesman_bag::{BagReader, Order};
use planesman_msgs::planesman_msgs::msg::{MotionEstimate, VehicleState};

use crate::foreign::{RCLPY, Running, root};
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
fn loop_messages(bag: &Path) -> BTreeMap<String, Vec<Vec<u8>>> {
    let bag = BagReader::open(bag).unwrap();
    let mut topics: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
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

/// Ten seconds with a controller, an actuator and an estimator of one's own.
fn flight() -> BTreeMap<String, Vec<Vec<u8>>> {
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
    let plant = stage.node(
        "plant_sim",
        &[
            "time:=lockstep",
            "duration:=10.0",
            "end_when_flown:=true",
            "lockstep.members:=[recorder]",
            "lockstep.gates:=[estimate]",
        ],
    );
    plant.finish().success();
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

#[test]
fn a_loop_with_a_controller_an_actuator_and_an_estimator_in_rclpy_is_the_same_in_each_run() {
    let Some(_) = RCLPY.found() else { return };
    let [first, second] = [flight(), flight()];
    for topic in ["/clock", "/auv/state", "/auv/imu"] {
        assert_eq!(first[topic].len(), 200, "{topic}");
    }
    for topic in ["/auv/estimate", "/auv/plane_command", "/auv/planes"] {
        assert!(first[topic].len() > 150, "{topic}");
    }
    assert_eq!(first.len(), second.len());
    for (topic, messages) in &first {
        // The recorder misses what a node publishes before that node has found it.
        let (less, more) = match second[topic].len() < messages.len() {
            true => (&second[topic], messages),
            false => (messages, &second[topic]),
        };
        assert!(more.ends_with(less), "{topic}");
    }
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
