//! The actuator's parameters: the only place with their defaults and ranges, except `first_order.*` (`Lag`).
//!
//! The actuator's constants are in its file ([`crate::actuator_file`]); the parameters select the file and contain the values that can
//! change at run time.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use planesman_parameters::{Choice, Parameters};

use crate::actuator_model::Model;
use crate::condition::{Condition, Encoder, StuckValve};
use crate::first_order::Lag;
use crate::groups::{Group, Grouping};
use crate::pulse_logic::{DriftOption, Options, SignChange};

/// Every parameter of `dha_actuator`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ActuatorParameters {
    /// Actuator constants: a built-in actuator (auv, auv_two_speed, table_3_1 or table_4_1 of IBM 66-L03-005, or another; a wrong name lists all), a
    /// circuit of on/off valves (dfcu), or the path of an actuator or circuit file; ideal or first_order select that `model`.
    #[parameter(default = "auv", read_only)]
    pub actuator: String,
    /// Actuator model: dha (digital hydraulic actuator), first_order (lag with rate limit) or ideal (no delay).
    #[parameter(default = Model::Dha, read_only)]
    pub model: Model,
    /// Grouping of the planes. together: one ram moves bow and stern planes, differential and rudder are ideal.
    /// each: bow, stern, roll differential and rudder have one actuator each.
    #[parameter(default = Grouping::Together, read_only)]
    pub groups: Grouping,
    /// `bow.*`.
    pub bow: GroupParameters,
    /// `stern.*`.
    pub stern: GroupParameters,
    /// `roll.*`.
    pub roll: GroupParameters,
    /// `rudder.*`.
    pub rudder: GroupParameters,
    /// `first_order.*`.
    pub first_order: Lag,
    /// Whether the measured plane angle is fed back (the report's analog mode). false: pulses are counted only,
    /// and leakage becomes an angle error.
    #[parameter(default = true)]
    pub position_loop: bool,
    /// `logic.*`.
    pub logic: Logic,
    /// Limit of the plane command to either side, 30 degrees (Brunner 1988, ch. III).
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub command_limit: f64,
    /// Time without a plane command after which the planes are commanded to neutral.
    #[parameter(default = 0.5, unit = "s", range = 0.0..=60.0)]
    pub command_timeout: f64,
    /// Largest interval between samples in plane_motion; a tick is divided evenly.
    #[parameter(default = 0.001, unit = "s", range = 1e-4..=1.0)]
    pub sample_interval: f64,
    /// Sampling time of the loop: each command is answered with the motion over one tick.
    #[parameter(default = 0.05, unit = "s", range = 1e-4..=10.0, read_only)]
    pub tick: f64,
    /// Whether every tick waits for its command, so that no answer is given without one.
    #[parameter(default = false, read_only)]
    pub lockstep: bool,
    /// Run as a managed node (`ros2 lifecycle`), which commands only while it is active.
    #[parameter(default = false, read_only)]
    pub managed: bool,
    /// `leakage.*`.
    pub leakage: Leakage,
    /// `friction.*`.
    pub friction: Friction,
    /// `fault.*`.
    pub fault: Fault,
    /// Prefix of the frames in its messages' headers, to distinguish vehicles: 'auv2/'; the same as plant_sim's.
    #[parameter(default = "", read_only)]
    pub frame_prefix: String,
}

/// The parameters of one group of planes with its own actuator, `bow.*` and so on.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct GroupParameters {
    /// With groups: each, this group's actuator, ideal or first_order; same: as `actuator`.
    #[parameter(default = "same", read_only)]
    pub actuator: String,
    /// Actuator model of this group, with groups each; same: as `model`.
    #[parameter(default = GroupModel::Same, read_only)]
    pub model: GroupModel,
}

/// The parameters `logic.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Logic {
    /// Pulse logic (IBM 66-L03-005, II.B.1): single_speed (one volume), two_speed (a large and a small one, if
    /// the actuator has both), precision (the direction valve steers the drift between volumes) or
    /// two_speed_precision.
    #[parameter(default = LogicMode::SingleSpeed)]
    pub mode: LogicMode,
    /// Sign that steers the drift in precision logic while no volume is due: 1 of the change of command, 2 of the
    /// error, 3 of the last command.
    #[parameter(default = 2, range = 1..=3)]
    pub drift_option: i64,
    /// delta_n: angle counted in a cycle without a volume, with the sign of the error; without position loop.
    #[parameter(default = 0.0, unit = "rad", range = -0.1..=0.1)]
    pub error_feedback: f64,
    /// delta_p: angle counted in a cycle without a volume, with the sign of the sign pulse; without position
    /// loop. K_L T compensates the drift.
    #[parameter(default = 0.0, unit = "rad", range = -0.1..=0.1)]
    pub sign_feedback: f64,
    /// Effect of a volume commanded together with a change of direction: moved when the direction valve switches,
    /// or dropped; the report's II.A.1 allows both.
    #[parameter(default = SignChange::MovesVolume)]
    pub sign_change: SignChange,
}

/// The parameters `leakage.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Leakage {
    /// Factor on both leakages of the actuator file, q_L and q_LC; 0: no leakage.
    #[parameter(default = 1.0, range = 0.0..=100.0)]
    pub scale: f64,
}

/// The parameters `friction.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Friction {
    /// Excess of static friction over Delta F, as a share: 0.05 gives the 'stepping' of the report's latch (III), 0 gives pure Coulomb friction.
    #[parameter(default = 0.0, range = 0.0..=1.0)]
    pub stepping: f64,
}

/// The parameters `fault.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Fault {
    /// Group whose actuator has the faults below.
    #[parameter(default = FaultyGroup::All)]
    pub group: FaultyGroup,
    /// Increased leakage: factor on q_L and q_LC, in addition to leakage.scale.
    #[parameter(default = 1.0, range = 1.0..=100.0)]
    pub leakage: f64,
    /// Short volume: missing share of each calibrated volume.
    #[parameter(default = 0.0, range = 0.0..=0.95)]
    pub short_volume: f64,
    /// Low supply pressure: missing share of P_h, which also lowers clamp forces and leakage.
    #[parameter(default = 0.0, range = 0.0..=0.95)]
    pub lost_supply: f64,
    /// Air in the oil: missing share of beta/V.
    #[parameter(default = 0.0, range = 0.0..=0.99)]
    pub air: f64,
    /// Slow latch: additional time of every second stroke of the actuating valve, beyond T_v.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=0.02)]
    pub slow_latch: f64,
    /// Stuck valve: the actuating valve of the large volume, or the direction valve.
    #[parameter(default = FaultyValve::None)]
    pub stuck_valve: FaultyValve,
    /// State of the ram's position feedback: sound, lost and detected (the actuator counts its volumes and
    /// drifts), or frozen and undetected.
    #[parameter(default = Encoder::Sound)]
    pub encoder: Encoder,
}

/// The actuator model of a group of planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum GroupModel {
    /// The node's `model`.
    Same,
    /// The digital hydraulic actuator.
    Dha,
    /// A first-order lag.
    FirstOrder,
    /// Planes that follow their command at once.
    Ideal,
}

/// The pulse logic (IBM 66-L03-005, II.B.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum LogicMode {
    /// One volume.
    SingleSpeed,
    /// A large and a small volume.
    TwoSpeed,
    /// The direction valve steers the drift between two volumes.
    Precision,
    /// Two volumes, and the drift steered.
    TwoSpeedPrecision,
}

/// Group whose actuator has the faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum FaultyGroup {
    /// Every group.
    All,
    /// Bow and stern planes together.
    DivePlanes,
    /// The bow planes.
    Bow,
    /// The stern planes.
    Stern,
    /// The roll differential.
    Roll,
    /// The rudder.
    Rudder,
}

/// The stuck valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum FaultyValve {
    /// None.
    None,
    /// The large volume's actuating valve.
    Actuating,
    /// The direction valve.
    Direction,
}

/// A group's actuator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    /// The planes that the actuator moves.
    pub group: Group,
    /// Name of a built-in actuator, or a path.
    pub actuator: String,
    /// The actuator model.
    pub model: Model,
}

/// Faults, and the group that has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Faults {
    /// Group with the faults; `None` for all.
    pub group: Option<Group>,
    /// Wear and faults together.
    pub condition: Condition,
}

/// The parameters, with derived quantities.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Config {
    /// The parameters.
    pub parameters: ActuatorParameters,
    /// The actuators, in the order of [`Grouping::groups`].
    pub members: Vec<Member>,
    /// The pulse logic's options.
    pub logic: Options,
    /// The lifetime of a command, ns.
    pub command_timeout: i64,
    /// Longest time between two motion samples, ns.
    pub sample_interval: i64,
    /// Condition of every actuator without faults.
    pub worn: Condition,
    /// The faults.
    pub faults: Faults,
}

impl Config {
    /// Converts the parameters to the models' types.
    #[must_use]
    pub(crate) fn new(parameters: &ActuatorParameters) -> Self {
        let nanos = |seconds: f64| (seconds * 1e9).round() as i64;
        let worn = Condition {
            leakage_scale: parameters.leakage.scale,
            stepping: parameters.friction.stepping,
            ..Condition::SOUND
        };
        Self {
            parameters: parameters.clone(),
            members: (parameters.groups)
                .groups()
                .iter()
                .map(|group| member(parameters, *group))
                .collect(),
            logic: logic(&parameters.logic),
            command_timeout: nanos(parameters.command_timeout),
            sample_interval: nanos(parameters.sample_interval),
            worn,
            faults: faults(&parameters.fault, worn),
        }
    }

    /// Condition of a group's actuator.
    #[must_use]
    pub(crate) fn condition(&self, group: Group) -> Condition {
        if self.faults.group.is_none_or(|only| only == group) {
            self.faults.condition
        } else {
            self.worn
        }
    }

    /// Faults of an actuator as texts; empty for a sound actuator or one without oil.
    #[must_use]
    pub(crate) fn fault_texts(&self, member: &Member) -> Vec<String> {
        match member.model {
            Model::Dha => self.condition(member.group).faults_beside(&self.worn),
            Model::FirstOrder | Model::Ideal => Vec::new(),
        }
    }
}

impl ActuatorParameters {
    /// Model of the actuator that moves the dive planes, or the bow planes with `groups: each`.
    #[must_use]
    pub fn dive_planes_model(&self) -> Model {
        let groups = self.groups.groups();
        member(self, groups[0]).model
    }

    /// Whether any group has a hydraulic actuator, digital or a circuit.
    #[must_use]
    pub fn is_hydraulic(&self) -> bool {
        let mut groups = self.groups.groups().iter();
        groups.any(|group| member(self, *group).model == Model::Dha)
    }
}

/// Actuator of a group: the group's own, or the node's.
fn member(parameters: &ActuatorParameters, group: Group) -> Member {
    let own = match group {
        Group::DivePlanes => None,
        Group::Bow => Some(&parameters.bow),
        Group::Stern => Some(&parameters.stern),
        Group::Roll => Some(&parameters.roll),
        Group::Rudder => Some(&parameters.rudder),
    };
    let actuator = match own {
        Some(own) if own.actuator != "same" => &own.actuator,
        _ => &parameters.actuator,
    };
    // A model's name means that model wherever an actuator is named; it has no constants of its own.
    let (actuator, model_named) = match Model::named(actuator) {
        Some(model) => (ActuatorParameters::default().actuator, model),
        None => (actuator.clone(), parameters.model),
    };
    let model = match own.map_or(GroupModel::Same, |own| own.model) {
        GroupModel::Same => model_named,
        GroupModel::Dha => Model::Dha,
        GroupModel::FirstOrder => Model::FirstOrder,
        GroupModel::Ideal => Model::Ideal,
    };
    Member {
        group,
        actuator,
        model,
    }
}

/// Adds the faults to the wear.
fn faults(fault: &Fault, worn: Condition) -> Faults {
    Faults {
        group: match fault.group {
            FaultyGroup::All => None,
            FaultyGroup::DivePlanes => Some(Group::DivePlanes),
            FaultyGroup::Bow => Some(Group::Bow),
            FaultyGroup::Stern => Some(Group::Stern),
            FaultyGroup::Roll => Some(Group::Roll),
            FaultyGroup::Rudder => Some(Group::Rudder),
        },
        condition: Condition {
            leakage_scale: worn.leakage_scale * fault.leakage,
            short_volume: fault.short_volume,
            lost_supply: fault.lost_supply,
            air: fault.air,
            slow_latch: fault.slow_latch,
            stuck: match fault.stuck_valve {
                FaultyValve::None => None,
                FaultyValve::Actuating => Some(StuckValve::Actuating),
                FaultyValve::Direction => Some(StuckValve::Direction),
            },
            encoder: fault.encoder,
            ..worn
        },
    }
}

/// The pulse logic's options.
fn logic(logic: &Logic) -> Options {
    let precision_drift = match logic.drift_option {
        1 => DriftOption::Input,
        2 => DriftOption::Error,
        _ => DriftOption::LastCommand,
    };
    let (two_speed, drift) = match logic.mode {
        LogicMode::SingleSpeed => (false, DriftOption::LastCommand),
        LogicMode::TwoSpeed => (true, DriftOption::LastCommand),
        LogicMode::Precision => (false, precision_drift),
        LogicMode::TwoSpeedPrecision => (true, precision_drift),
    };
    Options {
        two_speed,
        drift,
        error_feedback: logic.error_feedback,
        sign_feedback: logic.sign_feedback,
        sign_change: logic.sign_change,
    }
}
