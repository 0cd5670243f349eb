//! Manoeuvres asked of the controller's action over DDS: executed on the planes, reported, cancelled, replaced,
//! refused.

use crate::stage;
use std::cell::Cell;
use std::collections::BTreeMap;

use planesman_msgs::planesman_msgs::action::{
    Manoeuvre, ManoeuvreFeedback, ManoeuvreGoal, ManoeuvreResult,
};
use planesman_msgs::planesman_msgs::srv::{Step, StepRequest};
use planesman_node::{ActionClient, Client, GoalId, GoalStatus};
use stage::{Operator, PATIENCE, Process, Received, Stage, text};

/// The sampling time, ns.
const TICK: i64 = 50_000_000;

/// The loop in lockstep, paused between steps, and its controller's action.
struct Flight {
    operator: Operator,
    step: Client<Step>,
    action: ActionClient<Manoeuvre>,
    /// Ticks flown.
    flown: Cell<i64>,
    _nodes: [Process; 3],
}

impl Flight {
    fn begin(stage: &Stage, controller: &[&str]) -> Self {
        let operator = stage.operator();
        let plant = ["time:=lockstep", "start_paused:=true", "initial_depth:=1.0"];
        let controller = [&["use_sim_time:=true"], controller].concat();
        let nodes = [
            stage.node("plant_sim", &plant),
            stage.node("dha_actuator", &["lockstep:=true", "use_sim_time:=true"]),
            stage.node("depth_controller", &controller),
        ];
        let flight = Self {
            step: operator.rt.client("plant_sim/step").unwrap(),
            action: operator
                .rt
                .action_client("depth_controller/manoeuvre", Received::Progress)
                .unwrap(),
            operator,
            flown: Cell::new(0),
            _nodes: nodes,
        };
        flight.fly(1);
        flight
    }

    fn fly(&self, ticks: u32) {
        let answer = self.operator.call(&self.step, StepRequest { ticks });
        assert!(answer.success, "{}", answer.message);
        self.flown.set(self.flown.get() + i64::from(ticks));
    }

    fn send(&self, goal: ManoeuvreGoal) -> GoalId {
        let sent = self.action.send(goal, PATIENCE);
        self.operator.rt.block_on(sent).unwrap().unwrap()
    }

    fn result(&self, id: GoalId) -> (GoalStatus, ManoeuvreResult) {
        let result = self.action.result(id, PATIENCE);
        self.operator.rt.block_on(result).unwrap()
    }

    /// The plane angles added by the manoeuvre at the next ticks. A repeated answer counts once.
    fn offsets(&self, ticks: u32) -> Vec<f64> {
        let first = self.flown.get() * TICK;
        self.fly(ticks);
        let mut offsets = BTreeMap::new();
        self.operator.until("as many answers", |received| {
            if let Received::Control(control) = received {
                offsets.insert(control.header.stamp.nanos(), control.manoeuvre);
            }
            (offsets.range(first..).count() == ticks as usize).then_some(())
        });
        offsets.split_off(&first).into_values().collect()
    }
}

/// A pulse of 0.1 rad, four ticks long.
fn pulse() -> ManoeuvreGoal {
    ManoeuvreGoal {
        name: "pulse".to_owned(),
        amplitude: 0.1,
        period: 0.2,
        ..ManoeuvreGoal::default()
    }
}

#[test]
fn a_pulse_is_flown_told_of_and_completed() {
    let stage = Stage::new();
    let flight = Flight::begin(&stage, &["mode:=open_loop"]);
    let id = flight.send(pulse());
    assert_eq!(flight.offsets(6), [0.1, 0.1, 0.1, 0.1, 0.0, 0.0]);
    let (status, result) = flight.result(id);
    assert_eq!(status, GoalStatus::Succeeded);
    assert!(result.completed);
    assert_eq!(
        flight.result(id).0,
        GoalStatus::Succeeded,
        "a late client gets the result"
    );
}

#[test]
fn a_manoeuvre_tells_how_far_it_has_come_and_stops_when_it_is_cancelled() {
    let stage = Stage::new();
    let flight = Flight::begin(&stage, &["mode:=open_loop"]);
    let run = ManoeuvreGoal {
        name: "run_8_1".to_owned(),
        ..ManoeuvreGoal::default()
    };
    let id = flight.send(run);
    flight.fly(30);
    let progress = flight.operator.until(
        "feedback from within the pulse",
        |received| match received {
            Received::Progress(of, progress) if of == id && progress.elapsed >= 1.2 => {
                Some(progress)
            }
            _ => None,
        },
    );
    let ManoeuvreFeedback { dive_planes, .. } = progress;
    assert_eq!(dive_planes, 20_f64.to_radians());

    let cancel = flight.action.cancel(id, PATIENCE);
    assert!(flight.operator.rt.block_on(cancel).unwrap());
    let (status, result) = flight.result(id);
    assert_eq!(status, GoalStatus::Canceled);
    assert!(!result.completed);
    assert_eq!(flight.offsets(2), [0.0, 0.0]);
    let again = flight.action.cancel(id, PATIENCE);
    assert!(!flight.operator.rt.block_on(again).unwrap(), "it has ended");
}

#[test]
fn a_newer_goal_takes_the_place_of_an_older_one() {
    let stage = Stage::new();
    let flight = Flight::begin(&stage, &[]);
    let older = flight.send(pulse());
    let newer = flight.send(ManoeuvreGoal {
        amplitude: -0.1,
        ..pulse()
    });
    let (status, result) = flight.result(older);
    assert_eq!(status, GoalStatus::Aborted);
    assert!(result.message.contains("newer"), "{}", result.message);
    assert_eq!(flight.offsets(5), [-0.1, -0.1, -0.1, -0.1, 0.0]);
    assert_eq!(flight.result(newer).0, GoalStatus::Succeeded);
}

#[test]
fn what_cannot_be_flown_is_refused_with_the_reason() {
    let stage = Stage::new();
    let flight = Flight::begin(&stage, &["planes.limit:=0.2"]);
    let refused = |change: fn(&mut ManoeuvreGoal), phrase: &str| {
        let mut goal = pulse();
        change(&mut goal);
        let (status, result) = flight.result(flight.send(goal));
        assert_eq!(status, GoalStatus::Aborted);
        assert!(result.message.contains(phrase), "{}", result.message);
    };
    refused(|goal| goal.amplitude = 0.3, "planes.limit");
    refused(|goal| goal.name = "roll".to_owned(), "run_9_2");
    refused(|goal| goal.period = 0.0, "period");
    let off = flight
        .operator
        .set("depth_controller", &[text("mode", "off")]);
    assert!(off.successful, "{}", off.reason);
    refused(|_| (), "mode off");
}
