//! What of a log may be identified from what: a first command to run. Names propose inputs and outputs, the share of an output's
//! variation that goes with the input ranks them, and a quick fit has to find a model that is usable.

use planesman_identification::analysis::{Options, analyse, may_integrate};
use planesman_identification::estimators::Method;
use planesman_identification::frequency::MeasuredResponse;
use planesman_identification::{Record, StraightLine};
use planesman_signals::Trend;
use planesman_text::shell_word;

use crate::data::{DataOptions, Sources};
use crate::options::SignalOptions;

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

/// So many inputs are tried, and so many outputs of each, by their names.
const TRIED: (usize, usize) = (3, 12);
/// The share of an output's variation from which a straight line is all that it is: a ramp, a counter or a stamp.
const RAMP: f64 = 0.98;
/// The share of an output's variation from which it is proposed.
const LEAST: f64 = 0.1;
/// Outputs of an input that a model is sought of, by these orders, in records of so many samples at most.
const MODELLED: usize = 4;
const ORDERS: [usize; 2] = [2, 1];
const MOST_SAMPLES: usize = 20_000;

/// A signal by its name, with its rank among inputs or outputs.
type Ranked = ([usize; 2], String);

/// A command that fits the output most likely to the input most likely, with the others to choose from, of signals that vary: topic, empty
/// in a table, and path. `None` where nothing looks like an input and an output that goes with it.
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
            "" => path.to_owned(),
            topic => format!("{topic}:{path}"),
        };
        match (rank(&INPUTS), rank(&OUTPUTS)) {
            (Some(rank), _) => inputs.push((rank, signal)),
            (None, Some(rank)) => outputs.push((rank, signal)),
            (None, None) => {}
        }
    }
    inputs.sort_by_key(|it| it.0);
    outputs.sort_by_key(|it| it.0);
    let mut tried = data.clone();
    if !has_time {
        // Which model there is does not depend on the unit of time.
        tried.time.sample_time = tried.time.sample_time.or(Some(1.0));
    }
    let each = (0..inputs.len()).take(TRIED.0);
    let (chosen, outputs) = { each }.find_map(|at| {
        let input = &inputs[at].1;
        let mut going = going_with(input, &outputs, &tried);
        let first = going.iter().take(MODELLED).enumerate();
        let models = first.filter_map(|(at, it)| Some((integrates(input, &it.1, &tried)?, at)));
        let (_, place) = models.min()?;
        going[..=place].rotate_right(1);
        Some((at, going))
    })?;
    inputs[..=chosen].rotate_right(1);
    let (input, output) = (shell_word(&inputs[0].1), shell_word(&outputs[0].1));
    let files: Vec<String> = paths
        .iter()
        .map(|it| shell_word(&it.display().to_string()))
        .collect();
    let others = |of: &[Ranked]| {
        let names: Vec<String> = of
            .iter()
            .skip(1)
            .take(4)
            .map(|it| shell_word(&it.1))
            .collect();
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

/// The outputs that go with an input, those first of which it accounts for most, to a tenth; places in space last, since they integrate
/// everything that moves the vehicle.
fn going_with(input: &str, outputs: &[Ranked], data: &DataOptions) -> Vec<Ranked> {
    let tried = outputs.iter().take(TRIED.1);
    let mut going: Vec<((bool, u8), Ranked)> = tried
        .filter_map(|it| {
            let share = linear_share(input, &it.1, data).filter(|share| *share >= LEAST)?;
            let is_place = it.1.contains(".position.") || it.1.contains(".translation.");
            Some(((is_place, (10.0 * (1.0 - share)) as u8), it.clone()))
        })
        .collect();
    going.sort_by_key(|it| it.0);
    going.into_iter().map(|it| it.1).collect()
}

/// The share of an output's variation about a straight line, 0 to 1, that a linear response to an input explains: by their coherence, where
/// it is more than chance. `None` of a ramp or a stamp, and where they make no record.
fn linear_share(input: &str, output: &str, data: &DataOptions) -> Option<f64> {
    let raw = record(input, output, data, Trend::None)?;
    let longest = raw.segments.iter().max_by_key(|it| it.len())?;
    if StraightLine::nearest_to(longest.outputs.first()?).share > RAMP {
        return None;
    }
    let record = record(input, output, data, Trend::Line)?;
    let (mut with, mut all) = (0.0, 0.0);
    for point in MeasuredResponse::new(&record).ok()?.points {
        let moved = point.values[0].norm_sqr() * point.inputs[0];
        // The frequencies lie evenly over their logarithm.
        all += point.omega * (moved + point.noise);
        if point.coherence > point.coherence_by_chance() {
            with += point.omega * moved;
        }
    }
    Some(with / all).filter(|share| share.is_finite())
}

/// Whether the pair's model may integrate, as of a position, which is harder to identify than the rate; `None` where output error, the
/// quickest method that noise of no colour misleads, finds none that is usable.
fn integrates(input: &str, output: &str, data: &DataOptions) -> Option<bool> {
    let record = record(input, output, data, Trend::None)?;
    if record.samples() > MOST_SAMPLES {
        return Some(false);
    }
    ORDERS.into_iter().find_map(|order| {
        let options = Options {
            method: Method::OutputError,
            order: Some(order),
            ..Options::default()
        };
        let analysis = analyse(&record, &options).ok()?;
        let is_usable = analysis.verdict.is_usable();
        is_usable.then(|| may_integrate(&analysis.estimate))
    })
}

fn record(input: &str, output: &str, data: &DataOptions, detrend: Trend) -> Option<Record> {
    let mut signals = SignalOptions {
        data: data.clone(),
        input: input.to_owned(),
        output: output.to_owned(),
        ..SignalOptions::default()
    };
    signals.preparation.detrend = detrend;
    Some(signals.read(&()).ok()?.resampled.record)
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
