//! The node: answers every vehicle state with a plane command; setpoints come from topics, manoeuvres from an action.

use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use planesman_msgs::planesman_msgs::action::{Manoeuvre, ManoeuvreFeedback, ManoeuvreResult};
use planesman_msgs::planesman_msgs::msg::{
    ControlState, ModelEstimate, MotionEstimate, PlaneCommand, ThrusterCommand, VehicleState,
};
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use planesman_node::{
    Change, Flow, Goal, GoalId, Level, Lifecycle, NodeSpec, Publisher, Qos, Responder, Runtime,
    args,
};
use planesman_parameters::Parameters as _;

use crate::waiting::Waiting;
use planesman_control::{Answer, Controller, ControllerParameters, Quantity};

enum Event {
    State(VehicleState),
    Imu(Imu),
    DepthPressure(FluidPressure),
    SpeedPressure(FluidPressure),
    Model(ModelEstimate),
    Setpoint(Quantity, f64),
    Manoeuvre(Goal<Manoeuvre>),
    CancelManoeuvre(GoalId),
    ResetFault(Responder<Trigger>),
    /// Timer event: checks whether vehicle states still arrive.
    Poll,
    Parameters(Box<ControllerParameters>),
    /// A lifecycle transition of the node.
    Lifecycle(Change),
}

/// Runs the node with its command-line arguments until it is stopped.
#[must_use]
pub fn main(args: Vec<OsString>) -> ExitCode {
    planesman_node::exit_code("depth_controller", || run(args))
}

fn run(args: Vec<OsString>) -> Result<()> {
    let (rt, parameters) = Runtime::start(
        NodeSpec {
            name: "depth_controller",
            namespace: "/auv",
            validate: |parameters| Ok(Controller::new(parameters).map(drop)?),
            on_parameters: |parameters| Event::Parameters(Box::new(parameters)),
        },
        args::only(args)?,
    )?;
    let controller = Controller::new(&parameters)?;
    let on_instruments = controller.reads_instruments();
    let thrusters = controller.has_thrusters();
    let mut node = Node {
        lifecycle: rt.lifecycle(parameters.managed, Event::Lifecycle)?,
        controller,
        parameters: Box::new(parameters),
        waiting: Waiting::default(),
        estimate: match on_instruments {
            true => Some(rt.loop_publisher("estimate")?),
            false => None,
        },
        thrusters: match thrusters {
            true => Some(rt.loop_publisher("thruster_command")?.sole()),
            false => None,
        },
        command: rt.loop_publisher("plane_command")?.sole(),
        inside: rt.loop_publisher("control_state")?,
        flown: None,
        received: None,
        silent: false,
        refused: Vec::new(),
    };
    rt.subscribe("state", Qos::reliable(100).of_one_publisher(), Event::State)?;
    rt.subscribe("model", Qos::reliable(10).of_one_publisher(), Event::Model)?;
    if on_instruments {
        let sensor = match node.parameters.lockstep {
            true => Qos::reliable(100),
            false => Qos::sensor(),
        };
        let sensor = sensor.of_one_publisher();
        rt.subscribe("imu", sensor, Event::Imu)?;
        rt.subscribe("depth_pressure", sensor, Event::DepthPressure)?;
        rt.subscribe("speed_pressure", sensor, Event::SpeedPressure)?;
    }
    for quantity in Quantity::ALL {
        let topic = format!("{}_setpoint", quantity.name());
        rt.subscribe(&topic, Qos::reliable(10), move |setpoint: Float64| {
            Event::Setpoint(quantity, setpoint.data)
        })?;
    }
    rt.serve_action("~/manoeuvre", Event::Manoeuvre, Event::CancelManoeuvre)?;
    rt.serve::<Trigger>("~/reset_fault", |_, responder| Event::ResetFault(responder))?;
    drop(rt.every(Duration::from_millis(100), || Event::Poll));
    rt.run(|rt, event| node.on(rt, event))
}

/// Vehicle time between two feedbacks of a manoeuvre, s.
const FEEDBACK_PERIOD: f64 = 0.2;

/// The running manoeuvre.
struct ControlTick {
    goal: Goal<Manoeuvre>,
    /// Manoeuvre time of the next feedback, s.
    next_feedback: f64,
}

fn ended(completed: bool, message: &str) -> ManoeuvreResult {
    ManoeuvreResult {
        completed,
        message: message.to_owned(),
    }
}

struct Node {
    lifecycle: Lifecycle,
    controller: Controller,
    /// Current parameters.
    parameters: Box<ControllerParameters>,
    command: Publisher<PlaneCommand>,
    /// The publisher of thruster commands; `None` unless `hover.vehicle` names a vehicle.
    thrusters: Option<Publisher<ThrusterCommand>>,
    inside: Publisher<ControlState>,
    /// The publisher of the estimate; `None` if the loops use the true state.
    estimate: Option<Publisher<MotionEstimate>>,
    /// A state that waits for its sensor readings.
    waiting: Waiting,
    /// The running manoeuvre.
    flown: Option<ControlTick>,
    /// Arrival time of the last state, ns of the node's clock; that clock stops when a simulation is paused.
    received: Option<i64>,
    silent: bool,
    /// For each quantity whose last setpoint was refused: the quantity and the reason.
    refused: Vec<(Quantity, String)>,
}

impl Node {
    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Lifecycle(change) => self.on_change(rt, change),
            // An inactive node takes note of nothing but its parameters: it begins anew when it is activated.
            Event::State(_)
            | Event::Imu(_)
            | Event::DepthPressure(_)
            | Event::SpeedPressure(_)
            | Event::Model(_)
            | Event::Setpoint(..)
                if !self.lifecycle.is_active() => {}
            Event::Manoeuvre(goal) if !self.lifecycle.is_active() => {
                let reason = format!("the node is {}", self.lifecycle.label());
                goal.abort(ended(false, &reason));
            }
            Event::State(state) => {
                self.received = Some(rt.now().nanos());
                let ready = self.controller.ready_for(&state.header.stamp);
                if let Some(state) = self.waiting.on_state(state, ready) {
                    self.answer(&state);
                }
            }
            Event::Manoeuvre(goal) => self.begin(goal),
            Event::CancelManoeuvre(id) => {
                if let Some(flown) = self.flown.take_if(|flown| flown.goal.id() == id) {
                    self.controller.stop_manoeuvre();
                    log::info!("manoeuvre {} cancelled", flown.goal.request().name);
                    flown.goal.cancel(ended(false, "cancelled"));
                }
            }
            Event::Imu(imu) => {
                self.controller.on_imu(&imu);
                self.answer_the_waiting();
            }
            Event::DepthPressure(pressure) => {
                self.controller.on_depth_pressure(&pressure);
                self.answer_the_waiting();
            }
            Event::SpeedPressure(pressure) => {
                self.controller.on_speed_pressure(&pressure);
                self.answer_the_waiting();
            }
            Event::Model(model) => self.controller.on_model(model),
            Event::Setpoint(quantity, value) => {
                let (name, unit) = (quantity.name(), quantity.unit());
                let outcome = self.controller.set_setpoint(quantity, value);
                self.refused.retain(|(other, _)| *other != quantity);
                match outcome {
                    Ok(limited) if limited == value => log::info!("{name} setpoint {value} {unit}"),
                    Ok(limited) => {
                        log::warn!("{name} setpoint {value} {unit}: limited to {limited} {unit}")
                    }
                    Err(reason) => {
                        log::warn!("{reason}; the last setpoint stays in force");
                        self.refused.push((quantity, reason.to_string()));
                    }
                }
                self.tell_status(rt);
            }
            Event::ResetFault(responder) => self.reset_fault(rt, responder),
            Event::Poll => self.poll(rt),
            Event::Parameters(parameters) => {
                // They have been accepted; but a file that they name may have changed since.
                if let Err(reason) = self.controller.set_parameters(&parameters) {
                    log::error!("{reason}; the previous parameters stay in force");
                    return Ok(Flow::Continue);
                }
                for change in changes(&self.parameters, &parameters) {
                    log::info!("{change}");
                }
                self.parameters = parameters;
                self.tell_progress();
            }
        }
        Ok(Flow::Continue)
    }

    /// An activated node starts afresh; a node that is no longer active ends its manoeuvre.
    fn on_change(&mut self, rt: &Runtime<Event>, change: Change) {
        match change {
            Change::Activate => {
                // A file that the parameters name may have changed since they were accepted.
                match Controller::new(&self.parameters) {
                    Ok(controller) => self.controller = controller,
                    Err(reason) => log::error!("{reason}; the previous controller continues"),
                }
                self.waiting = Waiting::default();
                self.received = None;
                self.silent = false;
                self.refused.clear();
            }
            Change::Deactivate | Change::ShutDown => {
                if let Some(flown) = self.flown.take() {
                    let reason = format!("the node is {}", self.lifecycle.label());
                    flown.goal.abort(ended(false, &reason));
                }
            }
            Change::Configure | Change::CleanUp => {}
        }
        self.tell_status(rt);
    }

    /// Answers the waiting state once all its sensor readings have arrived.
    fn answer_the_waiting(&mut self) {
        let waiting = self
            .waiting
            .on_instrument(|stamp| self.controller.ready_for(stamp));
        if let Some(state) = waiting {
            self.answer(&state);
        }
    }

    fn answer(&mut self, state: &VehicleState) {
        match self.controller.on_state(state) {
            Ok(answer) => {
                self.say(&answer);
                if let (Some(publisher), Some(estimate)) =
                    (&self.estimate, self.controller.estimate())
                {
                    publisher.publish(estimate);
                }
            }
            Err(reason) => log::warn!("{reason}"),
        }
        self.tell_progress();
    }

    fn say(&self, (command, inside): &Answer) {
        if let (Some(publisher), Some(thrusters)) = (&self.thrusters, self.controller.thrusters()) {
            publisher.publish(thrusters);
        }
        self.command.publish(command);
        self.inside.publish(inside);
    }

    fn reset_fault(&mut self, rt: &Runtime<Event>, responder: Responder<Trigger>) {
        let (success, message) = match self.controller.reset_fault() {
            Ok(fault) => (true, format!("fault reset: {}", fault.text())),
            Err(reason) => (false, format!("not reset: {reason}")),
        };
        log::info!("{message}");
        responder.answer(TriggerResponse { success, message });
        self.tell_status(rt);
    }

    /// Starts a manoeuvre, replacing the running one, or refuses the goal with a reason.
    fn begin(&mut self, goal: Goal<Manoeuvre>) {
        let name = goal.request().name.clone();
        if let Err(reason) = self.controller.begin_manoeuvre(goal.request()) {
            log::warn!("{reason}");
            return goal.abort(ended(false, &reason.to_string()));
        }
        log::info!("manoeuvre {name} started");
        let begun = ControlTick {
            goal,
            next_feedback: 0.0,
        };
        if let Some(last) = self.flown.replace(begun) {
            let reason = format!("replaced by a newer goal, {name}");
            log::info!("manoeuvre {}: {reason}", last.goal.request().name);
            last.goal.abort(ended(false, &reason));
        }
    }

    /// Logs the events, and sends feedback to the manoeuvre's client.
    fn tell_progress(&mut self) {
        for change in self.controller.take_changes() {
            log::warn!("{change}");
        }
        if let Some(end) = self.controller.manoeuvre_end()
            && let Some(flown) = self.flown.take()
        {
            let name = &flown.goal.request().name;
            match end {
                Ok(()) => {
                    log::info!("manoeuvre {name} completed");
                    flown.goal.succeed(ended(true, ""));
                }
                Err(reason) => {
                    log::warn!("manoeuvre {name} {reason}");
                    flown.goal.abort(ended(false, &reason.to_string()));
                }
            }
        }
        if let (Some(flown), Some(progress)) = (&mut self.flown, self.controller.manoeuvre())
            && progress.elapsed >= flown.next_feedback
        {
            flown.next_feedback = progress.elapsed + FEEDBACK_PERIOD;
            flown.goal.feedback(ManoeuvreFeedback {
                elapsed: progress.elapsed,
                dive_planes: progress.dive_planes,
            });
        }
    }

    /// Moves the planes to neutral, once, if no state has arrived for the timeout, and logs it.
    fn poll(&mut self, rt: &Runtime<Event>) {
        if !self.lifecycle.is_active() {
            return self.tell_status(rt);
        }
        let timeout = self.controller.state_timeout();
        let now = rt.now();
        let silent = self
            .received
            .is_some_and(|at| (now.nanos() - at) as f64 * 1e-9 > timeout);
        if silent && !self.silent {
            log::warn!("no vehicle state for {timeout} s: planes go to neutral");
            let answer = self.controller.on_silence(now);
            self.say(&answer);
            self.tell_progress();
        }
        self.silent = silent;
        self.tell_status(rt);
    }

    fn tell_status(&self, rt: &Runtime<Event>) {
        if !self.lifecycle.is_active() {
            return rt.set_status("loop", Level::Ok, &self.lifecycle.label(), &[]);
        }
        let fault = self.controller.fault();
        let (level, message) = match (fault, self.received, self.silent) {
            (Some(fault), ..) => {
                let reset = "until ~/reset_fault is called";
                (Level::Error, format!("fault: {}; {reset}", fault.text()))
            }
            (None, None, _) => (Level::Warn, "no vehicle state yet".to_owned()),
            (None, _, true) => (
                Level::Error,
                "vehicle state stale: planes neutral".to_owned(),
            ),
            _ => match self.refused.last() {
                Some((_, reason)) => (Level::Warn, format!("controlling; {reason}")),
                None => (Level::Ok, "controlling".to_owned()),
            },
        };
        rt.set_status("loop", level, &message, &[]);
    }
}

/// The changed parameters, as `depth.p: 0.82 -> 0.5`.
fn changes(old: &ControllerParameters, new: &ControllerParameters) -> Vec<String> {
    let (old, new) = (old.values(), new.values());
    let names = new.declarations().iter().map(|declared| &declared.name);
    let pairs = names.filter_map(|name| Some((name, old.get(name)?, new.get(name)?)));
    pairs
        .filter(|(_, old, new)| old != new)
        .map(|(name, old, new)| format!("{name}: {old} -> {new}"))
        .collect()
}
