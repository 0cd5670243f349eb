//! Nodes that know nothing of `tick_answer` in a loop in lockstep: those of `launch-scripts/examples`, in rclpy, and an actuator on
//! Cyclone DDS.

use std::collections::BTreeMap;
use std::path::Path;

use planesman_bag::{BagReader, BagWriter, Order, Topic, WriterOptions};
use planesman_msgs::planesman_msgs::msg::{MotionEstimate, VehicleState};

use crate::foreign::{CYCLONE, RCLPY, Running, root};
use crate::recorded;
use crate::stage::{Outcome, Process, Signal, Stage};

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

/// The last state of a flight, whose recorder closes its bag.
fn last_state(recorder: Process, bag: &str) -> VehicleState {
    recorder.signal(Signal::INT);
    recorder.finish().success();
    let states: Vec<VehicleState> = recorded::messages(Path::new(bag), "/auv/state").unwrap();
    states.last().cloned().unwrap()
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
        example(&stage, "own_estimator.py", &["reliable_sensors:=true"]),
        example(
            &stage,
            "own_controller.py",
            &["depth:=0.914", "feedback:=estimate"],
        ),
    ];
    vehicle(&stage, "lockstep.gates:=[estimate]")
        .finish()
        .success();
    let last = last_state(recorder, &bag);
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

/// The same three nodes at five times real time, in which the plant's sensors are best effort.
#[test]
fn a_loop_of_own_nodes_flies_in_real_time() {
    let Some(_) = RCLPY.found() else { return };
    let stage = Stage::with(RCLPY.middleware);
    let bag = stage.path("bag");
    let recorder = stage.node(
        "recorder",
        &[&format!("output:={bag}"), "use_sim_time:=true"],
    );
    let _own = [
        example(&stage, "own_actuator.py", &[]),
        example(&stage, "own_estimator.py", &[]),
        example(
            &stage,
            "own_controller.py",
            &["depth:=0.914", "feedback:=estimate"],
        ),
    ];
    let parameters = ["time:=real", "factor:=5.0", "duration:=30.0"];
    let ending = ["end_when_flown:=true"];
    stage
        .node("plant_sim", &[&parameters[..], &ending].concat())
        .finish()
        .success();
    let last = last_state(recorder, &bag);
    assert!(last.depth > 0.05 && last.dive_planes != 0.0, "{last:?}");
    let estimates: Vec<MotionEstimate> =
        recorded::messages(Path::new(&bag), "/auv/estimate").unwrap();
    let estimate = estimates.last().unwrap();
    assert!((estimate.depth - last.depth).abs() < 0.1, "{estimate:?}");
}

/// A trained policy takes the LAUV to its depth, in lockstep and by the clock.
#[test]
fn a_policy_flies_in_both_modes() {
    let Some(_) = RCLPY.found() else { return };
    for [time, factor, lockstep] in [
        ["time:=lockstep", "factor:=1.0", "lockstep:=true"],
        ["time:=real", "factor:=10.0", "lockstep:=false"],
    ] {
        let stage = Stage::with(RCLPY.middleware);
        let bag = stage.path("bag");
        let output = format!("output:={bag}");
        let recorder = stage.node("recorder", &[&output, "use_sim_time:=true"]);
        let follow = [lockstep, "model:=ideal", "use_sim_time:=true"];
        let _actuator = stage.node("dha_actuator", &follow);
        let _policy = example(&stage, "policy_controller.py", &["depth:=8.0"]);
        let vehicle = [
            "vehicle:=lauv",
            "speed:=1.5",
            "duration:=40.0",
            time,
            factor,
        ];
        let ending = ["end_when_flown:=true"];
        stage
            .node("plant_sim", &[&vehicle[..], &ending].concat())
            .finish()
            .success();
        let last = last_state(recorder, &bag);
        assert!((last.depth - 8.0).abs() < 2.0, "{time}: {last:?}");
    }
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
        assert!(last_state(recorder, &bag).depth > 0.05);
        loop_messages(Path::new(&bag))
    };
    are_the_same(&flight(), &flight());
}

/// Plays a bag through an estimator in rclpy whose output the bag does not have. Returns what was printed.
fn plays_estimator(stage: &Stage, bag: &str, namespace: &str, speed: &str, out: &str) -> Outcome {
    let mut command = RCLPY.node(
        &root().join("launch-scripts/examples/own_estimator.py"),
        stage.domain(),
    );
    let namespace = format!("__ns:={namespace}");
    command.args(["--ros-args", "-r", &namespace, "-p", speed]);
    command.args(["-p", "reliable_sensors:=true"]);
    let _node = Running::of(command);
    let play = ["bag", "play", bag, "--lockstep", "--through", "own"];
    let topics = ["--output", "estimate", "--tick", "imu"];
    let inputs = ["--input", "imu", "--input", "depth_pressure", "--out", out];
    stage.run(&[&play[..], &topics, &inputs].concat()).success()
}

/// The gyro and the depth cell of a bag, under the names of another vehicle, their stamps shifted against each other.
fn foreign_bag(bag: &str, out: &str) {
    let bag = BagReader::open(Path::new(bag)).unwrap();
    let mut writer = BagWriter::create_file(Path::new(out), WriterOptions::default()).unwrap();
    let wanted = |it: &Topic| it.name == "/auv/imu" || it.name == "/auv/depth_pressure";
    let mut ids = BTreeMap::new();
    for message in bag.messages_of(wanted, Order::File) {
        let message = message.unwrap();
        let id = ids.entry(message.topic.name.clone()).or_insert_with(|| {
            let topic = Topic {
                name: message.topic.name.replace("/auv", "/ship"),
                kind: message.topic.kind.clone(),
            };
            writer.add_topic(&topic).unwrap()
        });
        let time = 1_700_000_000_000_000_000 + message.log_time;
        writer.write_raw(*id, &message.payload, time, time).unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn a_new_estimator_in_rclpy_says_the_same_in_two_plays_of_a_bag_without_its_output() {
    let Some(_) = RCLPY.found() else { return };
    let stage = Stage::with(RCLPY.middleware);
    let dive = stage.path("dive.mcap");
    let text = crate::stage::scenario(10.0, "  depth_controller: {depth_setpoint: 0.914}");
    let scenario = stage.file("short.yaml", text);
    stage.run(&["sim", &scenario, "--out", &dive]).success();
    let foreign = stage.path("ship.mcap");
    foreign_bag(&dive, &foreign);
    for (bag, namespace) in [(&dive, "/auv"), (&foreign, "/ship")] {
        let play = |speed: &str, name: &str| {
            let out = stage.path(&format!("{}_{name}.mcap", &namespace[1..]));
            let outcome = plays_estimator(&stage, bag, namespace, speed, &out);
            assert!(outcome.stdout.contains("200 ticks"), "{outcome:#?}");
            assert!(
                outcome.stdout.contains("no comparison is possible"),
                "{outcome:#?}"
            );
            let messages = recorded::messages::<MotionEstimate>(
                Path::new(&out),
                &format!("{namespace}/estimate"),
            );
            assert_eq!(messages.unwrap().len(), 200);
            out
        };
        let [first, second, faster] = [
            play("speed:=0.3048", "first"),
            play("speed:=0.3048", "second"),
            play("speed:=0.4", "faster"),
        ];
        stage.run(&["bag", "diff", &first, &second]).success();
        let outcome = stage.run(&["bag", "diff", &first, &faster]);
        assert_eq!(outcome.status.code(), Some(4), "{outcome:#?}");
        let difference = format!("first difference: {namespace}/estimate field pitch at stamp ");
        assert!(outcome.stdout.contains(&difference), "{outcome:#?}");
    }
}

#[test]
fn a_vehicle_in_rclpy_is_dived_by_our_controller_and_actuator() {
    let Some(_) = RCLPY.found() else { return };
    // Its nodes fly by the clock too, which the vehicle makes.
    for lockstep in ["lockstep:=true", "lockstep:=false"] {
        dives_the_vehicle_in_rclpy(lockstep);
    }
}

fn dives_the_vehicle_in_rclpy(lockstep: &str) {
    let stage = Stage::with(RCLPY.middleware);
    let (recorder, bag) = recorder(&stage);
    let ours = [lockstep, "use_sim_time:=true"];
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
    let last = last_state(recorder, &bag);
    assert!(last.header.stamp.nanos() >= 1190 * 50_000_000, "{last:?}");
    assert!((last.depth - 0.914).abs() < 0.05, "{last:?}");
}
