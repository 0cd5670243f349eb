//! The parts of the loop as traits: a plant, a law, an actuator or an estimator of one's own flies in it.
//!
//! ```text
//! Plant -> state, instruments -> Law -> plane command -> Actuator -> plane motion -> Plant
//!                                          state, plane motion -> Estimator -> models -> Law
//! ```
//! [`Parts`] makes them for a scenario: the built-in ones, but for those that are replaced.

use std::fmt;
use std::sync::Arc;

pub use crate::error::PartError;
use crate::error::{Error, Result, refused};
use planesman_control::Controller;
use planesman_hydraulics::{Actuator as Hydraulic, Energy, Group, Output};
use planesman_identifier::{DueEstimate, Identifier};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, MotionEstimate, PlaneCommand, PlaneMotion,
    ThrusterCommand, VehicleState,
};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_plant::{Instruments, Plant as Simulated, Pose, StaticMessages};

use crate::scenario::Scenario;

/// A plant at one stamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The truth.
    pub state: VehicleState,
    /// What the instruments read.
    pub instruments: Option<Instruments>,
    /// The truth in ROS frames.
    pub pose: Option<Pose>,
}

/// The vehicle and its instruments.
pub trait Plant: Send {
    /// The state at the present tick, which falls on `stamp`. Depth and distance \[m\], angles \[rad\], depth positive down.
    fn state(&self, stamp: Time) -> VehicleState;

    /// Moves on by one tick along `motion`.
    ///
    /// # Errors
    /// A motion that it refuses, or a state that would not be finite.
    fn advance(&mut self, motion: &PlaneMotion) -> Result<(), PartError>;

    /// What the instruments read at the present tick; a plant without them has none.
    fn instruments(&mut self, _stamp: Time) -> Option<Instruments> {
        None
    }

    /// Everything there is to publish of the present tick.
    fn observe(&mut self, stamp: Time) -> Observation {
        Observation {
            state: self.state(stamp.clone()),
            instruments: self.instruments(stamp),
            pose: None,
        }
    }

    /// What holds for the whole flight.
    fn static_messages(&self) -> Option<StaticMessages> {
        None
    }

    /// Takes the thrusters' commands, from the present tick on.
    ///
    /// # Errors
    /// Commands that it refuses.
    fn set_thrusters(&mut self, _command: &ThrusterCommand) -> Result<(), PartError> {
        Ok(())
    }
}

/// A control law: the vehicle's state in, a plane command out.
pub trait Law: Send {
    /// The command that answers `state`, of the same stamp, and what led to it.
    ///
    /// # Errors
    /// A state that it refuses.
    fn on_state(&mut self, state: &VehicleState)
    -> Result<(PlaneCommand, ControlState), PartError>;

    /// Whether it uses the instruments; they are read then, before each state.
    fn reads_instruments(&self) -> bool {
        false
    }

    /// Takes the instruments' readings, before the state of their stamp.
    fn on_instruments(&mut self, _instruments: &Instruments) {}

    /// Whether it uses identified models.
    fn reads_models(&self) -> bool {
        false
    }

    /// Takes an identified model.
    fn on_model(&mut self, _model: ModelEstimate) {}

    /// The motion that it has estimated for its last answer.
    fn estimate(&self) -> Option<&MotionEstimate> {
        None
    }

    /// What it asks of the thrusters with its last answer.
    fn thrusters(&self) -> Option<&ThrusterCommand> {
        None
    }
}

/// The answer of a law that holds a depth by the dive planes alone: `dive_planes` \[rad\], positive dive, `depth_setpoint` \[m\].
#[must_use]
pub fn dive(
    state: &VehicleState,
    dive_planes: f64,
    depth_setpoint: f64,
) -> (PlaneCommand, ControlState) {
    let header = state.header.clone();
    let command = PlaneCommand {
        header: header.clone(),
        dive_planes,
        ..PlaneCommand::default()
    };
    let control = ControlState {
        header,
        mode: ControlState::MODE_DEPTH,
        depth_target: depth_setpoint,
        depth_setpoint,
        depth_error: depth_setpoint - state.depth,
        depth_rate: state.depth_rate,
        dive_planes,
        ..ControlState::default()
    };
    (command, control)
}

/// What moves the planes.
pub trait Actuator: Send {
    /// The motion over the tick that begins at the command's stamp.
    ///
    /// # Errors
    /// A command that it refuses.
    fn on_command(&mut self, command: &PlaneCommand) -> Result<Arc<dyn Motion>, PartError>;

    /// The groups of planes whose states [`Motion::states`] are.
    fn groups(&self) -> &'static [Group] {
        &[]
    }
}

/// The planes over a tick.
pub trait Motion: fmt::Debug + Send + Sync {
    /// The plane angles over the tick \[rad\].
    fn motion(&self) -> &PlaneMotion;

    /// Planes and rams by name, at the stamp.
    fn planes(&self) -> Option<JointState> {
        None
    }

    /// The state of the actuator of each group.
    fn states(&self) -> Vec<DhaState> {
        Vec::new()
    }

    /// The mean hydraulic power over the tick \[W\].
    fn hydraulic_power(&self) -> f64 {
        0.0
    }

    /// Calibrated volumes commanded since the start.
    fn pulses(&self) -> u64 {
        0
    }

    /// The energies of all actuators since the start.
    fn energy(&self) -> Option<Energy> {
        None
    }
}

/// What identifies the vehicle while it flies.
pub trait Estimator: Send {
    /// Takes a state and the motion that answers it; the estimates that are due then.
    ///
    /// # Errors
    /// A signal that it cannot read.
    fn learn(
        &mut self,
        state: &VehicleState,
        motion: &PlaneMotion,
    ) -> Result<Vec<Model>, PartError>;
}

/// An identified model, made where somebody reads it.
#[derive(Clone, Debug)]
pub enum Model {
    /// One of [`Identifier`].
    Due(Box<DueEstimate>),
    /// One at hand.
    Made(Box<ModelEstimate>),
}

impl Model {
    /// The name of its pair of signals.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Due(due) => due.name(),
            Self::Made(model) => &model.name,
        }
    }

    /// The model; `None` where a number of it is not finite.
    #[must_use]
    pub fn estimate(&self) -> Option<ModelEstimate> {
        match self {
            Self::Due(due) => due.estimate(),
            Self::Made(model) => {
                let finite = planesman_msgs::Message::first_non_finite(&**model).is_none();
                finite.then(|| (**model).clone())
            }
        }
    }
}

impl Plant for Simulated {
    fn state(&self, stamp: Time) -> VehicleState {
        Self::state(self, stamp)
    }

    fn advance(&mut self, motion: &PlaneMotion) -> Result<(), PartError> {
        Ok(Self::advance(self, Some(motion))?)
    }

    fn instruments(&mut self, stamp: Time) -> Option<Instruments> {
        Some(Self::instruments(self, stamp))
    }

    fn observe(&mut self, stamp: Time) -> Observation {
        let all = Self::observe(self, stamp);
        Observation {
            state: all.state,
            instruments: Some(all.instruments),
            pose: Some(all.pose),
        }
    }

    fn static_messages(&self) -> Option<StaticMessages> {
        Some(Self::static_messages(self))
    }

    fn set_thrusters(&mut self, command: &ThrusterCommand) -> Result<(), PartError> {
        Ok(Self::set_thrusters(self, command)?)
    }
}

impl Law for Controller {
    fn on_state(
        &mut self,
        state: &VehicleState,
    ) -> Result<(PlaneCommand, ControlState), PartError> {
        Ok(Self::on_state(self, state)?)
    }

    fn reads_instruments(&self) -> bool {
        Self::reads_instruments(self)
    }

    fn on_instruments(&mut self, instruments: &Instruments) {
        self.on_imu(&instruments.imu);
        self.on_depth_pressure(&instruments.depth_pressure);
        self.on_speed_pressure(&instruments.speed_pressure);
    }

    fn reads_models(&self) -> bool {
        Self::reads_models(self)
    }

    fn on_model(&mut self, model: ModelEstimate) {
        Self::on_model(self, model);
    }

    fn estimate(&self) -> Option<&MotionEstimate> {
        Self::estimate(self)
    }

    fn thrusters(&self) -> Option<&ThrusterCommand> {
        Self::thrusters(self)
    }
}

impl Actuator for Hydraulic {
    fn on_command(&mut self, command: &PlaneCommand) -> Result<Arc<dyn Motion>, PartError> {
        Ok(Self::on_command(self, command)?)
    }

    fn groups(&self) -> &'static [Group] {
        Self::groups(self)
    }
}

impl Motion for Output {
    fn motion(&self) -> &PlaneMotion {
        &self.motion
    }

    fn planes(&self) -> Option<JointState> {
        Some(Self::planes(self))
    }

    fn states(&self) -> Vec<DhaState> {
        Self::states(self)
    }

    fn hydraulic_power(&self) -> f64 {
        Self::hydraulic_power(self)
    }

    fn pulses(&self) -> u64 {
        Self::pulses(self)
    }

    fn energy(&self) -> Option<Energy> {
        Self::energy(self)
    }
}

impl Motion for PlaneMotion {
    fn motion(&self) -> &PlaneMotion {
        self
    }
}

impl Estimator for Identifier {
    fn learn(
        &mut self,
        state: &VehicleState,
        motion: &PlaneMotion,
    ) -> Result<Vec<Model>, PartError> {
        let stamp = &state.header.stamp;
        let mut due = Self::learn(self, "state", stamp.clone(), state)?;
        due.extend(Self::learn(self, "plane_motion", stamp.clone(), motion)?);
        Ok(due.into_iter().map(|it| Model::Due(Box::new(it))).collect())
    }
}

/// Makes a part for a scenario.
type Make<T> = Arc<dyn Fn(&Scenario) -> Result<Box<T>> + Send + Sync>;

/// The parts of a loop: those that the scenario's parameters describe, but for those that are replaced.
#[derive(Clone)]
pub struct Parts {
    plant: Make<dyn Plant>,
    law: Make<dyn Law>,
    actuator: Make<dyn Actuator>,
    estimator: Make<dyn Estimator>,
}

impl fmt::Debug for Parts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Parts")
    }
}

/// A refusal, with the node's name.
fn refused_by<E: fmt::Display>(node: &'static str) -> impl Fn(E) -> Error {
    move |e| refused!("node {node}: {e}")
}

/// What a part or its maker refuses, with the name of the node in whose place it is.
pub(crate) fn in_place_of<R: Into<PartError>>(node: &'static str) -> impl Fn(R) -> Error {
    move |reason| Error::Part {
        node,
        reason: reason.into(),
    }
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            plant: Arc::new(|scenario| {
                let parameters = scenario.parameters_of("plant_sim")?;
                Ok(Box::new(
                    Simulated::new(&parameters).map_err(refused_by("plant_sim"))?,
                ))
            }),
            law: Arc::new(|scenario| {
                let parameters = scenario.parameters_of("depth_controller")?;
                Ok(Box::new(
                    Controller::new(&parameters).map_err(refused_by("depth_controller"))?,
                ))
            }),
            actuator: Arc::new(|scenario| {
                let parameters = scenario.parameters_of("dha_actuator")?;
                Ok(Box::new(
                    Hydraulic::new(&parameters, scenario.tick_nanos())
                        .map_err(refused_by("dha_actuator"))?,
                ))
            }),
            estimator: Arc::new(|scenario| {
                let parameters = scenario.parameters_of("sysid")?;
                Ok(Box::new(
                    Identifier::new(&parameters).map_err(refused_by("sysid"))?,
                ))
            }),
        }
    }
}

impl Parts {
    /// The same with another plant, made anew for each flight.
    #[must_use]
    pub fn with_plant<P: Plant + 'static, R: Into<PartError>>(
        self,
        make: impl Fn(&Scenario) -> Result<P, R> + Send + Sync + 'static,
    ) -> Self {
        let plant: Make<dyn Plant> = Arc::new(move |it| {
            let made = make(it).map_err(in_place_of("plant_sim"))?;
            Ok(Box::new(made))
        });
        Self { plant, ..self }
    }

    /// The same with another law, made anew for each flight.
    #[must_use]
    pub fn with_law<L: Law + 'static, R: Into<PartError>>(
        self,
        make: impl Fn(&Scenario) -> Result<L, R> + Send + Sync + 'static,
    ) -> Self {
        let law: Make<dyn Law> = Arc::new(move |it| {
            let made = make(it).map_err(in_place_of("depth_controller"))?;
            Ok(Box::new(made))
        });
        Self { law, ..self }
    }

    /// The same with another actuator, made anew for each flight.
    #[must_use]
    pub fn with_actuator<A: Actuator + 'static, R: Into<PartError>>(
        self,
        make: impl Fn(&Scenario) -> Result<A, R> + Send + Sync + 'static,
    ) -> Self {
        let actuator: Make<dyn Actuator> = Arc::new(move |it| {
            let made = make(it).map_err(in_place_of("dha_actuator"))?;
            Ok(Box::new(made))
        });
        Self { actuator, ..self }
    }

    /// The same with another estimator, made anew for each flight.
    #[must_use]
    pub fn with_estimator<E: Estimator + 'static, R: Into<PartError>>(
        self,
        make: impl Fn(&Scenario) -> Result<E, R> + Send + Sync + 'static,
    ) -> Self {
        let estimator: Make<dyn Estimator> = Arc::new(move |it| {
            let made = make(it).map_err(in_place_of("sysid"))?;
            Ok(Box::new(made))
        });
        Self { estimator, ..self }
    }

    pub(crate) fn plant(&self, scenario: &Scenario) -> Result<Box<dyn Plant>> {
        (self.plant)(scenario)
    }

    pub(crate) fn law(&self, scenario: &Scenario) -> Result<Box<dyn Law>> {
        (self.law)(scenario)
    }

    pub(crate) fn actuator(&self, scenario: &Scenario) -> Result<Box<dyn Actuator>> {
        (self.actuator)(scenario)
    }

    pub(crate) fn estimator(&self, scenario: &Scenario) -> Result<Box<dyn Estimator>> {
        (self.estimator)(scenario)
    }
}
