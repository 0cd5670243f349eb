//! The actuator's parameters: the only place where its defaults and ranges stand.
//!
//! What the actuator is made of stands in its file ([`crate::actuator_file`]); here is which
//! file, and what a user changes while it runs.

use planesman_parameters::{Declaration, Values};

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};
    vec![
        Declaration::new(
            "actuator",
            "auv",
            "The actuator's constants: auv, table_3_1, table_4_1 (IBM 66-L03-005), or the path of an actuator file.",
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
            command_limit: values.double("command_limit"),
            command_timeout: nanos("command_timeout"),
            sample_interval: nanos("sample_interval"),
            leakage_scale: values.double("leakage.scale"),
        }
    }
}
