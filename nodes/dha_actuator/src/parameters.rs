//! The actuator's parameters: the only place where its defaults and ranges stand.
//!
//! What the actuator is made of stands in its file ([`crate::actuator_file`]); here is which
//! file, and what a user changes while it runs.

use planesman_parameters::{Declaration, Values};

use crate::actuator_model::Model;
use crate::condition::{Condition, Encoder, StuckValve};
use crate::first_order::Lag;
use crate::groups::{Group, Grouping};
use crate::pulse_logic::{DriftOption, Options, SignChange};

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};
    vec![
        Declaration::new(
            "actuator",
            "auv",
            "The actuator's constants: auv, auv_two_speed, table_3_1, table_4_1 (IBM 66-L03-005), or the path of an actuator file.",
        )
        .read_only(),
        Declaration::new(
            "model",
            "dha",
            "dha: the digital hydraulic actuator; first_order: a lag with a rate limit; ideal: planes that follow their command at once.",
        )
        .choices(&["dha", "first_order", "ideal"])
        .read_only(),
        Declaration::new(
            "groups",
            "together",
            "together: one ram moves bow and stern planes, and differentials and rudder pass through; each: bow, stern, roll differential and rudder have an actuator each.",
        )
        .choices(&["together", "each"])
        .read_only(),
        group_actuator("bow.actuator"),
        group_model("bow.model"),
        group_actuator("stern.actuator"),
        group_model("stern.model"),
        group_actuator("roll.actuator"),
        group_model("roll.model"),
        group_actuator("rudder.actuator"),
        group_model("rudder.model"),
        Declaration::new(
            "first_order.omega",
            67.8,
            "Model first_order: its bandwidth; as late as a volume of the actuator auv, T_v + T_f/2 + T/2 = 14.75 ms.",
        )
        .unit("rad/s")
        .range(0.01, 1000.0),
        Declaration::new(
            "first_order.rate",
            0.698_131_700_797_731_8,
            "Model first_order: its largest plane rate; the slew rate of the actuator auv, 40 degrees a second.",
        )
        .unit("rad/s")
        .range(1e-4, 100.0),
        Declaration::new(
            "position_loop",
            true,
            "Feed the measured plane angle back (the report's analog mode). Off: pulses are counted only, and leakage becomes an angle error.",
        ),
        Declaration::new(
            "logic.mode",
            "single_speed",
            "The pulse logic (IBM 66-L03-005, II.B.1): one volume; a large and a small one, of an actuator that has both; precision: the direction valve steers the drift between two volumes; or both.",
        )
        .choices(&["single_speed", "two_speed", "precision", "two_speed_precision"]),
        Declaration::new(
            "logic.drift_option",
            2,
            "What steers the drift in precision logic while no volume is due: 1 the sign of the change asked for, 2 of the error, 3 the last command.",
        )
        .range(1.0, 3.0),
        Declaration::new(
            "logic.error_feedback",
            0.0,
            "delta_n: angle booked in a cycle without a volume, with the error's sign (without position loop).",
        )
        .unit("rad")
        .range(-0.1, 0.1),
        Declaration::new(
            "logic.sign_feedback",
            0.0,
            "delta_p: angle booked in a cycle without a volume, with the sign pulse's sign (without position loop); K_L T books the drift.",
        )
        .unit("rad")
        .range(-0.1, 0.1),
        Declaration::new(
            "logic.sign_change",
            "moves_volume",
            "A volume commanded with a change of direction: it moves with the sign valve's switching, or is dropped, as the report's II.A.1 can be read.",
        )
        .choices(&["moves_volume", "drops_volume"]),
        Declaration::new(
            "command_limit",
            FRAC_PI_6,
            "Largest plane angle asked for to either side, 30 degrees (Brunner 1988, ch. III).",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "command_timeout",
            0.5,
            "After this time without a plane command, neutral planes are asked for.",
        )
        .unit("s")
        .range(0.0, 60.0),
        Declaration::new(
            "sample_interval",
            0.001,
            "Longest time between two samples of plane_motion; a tick is divided evenly.",
        )
        .unit("s")
        .range(1e-4, 1.0),
        Declaration::new(
            "tick",
            0.05,
            "The loop's sampling time: each command is answered with the motion over one tick.",
        )
        .unit("s")
        .range(1e-4, 10.0)
        .read_only(),
        Declaration::new(
            "lockstep",
            false,
            "Every tick gets its command, however long it takes: no answer is given in silence.",
        )
        .read_only(),
        Declaration::new(
            "leakage.scale",
            1.0,
            "Factor on both leakages of the actuator file, q_L and q_LC: 0 is a tight actuator.",
        )
        .range(0.0, 100.0),
        Declaration::new(
            "friction.stepping",
            0.0,
            "Share by which the friction at rest exceeds Delta F: 0.05 gives the 'stepping' of the report's own latch (III), 0 exact Coulomb friction.",
        )
        .range(0.0, 1.0),
        Declaration::new(
            "fault.group",
            "all",
            "Which group's actuator the faults below befall.",
        )
        .choices(&["all", "dive_planes", "bow", "stern", "roll", "rudder"]),
        Declaration::new(
            "fault.leakage",
            1.0,
            "Leakage grown: a factor on q_L and q_LC, beside leakage.scale.",
        )
        .range(1.0, 100.0),
        Declaration::new(
            "fault.short_volume",
            0.0,
            "Volume short: the share of each calibrated volume that does not arrive.",
        )
        .range(0.0, 0.95),
        Declaration::new(
            "fault.lost_supply",
            0.0,
            "Supply pressure low: the share of P_h that is missing; the clamps and the leakage follow.",
        )
        .range(0.0, 0.95),
        Declaration::new(
            "fault.air",
            0.0,
            "Oil with air: the share of beta/V that is missing.",
        )
        .range(0.0, 0.99),
        Declaration::new(
            "fault.slow_latch",
            0.0,
            "One latch slow: what every second stroke of the actuating valve needs beside T_v.",
        )
        .unit("s")
        .range(0.0, 0.02),
        Declaration::new(
            "fault.stuck_valve",
            "none",
            "A valve that switches no more: the large volume's actuating valve, or the direction valve.",
        )
        .choices(&["none", "actuating", "direction"]),
        Declaration::new(
            "fault.encoder",
            "sound",
            "The ram's position feedback: lost, known to be so (the actuator counts its volumes and drifts), or frozen, and believed.",
        )
        .choices(&["sound", "lost", "frozen"]),
    ]
}

fn group_actuator(name: &'static str) -> Declaration {
    Declaration::new(
        name,
        "same",
        "With groups: each, this group's actuator; same: as `actuator`.",
    )
    .read_only()
}

fn group_model(name: &'static str) -> Declaration {
    Declaration::new(
        name,
        "same",
        "With groups: each, what moves this group; same: as `model`.",
    )
    .choices(&["same", "dha", "first_order", "ideal"])
    .read_only()
}

/// A group's actuator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    /// The planes it moves.
    pub group: Group,
    /// A built-in actuator's name or a path.
    pub actuator: String,
    /// What moves them.
    pub model: Model,
}

/// The faults, and whom they befall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Faults {
    /// One group, or all.
    pub group: Option<Group>,
    /// Wear and faults together.
    pub condition: Condition,
}

/// The parameters, read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Config {
    /// How the planes are divided among actuators.
    pub grouping: Grouping,
    /// The actuators, in the order of [`Grouping::groups`].
    pub members: Vec<Member>,
    /// The first-order actuator's law.
    pub lag: Lag,
    /// Whether the position loop is closed.
    pub position_loop: bool,
    /// The pulse logic's options.
    pub logic: Options,
    /// Bound of the plane angle asked for, rad.
    pub command_limit: f64,
    /// How long a command holds, ns.
    pub command_timeout: i64,
    /// Longest time between two samples of motion, ns.
    pub sample_interval: i64,
    /// Every actuator's condition without the faults.
    pub worn: Condition,
    /// The faults.
    pub faults: Faults,
}

impl Config {
    /// The parameters in `values`, which hold every declared one.
    #[must_use]
    pub(crate) fn from_values(values: &Values) -> Self {
        let nanos = |name| (values.double(name) * 1e9).round() as i64;
        let grouping = match values.string("groups") {
            "each" => Grouping::Each,
            _ => Grouping::Together,
        };
        let worn = Condition {
            leakage_scale: values.double("leakage.scale"),
            stepping: values.double("friction.stepping"),
            ..Condition::SOUND
        };
        Self {
            grouping,
            members: grouping
                .groups()
                .iter()
                .map(|group| member(values, *group))
                .collect(),
            lag: Lag {
                omega: values.double("first_order.omega"),
                rate: values.double("first_order.rate"),
            },
            position_loop: values.bool("position_loop"),
            logic: logic(values),
            command_limit: values.double("command_limit"),
            command_timeout: nanos("command_timeout"),
            sample_interval: nanos("sample_interval"),
            worn,
            faults: faults(values, worn),
        }
    }

    /// The condition of a group's actuator.
    #[must_use]
    pub(crate) fn condition(&self, group: Group) -> Condition {
        if self.faults.group.is_none_or(|only| only == group) {
            self.faults.condition
        } else {
            self.worn
        }
    }

    /// What the faults of an actuator are, in words; none of one that is sound or has no oil.
    #[must_use]
    pub(crate) fn fault_words(&self, member: &Member) -> Vec<String> {
        match member.model {
            Model::Dha => self.condition(member.group).faults_beside(&self.worn),
            Model::FirstOrder | Model::Ideal => Vec::new(),
        }
    }
}

/// The actuator of a group: its own, or the node's.
fn member(values: &Values, group: Group) -> Member {
    let own = |what: &str| {
        let node_wide = values.string(what);
        match group {
            Group::DivePlanes => node_wide,
            _ => match values.string(&format!("{}.{what}", group.name())) {
                "same" => node_wide,
                own => own,
            },
        }
    };
    Member {
        group,
        actuator: own("actuator").to_owned(),
        model: match own("model") {
            "ideal" => Model::Ideal,
            "first_order" => Model::FirstOrder,
            _ => Model::Dha,
        },
    }
}

/// The faults on top of wear.
fn faults(values: &Values, worn: Condition) -> Faults {
    let befallen = values.string("fault.group");
    Faults {
        group: Group::ALL
            .into_iter()
            .find(|group| group.name() == befallen),
        condition: Condition {
            leakage_scale: worn.leakage_scale * values.double("fault.leakage"),
            short_volume: values.double("fault.short_volume"),
            lost_supply: values.double("fault.lost_supply"),
            air: values.double("fault.air"),
            slow_latch: values.double("fault.slow_latch"),
            stuck: match values.string("fault.stuck_valve") {
                "actuating" => Some(StuckValve::Actuating),
                "direction" => Some(StuckValve::Direction),
                _ => None,
            },
            encoder: match values.string("fault.encoder") {
                "lost" => Encoder::Lost,
                "frozen" => Encoder::Frozen,
                _ => Encoder::Sound,
            },
            ..worn
        },
    }
}

/// The pulse logic's options.
fn logic(values: &Values) -> Options {
    let precision_drift = match values.integer("logic.drift_option") {
        1 => DriftOption::Input,
        2 => DriftOption::Error,
        _ => DriftOption::LastCommand,
    };
    let (two_speed, drift) = match values.string("logic.mode") {
        "two_speed" => (true, DriftOption::LastCommand),
        "precision" => (false, precision_drift),
        "two_speed_precision" => (true, precision_drift),
        _ => (false, DriftOption::LastCommand),
    };
    Options {
        two_speed,
        drift,
        error_feedback: values.double("logic.error_feedback"),
        sign_feedback: values.double("logic.sign_feedback"),
        sign_change: match values.string("logic.sign_change") {
            "drops_volume" => SignChange::DropsVolume,
            _ => SignChange::MovesVolume,
        },
    }
}
