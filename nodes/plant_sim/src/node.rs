//! The node: keeps the vehicle's time, publishes state and sensor readings, and receives the actuator's answer.
//!
//! [`Plant`] moves the vehicle; this module decides when a tick ends, in one of the ways described in ARCHITECTURE.md ("Time").

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::ffi::OsString;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow, bail};
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::loop_topics::Sink;
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, ThrusterCommand, TickAnswer, VehicleState};
use planesman_msgs::planesman_msgs::srv::{Step, StepRequest, StepResponse};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::{Float64MultiArray, String as Text};
use planesman_msgs::std_srvs::srv::{
    SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse,
};
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_node::claim::{Claim, Stage};
use planesman_node::logging::Throttle;
use planesman_node::{Flow, Level, NodeSpec, Publisher, Qos, Responder, Runtime, args};

use planesman_plant::{
    Answers, Instruments, Observation, Plant, PlantParameters, Pose, StaticMessages, THE_ACTUATOR,
    TimeSource,
};
use planesman_vehicle::Boundary;

use crate::gates::{GateEvent, Gates};

/// In lockstep, time without all answers after which state and sensor readings are published again: a member may have restarted or lost its
/// connection, and so have missed them.
const REPEAT_AFTER: Duration = Duration::from_secs(1);

/// Time to detect another vehicle before the first tick; a running peer is found within 0.2 s.
const LISTENING: Duration = Duration::from_millis(500);

/// Time between the opening of the last gate and the first tick, in which the gate's publisher discovers all its subscribers.
const SETTLING: Duration = Duration::from_secs(1);

/// Time after which nodes of an ended launcher have disappeared from discovery.
const LEAVING: Duration = Duration::from_secs(7);

/// Longest interval of `/clock` messages for which the vehicle catches up between two of them, ns.
const COARSEST_CLOCK: i64 = 1_000_000_000;

/// Time between two warnings about missed ticks, s.
const WARNING_PERIOD: Duration = Duration::from_secs(5);

/// Topics of an actuator's answer. The first contains the angle over the whole tick, the second a constant angle for the tick.
const PLANE_MOTION: &str = "plane_motion";
const PLANES: &str = "planes";

/// Topic of the commands to the actuator.
const PLANE_COMMAND: &str = "plane_command";

/// Topics of the thruster commands: with names and stamp, or (as for Stonefish) as a list of numbers in the order of the vehicle file.
const THRUSTER_COMMAND: &str = "thruster_command";
const THRUSTER_SETPOINTS: &str = "thruster_setpoints";

/// Message of the status `vehicle` after the scenario's `duration`.
pub const DONE: &str = "done";

enum Event {
    Motion(PlaneMotion),
    Planes(JointState),
    Thrusters(ThrusterCommand),
    ThrusterSetpoints(Float64MultiArray),
    Answer(TickAnswer),
    Gate(GateEvent),
    /// Timer event: checks whether the tick is over.
    Poll,
    Pause(SetBoolRequest, Responder<SetBool>),
    Step(StepRequest, Responder<Step>),
    Reset(Responder<Trigger>),
    Parameters(Box<PlantParameters>),
}

impl From<GateEvent> for Event {
    fn from(event: GateEvent) -> Self {
        Self::Gate(event)
    }
}

/// Runs the node with its command-line arguments until it is requested to stop.
#[must_use]
pub fn main(args: Vec<OsString>) -> ExitCode {
    planesman_node::exit_code("plant_sim", || run(args))
}

fn run(args: Vec<OsString>) -> Result<()> {
    let (rt, parameters) = Runtime::start(
        NodeSpec {
            name: "plant_sim",
            namespace: "/auv",
            validate: |parameters: &PlantParameters| Ok(Plant::new(parameters).map(drop)?),
            on_parameters: |parameters| Event::Parameters(Box::new(parameters)),
        },
        args::only(args)?,
    )?;
    let mut node = Node::new(&rt, &parameters)?;
    let answers = Qos::reliable(100).of_one_publisher();
    // The tick is fixed at the start, so this copy checks as the plant that flies does.
    let judge = Rc::new(node.plant.clone());
    let refuses = |judge: &Plant, motion: &PlaneMotion| {
        let refusal = judge.check_motion(motion).err()?;
        Some(refusal.to_string())
    };
    let of_motion = Rc::clone(&judge);
    rt.subscribe_checked(
        PLANE_MOTION,
        answers,
        move |motion| refuses(&of_motion, motion),
        Event::Motion,
    )?;
    rt.subscribe_checked(
        PLANES,
        answers,
        move |planes| match judge.motion(planes) {
            Some(motion) => refuses(&judge, &motion),
            None => Some("the message has no joint 'dive_planes' with a position".to_owned()),
        },
        Event::Planes,
    )?;
    if !node.plant.thrusters().is_empty() {
        rt.subscribe(THRUSTER_COMMAND, answers, Event::Thrusters)?;
        rt.subscribe(
            THRUSTER_SETPOINTS,
            Qos::reliable(10),
            Event::ThrusterSetpoints,
        )?;
    }
    // A member is a node beside this one, and nobody else answers for it.
    let own = rt.full_name();
    let namespace = own.rsplit_once('/').unwrap_or_default().0.to_owned();
    rt.subscribe_to_speakers(
        "tick_answer",
        Qos::reliable(100),
        move |answer: &TickAnswer| vec![format!("{namespace}/{}", answer.member)],
        Event::Answer,
    )?;
    rt.serve::<SetBool>("~/pause", Event::Pause)?;
    rt.serve::<Step>("~/step", Event::Step)?;
    rt.serve::<Trigger>("~/reset", |_, responder| Event::Reset(responder))?;
    drop(rt.every(Duration::from_millis(100), || Event::Poll));
    rt.run(|rt, event| node.on(rt, event))
}

/// What ends a tick.
enum Pace {
    /// All answers have arrived.
    Lockstep {
        /// Times at which the present tick began, and at which its `state` was last published.
        began: Instant,
        said: Instant,
    },
    /// The wall clock, `factor` times faster. Stamps are the vehicle's own time, published on `/clock`.
    Real {
        factor: f64,
        /// Wall-clock time at which the present tick ends.
        deadline: Instant,
    },
    /// The node's clock: the machine's, or `/clock` from elsewhere. Stamps are in its time.
    Clock,
}

/// The remaining ticks of a `step` request.
struct Stepping {
    ticks: u32,
    responder: Responder<Step>,
}

/// The wait for the answers to a tick.
struct Wait {
    /// Wall-clock time at which the tick's state was first sent.
    sent: Time,
    /// `answer_timeout`, s.
    timeout: f64,
    /// Whether the answers have been missing for longer than the timeout.
    overdue: bool,
}

struct Node {
    plant: Plant,
    publishers: Publishers,
    pace: Pace,
    /// Index of the present tick.
    k: i64,
    /// Stamp of the present tick, ns.
    stamp: i64,
    /// Total number of ticks, `None` without end.
    ticks: Option<i64>,
    /// Whether the node ends after these ticks.
    end_when_flown: bool,
    /// The observation of the present tick, sent again to a member that restarts; `None` between ticks, while paused and at the end.
    observation: Option<Observation>,
    /// Saturated channels of the acquisition ([`DaqSample`]), and when the last one saturated.
    saturated: (u8, Instant),
    answers: Answers,
    gates: Gates,
    wait: Wait,
    /// Whether `plane_motion` has a publisher; `planes` is then ignored.
    has_motion: bool,
    /// Whether ignored publishers of `planes` have been logged.
    told_of_vain: bool,
    paused: bool,
    /// Whether the vehicle is reset before the next tick.
    reset_due: bool,
    stepping: Option<Stepping>,
    /// Number of ticks missed because the clock was ahead.
    missed: i64,
    /// Whether the next tick follows a pause.
    resumes: bool,
    warnings: Throttle,
    /// The last reading of the clock, ns, and its time on the monotonic clock.
    seen: Option<(Instant, i64)>,
    /// The latest contact, with its time.
    contact: String,
    /// The claim to be the only vehicle in the namespace.
    claim: Claim,
    /// Time at which the search for other vehicles began; `None` once the search has ended without finding one.
    listening: Option<Instant>,
}

impl Node {
    fn new(rt: &Runtime<Event>, parameters: &PlantParameters) -> Result<Self> {
        let plant = Plant::new(parameters).map_err(|e| anyhow!("{e}"))?;
        let factor = parameters.factor;
        let (pace, owns_time) = match parameters.time {
            TimeSource::Lockstep => {
                let (began, said) = (Instant::now(), Instant::now());
                (Pace::Lockstep { began, said }, true)
            }
            TimeSource::Real if factor != 1.0 || parameters.sim_time => {
                let pace = Pace::Real {
                    factor,
                    deadline: Instant::now(),
                };
                (pace, true)
            }
            TimeSource::Real | TimeSource::External => (Pace::Clock, false),
        };
        if owns_time {
            rt.set_time(&Time::default());
        }
        let duration = parameters.duration;
        let ticks = (duration * 1e9 / plant.tick_nanos() as f64).round() as i64;
        let lockstep = matches!(pace, Pace::Lockstep { .. });
        let reliable = lockstep || parameters.reliable_sensors;
        let publishers = Publishers::new(
            rt,
            &plant.static_messages(),
            &plant.instruments_that_are_on(),
            owns_time,
            reliable,
        )?;
        let mut answers = Answers::new(parameters, plant.tick_nanos());
        let gates: &[String] = match lockstep {
            true => &parameters.lockstep.gates,
            false => &[],
        };
        let in_vain = |names: &[String]| !lockstep && !names.is_empty();
        let has_pace = parameters.time == TimeSource::Real;
        for (name, is_in_vain) in [
            ("lockstep.gates", in_vain(&parameters.lockstep.gates)),
            ("lockstep.members", in_vain(&parameters.lockstep.members)),
            ("factor", !has_pace && factor != 1.0),
            ("delay_budget", lockstep && parameters.delay_budget != 0),
        ] {
            if is_in_vain {
                log::warn!("parameter '{name}' has no effect with the chosen value of 'time'");
            }
        }
        let gates = Gates::new(rt, gates)?;
        let thrusters = (!plant.thrusters().is_empty()).then_some(THRUSTER_COMMAND);
        answers.set_gates(gates.topics().chain(thrusters));
        if plant.craft().is_of_thrusters_alone() {
            answers.need_no_actuator();
        }
        Ok(Self {
            claim: {
                let topic = publishers.state.topic();
                rt.claim(topic, &format!("rt{topic}"))?
            },
            listening: Some(Instant::now()),
            publishers,
            pace,
            k: 0,
            stamp: 0,
            ticks: (duration > 0.0).then_some(ticks),
            end_when_flown: parameters.end_when_flown,
            observation: None,
            saturated: (0, Instant::now()),
            answers,
            gates,
            wait: Wait {
                sent: Time::default(),
                timeout: parameters.answer_timeout,
                overdue: false,
            },
            has_motion: false,
            told_of_vain: false,
            paused: parameters.start_paused,
            reset_due: false,
            stepping: None,
            missed: 0,
            resumes: true,
            warnings: Throttle::new(WARNING_PERIOD),
            seen: None,
            contact: "none".to_owned(),
            plant,
        })
    }

    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Motion(motion) => {
                self.has_motion = true;
                self.answers.on_motion(motion, self.stamp);
            }
            Event::Planes(planes) => self.on_planes(rt, &planes)?,
            Event::Thrusters(command) => self.on_thrusters(&command),
            Event::ThrusterSetpoints(setpoints) => {
                // It has no stamp: that of the tick in which it comes.
                let mut command = ThrusterCommand {
                    name: self.plant.thrusters().to_vec(),
                    command: setpoints.data,
                    ..ThrusterCommand::default()
                };
                command.header.stamp = self.stamp();
                self.on_thrusters(&command);
            }
            Event::Answer(answer) => self.answers.on_answer(&answer, self.stamp),
            Event::Gate(event) => {
                if let Some(topic) = self.gates.on(rt, event, self.stamp, &self.wait.sent) {
                    self.answers.on_gate(topic);
                }
            }
            Event::Poll => self.poll(rt)?,
            Event::Pause(request, responder) => {
                self.paused = request.data;
                self.resumes |= self.paused;
                self.begin_tick(rt)?;
                // The tick that is on will be flown yet.
                let stands = self.k + i64::from(self.paused && self.observation.is_some());
                responder.answer(SetBoolResponse {
                    success: true,
                    message: format!("at tick {stands}"),
                });
            }
            Event::Step(request, responder) => self.step(rt, &request, responder)?,
            Event::Reset(responder) => {
                // What was published at a stamp stays so: a tick that is on is flown first.
                self.reset_due = true;
                self.reset_between_ticks();
                log::info!("vehicle reset to its initial state; time continues");
                responder.answer(TriggerResponse {
                    success: true,
                    message: "reset to the initial state".to_owned(),
                });
            }
            // They have been accepted; but a file that they name may have changed since.
            Event::Parameters(parameters) => match self.plant.set_parameters(&parameters) {
                Ok(()) => {
                    self.answers.set_parameters(&parameters);
                    self.wait.timeout = parameters.answer_timeout;
                }
                Err(reason) => log::error!("{reason}; the previous parameters stay in force"),
            },
        }
        while self.tick_is_over(rt) {
            self.end_tick()?;
            self.begin_tick(rt)?;
        }
        if self.end_when_flown && self.is_flown() {
            return Ok(Flow::Stop);
        }
        Ok(Flow::Continue)
    }

    /// Takes the answer of an actuator that publishes only joint states. An actuator that also publishes `plane_motion` announces that topic
    /// first, so the choice of the topic does not depend on which message is faster.
    fn on_planes(&mut self, rt: &Runtime<Event>, planes: &JointState) -> Result<()> {
        self.has_motion = self.has_motion || !rt.publishing_nodes(PLANE_MOTION)?.is_empty();
        if self.has_motion {
            return Ok(());
        }
        if let Some(motion) = self.plant.motion(planes) {
            self.answers.on_motion(motion, self.stamp);
        }
        Ok(())
    }

    /// Takes thruster commands; in lockstep only commands for the present tick.
    fn on_thrusters(&mut self, command: &ThrusterCommand) {
        let is_lockstep = matches!(self.pace, Pace::Lockstep { .. });
        if is_lockstep && (self.observation.is_none() || command.header.stamp.nanos() != self.stamp)
        {
            return;
        }
        match self.plant.set_thrusters(command) {
            Ok(()) => self.answers.on_gate(THRUSTER_COMMAND),
            Err(reason) => self.warnings.warn("thrusters", &reason.to_string()),
        }
    }

    /// Publishes in the status which topic moves the planes and who publishes it; warns of publishers that are ignored.
    fn tell_actuator(&mut self, rt: &Runtime<Event>) -> Result<()> {
        if self.plant.craft().is_of_thrusters_alone() {
            rt.set_status(
                "actuator",
                Level::Ok,
                "only thrusters move this vehicle",
                &[],
            );
            return Ok(());
        }
        let motion = rt.publishing_nodes(PLANE_MOTION)?;
        let planes = rt.publishing_nodes(PLANES)?;
        self.has_motion = !motion.is_empty();
        let used = match self.has_motion {
            true => format!("{PLANE_MOTION} of {}", motion.join(", ")),
            false => format!("{PLANES} of {}", planes.join(", ")),
        };
        let vain: Vec<&str> = planes
            .iter()
            .filter(|it| self.has_motion && !motion.contains(it))
            .map(String::as_str)
            .collect();
        let (level, message) = match (vain.as_slice(), planes.is_empty() && !self.has_motion) {
            (_, true) => (
                Level::Warn,
                format!("nobody publishes {PLANE_MOTION} or {PLANES}"),
            ),
            ([], false) => (Level::Ok, used.clone()),
            (vain, false) => (
                Level::Warn,
                format!("{used}; {PLANES} of {} ignored", vain.join(", ")),
            ),
        };
        if !vain.is_empty() && !std::mem::replace(&mut self.told_of_vain, true) {
            log::warn!("{message}: an actuator with {PLANE_MOTION} has priority");
        }
        rt.set_status("actuator", level, &message, &[]);
        Ok(())
    }

    /// Whether all ticks of the scenario have been flown.
    fn is_flown(&self) -> bool {
        self.ticks.is_some_and(|ticks| self.k >= ticks)
    }

    fn stamp(&self) -> Time {
        Time::from_nanos(self.stamp)
    }

    fn reset_between_ticks(&mut self) {
        if self.observation.is_none() && std::mem::take(&mut self.reset_due) {
            self.plant.reset();
        }
    }

    fn step(
        &mut self,
        rt: &Runtime<Event>,
        request: &StepRequest,
        responder: Responder<Step>,
    ) -> Result<()> {
        let refusal = if !(1..=100_000).contains(&request.ticks) {
            Some(format!(
                "ticks: {} refused: a number from 1 to 100000 is expected",
                request.ticks
            ))
        } else if !self.paused || self.observation.is_some() {
            Some("the vehicle is not paused".to_owned())
        } else {
            None
        };
        if let Some(message) = refusal {
            responder.answer(StepResponse {
                success: false,
                message,
            });
            return Ok(());
        }
        self.stepping = Some(Stepping {
            ticks: request.ticks,
            responder,
        });
        self.begin_tick(rt)
    }

    /// Publishes the state and sensor readings at the beginning of the next tick, unless a tick is running or no tick is due.
    fn begin_tick(&mut self, rt: &Runtime<Event>) -> Result<()> {
        if self.listening.is_some()
            || self.observation.is_some()
            || self.is_flown()
            || (self.paused && self.stepping.is_none())
        {
            return Ok(());
        }
        let now = rt.now().nanos();
        if matches!(self.pace, Pace::Clock) {
            if now == 0 {
                return Ok(()); // No `/clock` yet.
            }
            self.keep_up(now, rt.is_time_simulated());
        }
        self.claim.advance_to(Stage::Used);
        let stamp = self.stamp();
        if self.publishers.clock.is_some() {
            rt.set_time(&stamp);
        }
        let observation = self.plant.observe(stamp.clone());
        let saturated = observation.instruments.daq.saturated;
        if saturated != 0 {
            self.saturated = (self.saturated.0 | saturated, Instant::now());
        }
        self.wait.sent = planesman_node::wall_time();
        let Ok(()) = self.publishers.say(&stamp, &observation);
        self.observation = Some(observation);
        self.answers.begin();
        let mut missed = 0;
        match &mut self.pace {
            Pace::Lockstep { began, said } => {
                *began = Instant::now();
                *said = *began;
            }
            Pace::Real { factor, deadline } => {
                let now = Instant::now();
                let tick = Duration::from_secs_f64(self.plant.tick_nanos() as f64 * 1e-9 / *factor);
                let behind = now.saturating_duration_since(*deadline);
                *deadline += tick;
                if behind >= tick {
                    // No hurry to catch up: `/clock` stood meanwhile.
                    missed = (behind.as_nanos() / tick.as_nanos().max(1)) as i64;
                    *deadline = now + tick;
                }
                drop(rt.after(*deadline - now, || Event::Poll));
            }
            Pace::Clock => drop(rt.at(self.end(), || Event::Poll)),
        }
        if self.k > 0 {
            self.miss(missed, 0);
        }
        self.resumes = false;
        Ok(())
    }

    /// End time of the present tick.
    fn end(&self) -> Time {
        Time::from_nanos(self.stamp + self.plant.tick_nanos())
    }

    /// Moves the stamp of the next tick forward to `now` (ns) by whole ticks if the clock has run on without the vehicle: in a pause, in a
    /// stall, or because somebody set the clock. If `/clock` comes less often than the ticks (`coarse`), the vehicle catches up instead.
    fn keep_up(&mut self, now: i64, coarse: bool) {
        let tick = self.plant.tick_nanos();
        let behind = now - self.stamp;
        let seen = self.seen.replace((Instant::now(), now));
        // By how much somebody set the machine's clock since the last tick.
        let set = seen.filter(|_| !coarse).map_or(0, |(at, then)| {
            now - then - i64::try_from(at.elapsed().as_nanos()).unwrap_or(i64::MAX)
        });
        let tolerated = match coarse && !self.resumes {
            true => COARSEST_CLOCK,
            false => 0,
        };
        if self.k == 0 || behind < -tick {
            if self.k > 0 {
                log::warn!("the clock was set back by {:.3} s", -behind as f64 * 1e-9);
                self.answers.restart();
            }
            self.stamp = now;
        } else if behind >= tick.max(tolerated) {
            self.stamp += behind / tick * tick;
            self.miss(behind / tick, set);
        }
    }

    /// Counts and logs the ticks missed. `set`: the amount by which the clock was set forward, ns.
    fn miss(&mut self, ticks: i64, set: i64) {
        if ticks == 0 {
            return;
        }
        self.missed += ticks;
        let time = (ticks * self.plant.tick_nanos()) as f64 * 1e-9;
        if self.resumes {
            log::info!("resumed at tick {} after a pause of {time:.2} s", self.k);
        } else {
            let reason = match set > self.plant.tick_nanos() {
                true => "this machine's clock was set forward",
                false => "this machine was too slow, or the process was stopped",
            };
            let text = format!("{ticks} before tick {} ({time:.2} s): {reason}", self.k);
            self.warnings.warn("ticks missed", &text);
        }
    }

    /// Fails if another vehicle runs in the namespace: each would take the answers to the other's ticks.
    fn be_alone(&mut self) -> Result<()> {
        let topic = self.publishers.state.topic();
        if let Some(holder) = self.claim.holder() {
            bail!(
                "{holder} already publishes {topic}. Stop that node, or choose another namespace or ROS_DOMAIN_ID"
            );
        }
        let Some(since) = self.listening else {
            return Ok(());
        };
        if self.publishers.state.others() == 0 {
            if since.elapsed() >= LISTENING && self.gates.are_open_for(SETTLING) {
                self.listening = None;
                self.claim.advance_to(Stage::Held);
            }
        } else if since.elapsed() >= LEAVING && self.claim.rival().is_none() {
            bail!(
                "{topic} has a publisher already. Stop that node, or choose another namespace or ROS_DOMAIN_ID"
            );
        }
        Ok(())
    }

    fn tick_is_over(&self, rt: &Runtime<Event>) -> bool {
        self.observation.is_some()
            && match &self.pace {
                Pace::Lockstep { .. } => self.answers.missing(self.stamp).is_empty(),
                Pace::Real { deadline, .. } => Instant::now() >= *deadline,
                Pace::Clock => {
                    let (now, tick) = (rt.now().nanos(), self.plant.tick_nanos());
                    // Long before the tick: somebody set the clock back.
                    now >= self.stamp + tick || now < self.stamp - tick
                }
            }
    }

    /// Moves the vehicle over the present tick.
    fn end_tick(&mut self) -> Result<()> {
        let motion = self.answers.fly(self.stamp);
        let advanced = match &motion {
            Some(motion) if self.answers.age > 0 => self.plant.advance_late(motion),
            motion => self.plant.advance(motion.as_ref()),
        };
        match advanced {
            Ok(()) => {
                if let Some(contact) = self.plant.contact() {
                    let boundary = match contact.boundary {
                        Boundary::Surface => "surface",
                        Boundary::Bottom => "bottom",
                    };
                    let time = self.stamp + (contact.time * 1e9).round() as i64;
                    self.contact = format!("{boundary} at {:.6} s", time as f64 * 1e-9);
                }
            }
            // A vehicle that cannot go on ends, and with it the flight: standing, it would look alive.
            Err(reason) => {
                let time = self.stamp as f64 * 1e-9;
                bail!(
                    "the simulation stopped at tick {}, stamp {time:.3} s: {reason}",
                    self.k
                )
            }
        }
        self.observation = None;
        self.reset_between_ticks();
        self.k += 1;
        self.stamp += self.plant.tick_nanos();
        if self.ticks == Some(self.k) {
            log::info!("done: {} ticks", self.k);
        }
        if let Some(stepping) = &mut self.stepping {
            stepping.ticks -= 1;
            if stepping.ticks == 0
                && let Some(done) = self.stepping.take()
            {
                self.resumes = true;
                done.responder.answer(StepResponse {
                    success: true,
                    message: format!("at tick {}", self.k),
                });
            }
        }
        Ok(())
    }

    /// Publishes in the status which sensors saturated lately, with their range; diagnostics are sent once a second.
    fn tell_saturated(&mut self, rt: &Runtime<Event>) {
        if self.saturated.1.elapsed() > WARNING_PERIOD {
            self.saturated.0 = 0;
        }
        let limits = self.plant.saturated(self.saturated.0).join("; ");
        let (level, message) = match &*limits {
            "" => (Level::Ok, "within their ranges".to_owned()),
            limits => (Level::Warn, format!("saturated: {limits}")),
        };
        rt.set_status("sensors", level, &message, &[]);
    }

    /// Runs ten times a second, and when the wall clock ends a tick.
    fn poll(&mut self, rt: &Runtime<Event>) -> Result<()> {
        self.gates.discover(rt);
        self.be_alone()?;
        self.tell_actuator(rt)?;
        let by_the_machine = matches!(self.pace, Pace::Clock) && !rt.is_time_simulated();
        if by_the_machine && rt.now().sec == i32::MAX {
            bail!(
                "this machine's clock has reached 2038-01-19 03:14:07 UTC, the end of ROS 2 stamps. Use simulated time (time: lockstep, or sim_time)"
            );
        }
        self.begin_tick(rt)?;
        let mut status = (Level::Ok, "running".to_owned());
        // The actuator's silence by the stamps; below, that of a tick's members by the wall clock.
        let silent = self.observation.as_ref().map_or(0, |_| self.answers.silent);
        let mut silence = (silent * self.plant.tick_nanos()) as f64 * 1e-9;
        let mut outcome = "no answer of the actuator, planes held".to_owned();
        if let Some(since) = self.listening {
            let closed = self.gates.closed().join(", ");
            status = match closed.is_empty() {
                true => (Level::Ok, "checking for another vehicle".to_owned()),
                false => (Level::Warn, format!("waiting for {closed}")),
            };
            if status.0 == Level::Warn && since.elapsed() >= WARNING_PERIOD {
                self.warnings.warn("the first tick waits for", &closed);
            }
        } else if self.observation.is_none() {
            status = match (self.is_flown(), self.paused) {
                (true, _) => (Level::Ok, DONE.to_owned()),
                (false, true) => (Level::Ok, "paused".to_owned()),
                (false, false) => (Level::Warn, "waiting for /clock".to_owned()),
            };
        } else if self.answers.age > 0 {
            let age = self.answers.age;
            status = (
                Level::Warn,
                format!("using an answer that is {age} ticks old"),
            );
        } else if let (Pace::Lockstep { began, said }, Some(observation)) =
            (&mut self.pace, &self.observation)
            && began.elapsed() >= REPEAT_AFTER
        {
            // The status stays until the tick is over: diagnostics go out once a second.
            let missing: Vec<String> = (self.answers.missing(self.stamp).into_iter())
                .map(|it| reason(rt, &self.gates, it))
                .collect::<Result<_>>()?;
            let missing = missing.join(", ");
            silence = began.elapsed().as_secs_f64();
            outcome = format!("waiting for {missing}");
            status = (Level::Warn, outcome.clone());
            if said.elapsed() >= REPEAT_AFTER {
                log::warn!("tick {} waits for {missing}", self.k);
                *said = Instant::now();
                let stamp = &observation.state.header.stamp;
                self.publishers.say(stamp, observation);
            }
        }
        let was_overdue = self.wait.overdue;
        self.wait.overdue = self.wait.timeout > 0.0 && silence >= self.wait.timeout;
        if self.wait.overdue {
            status = (Level::Error, format!("{outcome} for {silence:.0} s"));
        }
        match (was_overdue, self.wait.overdue) {
            (false, true) => log::error!("tick {}: {}", self.k, status.1),
            (true, false) => log::info!("tick {}: answers arrive again", self.k),
            _ => {}
        }
        self.tell_saturated(rt);
        rt.set_status(
            "vehicle",
            status.0,
            &status.1,
            &[
                ("ticks", self.k.to_string()),
                (
                    "ticks without the actuator's answer",
                    self.answers.unanswered.to_string(),
                ),
                ("ticks on an older answer", self.answers.delayed.to_string()),
                ("ticks missed", self.missed.to_string()),
                ("latest contact", self.contact.clone()),
            ],
        );
        Ok(())
    }
}

/// The part of the loop that causes a missing answer: the first one in the chain whose topic has no publisher, or else the last one.
fn reason(rt: &Runtime<Event>, gates: &Gates, missing: &str) -> Result<String> {
    let controller = "the controller";
    let chain: &[(&str, &[&str])] = match missing {
        THE_ACTUATOR => &[
            (controller, &[PLANE_COMMAND]),
            (THE_ACTUATOR, &[PLANE_MOTION, PLANES]),
        ],
        THRUSTER_COMMAND => &[(controller, &[THRUSTER_COMMAND, THRUSTER_SETPOINTS])],
        _ => &[],
    };
    let mut last = gates.reason(missing).unwrap_or_else(|| missing.to_owned());
    for (who, topics) in chain {
        let mut nodes = BTreeSet::new();
        for topic in *topics {
            nodes.extend(rt.publishing_nodes(topic)?);
        }
        let (topics, nodes) = (topics.join(" or "), Vec::from_iter(nodes).join(", "));
        if nodes.is_empty() {
            return Ok(format!("{who}: nobody publishes {topics}"));
        }
        last = format!("{who}: {topics} of {nodes}");
    }
    Ok(last)
}

/// Publishers by topic.
struct Publishers {
    clock: Option<Publisher<Clock>>,
    /// Kept open for late joiners.
    _static_messages: (Publisher<TFMessage>, Publisher<Text>),
    state: Publisher<VehicleState>,
    /// Publishers of pose and sensors, each a [`Publisher`] of its type.
    others: BTreeMap<String, Box<dyn Any>>,
}

impl Publishers {
    fn new(
        rt: &Runtime<Event>,
        static_messages: &StaticMessages,
        instruments: &Instruments,
        owns_time: bool,
        lossless: bool,
    ) -> Result<Self> {
        let transforms = rt.loop_publisher("/tf_static")?;
        transforms.publish(&static_messages.transforms);
        let description = rt.loop_publisher("robot_description")?;
        description.publish(&static_messages.description);
        let mut opened = Opened {
            rt,
            lossless,
            publishers: BTreeMap::new(),
        };
        let any = Time::default();
        Pose::default().put_into(&any, &mut opened)?;
        instruments.put_into(&any, &mut opened)?;
        Ok(Self {
            _static_messages: (transforms, description),
            clock: owns_time
                .then(|| anyhow::Ok(rt.loop_publisher("/clock")?.sole()))
                .transpose()?,
            state: rt.loop_publisher("state")?.sole(),
            others: opened.publishers,
        })
    }

    /// Publishes an observation; the state last, because the members of lockstep answer to the state.
    fn say(&mut self, stamp: &Time, observation: &Observation) -> Result<(), Infallible> {
        if let Some(clock) = &self.clock {
            clock.publish(&Clock {
                clock: stamp.clone(),
            });
        }
        observation.instruments.put_into(stamp, self)?;
        observation.pose.put_into(stamp, self)?;
        self.state.publish(&observation.state);
        Ok(())
    }
}

impl Sink for Publishers {
    type Error = Infallible;

    fn put<M: Message>(
        &mut self,
        topic: &str,
        _stamp: &Time,
        message: &M,
    ) -> Result<(), Infallible> {
        let publisher = self.others.get(topic);
        if let Some(publisher) = publisher.and_then(|it| it.downcast_ref::<Publisher<M>>()) {
            publisher.publish(message);
        }
        Ok(())
    }
}

/// Opens a publisher for each message type of an observation, without sending. Sensor topics are best effort, except in lockstep, where
/// the members must receive every message.
struct Opened<'a> {
    rt: &'a Runtime<Event>,
    lossless: bool,
    publishers: BTreeMap<String, Box<dyn Any>>,
}

impl Sink for Opened<'_> {
    type Error = anyhow::Error;

    fn put<M: Message>(&mut self, topic: &str, _stamp: &Time, _message: &M) -> Result<()> {
        let publisher = match self.lossless {
            true => self.rt.lossless_publisher::<M>(topic)?,
            false => self.rt.loop_publisher::<M>(topic)?,
        };
        self.publishers
            .insert(topic.to_owned(), Box::new(publisher));
        Ok(())
    }
}
