//! The default charts of a vehicle, and the channels of its side view.

use serde::Serialize;

/// A line of a chart: its label, the channel `TOPIC:FIELD` (topic relative to the vehicle's namespace), and its style.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Trace {
    pub(crate) label: &'static str,
    pub(crate) channel: &'static str,
    /// Whether a value is held until the next one.
    pub(crate) held: bool,
    /// Whether the line is an edge of the band about the first line.
    pub(crate) band: bool,
}

/// A chart of the recorder.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Chart {
    pub(crate) title: &'static str,
    /// SI unit, empty for a count. The page may show another unit.
    pub(crate) unit: &'static str,
    /// Whether the axis points down, as for depth.
    pub(crate) down: bool,
    pub(crate) traces: &'static [Trace],
}

const fn line(label: &'static str, channel: &'static str) -> Trace {
    Trace {
        label,
        channel,
        held: false,
        band: false,
    }
}

const fn held(label: &'static str, channel: &'static str) -> Trace {
    Trace {
        held: true,
        ..line(label, channel)
    }
}

const fn edge(label: &'static str, channel: &'static str) -> Trace {
    Trace {
        band: true,
        ..line(label, channel)
    }
}

/// Computed channels that are not fields of a message: the dominant pole of the identified model, two standard deviations about this pole, and the
/// number of warnings and errors in the statuses of the vehicle's nodes.
pub(crate) const POLE: &str = "~pole";
pub(crate) const POLE_LOW: &str = "~pole_low";
pub(crate) const POLE_HIGH: &str = "~pole_high";
pub(crate) const WARNINGS: &str = "diagnostics:~warnings";
pub(crate) const ERRORS: &str = "diagnostics:~errors";

/// The eight default charts.
pub(crate) const CHARTS: &[Chart] = &[
    Chart {
        title: "Depth",
        unit: "m",
        down: true,
        traces: &[
            line("depth", "state:depth"),
            held("setpoint", "control_state:depth_setpoint"),
        ],
    },
    Chart {
        title: "Pitch",
        unit: "rad",
        down: false,
        traces: &[
            line("pitch", "state:pitch"),
            held("command", "control_state:pitch_command"),
        ],
    },
    Chart {
        title: "Plane angle",
        unit: "rad",
        down: false,
        traces: &[
            held("ram (in quanta)", "dha_state:plane_angle"),
            held("command", "plane_command:dive_planes"),
        ],
    },
    Chart {
        title: "Chamber pressure",
        unit: "Pa",
        down: false,
        traces: &[line("pressure across the ram", "dha_state:pressure")],
    },
    Chart {
        title: "Speed",
        unit: "m/s",
        down: false,
        traces: &[line("speed through the water", "state:surge")],
    },
    Chart {
        title: "Diagnostics",
        unit: "",
        down: false,
        traces: &[held("warnings", WARNINGS), held("errors", ERRORS)],
    },
    Chart {
        title: "Dominant pole, real part",
        unit: "1/s",
        down: false,
        traces: &[
            held("identified, with 2 sd", "model:~pole"),
            edge("+ 2 sd", "model:~pole_high"),
            edge("- 2 sd", "model:~pole_low"),
        ],
    },
    Chart {
        title: "One-step fit",
        unit: "%",
        down: false,
        traces: &[held("fit", "model:fit")],
    },
];

/// Setpoints that an operator may send, with their SI units; the topic is `NAME_setpoint`.
pub(crate) const SETPOINTS: &[(&str, &str)] = &[
    ("depth", "m"),
    ("pitch", "rad"),
    ("heading", "rad"),
    ("speed", "m/s"),
];

/// Channels that the side view needs, regardless of the charts shown.
pub(crate) const SIDE_VIEW: &[&str] = &[
    "state:depth",
    "state:pitch",
    "state:distance",
    "state:cross_track",
    "state:yaw",
    "state:dive_planes",
    "dha_state:ram",
    "dha_state:pulses",
    "control_state:mode",
];

/// Channels kept for every vehicle, relative to its namespace.
pub(crate) fn channels() -> impl Iterator<Item = &'static str> {
    let drawn = CHARTS.iter().flat_map(|chart| chart.traces);
    drawn.map(|it| it.channel).chain(SIDE_VIEW.iter().copied())
}

/// The topics of these channels, with their types.
pub(crate) const TOPICS: &[(&str, &str)] = &[
    ("state", "planesman_msgs/msg/VehicleState"),
    ("control_state", "planesman_msgs/msg/ControlState"),
    ("plane_command", "planesman_msgs/msg/PlaneCommand"),
    ("dha_state", "planesman_msgs/msg/DhaState"),
    ("model", "planesman_msgs/msg/ModelEstimate"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_decode::{Decoder, schema};

    #[test]
    fn every_channel_is_a_field_of_its_topics_type_or_is_computed_here() {
        for channel in channels() {
            let (topic, field) = channel.split_once(':').expect("TOPIC:FIELD");
            if field.starts_with('~') {
                continue;
            }
            let (_, type_name) = TOPICS
                .iter()
                .find(|(name, _)| *name == topic)
                .expect("listed");
            let info = planesman_msgs::type_info(type_name).expect("our own");
            let types = schema::read(type_name, "ros2msg", info.definition).expect("a schema");
            Decoder::compile(&types, &[field.parse().expect("a path")]).expect(channel);
        }
    }

    #[test]
    fn every_chart_has_the_unit_of_its_fields() {
        for chart in CHARTS {
            for trace in chart.traces {
                let (topic, field) = trace.channel.split_once(':').expect("TOPIC:FIELD");
                let Some((_, type_name)) = TOPICS.iter().find(|(name, _)| *name == topic) else {
                    continue;
                };
                let info = planesman_msgs::type_info(type_name).expect("our own");
                if let Some(unit) = crate::units::of_fields(info.definition).get(field) {
                    assert_eq!(*unit, chart.unit, "{}", trace.channel);
                }
            }
        }
    }
}
