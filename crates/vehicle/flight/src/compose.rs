//! The loop in one process: the nodes' cores are called in turn, without DDS and without a clock.
//!
//! A tick follows the rules of ARCHITECTURE.md with the same messages, so the trajectories equal those of the lockstep loop over DDS bit
//! for bit.

use std::sync::Arc;

use crate::error::Result;
use planesman_hydraulics::Group;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::loop_topics::Sink;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, MotionEstimate, PlaneCommand, ThrusterCommand,
    VehicleState,
};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_parallel::stop_point;
use planesman_plant::StaticMessages;

use crate::parts::{
    Actuator, Estimator, Law, Model, Motion, Observation, Parts, Plant, in_place_of,
};
use crate::scenario::Scenario;

/// All messages of the loop in one tick.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Messages that are constant for the whole flight; only in its first tick.
    pub static_messages: Option<StaticMessages>,
    /// Time of the tick, and stamp of every message.
    pub stamp: Time,
    /// State and sensors of the vehicle at this time.
    pub observation: Observation,
    /// Command of the controller.
    pub command: PlaneCommand,
    /// State of the controller.
    pub control: ControlState,
    /// Command of the controller to the thrusters, if the vehicle has any.
    pub thrusters: Option<ThrusterCommand>,
    /// Estimated motion, if the controller does not use the true state.
    pub estimate: Option<MotionEstimate>,
    /// Motion of the actuator until the next stamp.
    pub actuator: Arc<dyn Motion>,
    /// Planes and rams.
    pub planes: Option<JointState>,
    /// Groups of planes that the actuator moves.
    pub groups: &'static [Group],
    /// State of each group's actuator.
    pub states: Vec<DhaState>,
    /// Identified models that are due in this tick.
    pub models: Vec<ModelEstimate>,
}

/// The part of a tick that the loop itself needs, without messages for other readers.
#[derive(Clone, Debug)]
pub struct Step {
    /// True state.
    pub state: VehicleState,
    /// Answers to it.
    pub answers: Answers,
}

/// Answers of controller, actuator and identifier to a state.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Same as [`Tick::command`].
    pub command: PlaneCommand,
    /// Same as [`Tick::control`].
    pub control: ControlState,
    /// Same as [`Tick::actuator`].
    pub actuator: Arc<dyn Motion>,
    /// Identified models that are due.
    pub models: Vec<Model>,
}

impl Tick {
    /// Sends every message of the tick to `sink`, in the order in which the loop publishes them.
    ///
    /// # Errors
    /// If the sink cannot store a message.
    pub fn put_into<S: Sink>(&self, sink: &mut S) -> Result<(), S::Error> {
        let t = &self.stamp;
        let o = &self.observation;
        sink.put("/clock", t, &Clock { clock: t.clone() })?;
        if let Some(static_messages) = &self.static_messages {
            sink.put("/tf_static", t, &static_messages.transforms)?;
            sink.put("robot_description", t, &static_messages.description)?;
        }
        sink.put("state", t, &o.state)?;
        if let Some(pose) = &o.pose {
            pose.put_into(t, sink)?;
        }
        if let Some(instruments) = &o.instruments {
            instruments.put_into(t, sink)?;
        }
        sink.put("plane_command", t, &self.command)?;
        if let Some(thrusters) = &self.thrusters {
            sink.put("thruster_command", t, thrusters)?;
        }
        sink.put("control_state", t, &self.control)?;
        if let Some(estimate) = &self.estimate {
            sink.put("estimate", t, estimate)?;
        }
        sink.put("plane_motion", t, self.actuator.motion())?;
        if let Some(planes) = &self.planes {
            sink.put("planes", t, planes)?;
        }
        for (group, state) in self.groups.iter().zip(&self.states) {
            sink.put(group.topic(), t, state)?;
        }
        for model in &self.models {
            sink.put("model", t, model)?;
        }
        Ok(())
    }
}

/// The loop in one process.
pub struct Loop {
    plant: Box<dyn Plant>,
    law: Box<dyn Law>,
    actuator: Box<dyn Actuator>,
    estimator: Box<dyn Estimator>,
    tick_nanos: i64,
    /// Number of the next tick.
    k: i64,
    /// Total number of ticks.
    ticks: u64,
}

impl Loop {
    /// Creates the loop of a scenario, before its first tick.
    ///
    /// # Errors
    /// If a vehicle, actuator or parameter set is refused.
    pub fn new(scenario: &Scenario) -> Result<Self> {
        Self::of_parts(&Parts::default(), scenario)
    }

    /// Like [`Loop::new`], with these parts.
    ///
    /// # Errors
    /// Same as [`Loop::new`], and the refusals of the parts' constructors.
    pub fn of_parts(parts: &Parts, scenario: &Scenario) -> Result<Self> {
        Ok(Self {
            plant: parts.plant(scenario)?,
            law: parts.law(scenario)?,
            actuator: parts.actuator(scenario)?,
            estimator: parts.estimator(scenario)?,
            tick_nanos: scenario.tick_nanos(),
            k: 0,
            ticks: scenario.ticks(),
        })
    }

    /// Runs one tick: all parts answer for the present stamp, then the vehicle advances.
    ///
    /// # Errors
    /// If a part refuses another part's message, or the vehicle's state would diverge.
    pub fn tick(&mut self) -> Result<Tick> {
        let stamp = self.stamp();
        let static_messages = (self.k == 0)
            .then(|| self.plant.static_messages())
            .flatten();
        let observation = self.plant.observe(stamp.clone());
        if let Some(instruments) = &observation.instruments {
            self.law.on_instruments(instruments);
        }
        let Answers {
            command,
            control,
            actuator,
            models,
        } = self.answer(&observation.state)?;
        let models: Vec<_> = models.iter().filter_map(Model::estimate).collect();
        for model in &models {
            self.law.on_model(model.clone());
        }
        Ok(Tick {
            static_messages,
            stamp,
            observation,
            command,
            control,
            thrusters: self.law.thrusters().cloned(),
            estimate: self.law.estimate().cloned(),
            planes: actuator.planes(),
            groups: self.actuator.groups(),
            states: actuator.states(),
            actuator,
            models,
        })
    }

    /// Like [`Loop::tick`], without the messages that only outside readers use.
    ///
    /// # Errors
    /// Same as [`Loop::tick`].
    pub fn step(&mut self) -> Result<Step> {
        let stamp = self.stamp();
        if self.law.reads_instruments()
            && let Some(instruments) = self.plant.instruments(stamp.clone())
        {
            self.law.on_instruments(&instruments);
        }
        let state = self.plant.state(stamp);
        let answers = self.answer(&state)?;
        if self.law.reads_models() {
            for model in answers.models.iter().filter_map(Model::estimate) {
                self.law.on_model(model);
            }
        }
        Ok(Step { state, answers })
    }

    /// Whether the flight is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.k.unsigned_abs() >= self.ticks
    }

    /// State at the present tick.
    #[must_use]
    pub fn state(&self) -> VehicleState {
        self.plant.state(self.stamp())
    }

    /// Stamp of the present tick.
    fn stamp(&self) -> Time {
        Time::from_nanos(self.k * self.tick_nanos)
    }

    /// Collects all parts' answers to the present state and advances the vehicle.
    fn answer(&mut self, state: &VehicleState) -> Result<Answers> {
        stop_point();
        let (command, control) = self
            .law
            .on_state(state)
            .map_err(in_place_of("depth_controller"))?;
        let actuator = self
            .actuator
            .on_command(&command)
            .map_err(in_place_of("dha_actuator"))?;
        let models = self
            .estimator
            .learn(state, actuator.motion())
            .map_err(in_place_of("sysid"))?;
        if let Some(thrusters) = self.law.thrusters() {
            self.plant
                .set_thrusters(thrusters)
                .map_err(in_place_of("plant_sim"))?;
        }
        self.plant
            .advance(actuator.motion())
            .map_err(in_place_of("plant_sim"))?;
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
