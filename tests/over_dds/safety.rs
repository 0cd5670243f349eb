//! Beyond its envelope the vehicle climbs, then its planes are neutral, and so they stay until somebody resets
//! the fault; over DDS, as an operator sees it.

use crate::stage;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use planesman_msgs::lifecycle_msgs::msg::Transition;
use planesman_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
use planesman_msgs::planesman_msgs::action::{Manoeuvre, ManoeuvreGoal};
use planesman_msgs::planesman_msgs::msg::ControlState;
use planesman_msgs::rcl_interfaces::msg::Parameter;
use planesman_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use planesman_node::{ActionClient, Client, GoalStatus};
use stage::{Operator, PATIENCE, Received, Stage, double};

/// The controller's next state that `wanted` likes.
fn control(operator: &Operator, what: &str, wanted: fn(&ControlState) -> bool) -> ControlState {
    operator.until(what, |received| match received {
        Received::Control(control) if wanted(&control) => Some(control),
        _ => None,
    })
}

#[test]
fn a_vehicle_too_deep_climbs_and_obeys_again_only_after_a_reset() {
    let stage = Stage::new();
    let operator = stage.operator();
    let reset: Client<Trigger> = operator.rt.client("depth_controller/reset_fault").unwrap();
    let action: ActionClient<Manoeuvre> = operator
        .rt
        .action_client("depth_controller/manoeuvre", Received::Progress)
        .unwrap();
    let _plant = stage.node("plant_sim", &["initial_depth:=3.0", "factor:=4.0"]);
    let _actuator = stage.node("dha_actuator", &[]);
    let controller = stage.node(
        "depth_controller",
        &[
            "depth_setpoint:=1.0",
            "depth.max:=2.0",
            "safety.floor:=2.0",
            "safety.climb_time:=2.0",
        ],
    );

    let climbs = control(&operator, "a climb", |control| control.climbing);
    assert_eq!(climbs.fault, ControlState::FAULT_FLOOR);
    assert!((climbs.dive_planes + 10_f64.to_radians()).abs() < 1e-12);
    let over = control(&operator, "the end of the climb", |control| {
        !control.climbing
    });
    assert_eq!(over.fault, ControlState::FAULT_FLOOR);
    assert_eq!(over.dive_planes, 0.0);
    let level = operator.status("/auv/depth_controller: loop", "reset_fault");
    assert_eq!(level, DiagnosticStatus::ERROR);

    // Meanwhile a manoeuvre is refused with the reason, and the fault cannot be wished away.
    let goal = ManoeuvreGoal {
        name: "run_8_1".to_owned(),
        ..ManoeuvreGoal::default()
    };
    let flown = async {
        let id = action.send(goal, PATIENCE).await?.unwrap();
        action.result(id, PATIENCE).await
    };
    let (status, result) = operator.rt.block_on(flown).unwrap();
    assert_eq!(status, GoalStatus::Aborted);
    assert!(
        result.message.contains("safety.floor"),
        "{}",
        result.message
    );
    let answer = operator.call(&reset, TriggerRequest::default());
    assert!(!answer.success);
    assert!(
        answer.message.contains("still deeper"),
        "{}",
        answer.message
    );

    // Neither change is allowed without the other; both together are, and then so is the reset.
    let change = |parameters: &[Parameter]| operator.set("depth_controller", parameters);
    let (deeper, floor) = (double("depth.max", 9.0), double("safety.floor", 9.0));
    let refusal = change(std::slice::from_ref(&deeper));
    assert!(!refusal.successful);
    assert!(
        refusal.reason.contains("safety.floor"),
        "{}",
        refusal.reason
    );
    assert!(change(&[deeper, floor]).successful);
    let answer = operator.call(&reset, TriggerRequest::default());
    assert!(answer.success, "{}", answer.message);
    let obeys = control(&operator, "control", |control| {
        control.fault == ControlState::FAULT_NONE && control.dive_planes != 0.0
    });
    assert!(obeys.dive_planes < 0.0, "it rises to its setpoint");
    let level = operator.status("/auv/depth_controller: loop", "controlling");
    assert_eq!(level, DiagnosticStatus::OK);
    assert!(
        controller
            .stderr()
            .contains("fault: deeper than safety.floor")
    );
}

#[test]
fn an_actuator_that_is_cut_off_is_an_error_of_the_vehicle_until_it_answers_again() {
    for (time, silence) in [
        ("time:=real", "no answer of the actuator, planes held for"),
        (
            "time:=lockstep",
            "waiting for the controller: nobody publishes plane_command for",
        ),
    ] {
        let stage = Stage::new();
        let operator = stage.operator();
        let plant = stage.node("plant_sim", &[time, "answer_timeout:=1.5"]);
        let level = operator.status("/auv/plant_sim: vehicle", silence);
        assert_eq!(level, DiagnosticStatus::ERROR, "{time}");
        assert!(plant.stderr().contains(silence), "{}", plant.stderr());
        let _others = ["depth_controller", "dha_actuator"].map(|name| stage.node(name, &[]));
        let level = operator.status("/auv/plant_sim: vehicle", "running");
        assert_eq!(level, DiagnosticStatus::OK, "{time}");
    }
}

/// The numbers of commands and of motions while the vehicle goes on for 20 states.
fn answered(operator: &Operator) -> (u32, u32) {
    let (mut states, mut commands, mut motions) = (0, 0, 0);
    operator.until("twenty states", |received| {
        match received {
            Received::State(_) => states += 1,
            Received::Control(_) => commands += 1,
            Received::Actuator(_) => motions += 1,
            _ => {}
        }
        (states >= 20).then_some(())
    });
    (commands, motions)
}

#[test]
fn a_managed_controller_and_actuator_command_only_while_they_are_active() {
    let stage = Stage::new();
    let operator = stage.operator();
    let _plant = stage.node("plant_sim", &["factor:=4.0"]);
    let names = ["depth_controller", "dha_actuator"];
    let _nodes = names.map(|name| stage.node(name, &["managed:=true"]));
    let clients: [Client<ChangeState>; 2] = names.map(|name| {
        let service = format!("{name}/change_state");
        operator.rt.client(&service).unwrap()
    });
    let change = |client: &Client<ChangeState>, label: &str| {
        let transition = Transition {
            id: 0,
            label: label.to_owned(),
        };
        operator
            .call(client, ChangeStateRequest { transition })
            .success
    };
    for client in &clients {
        assert!(!change(client, "activate"), "it is not configured");
        assert!(change(client, "configure"));
    }
    assert_eq!(answered(&operator), (0, 0));
    operator.status("/auv/dha_actuator: actuator", "inactive");

    for client in &clients {
        assert!(change(client, "activate"));
    }
    operator.status("/auv/depth_controller: loop", "controlling");
    operator.status("/auv/dha_actuator: actuator", "following");
    let (commands, motions) = answered(&operator);
    assert!(commands >= 10 && motions >= 10, "{commands}, {motions}");

    for client in &clients {
        assert!(change(client, "deactivate"));
    }
    answered(&operator); // What was on its way.
    assert_eq!(answered(&operator), (0, 0));
    operator.status("/auv/depth_controller: loop", "inactive");
}
