//! The loop in one process: the nodes' cores called in turn, no DDS, no clock.
//!
//! It does per tick what ARCHITECTURE.md says the processes do, with the same messages,
//! so its trajectories equal those of the lockstep loop over DDS bit for bit.

use std::fmt::Display;
use std::sync::Arc;

use anyhow::{Result, anyhow};
use planesman_control::Controller;
use planesman_hydraulics::{Actuator, Group, Output};
use planesman_identification::stop_point;
use planesman_identifier::{Due, Identifier};
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, MotionEstimate, PlaneCommand, VehicleState,
};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu, JointState};
use planesman_plant::{Facts, Instruments, Observation, Plant};

use crate::scenario::Scenario;

/// Every message of the loop in one tick.
#[derive(Clone, Debug)]
pub struct Tick {
    /// What holds for the whole flight, in its first tick.
    pub facts: Option<Facts>,
    /// The instant, also the stamp of every message.
    pub stamp: Time,
    /// State and sensors of the vehicle at the stamp.
    pub observation: Observation,
    /// The command of the controller.
    pub command: PlaneCommand,
    /// The state of the controller.
    pub control: ControlState,
    /// The estimated motion, when the controller does not use the true state.
    pub estimate: Option<MotionEstimate>,
    /// The motion of the actuator until the next stamp.
    pub actuator: Arc<Output>,
    /// Planes and rams.
    pub planes: JointState,
    /// The planes it moves, a state each.
    pub groups: &'static [Group],
    /// The actuators inside.
    pub states: Vec<DhaState>,
    /// The identified model, when one is due.
    pub models: Vec<ModelEstimate>,
}

/// Of a tick the messages that pass between the parts, when nobody else is to read any.
#[derive(Clone, Debug)]
pub struct Step {
    /// The true state.
    pub state: VehicleState,
    /// The answers to it.
    pub answers: Answers,
}

/// The answers of controller, actuator and identifier to a state.
#[derive(Clone, Debug)]
pub struct Answers {
    /// As of [`Tick::command`].
    pub command: PlaneCommand,
    /// As of [`Tick::control`].
    pub control: ControlState,
    /// As of [`Tick::actuator`].
    pub actuator: Arc<Output>,
    /// The identified model, when one is due.
    pub models: Vec<Due>,
}

/// Something that takes messages by topic.
pub trait Sink {
    /// Takes one message of `topic` (relative to the namespace unless it begins with `/`).
    ///
    /// # Errors
    /// When it cannot be kept.
    fn put<M: Message>(&mut self, topic: &str, stamp: &Time, message: &M) -> Result<()>;
}

impl Tick {
    /// Hands every message of the tick to `sink`, in the order in which the loop publishes them.
    ///
    /// # Errors
    /// When the sink cannot keep one.
    pub fn put_into(&self, sink: &mut impl Sink) -> Result<()> {
        let t = &self.stamp;
        let o = &self.observation;
        sink.put("/clock", t, &Clock { clock: t.clone() })?;
        if let Some(facts) = &self.facts {
            sink.put("/tf_static", t, &facts.transforms)?;
            sink.put("robot_description", t, &facts.description)?;
        }
        sink.put("state", t, &o.state)?;
        sink.put("odom", t, &o.odometry)?;
        sink.put("/tf", t, &o.transforms)?;
        sink.put("imu", t, &o.imu)?;
        sink.put("depth_pressure", t, &o.depth_pressure)?;
        sink.put("speed_pressure", t, &o.speed_pressure)?;
        sink.put("daq", t, &o.daq)?;
        sink.put("plane_command", t, &self.command)?;
        sink.put("control_state", t, &self.control)?;
        if let Some(estimate) = &self.estimate {
            sink.put("estimate", t, estimate)?;
        }
        sink.put("plane_motion", t, &self.actuator.motion)?;
        sink.put("planes", t, &self.planes)?;
        for (group, state) in self.groups.iter().zip(&self.states) {
            sink.put(group.topic(), t, state)?;
        }
        for model in &self.models {
            sink.put("model", t, model)?;
        }
        Ok(())
    }
}

/// The composed loop.
pub struct Loop {
    plant: Plant,
    controller: Controller,
    actuator: Actuator,
    identifier: Identifier,
    tick_nanos: i64,
    /// The next tick.
    k: i64,
    /// Ticks in all.
    ticks: u64,
}

/// The error of a node, with its name.
fn of<E: Display>(node: &'static str) -> impl Fn(E) -> anyhow::Error {
    move |e| anyhow!("node {node}: {e}")
}

impl Loop {
    /// The loop of a scenario, before its first tick.
    ///
    /// # Errors
    /// When a vehicle, actuator or parameter set is refused.
    pub fn new(scenario: &Scenario) -> Result<Self> {
        let plant = Plant::new(&scenario.parameters_of("plant_sim")?).map_err(of("plant_sim"))?;
        let tick_nanos = plant.tick_nanos();
        Ok(Self {
            controller: Controller::new(&scenario.parameters_of("depth_controller")?)
                .map_err(of("depth_controller"))?,
            actuator: Actuator::new(&scenario.parameters_of("dha_actuator")?, tick_nanos)
                .map_err(of("dha_actuator"))?,
            identifier: Identifier::new(&scenario.parameters_of("sysid")?).map_err(of("sysid"))?,
            plant,
            tick_nanos,
            k: 0,
            ticks: scenario.ticks(),
        })
    }

    /// One tick: everybody answers for the present stamp, then the vehicle moves on.
    ///
    /// # Errors
    /// When a part refuses what another said, or the vehicle's state would blow up.
    pub fn tick(&mut self) -> Result<Tick> {
        let stamp = self.stamp();
        let facts = (self.k == 0).then(|| self.plant.facts());
        let observation = self.plant.observe(stamp.clone());
        self.show(
            &observation.imu,
            &observation.depth_pressure,
            &observation.speed_pressure,
        );
        let Answers {
            command,
            control,
            actuator,
            models,
        } = self.answer(&observation.state)?;
        let models: Vec<_> = models.iter().filter_map(Due::estimate).collect();
        for model in &models {
            self.controller.on_model(model.clone());
        }
        Ok(Tick {
            facts,
            stamp,
            observation,
            command,
            control,
            estimate: self.controller.estimate().cloned(),
            planes: actuator.planes(),
            groups: self.actuator.groups(),
            states: actuator.states(),
            actuator,
            models,
        })
    }

    /// As [`Loop::tick`], without the messages that nobody in the loop reads.
    ///
    /// # Errors
    /// Those of [`Loop::tick`].
    pub fn step(&mut self) -> Result<Step> {
        let stamp = self.stamp();
        if self.controller.reads_instruments() {
            let Instruments {
                imu,
                depth_pressure,
                speed_pressure,
            } = self.plant.instruments(stamp.clone());
            self.show(&imu, &depth_pressure, &speed_pressure);
        }
        let state = self.plant.state(stamp);
        let answers = self.answer(&state)?;
        if self.controller.reads_models() {
            for model in answers.models.iter().filter_map(Due::estimate) {
                self.controller.on_model(model);
            }
        }
        Ok(Step { state, answers })
    }

    /// Whether the flight is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.k.unsigned_abs() >= self.ticks
    }

    /// The present tick's.
    fn stamp(&self) -> Time {
        Time::from_nanos(self.k * self.tick_nanos)
    }

    /// Gives the controller the instruments' readings, before the state of their stamp.
    fn show(&mut self, imu: &Imu, depth_pressure: &FluidPressure, speed_pressure: &FluidPressure) {
        self.controller.on_imu(imu);
        self.controller.on_depth_pressure(depth_pressure);
        self.controller.on_speed_pressure(speed_pressure);
    }

    /// Everybody's answers to the present tick's state, on which the vehicle moves on.
    fn answer(&mut self, state: &VehicleState) -> Result<Answers> {
        stop_point();
        let (command, control) = self
            .controller
            .on_state(state)
            .map_err(|e| anyhow!("depth_controller: {e}"))?;
        let actuator = self
            .actuator
            .on_command(&command)
            .map_err(|e| anyhow!("dha_actuator: {e}"))?;
        let mut models = Vec::new();
        for learnt in [
            self.identifier
                .learn("state", state.header.stamp.clone(), state),
            self.identifier
                .learn("plane_motion", state.header.stamp.clone(), &actuator.motion),
        ] {
            models.extend(learnt.map_err(|e| anyhow!("sysid: {e}"))?);
        }
        self.plant
            .advance(Some(&actuator.motion))
            .map_err(|e| anyhow!("plant_sim: {e}"))?;
        self.k += 1;
        Ok(Answers {
            command,
            control,
            actuator,
            models,
        })
    }
}

impl Iterator for Loop {
    type Item = Result<Tick>;

    fn next(&mut self) -> Option<Self::Item> {
        (!self.is_over()).then(|| self.tick())
    }
}
