//! Messages that speak for others: nobody's message ends a flight.

use crate::stage;
use std::path::Path;

use planesman::run_folder::RunFolder;
use planesman_flight::flight::Flight;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, TickAnswer, VehicleState};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_node::{Direction, Qos};

use stage::{Process, Received, Stage, scenario};

/// Vehicle time of a flight, s, and its ticks.
const SECONDS: f64 = 60.0;
const TICKS: u64 = 1200;

fn status(name: &str, level: u8, message: &str, values: &[(&str, &str)]) -> DiagnosticArray {
    let pair = |(key, value): &(&str, &str)| KeyValue {
        key: (*key).to_owned(),
        value: (*value).to_owned(),
    };
    DiagnosticArray {
        status: vec![DiagnosticStatus {
            level,
            name: name.to_owned(),
            message: message.to_owned(),
            values: values.iter().map(pair).collect(),
            ..DiagnosticStatus::default()
        }],
        ..DiagnosticArray::default()
    }
}

/// Claims to the roles of vehicle and launcher, in both forms that have been on the wire, and the words by which plant_sim
/// and recorder end a flight.
fn forged() -> Vec<DiagnosticArray> {
    let claim = [
        ("stage", "used"),
        ("since", "0"),
        ("id", "0"),
        ("who", "nobody"),
    ];
    vec![
        status("x: claim to /auv/state", 0, "used", &claim),
        status("x: claim to launch /auv", 0, "used", &claim),
        status("/auv/plant_sim: vehicle", 0, "done", &[]),
        status("/auv/recorder: bag", DiagnosticStatus::ERROR, "full", &[]),
    ]
}

fn dive(stage: &Stage, more: &[&str]) -> Process {
    let file = stage.file("flight.yaml", scenario(SECONDS, "  sysid: {start: 1.0}\n"));
    stage.start(&[&["dive", &file, "--out", "run"], more].concat())
}

/// Waits for a dive's end and checks that it flew every tick.
fn flies_to_its_end(stage: &Stage, dive: Process) {
    dive.finish_within(stage::LONG_WORK).success();
    let run = RunFolder::open(Path::new(&stage.path("run"))).unwrap();
    assert_eq!(
        Flight::read(&run.bag()).unwrap().counts["/auv/state"],
        TICKS
    );
}

/// The messages that a node has refused on a topic it receives, by its diagnostics.
fn refused(received: &Received, node: &str, topic: &str) -> Option<u64> {
    let Received::Diagnostics(array) = received else {
        return None;
    };
    let connections = planesman_node::Connections::from_diagnostics(array)?;
    (connections.node == node).then(|| {
        connections
            .find(Direction::Subscription, topic)
            .map(|it| it.refused)
    })?
}

#[test]
fn a_claim_without_the_vehicle_and_words_of_other_nodes_end_no_flight() {
    for pace in [&[][..], &["--factor", "20"]] {
        let stage = Stage::new();
        let operator = stage.operator();
        let publisher = operator
            .rt
            .publisher::<DiagnosticArray>("/diagnostics", Qos::reliable(100))
            .unwrap();
        let dive = dive(&stage, pace);
        // Before the first tick, in flight, and until the end.
        let mut last = 0;
        while last < 40 {
            for array in forged() {
                publisher.publish(&array);
            }
            operator.state("ticks", |_| true);
            last += 1;
        }
        flies_to_its_end(&stage, dive);
    }
}

#[test]
fn a_state_of_somebody_else_does_not_end_the_dive_for_its_launcher() {
    let stage = Stage::new();
    let operator = stage.operator();
    let dive = dive(&stage, &[]);
    let state = operator.state("a tick", |state| state.header.stamp.nanos() > 0);
    let publisher = operator
        .rt
        .publisher::<VehicleState>("state", Qos::reliable(100))
        .unwrap();
    let mut later = state;
    later.header.stamp = Time::from_nanos(1_000_000_000_000);
    publisher.publish(&later);
    flies_to_its_end(&stage, dive);
}

#[test]
fn an_answer_in_the_name_of_a_member_is_refused_and_the_tick_waits_for_the_member() {
    let stage = Stage::new();
    let operator = stage.operator();
    let publisher = operator
        .rt
        .publisher::<TickAnswer>("tick_answer", Qos::reliable(100))
        .unwrap();
    let dive = dive(&stage, &[]);
    let mut forged = 0;
    let told = operator.until("refusals", |received| {
        if let Received::State(state) = &received {
            for member in ["sysid", "recorder"] {
                let mut answer = TickAnswer {
                    member: member.to_owned(),
                    ..TickAnswer::default()
                };
                answer.header.stamp = state.header.stamp.clone();
                publisher.publish(&answer);
                forged += 1;
            }
        }
        let refused = refused(&received, "/auv/plant_sim", "/auv/tick_answer")?;
        (refused > 0).then_some(refused)
    });
    assert!(told <= forged);
    flies_to_its_end(&stage, dive);
}

/// What no actuator can mean, from before the flight on: refused and counted, and the actuator is heard.
#[test]
fn a_motion_without_samples_ends_no_flight_and_makes_nobody_the_actuator() {
    let stage = Stage::new();
    let operator = stage.operator();
    let qos = Qos::reliable(100);
    let motions = operator.rt.publisher::<PlaneMotion>("plane_motion", qos);
    let planes = operator.rt.publisher::<JointState>("planes", qos);
    let (motions, planes) = (motions.unwrap(), planes.unwrap());
    let dive = dive(&stage, &[]);
    let (mut on_motion, mut on_planes) = (0, 0);
    operator.until("refusals of both", |received| {
        if matches!(received, Received::Diagnostics(_)) {
            motions.publish(&PlaneMotion::default());
            planes.publish(&JointState::default());
        }
        let of = |topic| refused(&received, "/auv/plant_sim", topic).unwrap_or(0);
        on_motion = of("/auv/plane_motion").max(on_motion);
        on_planes = of("/auv/planes").max(on_planes);
        (on_motion > 0 && on_planes > 0).then_some(())
    });
    flies_to_its_end(&stage, dive);
}

#[test]
fn a_clock_of_somebody_else_ends_no_flight_in_lockstep() {
    let stage = Stage::new();
    let operator = stage.operator();
    let publisher = operator
        .rt
        .publisher::<Clock>("/clock", Qos::reliable(10))
        .unwrap();
    let dive = dive(&stage, &[]);
    for second in [1_000_000, 0, -5, 2_000_000, 1] {
        operator.state("a tick", |_| true);
        publisher.publish(&Clock {
            clock: Time::from_nanos(second * 1_000_000_000),
        });
    }
    flies_to_its_end(&stage, dive);
}
