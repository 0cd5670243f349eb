//! The node: answers every plane command with the plane motion.

use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand, PlaneMotion, VehicleState};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_node::{Change, Flow, Level, Lifecycle, NodeSpec, Publisher, Qos, Runtime, args};

use planesman_hydraulics::{Actuator, ActuatorParameters, Error, Group, Output};

enum Event {
    Command(PlaneCommand),
    State(VehicleState),
    /// Timer event: checks whether commands still arrive.
    Poll,
    Parameters(Box<ActuatorParameters>),
    /// A lifecycle transition of the node.
    Lifecycle(Change),
}

/// Runs the node with its command-line arguments until it is stopped.
#[must_use]
pub fn main(args: Vec<OsString>) -> ExitCode {
    planesman_node::exit_code("dha_actuator", || run(args))
}

fn run(args: Vec<OsString>) -> Result<()> {
    let (rt, parameters) = Runtime::start(
        NodeSpec {
            name: "dha_actuator",
            namespace: "/auv",
            validate: |parameters: &ActuatorParameters| Ok(actuator(parameters).map(drop)?),
            on_parameters: |parameters| Event::Parameters(Box::new(parameters)),
        },
        args::only(args)?,
    )?;
    let actuator = actuator(&parameters)?;
    let groups = actuator.groups();
    let mut node = Node {
        lifecycle: rt.lifecycle(parameters.managed, Event::Lifecycle)?,
        actuator,
        lockstep: parameters.lockstep,
        timeout: parameters.command_timeout,
        publishers: Publishers::new(&rt, groups)?,
        limits: Vec::new(),
        begun: None,
        commanded: None,
        said: None,
        received: None,
    };
    rt.subscribe(
        "plane_command",
        Qos::reliable(100).of_one_publisher(),
        Event::Command,
    )?;
    if !node.lockstep {
        rt.subscribe("state", Qos::reliable(100).of_one_publisher(), Event::State)?;
    }
    drop(rt.every(Duration::from_millis(100), || Event::Poll));
    rt.run(|rt, event| node.on(rt, event))
}

fn actuator(parameters: &ActuatorParameters) -> Result<Actuator, Error> {
    Actuator::new(parameters, (parameters.tick * 1e9).round() as i64)
}

struct Node {
    lifecycle: Lifecycle,
    actuator: Actuator,
    /// Whether each tick waits for its command, however long it takes.
    lockstep: bool,
    /// Time without a command after which the planes go to neutral, s.
    timeout: f64,
    publishers: Publishers,
    /// The limits that the planes reached in the last tick.
    limits: Vec<String>,
    /// Stamps of the last tick begun by the vehicle and of the last tick with a command, ns.
    begun: Option<i64>,
    commanded: Option<i64>,
    /// Stamp of the last answered tick, ns.
    said: Option<i64>,
    /// Arrival time of the last command, ns of the node's clock.
    received: Option<i64>,
}

impl Node {
    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Lifecycle(change) => {
                // An activated node begins like one that was started anew.
                if change == Change::Activate {
                    self.actuator.restart();
                    (self.begun, self.commanded) = (None, None);
                    (self.said, self.received) = (None, None);
                    self.limits.clear();
                }
                self.poll(rt);
            }
            Event::Command(_) | Event::State(_) if !self.lifecycle.is_active() => {}
            Event::Command(command) => {
                self.received = Some(rt.now().nanos());
                match self.actuator.on_command(&command) {
                    Ok(output) => {
                        let stamp = command.header.stamp.nanos();
                        // Said again, somebody lacks an answer: this one, or that of the tick before.
                        if self.commanded == Some(stamp) {
                            if let Some(before) = self.actuator.before() {
                                self.publishers.say(before);
                            }
                            self.said = None;
                        }
                        self.commanded = Some(stamp);
                        self.say(&output);
                    }
                    Err(end @ Error::Motion { .. }) => return Err(end.into()),
                    Err(reason) => log::warn!("{reason}"),
                }
            }
            Event::State(state) => self.on_state(state.header.stamp.nanos())?,
            Event::Poll => self.poll(rt),
            Event::Parameters(parameters) => {
                // They have been accepted; but a file that they name may have changed since.
                if let Err(reason) = self.actuator.set_parameters(&parameters) {
                    log::error!("{reason}; the previous parameters stay in force");
                    return Ok(Flow::Continue);
                }
                self.timeout = parameters.command_timeout;
                log::info!("parameters changed");
                for fault in self.actuator.faults() {
                    log::warn!("fault: {fault}");
                }
            }
        }
        Ok(Flow::Continue)
    }

    /// A tick begins. If the previous tick got no command, both ticks are answered now: the planes follow the last command, and after the
    /// timeout go to neutral, while the vehicle flies on. A command that still arrives acts from the next tick on.
    fn on_state(&mut self, stamp: i64) -> Result<()> {
        let before = self.begun.replace(stamp);
        if before.is_some_and(|before| stamp < before) {
            self.actuator.restart();
            (self.commanded, self.said) = (None, None);
            return Ok(());
        }
        let unanswered =
            before.filter(|begun| *begun < stamp && self.commanded.is_none_or(|at| at < *begun));
        if let Some(before) = unanswered {
            for stamp in [before, stamp] {
                let output = self.actuator.on_silence(Time::from_nanos(stamp))?;
                self.say(&output);
            }
        }
        Ok(())
    }

    /// Publishes the answer to a tick, once; a command that arrives after its tick was answered gets the same answer.
    fn say(&mut self, output: &Output) {
        self.limits = output.limits();
        let stamp = output.motion.header.stamp.nanos();
        if self.said.replace(stamp) != Some(stamp) {
            self.publishers.say(output);
        }
    }

    fn poll(&mut self, rt: &Runtime<Event>) {
        let now = rt.now().nanos();
        match self.received {
            _ if !self.lifecycle.is_active() => {
                rt.set_status("actuator", Level::Ok, &self.lifecycle.label(), &[]);
            }
            None => rt.set_status("actuator", Level::Warn, "no plane command yet", &[]),
            Some(at) if (now - at) as f64 * 1e-9 > self.timeout => {
                rt.set_status(
                    "actuator",
                    Level::Error,
                    "plane command stale: planes neutral",
                    &[],
                );
            }
            Some(_) if !self.limits.is_empty() => {
                rt.set_status("actuator", Level::Warn, &self.limits.join(", "), &[]);
            }
            Some(_) => rt.set_status("actuator", Level::Ok, "following", &[]),
        }
        let faults = self.actuator.faults();
        if faults.is_empty() {
            rt.set_status("faults", Level::Ok, "none", &[]);
        } else {
            rt.set_status("faults", Level::Warn, &faults.join(", "), &[]);
        }
    }
}

struct Publishers {
    motion: Publisher<PlaneMotion>,
    planes: Publisher<JointState>,
    /// One publisher for each group of planes.
    states: Vec<Publisher<DhaState>>,
}

impl Publishers {
    fn new(rt: &Runtime<Event>, groups: &[Group]) -> Result<Self> {
        let states = groups.iter().map(|group| rt.loop_publisher(group.topic()));
        Ok(Self {
            motion: rt.loop_publisher("plane_motion")?.sole(),
            planes: rt.loop_publisher("planes")?,
            states: states.collect::<Result<_, _>>()?,
        })
    }

    fn say(&self, output: &Output) {
        self.motion.publish(&output.motion);
        self.planes.publish(&output.planes());
        for (publisher, state) in self.states.iter().zip(output.states()) {
            publisher.publish(&state);
        }
    }
}
