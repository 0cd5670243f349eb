//! Two that do the same thing in one place: one of them does it, the other says who.

use crate::recorded;
use crate::stage;
use std::path::Path;

use planesman_flight::flight::Flight;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use stage::{Process, Received, Stage, eventually, scenario};

#[test]
fn of_two_dives_started_at_once_one_flies_and_the_other_says_who_holds_the_loop() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(5.0, "  sysid: {start: 1.0}\n"));
    let dives = ["one", "other"].map(|name| stage.start(&["dive", &file, "--out", name]));
    let pids = dives.each_ref().map(|dive| dive.id());
    let outcomes = dives.map(|dive| dive.finish());
    let flown = outcomes.iter().position(|outcome| outcome.status.success());
    let flown = flown.unwrap_or_else(|| panic!("{outcomes:#?}"));
    let refused = &outcomes[1 - flown];
    assert_eq!(refused.status.code(), Some(1), "{outcomes:#?}");
    let complaint = refused.complaints().join("\n");
    let holder = format!("another dive, process {}", pids[flown]);
    assert!(complaint.contains(&holder), "{holder}: {complaint}");
    assert!(outcomes[flown].stdout.contains(" for 5 s"), "{outcomes:#?}");
}

#[test]
fn a_second_vehicle_is_refused_and_the_first_flies_on() {
    let stage = Stage::new();
    let vehicle = stage.node("plant_sim", &["speed:=0.5"]);
    let operator = stage.operator();
    let before = operator.state("a flying vehicle", |_| true);
    let second = stage.node("plant_sim", &["speed:=0.25"]).finish();
    assert_eq!(second.status.code(), Some(1), "{second:#?}");
    let complaint = second.complaints().join("\n");
    let holder = format!("process {}", vehicle.id());
    assert!(complaint.contains(&holder), "{complaint}");
    assert!(complaint.contains("/auv/state"), "{complaint}");
    // It has said nothing: each state is later than the one before, and of the first one's speed.
    let mut last = before.header.stamp.nanos();
    for _ in 0..20 {
        let state: VehicleState = operator.state("the first vehicle", |_| true);
        assert_eq!(state.surge, 0.5);
        assert!(state.header.stamp.nanos() > last);
        last = state.header.stamp.nanos();
    }
}

#[test]
fn two_controllers_or_actuators_are_an_error_that_each_of_them_tells() {
    let stage = Stage::new();
    for (node, topic) in [
        ("depth_controller", "/auv/plane_command"),
        ("dha_actuator", "/auv/plane_motion"),
    ] {
        let both = [stage.node(node, &[]), stage.node(node, &[])];
        let operator = stage.operator();
        let name = format!("/auv/{node}: connections");
        let level = operator.until("an error", |received: Received| {
            let status = received.status(&name)?;
            let names_topic = status.message.contains(topic);
            names_topic.then_some(status.level)
        });
        assert_eq!(level, DiagnosticStatus::ERROR);
        let tells = |one: &Process| {
            let log = one.stderr();
            log.lines()
                .any(|line| line.starts_with("[ERROR]") && line.contains(topic))
        };
        eventually("both logs", || both.iter().all(tells).then_some(()));
    }
}

#[test]
fn dives_in_two_namespaces_fly_side_by_side_each_by_its_own_clock() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", scenario(5.0, "  sysid: {start: 1.0}\n"));
    let dives = ["auv", "auv2"].map(|name| {
        let namespace = format!("/{name}");
        let out = stage.path(name);
        stage.start(&["dive", &file, "--namespace", &namespace, "--out", &out])
    });
    for dive in dives {
        dive.finish().success();
    }
    for (name, clock, other) in [
        ("auv", "/clock", "/auv2/clock"),
        ("auv2", "/auv2/clock", "/clock"),
    ] {
        let bag = Path::new(&stage.path(name)).join("bag");
        let flight = Flight::read(&bag).unwrap();
        assert!(flight.counts.contains_key(clock) && !flight.counts.contains_key(other));
        let states = recorded::messages::<VehicleState>(&bag, &format!("/{name}/state")).unwrap();
        let mut stamps: Vec<i64> = states.iter().map(|s| s.header.stamp.nanos()).collect();
        stamps.dedup();
        assert_eq!(stamps.len(), 100);
    }
}
