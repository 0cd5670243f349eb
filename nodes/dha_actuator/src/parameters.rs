//! The actuator's parameters: the only place where its defaults and ranges stand.
//!
//! What the actuator is made of stands in its file ([`crate::actuator_file`]); here is which
//! file, and what a user changes while it runs.

use planesman_parameters::{Declaration, Values};

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
            "dha: the digital hydraulic actuator; ideal: planes that follow their command at once.",
        )
        .choices(&["dha", "ideal"])
        .read_only(),
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
    ]
}

/// Which actuator stands behind the messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// The digital hydraulic actuator.
    Dha,
    /// Planes that follow their command at once.
    Ideal,
}

/// The parameters, read.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// A built-in actuator's name or a path.
    pub actuator: String,
    /// What moves the planes.
    pub model: Model,
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
    /// Factor on both leakages.
    pub leakage_scale: f64,
}

impl Config {
    /// The parameters in `values`, which hold every declared one.
    #[must_use]
    pub fn from_values(values: &Values) -> Self {
        let nanos = |name| (values.double(name) * 1e9).round() as i64;
        Self {
            actuator: values.string("actuator").to_owned(),
            model: match values.string("model") {
                "ideal" => Model::Ideal,
                _ => Model::Dha,
            },
            position_loop: values.bool("position_loop"),
            logic: logic(values),
            command_limit: values.double("command_limit"),
            command_timeout: nanos("command_timeout"),
            sample_interval: nanos("sample_interval"),
            leakage_scale: values.double("leakage.scale"),
        }
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
