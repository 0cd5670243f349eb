//! What of a log may be identified from what: a first command to run.

use planesman_text::shell_word;

use crate::data::{DataOptions, Sources};

/// Words in the name of a command, and of a measurement.
#[rustfmt::skip]
const INPUTS: [&str; 25] = [
    "cmd", "command", "setpoint", "control", "effort", "pwm", "thrust", "throttle", "rudder", "actuator", "servo", "input", "reference",
    "desired", "voltage", "u",
    // As ArduPilot calls them.
    "rout", "pout", "yout", "aout", "rcou", "rdes", "pdes", "ydes", "des",
];
#[rustfmt::skip]
const OUTPUTS: [&str; 30] = [
    "odom", "imu", "gyro", "depth", "pose", "state", "angular", "rate", "velocity", "speed", "twist", "attitude", "heading", "yaw", "pitch",
    "roll", "angle", "altitude", "position", "range", "pressure", "temperature", "measured", "output", "transform", "tf", "y",
    "att", "gyr", "baro",
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

/// A command that fits the output most likely to the input most likely, with the others to choose from, of signals that vary: topic, empty
/// in a table, and path. `None` where nothing looks like an input and an output.
pub(crate) fn suggestion<'s>(
    signals: impl Iterator<Item = (&'s str, &'s str)>,
    data: &DataOptions,
    has_time: bool,
) -> Option<String> {
    let Sources::Files(paths) = &data.sources else {
        return None;
    };
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for (topic, path) in signals.filter(|it| is_of_the_system(it.1)) {
        let rank = |words: &[&str]| {
            let place = |text: &str| words.iter().position(|word| has(text, word));
            let last = words.len();
            let rank = [topic, path].map(|it| place(it).unwrap_or(last));
            (rank != [last, last]).then_some(rank)
        };
        let signal = match topic {
            "" => shell_word(path),
            topic => shell_word(&format!("{topic}:{path}")),
        };
        match (rank(&INPUTS), rank(&OUTPUTS)) {
            (Some(rank), _) => inputs.push((rank, signal)),
            (None, Some(rank)) => outputs.push((rank, signal)),
            (None, None) => {}
        }
    }
    inputs.sort_by_key(|it| it.0);
    outputs.sort_by_key(|it| it.0);
    let (input, output) = (&inputs.first()?.1, &outputs.first()?.1);
    let files: Vec<String> = paths
        .iter()
        .map(|it| shell_word(&it.display().to_string()))
        .collect();
    let others = |of: &[([usize; 2], String)]| {
        let names: Vec<&str> = of.iter().skip(1).take(4).map(|it| it.1.as_str()).collect();
        match names.is_empty() {
            true => String::new(),
            false => format!(" (or {})", names.join(", ")),
        }
    };
    Some(format!(
        "planesman sysid fit {} -i {input} -o {output}{}\n  input {input}{}\n  output {output}{}",
        files.join(" "),
        time(data, has_time),
        others(&inputs),
        others(&outputs)
    ))
}

/// The options of the time that the data needs.
fn time(data: &DataOptions, has_time: bool) -> String {
    let time = &data.time;
    let stamp = data.stamp.map(|it| it.described().0.to_owned());
    let unit = time.unit.map(|it| it.described().0.to_owned());
    let step = match (time.sample_time, has_time) {
        (None, false) => Some("SECONDS".to_owned()),
        (step, _) => step.map(|it| format!("{it}s")),
    };
    let options = [
        ("stamp", stamp),
        ("time", time.column.as_deref().map(shell_word)),
        ("time-unit", unit),
        ("sample-time", step),
    ];
    let given = options.into_iter();
    let given = given.filter_map(|(name, value)| Some(format!(" --{name} {}", value?)));
    given.collect()
}

/// Whether a field may be a signal of the system, not one of its message or a time.
fn is_of_the_system(path: &str) -> bool {
    let is_time = path.split(['[', '.']).any(|it| {
        let name = it.to_ascii_lowercase();
        name.starts_with("time_") || name.starts_with("timestamp") || name == "timeus"
    });
    if is_time {
        return false;
    }
    !NOT_SIGNALS.iter().any(|it| match it.contains('.') {
        true => path.ends_with(it),
        false => path.split(['[', '.']).any(|part| part == *it),
    })
}

/// Whether a name has the word between underscores, slashes and dots, or one that begins so: `thrusters`, `imu0`. What a controller says is
/// no control.
fn has(name: &str, word: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let mut parts = name.split(|sign: char| !sign.is_ascii_alphanumeric());
    let begins = |part: &str| word.len() > 2 && part.starts_with(word) && part != "controller";
    parts.any(|part| part == word || begins(part))
}
