//! The loop in one process: the nodes' cores called in turn, no DDS, no clock.
//!
//! It does per tick what ARCHITECTURE.md says the processes do, with the same messages,
//! so its trajectories equal those of the lockstep loop over DDS bit for bit.

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

/// Every message of the loop in one tick.
#[derive(Clone, Debug)]
pub struct Tick {
    /// What holds for the whole flight, in its first tick.
    pub static_messages: Option<StaticMessages>,
    /// The instant, also the stamp of every message.
    pub stamp: Time,
    /// State and sensors of the vehicle at the stamp.
    pub observation: Observation,
    /// The command of the controller.
    pub command: PlaneCommand,
    /// The state of the controller.
    pub control: ControlState,
    /// What the controller asks of the thrusters, of a vehicle that has them.
    pub thrusters: Option<ThrusterCommand>,
    /// The estimated motion, when the controller does not use the true state.
    pub estimate: Option<MotionEstimate>,
    /// The motion of the actuator until the next stamp.
    pub actuator: Arc<dyn Motion>,
    /// Planes and rams.
    pub planes: Option<JointState>,
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
    pub actuator: Arc<dyn Motion>,
    /// The identified model, when one is due.
    pub models: Vec<Model>,
}

impl Tick {
    /// Hands every message of the tick to `sink`, in the order in which the loop publishes them.
    ///
    /// # Errors
    /// When the sink cannot keep one.
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

/// The composed loop.
pub struct Loop {
    plant: Box<dyn Plant>,
    law: Box<dyn Law>,
    actuator: Box<dyn Actuator>,
    estimator: Box<dyn Estimator>,
    tick_nanos: i64,
    /// The next tick.
    k: i64,
    /// Ticks in all.
    ticks: u64,
}

impl Loop {
    /// The loop of a scenario, before its first tick.
    ///
    /// # Errors
    /// When a vehicle, actuator or parameter set is refused.
    pub fn new(scenario: &Scenario) -> Result<Self> {
        Self::of_parts(&Parts::default(), scenario)
    }

    /// As [`Loop::new`], of these parts.
    ///
    /// # Errors
    /// As [`Loop::new`], and what a part's maker refuses.
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

    /// One tick: everybody answers for the present stamp, then the vehicle moves on.
    ///
    /// # Errors
    /// When a part refuses what another said, or the vehicle's state would blow up.
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

    /// As [`Loop::tick`], without the messages that nobody in the loop reads.
    ///
    /// # Errors
    /// Those of [`Loop::tick`].
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

    /// The state at the present tick.
    #[must_use]
    pub fn state(&self) -> VehicleState {
        self.plant.state(self.stamp())
    }

    /// The present tick's.
    fn stamp(&self) -> Time {
        Time::from_nanos(self.k * self.tick_nanos)
    }

    /// Everybody's answers to the present tick's state, on which the vehicle moves on.
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
