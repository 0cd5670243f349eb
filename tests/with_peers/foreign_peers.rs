//! Another DDS speaks to the loop: Cyclone DDS, from Python, and ROS 2 Jazzy's own rclpy on Fast DDS discover its
//! topics, read and command it, and use its parameters, services and actions. Every claim is tried with both.
//!
//! Where their Python is absent these tests pass, saying what they skipped (tests/README.md).

use crate::foreign;
use crate::stage;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use foreign::{CYCLONE, Python, RCLPY, Running, full_name, root};
use planesman_control::ControllerParameters;
use planesman_flight::nodes::NODES;
use planesman_msgs::loop_topics::{self, Delivery, OPTIONAL_SENSORS};
use planesman_msgs::{
    Message,
    diagnostic_msgs::msg::DiagnosticArray,
    nav_msgs,
    planesman_msgs::msg::{PlaneMotion, VehicleState},
    rcl_interfaces::msg::Log,
    sensor_msgs, std_msgs,
    std_msgs::msg::Float64,
    tf2_msgs,
};
use planesman_node::Qos;
use planesman_parameters::Parameters as _;
use rustix::process::Pid;
use serde_json::{Value, json};
use stage::{Process, Signal, Stage, eventually, freeze, scenario};

/// A test of each claim with each peer.
macro_rules! whichever_peer_tries {
    ($($claim:ident)*) => {
        mod cyclone {
            $(#[test] fn $claim() { super::with(super::CYCLONE, super::$claim); })*
        }
        mod rclpy {
            $(#[test] fn $claim() { super::with(super::RCLPY, super::$claim); })*
        }
    };
}

whichever_peer_tries! {
    every_topic_is_discovered_with_its_type_qos_and_type_hash
    state_odometry_imu_and_planes_decode_to_what_the_vehicle_does
    a_depth_setpoint_published_from_there_moves_the_vehicle
    parameters_are_listed_read_described_and_set_and_a_bad_value_is_refused
    the_vehicle_is_paused_stepped_and_put_back_by_its_services
    stamps_are_the_machines_time_again_after_a_pause_and_a_stall
    in_simulated_time_diagnostics_and_log_have_its_stamps
    a_qos_that_does_not_fit_is_told_in_rclcpps_words
    a_log_line_is_for_late_joiners_no_longer_than_its_lifespan
    a_reader_that_does_not_acknowledge_loses_and_is_named_and_nobody_else
    a_reader_that_comes_late_costs_nobody_a_sample
    messages_and_answers_larger_than_a_datagram_arrive_whatever_their_length
    the_identifier_publishes_its_model_and_forgets_it_when_asked
    a_node_describes_its_types_with_their_sources
    the_levels_of_a_nodes_loggers_are_told_and_set
    the_actuator_answers_each_state_once_however_late_the_commands_are
    a_foreign_actuator_flies_the_vehicle_with_joint_states_alone
    a_goal_is_sent_followed_and_cancelled_as_ros2_action_does
    a_client_of_the_other_middleware_is_told_of_once_and_what_to_set
}

/// Tests of what Cyclone DDS alone, without ROS, does not have.
mod ros {
    #[test]
    fn a_node_is_listed_again_after_a_pause_longer_than_its_lease() {
        super::with(super::RCLPY, super::a_node_is_listed_again_after_a_pause);
    }

    #[test]
    fn a_qos_that_does_not_fit_is_told_once_at_a_reader_there() {
        super::with(super::RCLPY, super::a_qos_that_does_not_fit_is_told_once);
    }
}

fn with(peer: Python, claim: fn(&Python, &Stage)) {
    let Some(peer) = peer.found() else { return };
    claim(&peer, &Stage::with(peer.middleware));
}

/// The sampling time, s.
const TICK: f64 = 0.05;

/// A vehicle that holds its depth, one metre down, without a test signal.
const HOLD_ONE_METRE: &str = "  plant_sim: {initial_depth: 1.0}
  depth_controller: {depth_setpoint: 1.0}
";

/// Topics that are published on request only: the estimate with feedback from the instruments, commands of thrusters, the further rams' states
/// where each group of planes has a ram.
const UNSAID: [&str; 6] = [
    "estimate",
    "thruster_command",
    "thruster_setpoints",
    "dha_state_stern",
    "dha_state_roll",
    "dha_state_rudder",
];

/// The arguments of a peer that reads the log, the last lines before it included.
const LATE_LOG: [&str; 10] = [
    "/rosout",
    Log::TYPE_NAME,
    "--reliability",
    "reliable",
    "--durability",
    "transient_local",
    "--count",
    "1000",
    "--timeout",
    "60",
];

/// The loop with these parameters, which flies at this pace until the test ends.
fn keep_flying(stage: &Stage, parameters: &str, pace: &[&str]) -> Process {
    let file = stage.file("scenario.yaml", scenario(60.0, parameters));
    stage.start(&[&["dive", &file, "--keep-running"], pace].concat())
}

/// The vehicle's states, for two minutes at most.
fn states(python: &Python, stage: &Stage) -> Running {
    let arguments = ["/auv/state", VehicleState::TYPE_NAME, "--timeout", "120"];
    let arguments = [&arguments[..], &["--count", "100000"]].concat();
    python.start("peer_echo.py", stage.domain(), &arguments)
}

/// The vehicle's answer to being paused, or set going again.
fn pause(python: &Python, stage: &Stage, paused: bool) -> Value {
    let request = json!({ "data": paused }).to_string();
    let service = ["/auv/plant_sim/pause", "std_srvs/srv/SetBool"];
    let arguments = [&service[..], &["--json", &request]].concat();
    let called = python.run("peer_call.py", stage.domain(), &arguments);
    called.answer()
}

/// Seconds of a message's stamp.
fn stamp(message: &Value) -> f64 {
    seconds(&message["header"]["stamp"])
}

/// Seconds of a time.
fn seconds(time: &Value) -> f64 {
    number(&time["sec"]) + 1e-9 * number(&time["nanosec"])
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("no number: {value}"))
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("no text: {value}"))
}

fn every_topic_is_discovered_with_its_type_qos_and_type_hash(python: &Python, stage: &Stage) {
    // In lockstep, for every topic of the loop to be there.
    let _loop = keep_flying(stage, HOLD_ONE_METRE, &["--lockstep"]);

    let from_the_operator =
        ["depth", "pitch", "heading", "speed"].map(|of| format!("{of}_setpoint"));
    let is_published = |topic: &str| {
        !from_the_operator.iter().any(|name| name == topic)
            && !UNSAID.contains(&topic)
            && !OPTIONAL_SENSORS.contains(&topic)
    };
    // Every topic is recorded.
    let ends = loop_topics::ALL
        .iter()
        .flat_map(|topic| ["subscription", "publication"].map(|kind| (kind, topic)));
    let expected: Vec<String> = ends
        .filter(|(kind, topic)| *kind == "subscription" || is_published(topic.name))
        .map(|(kind, topic)| format!("{kind}:{}={}", full_name(topic.name), topic.info.type_name))
        .collect();
    let mut arguments = vec!["--timeout", "30", "--quiet", "2", "--expect"];
    arguments.extend(expected.iter().map(String::as_str));
    let endpoints = python
        .run("peer_topics.py", stage.domain(), &arguments)
        .well();

    // A dive loses nothing, its sensors' messages neither.
    for topic in loop_topics::ALL.iter().map(|topic| topic.without_loss()) {
        let name = full_name(topic.name);
        let of = |kind: &str| -> Vec<&Value> {
            let is_it = |e: &&Value| e["topic"] == *name && e["kind"] == kind;
            endpoints.iter().filter(is_it).collect()
        };
        let (publications, subscriptions) = (of("publication"), of("subscription"));
        assert_eq!(
            !publications.is_empty(),
            is_published(topic.name),
            "{name}: {publications:?}"
        );
        for endpoint in publications.iter().chain(&subscriptions) {
            assert_eq!(endpoint["type"], topic.info.type_name, "{name}");
            assert_eq!(endpoint["type_hash"], topic.info.type_hash, "{name}");
        }
        let (reliability, durability) = match topic.delivery {
            Delivery::BestEffort => ("BestEffort", "Volatile"),
            Delivery::Reliable => ("Reliable", "Volatile"),
            Delivery::Latched => ("Reliable", "TransientLocal"),
        };
        for endpoint in publications {
            assert_eq!(endpoint["reliability"], reliability, "{name}");
            assert_eq!(endpoint["durability"], durability, "{name}");
        }
    }

    // Every endpoint has a hash, those of services, actions and ROS's own discovery too.
    for endpoint in &endpoints {
        let hash = endpoint["type_hash"].as_str().unwrap_or_default();
        assert!(hash.starts_with("RIHS01_"), "{endpoint}");
    }
    // One writer of the parameters' events for each node, and for the launcher.
    let of_events = |e: &&Value| e["topic"] == "/parameter_events" && e["kind"] == "publication";
    assert_eq!(endpoints.iter().filter(of_events).count(), NODES.len() + 1);

    // Nothing of ours that the table of topics does not know.
    let known: BTreeSet<String> = loop_topics::ALL.iter().map(|t| full_name(t.name)).collect();
    for endpoint in &endpoints {
        let topic = text(&endpoint["topic"]);
        // The names of services' topics, and of ROS's own, do not begin with a slash; those of
        // actions' topics are hidden: a part of them begins with an underscore.
        let seen = topic.starts_with('/') && !topic.contains("/_");
        assert!(!seen || known.contains(topic), "{endpoint}");
    }
}

fn state_odometry_imu_and_planes_decode_to_what_the_vehicle_does(python: &Python, stage: &Stage) {
    let with_sensors = "  plant_sim:
    initial_depth: 1.0
    environment: {bottom: 10.0}
    sensors: {dvl.rate: 5.0, gps.rate: 5.0}
  depth_controller: {depth_setpoint: 1.0}
";
    let _loop = keep_flying(stage, with_sensors, &["--factor", "4"]);
    let echo = |topic: &str, type_name| python.echo(stage.domain(), topic, type_name, 5);

    let states = echo("/auv/state", VehicleState::TYPE_NAME);
    for state in &states {
        assert_eq!(state["header"]["frame_id"], "map_ned");
        assert!((number(&state["depth"]) - 1.0).abs() < 0.2, "{state}");
        assert!((number(&state["surge"]) - 0.3048).abs() < 0.01, "{state}");
        assert!(number(&state["distance"]) >= 0.0, "{state}");
    }
    let stamps: Vec<f64> = states.iter().map(stamp).collect();
    for pair in stamps.windows(2) {
        assert!((pair[1] - pair[0] - TICK).abs() < 1e-6, "{stamps:?}");
    }

    for odometry in echo("/auv/odom", nav_msgs::msg::Odometry::TYPE_NAME) {
        // REP 103: z points up, so a metre down is -1; the bow is ahead along x.
        let pose = &odometry["pose"]["pose"];
        assert_eq!(odometry["header"]["frame_id"], "odom");
        assert_eq!(odometry["child_frame_id"], "base_link");
        assert!((number(&pose["position"]["z"]) + 1.0).abs() < 0.2);
        assert!(number(&odometry["twist"]["twist"]["linear"]["x"]) > 0.29);
        let norm: f64 = ["x", "y", "z", "w"]
            .iter()
            .map(|axis| number(&pose["orientation"][axis]).powi(2))
            .sum();
        assert!((norm - 1.0).abs() < 1e-9, "{odometry}");
    }

    for imu in echo("/auv/imu", sensor_msgs::msg::Imu::TYPE_NAME) {
        // At rest an accelerometer feels the ground's push upwards: +g along z.
        assert!(
            (number(&imu["linear_acceleration"]["z"]) - 9.81).abs() < 0.5,
            "{imu}"
        );
        assert_eq!(imu["orientation_covariance"][0], -1.0, "no orientation");
    }

    for altitude in echo("/auv/altitude", sensor_msgs::msg::Range::TYPE_NAME) {
        assert_eq!(altitude["header"]["frame_id"], "altimeter");
        assert!((number(&altitude["range"]) - 9.0).abs() < 0.3, "{altitude}");
    }
    for gps in echo("/auv/gps", sensor_msgs::msg::NavSatFix::TYPE_NAME) {
        assert_eq!(gps["status"]["status"], -1, "under water");
    }

    for planes in echo("/auv/planes", sensor_msgs::msg::JointState::TYPE_NAME) {
        assert_eq!(planes["name"], json!(["dive_planes", "ram"]));
        assert!(number(&planes["position"][0]).abs() < 30_f64.to_radians());
    }
}

/// By rclpy alone: the graph of nodes is ROS's, not DDS's.
#[test]
fn ros2_node_info_shows_what_each_node_offers() {
    let Some(python) = RCLPY.found() else { return };
    let stage = Stage::with(python.middleware);
    let _loop = keep_flying(&stage, HOLD_ONE_METRE, &["--factor", "1"]);
    let info = |node: &str| {
        let arguments = [node, "--timeout", "30"];
        python
            .run("peer_node_info.py", stage.domain(), &arguments)
            .answer()
    };

    let plant = info("/auv/plant_sim");
    for node in NODES {
        let nodes = plant["nodes"].as_array().unwrap();
        let count = nodes.iter().filter(|n| **n == full_name(node)).count();
        assert_eq!(count, 1, "{node}: {nodes:?}");
    }
    assert_eq!(plant["publishers"]["/auv/state"], VehicleState::TYPE_NAME);
    assert_eq!(
        plant["subscribers"]["/auv/plane_motion"],
        "planesman_msgs/msg/PlaneMotion"
    );
    let step = "/auv/plant_sim/step";
    assert_eq!(plant["services"][step], "planesman_msgs/srv/Step");
    let set = "/auv/plant_sim/set_parameters";
    assert_eq!(plant["services"][set], "rcl_interfaces/srv/SetParameters");
    assert_eq!(plant["actions"], json!({}));

    let controller = info("/auv/depth_controller");
    assert_eq!(
        controller["actions"],
        json!({"/auv/depth_controller/manoeuvre": "planesman_msgs/action/Manoeuvre"})
    );
}

/// By Cyclone DDS alone: tf2_msgs is not among the wheels.
#[test]
fn every_frame_named_in_a_header_is_in_one_tree_of_transforms() {
    let Some(python) = CYCLONE.found() else {
        return;
    };
    let stage = Stage::with(python.middleware);
    let of_a_second_vehicle = "  plant_sim: {frame_prefix: auv2/}
  depth_controller: {frame_prefix: auv2/, feedback.source: kalman}
  dha_actuator: {frame_prefix: auv2/}
";
    let _loop = keep_flying(&stage, of_a_second_vehicle, &["--factor", "4"]);
    let echo = |topic: &str, type_name, qos: &[&str]| {
        let arguments = [&[topic, type_name, "--timeout", "30"], qos].concat();
        let program = "peer_echo.py";
        let mut lines = python.run(program, stage.domain(), &arguments).well();
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines.remove(0)
    };
    let latched = [
        "--durability",
        "transient_local",
        "--reliability",
        "reliable",
    ];

    let tf = tf2_msgs::msg::TFMessage::TYPE_NAME;
    let mut parents = BTreeMap::new();
    for message in [echo("/tf_static", tf, &latched), echo("/tf", tf, &[])] {
        for transform in message["transforms"].as_array().unwrap() {
            let child = text(&transform["child_frame_id"]).to_owned();
            let parent = text(&transform["header"]["frame_id"]).to_owned();
            assert_eq!(parents.insert(child, parent), None, "{message}");
        }
    }
    for (child, parent) in [
        ("auv2/odom", "auv2/map"),
        ("auv2/map_ned", "auv2/map"),
        ("auv2/base_link", "auv2/odom"),
        ("auv2/base_link_frd", "auv2/base_link"),
        ("auv2/bow_planes", "auv2/base_link"),
        ("auv2/stern_planes", "auv2/base_link"),
        ("auv2/ram", "auv2/base_link"),
    ] {
        assert_eq!(parents.get(child).map(String::as_str), Some(parent));
    }
    for topic in loop_topics::ALL {
        let stamped_by_frame = topic.info.definition.contains("std_msgs/Header header");
        let name = topic.name;
        if !stamped_by_frame || name.starts_with('/') || ["model", "tick_answer"].contains(&name) {
            continue;
        }
        if UNSAID.contains(&name) && name != "estimate" || OPTIONAL_SENSORS.contains(&name) {
            continue;
        }
        let message = echo(&full_name(name), topic.info.type_name, &[]);
        let frame = text(&message["header"]["frame_id"]);
        assert!(parents.contains_key(frame), "{topic:?}: {frame}");
    }

    let string = std_msgs::msg::String::TYPE_NAME;
    let description = echo("/auv/robot_description", string, &latched);
    for link in [
        "base_link",
        "base_link_frd",
        "bow_planes",
        "stern_planes",
        "ram",
    ] {
        let named = format!("<link name=\"{link}\"");
        assert!(text(&description["data"]).contains(&named), "{description}");
    }
}

fn a_depth_setpoint_published_from_there_moves_the_vehicle(python: &Python, stage: &Stage) {
    let _loop = keep_flying(stage, HOLD_ONE_METRE, &["--factor", "8"]);
    let domain = stage.domain();
    let mut states = states(python, stage);

    // Let be, it stays where it is.
    for state in states.by_ref().take(50) {
        assert!((number(&state["depth"]) - 1.0).abs() < 0.2, "{state}");
    }

    let arguments = [
        "/auv/depth_setpoint",
        "std_msgs/msg/Float64",
        "--json",
        r#"{"data": 2.5}"#,
        // The recorder may listen before the controller does.
        "--rate",
        "2",
        "--duration",
        "10",
    ];
    let sent = python.run("peer_pub.py", domain, &arguments).answer();
    assert_eq!(sent["sent"], 20);

    let arrived = states
        .by_ref()
        .find(|state| (number(&state["depth"]) - 2.5).abs() < 0.1);
    assert!(arrived.is_some(), "the vehicle has not come near 2.5 m");
}

fn parameters_are_listed_read_described_and_set_and_a_bad_value_is_refused(
    python: &Python,
    stage: &Stage,
) {
    let _controller = stage.node("depth_controller", &[]);
    let ask = |arguments: &[&str]| {
        let arguments = [&["/auv/depth_controller"], arguments].concat();
        python.run("peer_params.py", stage.domain(), &arguments)
    };
    let gain = |value: f64| json!({"name": "depth.p", "value": value});

    let listed = ask(&["list"]).well();
    let listed: BTreeSet<&str> = listed.iter().map(|line| text(&line["name"])).collect();
    for declaration in ControllerParameters::declarations() {
        assert!(
            listed.contains(declaration.name.as_str()),
            "{}",
            declaration.name
        );
    }

    assert_eq!(ask(&["set", "depth.p=0.5"]).answer()["successful"], true);
    assert_eq!(ask(&["get", "depth.p"]).answer(), gain(0.5));

    // A value that is no number, out of range, or of another type; and a parameter that is not there.
    for (assignment, parts) in [
        ("depth.p=NaN", ["depth.p", "finite"]),
        ("depth.p=-1.0", ["depth.p", "[0, 1000]"]),
        ("depth.p=much", ["depth.p", "a number is expected"]),
        ("depth.q=1.0", ["depth.q", "parameter"]),
        ("mode=climb", ["mode", "off, open_loop, pitch, depth"]),
    ] {
        let refusal = ask(&["set", assignment]).refusal();
        assert_eq!(refusal["successful"], false);
        for part in parts {
            assert!(text(&refusal["reason"]).contains(part), "{refusal}");
        }
    }
    assert_eq!(ask(&["get", "depth.p"]).answer(), gain(0.5));

    // All or none.
    let both = ["set", "depth.p=0.75", "depth.d=-1.0", "--atomically"];
    assert!(text(&ask(&both).refusal()["reason"]).contains("depth.d"));
    assert_eq!(ask(&["get", "depth.p"]).answer(), gain(0.5));
    let both = ["set", "depth.p=0.75", "depth.d=1.5", "--atomically"];
    assert_eq!(ask(&both).answer()["successful"], true);
    assert_eq!(ask(&["get", "depth.p"]).answer(), gain(0.75));

    let described = ask(&["describe", "depth.p"]).answer();
    assert_eq!(described["name"], "depth.p");
    assert_eq!(described["read_only"], false);
    let printed = format!(
        "{} {}",
        described["description"], described["additional_constraints"]
    );
    assert!(printed.contains("rad/m"), "the unit: {described}");
    let range = &described["floating_point_range"][0];
    assert_eq!(number(&range["from_value"]), 0.0);
    assert_eq!(number(&range["to_value"]), 1000.0);
    assert_eq!(ask(&["describe", "depth.q"]).status, 3);
}

/// The ticks flown, as a service of `plant_sim` tells them ("at tick 12").
fn ticks(answer: &Value) -> u64 {
    let message = text(&answer["message"]);
    let number = message
        .strip_prefix("at tick ")
        .and_then(|n| n.parse().ok());
    number.unwrap_or_else(|| panic!("{answer}"))
}

fn the_vehicle_is_paused_stepped_and_put_back_by_its_services(python: &Python, stage: &Stage) {
    let _plant = stage.node("plant_sim", &["initial_depth:=3.0", "initial_pitch:=0.2"]);
    let call = |service: &str, type_name: &str, request: &str| {
        let service = format!("/auv/plant_sim/{service}");
        python
            .run(
                "peer_call.py",
                stage.domain(),
                &[&service, type_name, "--json", request],
            )
            .answer()
    };
    let pause = |paused| pause(python, stage, paused);
    let step = |n: u32| {
        call(
            "step",
            "planesman_msgs/srv/Step",
            &json!({"ticks": n}).to_string(),
        )
    };

    assert_eq!(step(1)["success"], false, "it is not paused");
    let stands = ticks(&pause(true));
    // The tick that was on when the pause came is still flown.
    let stepped = eventually("a paused vehicle", || {
        let answer = step(1);
        (answer["success"] == true).then_some(answer)
    });
    let before = ticks(&stepped);
    assert_eq!(
        before,
        stands + 1,
        "a pause tells the tick at which it stands"
    );
    assert_eq!(ticks(&step(3)), before + 3);
    assert_eq!(ticks(&pause(true)), before + 3, "time stands still");
    assert_eq!(step(0)["success"], false, "1 to 100000");

    let arguments = [
        "/auv/state",
        VehicleState::TYPE_NAME,
        "--timeout",
        "60",
        "--count",
        "1000",
    ];
    let mut states = python.start("peer_echo.py", stage.domain(), &arguments);
    pause(false);
    // Bow up it rises; put back, it is within a tick of where it began.
    let risen = states.find(|state| number(&state["depth"]) < 2.98).unwrap();
    assert_eq!(call("reset", "std_srvs/srv/Trigger", "{}")["success"], true);
    let back = states.find(|state| number(&state["depth"]) > 2.99).unwrap();
    assert!((number(&back["pitch"]) - 0.2).abs() < 0.01, "{back}");
    assert!(stamp(&back) > stamp(&risen), "time goes on");
}

fn stamps_are_the_machines_time_again_after_a_pause_and_a_stall(python: &Python, stage: &Stage) {
    /// Long enough that no busy machine is as late, s.
    const INTERRUPTION: Duration = Duration::from_secs(3);

    let plant = stage.node("plant_sim", &[]);
    let mut states = states(python, stage);
    let mut is_on_time = |when: &str| {
        let found = states.by_ref().find(|state| {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
            (now.as_secs_f64() - stamp(state)).abs() < 0.5 * INTERRUPTION.as_secs_f64()
        });
        assert!(found.is_some(), "{when}");
    };
    is_on_time("at the start");

    assert_eq!(pause(python, stage, true)["success"], true);
    std::thread::sleep(INTERRUPTION);
    assert_eq!(pause(python, stage, false)["success"], true);
    is_on_time("after a pause");

    freeze(plant.pid());
    std::thread::sleep(INTERRUPTION);
    plant.signal(Signal::CONT);
    is_on_time("after a stall");
    let log = plant.stderr();
    assert!(log.contains("after a pause of "), "{log}");
    assert!(log.contains("ticks missed: "), "{log}");
    let missed = stage
        .operator()
        .until("a count of missed ticks", |received| {
            let status = received.status("/auv/plant_sim: vehicle")?;
            let pair = status
                .values
                .iter()
                .find(|pair| pair.key == "ticks missed")?;
            pair.value.parse::<u64>().ok()
        });
    assert!(missed >= 120, "{missed}");
}

fn in_simulated_time_diagnostics_and_log_have_its_stamps(python: &Python, stage: &Stage) {
    let _loop = keep_flying(stage, HOLD_ONE_METRE, &["--factor", "4"]);
    let echo = |topic: &str, type_name: &str| {
        let arguments = [topic, type_name, "--count", "10000", "--timeout", "120"];
        python.start("peer_echo.py", stage.domain(), &arguments)
    };
    let is_simulated = |time: f64| time > 0.0 && time < 1e6;
    // Every node of the loop, once simulated time has come to it.
    let mut from: BTreeSet<String> = BTreeSet::new();
    let everybody = echo("/diagnostics", DiagnosticArray::TYPE_NAME).find(|message| {
        if is_simulated(stamp(message)) {
            from.insert(text(&message["status"][0]["name"]).to_owned());
        }
        from.len() >= 6
    });
    assert!(everybody.is_some(), "{from:?}");
    // A line of the log lasts for ten seconds only: one is caused.
    let mut lines = echo("/rosout", Log::TYPE_NAME);
    for paused in [true, false] {
        assert_eq!(pause(python, stage, paused)["success"], true);
    }
    let resumed = lines.find(|line| {
        text(&line["msg"]).starts_with("resumed at tick") && is_simulated(seconds(&line["stamp"]))
    });
    assert!(resumed.is_some(), "no line in simulated time");
}

fn a_node_describes_its_types_with_their_sources(python: &Python, stage: &Stage) {
    let _controller = stage.node("depth_controller", &[]);
    let ask = |name: &str, hash: &str| {
        let request = json!({"type_name": name, "type_hash": hash, "include_type_sources": true});
        let service = "/auv/depth_controller/get_type_description";
        let kind = "type_description_interfaces/srv/GetTypeDescription";
        let arguments = [service, kind, "--json", &request.to_string()];
        python
            .run("peer_call.py", stage.domain(), &arguments)
            .answer()
    };
    let answer = ask(VehicleState::TYPE_NAME, VehicleState::TYPE_HASH);
    assert_eq!(answer["successful"], true, "{answer}");
    let described = &answer["type_description"]["type_description"];
    assert_eq!(described["type_name"], VehicleState::TYPE_NAME);
    assert_eq!(described["fields"][0]["name"], "header");
    let sources = answer["type_sources"].as_array().unwrap();
    let named: Vec<&str> = sources
        .iter()
        .map(|source| text(&source["type_name"]))
        .collect();
    let expected = [
        VehicleState::TYPE_NAME,
        "builtin_interfaces/msg/Time",
        "std_msgs/msg/Header",
    ];
    assert_eq!(named, expected);
    let file = std::fs::read_to_string(root().join("msgs/msg/VehicleState.msg")).unwrap();
    assert_eq!(sources[0]["raw_file_contents"], file);
    assert_eq!(sources[0]["encoding"], "msg");

    let answer = ask(VehicleState::TYPE_NAME, Log::TYPE_HASH);
    assert_eq!(answer["successful"], false);
    assert!(
        text(&answer["failure_reason"]).contains(VehicleState::TYPE_HASH),
        "{answer}"
    );
}

fn the_levels_of_a_nodes_loggers_are_told_and_set(python: &Python, stage: &Stage) {
    let controller = stage.node("depth_controller", &["enable_logger_service:=true"]);
    let logger = "auv.depth_controller";
    let call = |verb: &str, kind: &str, request: &Value| {
        let service = format!("/auv/depth_controller/{verb}_logger_levels");
        let kind = format!("rcl_interfaces/srv/{kind}LoggerLevels");
        let arguments = [&service, &kind, "--json", &request.to_string()];
        python
            .run("peer_call.py", stage.domain(), &arguments)
            .answer()
    };
    let set = |level: u32| {
        let request = json!({"levels": [{"name": logger, "level": level}]});
        call("set", "Set", &request)["results"][0].clone()
    };
    let get = || call("get", "Get", &json!({"names": [logger, "other"]}))["levels"].clone();
    let change = |gain: &str| {
        let arguments = ["/auv/depth_controller", "set", gain];
        python
            .run("peer_params.py", stage.domain(), &arguments)
            .well();
    };
    assert_eq!(
        get(),
        json!([{"name": logger, "level": 0}, {"name": "other", "level": 0}])
    );
    assert_eq!(set(40)["successful"], true);
    assert_eq!(get()[0]["level"], 40);
    change("depth.p=0.5");
    assert_eq!(set(7)["successful"], false);
    assert_eq!(set(20)["successful"], true);
    change("depth.p=0.7");
    eventually("the second change", || {
        controller.stderr().contains("-> 0.7").then_some(())
    });
    let log = controller.stderr();
    assert!(!log.contains("-> 0.5"), "{log}");
}

fn the_actuator_answers_each_state_once_however_late_the_commands_are(
    python: &Python,
    stage: &Stage,
) {
    // So fast that commands come ticks late.
    let _loop = keep_flying(stage, HOLD_ONE_METRE, &["--factor", "20"]);
    let motions = python.echo(
        stage.domain(),
        "/auv/plane_motion",
        PlaneMotion::TYPE_NAME,
        400,
    );
    let stamps: Vec<f64> = motions.iter().map(stamp).collect();
    assert!(
        stamps.windows(2).all(|pair| pair[0] < pair[1]),
        "{stamps:?}"
    );
}

fn a_qos_that_does_not_fit_is_told_in_rclcpps_words(python: &Python, stage: &Stage) {
    let plant = stage.node("plant_sim", &[]);
    let controller = stage.node("depth_controller", &[]);
    let imu = [
        "/auv/imu",
        sensor_msgs::msg::Imu::TYPE_NAME,
        "--reliability",
        "reliable",
        "--timeout",
        "60",
    ];
    let setpoint = [
        "/auv/depth_setpoint",
        "std_msgs/msg/Float64",
        "--timeout",
        "60",
    ];
    let setpoint = [&setpoint[..], &["--reliability", "best_effort"]].concat();
    let _peers = [
        python.start("peer_echo.py", stage.domain(), &imu),
        python.start("peer_pub.py", stage.domain(), &setpoint),
    ];
    let says = |node: &Process, text: &str| {
        eventually(text, || node.stderr().contains(text).then_some(()));
        assert_eq!(node.stderr().matches("incompatible QoS").count(), 1);
    };
    says(
        &plant,
        "New subscription discovered on topic '/auv/imu', requesting incompatible QoS. No messages will be sent to it. \
         Last incompatible policy: RELIABILITY_QOS_POLICY",
    );
    says(
        &controller,
        "New publisher discovered on topic '/auv/depth_setpoint', offering incompatible QoS. No messages will be received from it. \
         Last incompatible policy: RELIABILITY_QOS_POLICY",
    );
}

/// `ros2` commands warn with each announcement of an endpoint; each command made us announce all of them twice more.
fn a_qos_that_does_not_fit_is_told_once(python: &Python, stage: &Stage) {
    let _plant = stage.node("plant_sim", &[]);
    let imu = ["/auv/imu", sensor_msgs::msg::Imu::TYPE_NAME];
    let reliable = ["--reliability", "reliable", "--timeout", "4"];
    let printed = python.run(
        "peer_echo.py",
        stage.domain(),
        &[&imu[..], &reliable].concat(),
    );
    assert_eq!(printed.status, 1, "{printed:?}");
    let told = printed.complaints.matches("offering incompatible QoS");
    assert_eq!(told.count(), 1, "{}", printed.complaints);
}

/// Fast DDS takes no sample a second time, though it has lost the participant meanwhile.
fn a_node_is_listed_again_after_a_pause(python: &Python, stage: &Stage) {
    let plant = stage.node("plant_sim", &[]);
    let mut tool = python.start("peer_nodes.py", stage.domain(), &["--timeout", "60"]);
    let mut lists = |is_listed: bool| {
        let node = json!("/auv/plant_sim");
        let found = tool.any(|nodes| nodes.as_array().unwrap().contains(&node) == is_listed);
        assert!(found, "listed: {is_listed}");
    };
    lists(true);
    // Until our endpoints have been announced for the last time (RustDDS patch 56).
    std::thread::sleep(Duration::from_secs(6));
    freeze(plant.pid());
    lists(false);
    std::thread::sleep(Duration::from_secs(1));
    plant.signal(Signal::CONT);
    lists(true);
}

fn a_client_of_the_other_middleware_is_told_of_once_and_what_to_set(python: &Python, _: &Stage) {
    let [ours, theirs] = match python.middleware == CYCLONE.middleware {
        true => [RCLPY.middleware, CYCLONE.middleware],
        false => [CYCLONE.middleware, RCLPY.middleware],
    };
    let stage = Stage::with(ours);
    let plant = stage.node("plant_sim", &[]);
    let call = ["/auv/plant_sim/pause", "std_srvs/srv/SetBool", "--json"];
    let call = [&call[..], &["{\"data\": true}", "--timeout", "2"]].concat();
    for _ in 0..2 {
        let called = python.run("peer_call.py", stage.domain(), &call);
        assert_eq!(called.status, 1, "{called:?}");
    }
    let log = plant.stderr();
    let advice = format!(
        "a client of /auv/plant_sim/pause uses the request format of {theirs}; this node uses {ours} and cannot read it. \
         Start both with the same RMW_IMPLEMENTATION"
    );
    assert_eq!(log.matches(&advice).count(), 1, "{log}");
    assert!(!log.contains("request refused"), "{log}");
}

fn a_log_line_is_for_late_joiners_no_longer_than_its_lifespan(python: &Python, stage: &Stage) {
    /// What /rosout offers, as in rcl.
    const LIFESPAN: Duration = Duration::from_secs(10);

    let controller = stage.node("depth_controller", &[]);
    let first = |why: &str| {
        let mut log = python.start("peer_echo.py", stage.domain(), &LATE_LOG);
        let line = log.next().unwrap_or_else(|| panic!("{why}"));
        text(&line["msg"]).to_owned()
    };
    let up = "up in domain";
    eventually(up, || controller.stderr().contains(up).then_some(()));
    assert!(first("a late joiner").starts_with(up));
    std::thread::sleep(LIFESPAN);
    let set = ["/auv/depth_controller", "set", "depth.p=0.5"];
    python.run("peer_params.py", stage.domain(), &set).well();
    let line = first("one that comes after the lifespan");
    assert!(line.contains("depth.p"), "{line}");
}

fn messages_and_answers_larger_than_a_datagram_arrive_whatever_their_length(
    python: &Python,
    stage: &Stage,
) {
    let _controller = stage.node("depth_controller", &[]);
    let names = ["depth.p"; 500];
    let ask = [&["/auv/depth_controller", "describe"], &names[..]].concat();
    let described = python.run("peer_params.py", stage.domain(), &ask).well();
    assert_eq!(described.len(), names.len());

    let operator = stage.operator();
    let texts = operator
        .rt
        .publisher::<std_msgs::msg::String>("texts", Qos::reliable(10))
        .unwrap();
    let lengths = [100_000, 100_001, 100_002, 100_003];
    let echo = ["/auv/texts", std_msgs::msg::String::TYPE_NAME];
    let echo = [
        &echo[..],
        &[
            "--count",
            "4",
            "--timeout",
            "60",
            "--reliability",
            "reliable",
        ],
    ]
    .concat();
    let mut hears = python.start("peer_echo.py", stage.domain(), &echo);
    eventually("a reader", || {
        operator.rt.next(Duration::from_millis(10));
        (texts.readers() == 1).then_some(())
    });
    operator.rt.next(Duration::from_secs(1));
    for length in lengths {
        let data = "x".repeat(length);
        assert!(texts.publish(&std_msgs::msg::String { data }));
        let heard = hears.next().unwrap_or_else(|| panic!("{length}"));
        assert_eq!(text(&heard["data"]).len(), length);
    }
}

fn a_reader_that_does_not_acknowledge_loses_and_is_named_and_nobody_else(
    python: &Python,
    stage: &Stage,
) {
    /// Twice the number of samples that the middleware keeps for its readers.
    const SAMPLES: u32 = 2 * 8192;

    let operator = stage.operator();
    let numbers = operator
        .rt
        .publisher::<Float64>("numbers", Qos::reliable(10))
        .unwrap();
    let echo = [
        "/auv/numbers",
        Float64::TYPE_NAME,
        "--reliability",
        "reliable",
        "--count",
        "1000000",
        "--timeout",
        "120",
    ];
    let [mut hears, mut deaf] =
        [(); 2].map(|()| python.start("peer_echo.py", stage.domain(), &echo));
    // A reader that is discovered may not have discovered the writer: both hear before one goes deaf.
    std::thread::scope(|scope| {
        let heard = [&mut hears, &mut deaf].map(|it| scope.spawn(|| it.next().is_some()));
        eventually("two readers that hear", || {
            numbers.publish(&Float64 { data: -1.0 });
            operator.rt.next(Duration::from_millis(10));
            let all = numbers.readers() == 2 && heard.iter().all(|it| it.is_finished());
            all.then_some(())
        });
    });
    let deaf_pid = Pid::from_raw(i32::try_from(deaf.id()).unwrap()).unwrap();
    freeze(deaf_pid);
    for number in 0..SAMPLES {
        let data = f64::from(number);
        // The one that hears may be slow for a while on a busy machine; a deaf one would be so for ever.
        eventually("room for the next sample", || {
            numbers.publish(&Float64 { data }).then_some(())
        });
    }
    let last = f64::from(SAMPLES - 1);
    assert!(hears.any(|message| number(&message["data"]) == last));

    let mut log = python.start("peer_echo.py", stage.domain(), &LATE_LOG);
    let named = std::thread::spawn(move || {
        let says = "/auv/numbers: the subscription ";
        let named = log.any(|line| {
            let line = text(&line["msg"]);
            line.starts_with(says) && line.contains(" does not acknowledge messages and has lost ")
        });
        assert!(named, "the one that is deaf");
    });
    // It goes on losing, and is named again: the peer may hear of it only when the first line's lifespan is over.
    eventually("the name of the one that is deaf", || {
        for _ in 0..200 {
            numbers.publish(&Float64 { data: last });
        }
        operator.rt.next(Duration::from_millis(10));
        named.is_finished().then_some(())
    });
    named.join().unwrap();
    drop(deaf);
}

fn a_reader_that_comes_late_costs_nobody_a_sample(python: &Python, stage: &Stage) {
    /// Twice the number of samples that the middleware keeps for its readers.
    const SAMPLES: u32 = 2 * 8192;

    let operator = stage.operator();
    let numbers = operator
        .rt
        .publisher::<Float64>("numbers", Qos::reliable(10))
        .unwrap();
    for number in 0..SAMPLES {
        let data = f64::from(number);
        eventually("room for the next sample", || {
            numbers.publish(&Float64 { data }).then_some(())
        });
    }
    let echo = ["/auv/numbers", Float64::TYPE_NAME, "--timeout", "90"];
    let echo = [&echo[..], &["--reliability", "reliable"]].concat();
    let mut reader = python.start("peer_echo.py", stage.domain(), &echo);
    let publish = |data| {
        assert!(numbers.publish(&Float64 { data }), "there is room");
        operator.rt.next(Duration::from_millis(1));
    };
    eventually("a reader", || {
        publish(1.0);
        (numbers.readers() == 1).then_some(())
    });
    for _ in 0..1000 {
        publish(2.0);
    }
    assert!(reader.next().is_some());
}

fn the_identifier_publishes_its_model_and_forgets_it_when_asked(python: &Python, stage: &Stage) {
    let square_wave = "  depth_controller:
    mode: open_loop
    identification: {signal: square, amplitude: 0.1, period: 4.0}
";
    let _loop = keep_flying(stage, square_wave, &["--factor", "2"]);
    let call = |service: &str, type_name: &str, request: &str| {
        let arguments = [service, type_name, "--json", request];
        python
            .run("peer_call.py", stage.domain(), &arguments)
            .answer()
    };
    let fit = || call("/auv/sysid/fit", "planesman_msgs/srv/Fit", "{}");

    let answer = eventually("a valid model", || {
        let answer = fit();
        (answer["success"] == true).then_some(answer)
    });
    let model = &answer["model"];
    assert_eq!(model["input"], "plane_motion:dive_planes");
    assert_eq!(
        model["a"].as_array().unwrap().len() as u64,
        model["order"].as_u64().unwrap()
    );
    assert!(number(&model["fit"]) > 50.0, "{model}");
    assert!(number(&model["samples"]) > 50.0, "{model}");

    // Frozen, it learns nothing of what the vehicle does meanwhile.
    let freeze = |data: bool| {
        let request = json!({"data": data}).to_string();
        call("/auv/sysid/freeze", "std_srvs/srv/SetBool", &request)
    };
    assert_eq!(freeze(true)["success"], true);
    let frozen = fit();
    assert_eq!(frozen["model"]["frozen"], true);
    assert_eq!(fit()["model"]["a"], frozen["model"]["a"]);
    assert_eq!(freeze(false)["message"], "estimation resumed");

    // With the vehicle paused there is nothing new to learn.
    let pause = r#"{"data": true}"#;
    let paused = call("/auv/plant_sim/pause", "std_srvs/srv/SetBool", pause);
    assert_eq!(paused["success"], true);
    let reset = call("/auv/sysid/reset", "std_srvs/srv/Trigger", "{}");
    assert_eq!(reset["success"], true);
    let after = fit();
    assert_eq!(after["success"], false);
    assert_eq!(after["model"]["samples"], 0, "{after}");
    assert_ne!(after["message"], "", "it says why");
}

fn a_foreign_actuator_flies_the_vehicle_with_joint_states_alone(python: &Python, stage: &Stage) {
    let _plant = stage.node("plant_sim", &[]);
    let _controller = stage.node("depth_controller", &["depth_setpoint:=1.0"]);
    let domain = stage.domain();
    let arguments = [
        "/auv/state",
        VehicleState::TYPE_NAME,
        "--timeout",
        "60",
        "--count",
        "1000",
    ];
    let mut states = python.start("peer_echo.py", domain, &arguments);
    let alone = states.next().unwrap();
    assert_eq!(alone["dive_planes"], 0.0, "nobody moves the planes yet");

    let _actuator = python.start("peer_actuator.py", domain, &["--rate", "0.2"]);
    let answered = u64::from(VehicleState::PLANES_ANSWERED);
    let (mut largest, mut last) = (0.0_f64, Value::Null);
    let dives = states.any(|state| {
        if state["planes_source"] == answered {
            largest = largest.max(number(&state["dive_planes"]));
        }
        last = state;
        number(&last["depth"]) > 0.15
    });
    assert!(dives, "it does not dive: {last}");
    assert!(largest > 0.2, "the planes went to {largest} rad at most");
    assert!(
        number(&last["pitch"]) < 0.0,
        "diving planes put the bow down: {last}"
    );
}

fn a_goal_is_sent_followed_and_cancelled_as_ros2_action_does(python: &Python, stage: &Stage) {
    let _nodes = [
        stage.node("plant_sim", &["factor:=4.0"]),
        stage.node("dha_actuator", &[]),
        stage.node("depth_controller", &["mode:=open_loop"]),
    ];
    let action = "/auv/depth_controller/manoeuvre";
    let ask = |goal: serde_json::Value, more: &[&str]| {
        let goal = goal.to_string();
        let arguments = [action, "planesman_msgs/action/Manoeuvre", "--json", &goal];
        let arguments = [&arguments, more].concat();
        python.run("peer_action.py", stage.domain(), &arguments)
    };

    let sinusoid = json!({"name": "sinusoid", "amplitude": 0.1, "period": 1.0, "duration": 2.0});
    let printed = ask(sinusoid, &[]).well();
    assert_eq!(printed[0]["accepted"], true);
    let feedback = printed.iter().filter(|line| line["feedback"].is_object());
    assert!(feedback.count() >= 5, "{printed:?}");
    let end = printed.last().unwrap();
    assert_eq!(end["status"], "SUCCEEDED");
    assert_eq!(end["result"]["completed"], true);
    let statuses = end["statuses"].as_array().unwrap();
    assert_eq!(statuses.last().unwrap(), "SUCCEEDED", "{statuses:?}");

    let endless = json!({"name": "square", "amplitude": 0.1, "period": 1.0, "duration": 1000.0});
    let printed = ask(endless, &["--cancel-after", "0.5"]).well();
    // Only rclpy's client keeps a handle of its goal.
    if let Some(handle) = printed.iter().find_map(|line| line.get("handle")) {
        assert_eq!(handle, "EXECUTING", "Ctrl-C does not cancel: {printed:?}");
    }
    let end = printed.last().unwrap();
    assert_eq!(end["status"], "CANCELED", "{printed:?}");
    assert_eq!(end["result"]["completed"], false);

    let printed = ask(json!({"name": "loop"}), &[]).well();
    let end = printed.last().unwrap();
    assert_eq!(end["status"], "ABORTED");
    let reason = end["result"]["message"].as_str().unwrap();
    assert!(
        reason.contains("'loop'") && reason.contains("run_7_3"),
        "{reason}"
    );
}

#[test]
fn what_ros2_param_dumps_it_loads_again_into_every_node() {
    let Some(python) = RCLPY.found() else { return };
    let stage = Stage::with(python.middleware);
    for name in NODES {
        let node = stage.node(name, &[]);
        let full_name = full_name(name);
        let results = python.run("peer_params.py", stage.domain(), &[&full_name, "reload"]);
        for result in results.well() {
            assert_eq!(result["successful"], true, "{name}: {result}");
        }
        node.signal(Signal::INT);
        node.finish().success();
    }
}

#[test]
fn a_controller_written_in_rclpy_flies_the_vehicle_in_lockstep() {
    let Some(python) = RCLPY.found() else { return };
    let stage = Stage::with(python.middleware);
    let _nodes = [
        stage.node("plant_sim", &["time:=lockstep"]),
        stage.node("dha_actuator", &["lockstep:=true", "use_sim_time:=true"]),
    ];
    let own = root().join("launch-scripts/examples/own_controller.py");
    let mut own = python.node(&own, stage.domain());
    own.args(["--ros-args", "-r", "__ns:=/auv", "-p", "depth:=0.914"]);
    let _controller = Running::of(own);

    let arguments = [
        "/auv/state",
        VehicleState::TYPE_NAME,
        "--timeout",
        "90",
        "--count",
        "100000",
    ];
    let states = python.start("peer_echo.py", stage.domain(), &arguments);
    let mut deepest = 0.0_f64;
    let last = states
        .inspect(|state| deepest = deepest.max(number(&state["depth"])))
        .find(|state| stamp(state) >= 60.0)
        .unwrap();
    assert!((number(&last["depth"]) - 0.914).abs() < 0.03, "{last}");
    assert!(deepest < 1.0, "overshoot to {deepest} m");
}

#[test]
fn the_identifier_learns_a_robot_of_another_make_while_it_moves() {
    let Some(python) = RCLPY.found() else { return };
    let stage = Stage::with(python.middleware);
    let _robot = python.start("peer_robot.py", stage.domain(), &["--timeout", "120"]);
    let _sysid = stage.node(
        "sysid",
        &[
            "input:=/fins:data",
            "input_type:=std_msgs/msg/Float64",
            "output:=/imu:angular_velocity.y",
            "output_type:=sensor_msgs/msg/Imu",
            "order:=2",
            "first_moment:=false",
        ],
    );
    let call = |service: &str, type_name: &str| {
        let arguments = [service, type_name];
        let called = python.run("peer_call.py", stage.domain(), &arguments);
        called.answer()
    };
    // The robot's clock is the machine's: a tick that a busy machine makes half an interval late is a wrong sample, and
    // the estimate begins anew.
    eventually("the robot's model", || {
        let answer = call("/auv/sysid/fit", "planesman_msgs/srv/Fit");
        let is = |name: &str, expected: [f64; 2]| {
            let found = answer["model"][name].as_array().unwrap();
            let mut both = found.iter().map(number).zip(expected);
            found.len() == 2 && both.all(|(found, expected)| (found - expected).abs() < 1e-3)
        };
        let is_valid = answer["success"] == true;
        let is_the_robot = is_valid && is("a", [-1.6, 0.68]) && is("b", [0.05, 0.0]);
        if is_valid && !is_the_robot {
            let reset = call("/auv/sysid/reset", "std_srvs/srv/Trigger");
            assert_eq!(reset["success"], true);
        }
        is_the_robot.then_some(())
    });
}

#[test]
fn messages_meet_by_their_stamps_and_with_a_sensor_of_elsewhere() {
    let Some(python) = RCLPY.found() else { return };
    let stage = Stage::with(python.middleware);
    let _loop = ["plant_sim", "dha_actuator", "depth_controller"].map(|name| stage.node(name, &[]));
    let arguments = ["--sets", "40", "--timeout", "60"];
    let sets = python.run("peer_sync.py", stage.domain(), &arguments);
    sets.answer();
}

#[test]
fn a_type_that_only_its_publisher_knows_is_recorded_with_its_definition() {
    let (Some(python), Some(reader)) = (RCLPY.found(), Python::find()) else {
        return;
    };
    let stage = Stage::with(python.middleware);
    let out = stage.path("bag");
    let output = format!("output:={out}");
    let recorder = stage.node("recorder", &[&output, "record.all_topics:=true"]);
    let fix = "geometry_msgs/msg/PoseStamped";
    assert!(planesman_msgs::type_info(fix).is_none());
    let arguments = [
        "/dock",
        fix,
        "--json",
        r#"{"pose": {"position": {"z": 2.5}}}"#,
    ];
    let sent = python
        .run("peer_pub.py", stage.domain(), &arguments)
        .answer();
    assert_eq!(sent["sent"], 1);
    recorder.signal(Signal::TERM);
    recorder.finish().success();
    let found = reader.read_bag(&[out.as_ref()]);
    let dock = &found["topics"]["/dock"];
    assert_eq!(dock["type"], fix);
    assert_eq!(number(&dock["values"][0]["pose"]["position"]["z"]), 2.5);
}
