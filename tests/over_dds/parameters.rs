//! Changes by an operator during a dive: gains through the parameter services, setpoints on their
//! topics; and that a bad one changes nothing and is refused with a reason.
//!
//! The vehicle is flown tick by tick, so that it is known between which two ticks a change falls.

use crate::stage;
use planesman_msgs::Message;
use planesman_msgs::Service;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticStatus;
use planesman_msgs::planesman_msgs::msg::{ControlState, DhaState};
use planesman_msgs::planesman_msgs::srv::{Step, StepRequest};
use planesman_msgs::rcl_interfaces::msg::Parameter;
use planesman_msgs::rcl_interfaces::srv::{
    SetParametersAtomically, SetParametersAtomicallyRequest, SetParametersAtomicallyResponse,
};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_node::{Client, Connections, Direction, Publisher, Qos};
use serde::{Deserialize, Serialize};
use stage::{Operator, Process, Received, Signal, Stage, double, text};

/// The sampling time, ns.
const TICK: i64 = 50_000_000;

/// The loop in lockstep, paused between steps.
struct Dive {
    operator: Operator,
    step: Client<Step>,
    controller: Process,
    _plant: Process,
    _actuator: Process,
    /// Ticks flown.
    flown: i64,
}

impl Dive {
    fn begin(stage: &Stage) -> Self {
        let operator = stage.operator();
        let plant = ["time:=lockstep", "start_paused:=true"];
        let mut dive = Self {
            step: operator.rt.client("plant_sim/step").unwrap(),
            _plant: stage.node("plant_sim", &plant),
            _actuator: stage.node("dha_actuator", &["lockstep:=true", "use_sim_time:=true"]),
            controller: stage.node("depth_controller", &["use_sim_time:=true"]),
            operator,
            flown: 0,
        };
        // The first state comes again until the operator hears the answer to it.
        dive.fly(1);
        dive.fly(20);
        dive
    }

    /// Flies some ticks, and returns what the controller did in the last of them.
    fn fly(&mut self, ticks: u32) -> ControlState {
        let last = self.fly_to(ticks);
        let what = format!("the controller's answer at {last} ns");
        self.operator.until(&what, |received| match received {
            Received::Control(control) if control.header.stamp.nanos() == last => Some(control),
            _ => None,
        })
    }

    /// Has some ticks flown, and returns the last one's stamp, ns.
    fn fly_to(&mut self, ticks: u32) -> i64 {
        let answer = self.operator.call(&self.step, StepRequest { ticks });
        assert!(answer.success, "{}", answer.message);
        self.flown += i64::from(ticks);
        (self.flown - 1) * TICK
    }

    /// Flies some ticks, and returns the actuator's state in the last of them.
    fn fly_actuator(&mut self, ticks: u32) -> DhaState {
        let last = self.fly_to(ticks);
        let what = format!("the actuator's answer at {last} ns");
        self.operator.until(&what, |received| match received {
            Received::Actuator(state) if state.header.stamp.nanos() == last => Some(state),
            _ => None,
        })
    }

    /// Sets the controller's parameters.
    fn set<S>(&self, parameters: &[Parameter]) -> SetParametersAtomicallyResponse
    where
        S: Service<Response = SetParametersAtomicallyResponse>,
        S::Request: From<Vec<Parameter>>,
    {
        self.set_of::<S>("depth_controller", parameters)
    }

    /// Sets a node's parameters.
    fn set_of<S>(&self, node: &str, parameters: &[Parameter]) -> SetParametersAtomicallyResponse
    where
        S: Service<Response = SetParametersAtomicallyResponse>,
        S::Request: From<Vec<Parameter>>,
    {
        let name = format!("{node}/set_parameters_atomically");
        let set: Client<S> = self.operator.rt.client(&name).unwrap();
        self.operator.call(&set, parameters.to_vec().into())
    }
}

/// A number that is not finite, let through by whoever sends it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
struct Unchecked<M>(M);

impl<M: Message> Message for Unchecked<M> {
    const TYPE_NAME: &'static str = M::TYPE_NAME;
    const DDS_TYPE_NAME: &'static str = M::DDS_TYPE_NAME;
    const DEFINITION: &'static str = M::DEFINITION;
    const TYPE_HASH: &'static str = M::TYPE_HASH;

    fn first_non_finite(&self) -> Option<String> {
        None
    }
}

impl From<Vec<Parameter>> for Unchecked<SetParametersAtomicallyRequest> {
    fn from(parameters: Vec<Parameter>) -> Self {
        Self(SetParametersAtomicallyRequest { parameters })
    }
}

/// Sets parameters without a look at them.
struct SetUnchecked;

impl Service for SetUnchecked {
    type Request = Unchecked<SetParametersAtomicallyRequest>;
    type Response = SetParametersAtomicallyResponse;
    const TYPE_NAME: &'static str = SetParametersAtomically::TYPE_NAME;
    const TYPE_HASH: &'static str = SetParametersAtomically::TYPE_HASH;
}

/// The proportional share of the dive angle under a gain.
fn share(control: &ControlState, gain: f64) -> f64 {
    gain * control.depth_error
}

#[test]
fn changed_gains_act_together_from_the_next_tick_on() {
    let stage = Stage::new();
    let mut dive = Dive::begin(&stage);
    let before = dive.fly(1);
    let printed = before.depth_p / before.depth_error;

    let gains = [double("depth.p", 0.5), double("pitch.p", 0.4)];
    let answer = dive.set::<SetUnchecked>(&gains);
    assert!(answer.result.successful, "{}", answer.result.reason);
    let after = dive.fly(1);
    assert_eq!(
        after.header.stamp.nanos(),
        before.header.stamp.nanos() + TICK
    );
    assert_eq!(after.depth_p, share(&after, 0.5));
    assert_ne!(printed, 0.5);
    // Positive pitch errors ask for the bow up, positive planes push it down.
    assert_eq!(after.planes_p.abs(), (0.4 * after.pitch_error).abs());
}

#[test]
fn a_set_with_one_bad_value_changes_nothing_and_the_reason_is_reported() {
    let stage = Stage::new();
    let mut dive = Dive::begin(&stage);
    let before = dive.fly(1);
    let printed = before.depth_p / before.depth_error;

    for (bad, reason) in [
        (double("depth.d", f64::NAN), "finite"),
        (double("depth.d", f64::INFINITY), "finite"),
        (double("depth.d", -1.0), "depth.d"),
        (double("planes.limit", 0.0), "planes.limit"),
        (double("deph.d", 1.0), "deph.d"),
        (text("depth.d", "much"), "depth.d"),
    ] {
        let answer = dive.set::<SetUnchecked>(&[double("depth.p", 0.5), bad.clone()]);
        assert!(!answer.result.successful, "{bad:?}");
        let answered = answer.result.reason;
        assert!(answered.contains(reason), "{reason}: {answered}");
        let after = dive.fly(1);
        let gain = after.depth_p / after.depth_error;
        assert!((gain - printed).abs() < 1e-12, "{bad:?}: gain {gain}");
    }
}

#[test]
fn a_setpoint_that_is_no_number_is_refused_and_told_and_the_dive_goes_on() {
    let stage = Stage::new();
    let mut dive = Dive::begin(&stage);
    let before = dive.fly(1);

    let topic = "depth_setpoint";
    let setpoint: Publisher<Unchecked<Float64>> = dive
        .operator
        .rt
        .publisher(topic, Qos::reliable(10))
        .unwrap();
    let refused = |received: &Received| {
        let Received::Diagnostics(array) = received else {
            return None;
        };
        let connections = Connections::from_diagnostics(array)?;
        let input = connections.find(Direction::Subscription, "/auv/depth_setpoint")?;
        Some((array.status[0].level, input.peers, input.refused))
    };
    dive.operator
        .until("a controller that listens", |received| {
            refused(&received).filter(|(_, peers, _)| *peers == 1)
        });
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(setpoint.publish(&Unchecked(Float64 { data: number })));
    }
    let (level, ..) = dive.operator.until("three refusals", |received| {
        refused(&received).filter(|(_, _, refused)| *refused == 3)
    });
    assert_eq!(level, DiagnosticStatus::WARN);
    let said = dive.controller.stderr();
    assert!(
        said.contains("/auv/depth_setpoint: message refused: data is not finite"),
        "{said}"
    );
    let after = dive.fly(1);
    assert_eq!(after.depth_setpoint, before.depth_setpoint);

    assert!(setpoint.publish(&Unchecked(Float64 { data: 2.5 })));
    let mut control = after;
    while control.depth_setpoint != 2.5 {
        control = dive.fly(1);
    }
}

#[test]
fn parameters_without_effect_in_the_chosen_time_are_named_once() {
    let given = [
        "factor",
        "delay_budget",
        "lockstep.gates",
        "lockstep.members",
    ];
    for (time, in_vain) in [("lockstep", &given[..2]), ("real", &given[2..])] {
        let stage = Stage::new();
        let time = format!("time:={time}");
        let paces = [&time, "factor:=2.0", "delay_budget:=3"];
        let waits = ["lockstep.gates:=[estimate]", "lockstep.members:=[sysid]"];
        let plant = stage.node("plant_sim", &[&paces[..], &waits].concat());
        stage
            .operator()
            .until("the vehicle's diagnostics", |received| {
                received.status("/auv/plant_sim: middleware").map(drop)
            });
        plant.signal(Signal::INT);
        let outcome = plant.finish();
        for name in given {
            let told = format!("parameter '{name}' has no effect");
            let times = outcome.stderr.matches(&told).count();
            assert_eq!(times, usize::from(in_vain.contains(&name)), "{outcome:#?}");
        }
    }
}

#[test]
fn a_fault_in_mid_dive_acts_from_the_next_tick_on_is_reported_and_can_be_mended() {
    let stage = Stage::new();
    let mut dive = Dive::begin(&stage);
    let node = "dha_actuator";
    assert_eq!(dive.fly_actuator(1).faults, "");
    let status = format!("/auv/{node}: faults");
    let sound = dive.operator.status(&status, "none");
    assert_eq!(sound, DiagnosticStatus::OK);

    // What cannot be is refused as a whole.
    for (bad, reason) in [
        (text("fault.encoder", "blind"), "fault.encoder"),
        (text("fault.group", "rudder"), "no actuator belongs to"),
    ] {
        let set = [double("fault.air", 0.5), bad];
        let answer = dive.set_of::<SetUnchecked>(node, &set);
        assert!(!answer.result.successful);
        let answered = answer.result.reason;
        assert!(answered.contains(reason), "{answered}");
    }
    assert_eq!(dive.fly_actuator(1).faults, "");

    let stuck = [text("fault.stuck_valve", "direction")];
    let answer = dive.set_of::<SetUnchecked>(node, &stuck);
    assert!(answer.result.successful, "{}", answer.result.reason);
    let state = dive.fly_actuator(1);
    assert_eq!(state.faults, "direction valve stuck");
    let level = dive.operator.status(&status, "direction valve stuck");
    assert_eq!(level, DiagnosticStatus::WARN);
    // Every volume goes one way: the planes end at their stop, and no command brings them back.
    let state = dive.fly_actuator(400);
    assert!(state.plane_angle.to_degrees() > 29.0, "{state:?}");
    assert!(state.error < 0.0 && state.slewing, "{state:?}");
    let actuator = format!("/auv/{node}: actuator");
    let level = dive.operator.status(&actuator, "dive_planes: at its stop");
    assert_eq!(level, DiagnosticStatus::WARN);

    let mended = dive.set_of::<SetUnchecked>(node, &[text("fault.stuck_valve", "none")]);
    assert!(mended.result.successful);
    let state = dive.fly_actuator(100);
    assert_eq!(state.faults, "");
    assert!((state.plane_angle - state.commanded_angle).abs() < 2.0_f64.to_radians());
    assert_eq!(dive.operator.status(&status, "none"), DiagnosticStatus::OK);
}

#[test]
fn a_client_that_has_just_come_is_answered_as_well_as_an_old_one() {
    let stage = Stage::new();
    let controller = stage.node("depth_controller", &[]);
    let operator = stage.operator();
    for depth in 1..=20 {
        // Each with a client of its own, whose request and answer go by ways nobody has gone before.
        let answer = operator.set(
            "depth_controller",
            &[double("depth_setpoint", depth.into())],
        );
        assert!(answer.successful, "{}", answer.reason);
    }
    let taken = controller.stderr();
    assert_eq!(
        taken.matches("depth_setpoint changed").count(),
        20,
        "{taken}"
    );
}
