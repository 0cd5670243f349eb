//! What of a log may be identified from what: a first command to run.

use crate::data::Sources;
use crate::survey::{FieldSurvey, Survey, TopicSurvey};

/// Words in the name of a command, and of a measurement.
#[rustfmt::skip]
const INPUTS: [&str; 16] = [
    "cmd", "command", "setpoint", "control", "effort", "pwm", "thrust", "throttle", "rudder", "actuator", "servo", "input", "reference",
    "desired", "voltage", "u",
];
#[rustfmt::skip]
const OUTPUTS: [&str; 27] = [
    "odom", "imu", "gyro", "depth", "pose", "state", "angular", "rate", "velocity", "speed", "twist", "attitude", "heading", "yaw", "pitch",
    "roll", "angle", "altitude", "position", "range", "pressure", "temperature", "measured", "output", "transform", "tf", "y",
];

/// Parts of messages that are no signal of the system.
const NOT_SIGNALS: [&str; 10] = [
    "norm",
    "covariance",
    "header",
    "stamp",
    "sec",
    "nanosec",
    "orientation.x",
    "orientation.y",
    "orientation.z",
    "orientation.w",
];

/// Numbers of which a signal has so many at least.
const FEWEST: u64 = 50;

/// A command that fits the output most likely to the input most likely, with the others to choose from; `None` where nothing looks like
/// an input and an output.
pub(crate) fn suggestion(survey: &Survey, sources: &Sources) -> Option<String> {
    let Sources::Files(paths) = sources else {
        return None;
    };
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for topic in &survey.topics {
        for field in topic.fields.iter().filter(|it| is_signal(it)) {
            let of = |words: &[&str]| {
                let topic_too = if topic.type_name.is_empty() {
                    ""
                } else {
                    &topic.name
                };
                let place = |text: &str| words.iter().position(|word| has(text, word));
                let [topic, field] = [topic_too, &field.path].map(place);
                let last = words.len();
                let rank = (topic.unwrap_or(last), field.unwrap_or(last));
                (rank != (last, last)).then_some(rank)
            };
            match (of(&INPUTS), of(&OUTPUTS)) {
                (Some(rank), _) => inputs.push((rank, signal(topic, field))),
                (None, Some(rank)) => outputs.push((rank, signal(topic, field))),
                (None, None) => {}
            }
        }
    }
    inputs.sort_by_key(|it| it.0);
    outputs.sort_by_key(|it| it.0);
    let (input, output) = (&inputs.first()?.1, &outputs.first()?.1);
    let files: Vec<String> = paths
        .iter()
        .map(|it| quoted(&it.display().to_string()))
        .collect();
    let others = |of: &[((usize, usize), String)]| {
        let names: Vec<&str> = of.iter().skip(1).take(4).map(|it| it.1.as_str()).collect();
        match names.is_empty() {
            true => String::new(),
            false => format!(" (or {})", names.join(", ")),
        }
    };
    Some(format!(
        "planesman sysid fit {} -i {input} -o {output}\n  input {input}{}\n  output {output}{}",
        files.join(" "),
        others(&inputs),
        others(&outputs)
    ))
}

/// Whether a field varies, as what excites or answers does.
fn is_signal(field: &FieldSurvey) -> bool {
    let path = &field.path;
    let is_other = |it: &&&str| match it.contains('.') {
        true => path.ends_with(**it),
        false => path.split(['[', '.']).any(|part| part == **it),
    };
    let is_other = NOT_SIGNALS.iter().any(|it| is_other(&it));
    field.count >= FEWEST && field.min < field.max && !is_other
}

/// Whether a name has the word between underscores, slashes and dots, or one that begins so: `thrusters`, `imu0`. What a controller says is
/// no control.
fn has(name: &str, word: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let mut parts = name.split(|sign: char| !sign.is_ascii_alphanumeric());
    let begins = |part: &str| word.len() > 2 && part.starts_with(word) && part != "controller";
    parts.any(|part| part == word || begins(part))
}

fn signal(topic: &TopicSurvey, field: &FieldSurvey) -> String {
    match topic.type_name.as_str() {
        "" => quoted(&field.path),
        _ => quoted(&format!("{}:{}", topic.name, field.path)),
    }
}

/// As a shell takes it.
fn quoted(text: &str) -> String {
    let is_plain = |sign: char| sign.is_alphanumeric() || "/:._-+=,".contains(sign);
    match text.chars().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}
