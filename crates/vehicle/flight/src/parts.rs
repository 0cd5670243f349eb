//! The parts of the loop as traits: implement a plant, law, actuator or estimator of your own.
//!
//! ```text
//! Plant -> state, instruments -> Law -> plane command -> Actuator -> plane motion -> Plant
//!                                          state, plane motion -> Estimator -> models -> Law
//! ```
//! [`Parts`] creates them for a scenario: the built-in parts, except those you replace.

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
    /// Readings of the instruments.
    pub instruments: Option<Instruments>,
    /// True pose in ROS frames.
    pub pose: Option<Pose>,
}

/// The vehicle and its instruments.
pub trait Plant: Send {
    /// State at the present tick, whose time is `stamp`. Depth and distance \[m\], angles \[rad\], depth positive down.
    fn state(&self, stamp: Time) -> VehicleState;

    /// Advances by one tick along `motion`.
    ///
    /// # Errors
    /// If the motion is refused, or the state would not be finite.
    fn advance(&mut self, motion: &PlaneMotion) -> Result<(), PartError>;

    /// Readings of the instruments at the present tick; `None` for a plant without instruments.
    fn instruments(&mut self, _stamp: Time) -> Option<Instruments> {
        None
    }

    /// Everything that the plant publishes at the present tick.
    fn observe(&mut self, stamp: Time) -> Observation {
        Observation {
            state: self.state(stamp.clone()),
            instruments: self.instruments(stamp),
            pose: None,
        }
    }

    /// Messages that are constant for the whole flight.
    fn static_messages(&self) -> Option<StaticMessages> {
        None
    }

    /// Sets the thrusters' commands from the present tick on.
    ///
    /// # Errors
    /// If the commands are refused.
    fn set_thrusters(&mut self, _command: &ThrusterCommand) -> Result<(), PartError> {
        Ok(())
    }
}

/// A control law: vehicle state in, plane command out.
pub trait Law: Send {
    /// Returns the command that answers `state`, with the same stamp, and the controller's state.
    ///
    /// # Errors
    /// If the state is refused.
    fn on_state(&mut self, state: &VehicleState)
    -> Result<(PlaneCommand, ControlState), PartError>;

    /// Whether the controller uses the instruments; they are then read before each state.
    fn reads_instruments(&self) -> bool {
        false
    }

    /// Receives the instruments' readings, before the state of the same stamp.
    fn on_instruments(&mut self, _instruments: &Instruments) {}

    /// Whether the controller uses identified models.
    fn reads_models(&self) -> bool {
        false
    }

    /// Receives an identified model.
    fn on_model(&mut self, _model: ModelEstimate) {}

    /// Estimated motion of its last answer.
    fn estimate(&self) -> Option<&MotionEstimate> {
        None
    }

    /// Thruster commands of its last answer.
    fn thrusters(&self) -> Option<&ThrusterCommand> {
        None
    }
}

/// Answer of a law that holds a depth with the dive planes only: `dive_planes` \[rad\], positive dive, `depth_setpoint` \[m\].
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

/// The planes' actuator.
pub trait Actuator: Send {
    /// Returns the motion over the tick that begins at the command's stamp.
    ///
    /// # Errors
    /// If the command is refused.
    fn on_command(&mut self, command: &PlaneCommand) -> Result<Arc<dyn Motion>, PartError>;

    /// Groups of planes whose states [`Motion::states`] returns.
    fn groups(&self) -> &'static [Group] {
        &[]
    }
}

/// Motion of the planes over a tick.
pub trait Motion: fmt::Debug + Send + Sync {
    /// Plane angles over the tick \[rad\].
    fn motion(&self) -> &PlaneMotion;

    /// Planes and rams by name, at the stamp.
    fn planes(&self) -> Option<JointState> {
        None
    }

    /// State of each group's actuator.
    fn states(&self) -> Vec<DhaState> {
        Vec::new()
    }

    /// Mean hydraulic power over the tick \[W\].
    fn hydraulic_power(&self) -> f64 {
        0.0
    }

    /// Commanded calibrated volumes since the start.
    fn pulses(&self) -> u64 {
        0
    }

    /// Energies of all actuators since the start.
    fn energy(&self) -> Option<Energy> {
        None
    }
}

/// Identifies the vehicle during the flight.
pub trait Estimator: Send {
    /// Receives a state and the motion that answers it; returns the estimates that are due.
    ///
    /// # Errors
    /// If it cannot read a signal.
    fn learn(
        &mut self,
        state: &VehicleState,
        motion: &PlaneMotion,
    ) -> Result<Vec<Model>, PartError>;
}

/// An identified model, which is computed only when it is read.
#[derive(Clone, Debug)]
pub enum Model {
    /// An estimate of [`Identifier`] that is still to be computed.
    Due(Box<DueEstimate>),
    /// A computed model.
    Made(Box<ModelEstimate>),
}

impl Model {
    /// Name of its pair of signals.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Due(due) => due.name(),
            Self::Made(model) => &model.name,
        }
    }

    /// The model; `None` if one of its numbers is not finite.
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

/// Creates a part for a scenario.
type Make<T> = Arc<dyn Fn(&Scenario) -> Result<Box<T>> + Send + Sync>;

/// The parts of a loop: those that the scenario's parameters describe, unless they are replaced.
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

/// Converts a refusal, with the node's name.
fn refused_by<E: fmt::Display>(node: &'static str) -> impl Fn(E) -> Error {
    move |e| refused!("node {node}: {e}")
}

/// Converts the refusal of a part or its constructor, with the name of the node it replaces.
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
    /// Replaces the plant; `make` is called for each flight.
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

    /// Replaces the law; `make` is called for each flight.
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

    /// Replaces the actuator; `make` is called for each flight.
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

    /// Replaces the estimator; `make` is called for each flight.
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
