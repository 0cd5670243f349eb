//! The signals of a recording: odometry of a bag, or columns with the names of `six-dof fly --out`.

use std::f64::consts::TAU;

use planesman_equations::Track;
use planesman_fit::{FitOptions, StampedRuns, Survey, survey};
use planesman_parallel::Progress;

use super::problem::SIGNALS;
use crate::error::SixDofError;

/// The type of odometry.
const ODOMETRY: &str = "nav_msgs/msg/Odometry";
/// Fields of odometry for each signal (x forward or north, y left, z up; twist in the body, forward, left, up), and the sign that converts
/// them to north, east, down and forward, starboard, keel.
const FIELDS: [(&str, f64); 12] = [
    ("pose.pose.position.x", 1.0),
    ("pose.pose.position.y", -1.0),
    ("pose.pose.position.z", -1.0),
    ("pose.pose.orientation.roll", 1.0),
    ("pose.pose.orientation.pitch", -1.0),
    ("pose.pose.orientation.yaw", -1.0),
    ("twist.twist.linear.x", 1.0),
    ("twist.twist.linear.y", -1.0),
    ("twist.twist.linear.z", -1.0),
    ("twist.twist.angular.x", 1.0),
    ("twist.twist.angular.y", -1.0),
    ("twist.twist.angular.z", -1.0),
];

/// The runs of a recording, and the signals ([`SIGNALS`]) of its outputs.
///
/// # Errors
/// If the data cannot be read, lacks signals, or has angles in degrees.
pub(super) fn read(
    options: &FitOptions,
    signals: &[String],
    (inputs, zero): (&[String], &[String]),
    progress: &dyn Progress,
) -> Result<(StampedRuns, Vec<usize>), SixDofError> {
    let found = survey(&options.signals.data, None, progress)?;
    let odometry = odometry(&found)?;
    let mut given: Vec<(&str, &str)> = Vec::new();
    for text in signals {
        let named = text.split_once('=').map(|it| (it.0.trim(), it.1.trim()));
        let names = || {
            inputs
                .iter()
                .map(String::as_str)
                .chain(SIGNALS.map(|it| it.0))
        };
        let named = named.filter(|it| names().any(|name| name == it.0));
        given.push(named.ok_or_else(|| SixDofError::no_number("signal", text, names()))?);
    }
    let given = |name: &str| {
        let of = given.iter().find(|it| it.0 == name);
        of.map(|it| it.1.to_owned())
    };
    let own = |channel: usize| {
        let name = SIGNALS[channel].0;
        let of_odometry = odometry.map(|topic| format!("{topic}:{}", FIELDS[channel].0));
        given(name).or(of_odometry).or_else(|| column(&found, name))
    };
    let all = (0..SIGNALS.len()).filter_map(|it| Some((it, own(it)?)));
    let (channels, outputs): (Vec<usize>, Vec<String>) = all.unzip();
    if outputs.is_empty() {
        return Err(SixDofError::NoMotion(SIGNALS.map(|it| it.0).join(", ")));
    }
    let own = |name: &String| {
        let own = given(name).or_else(|| column(&found, name));
        own.or_else(|| topic(&found, name))
            .unwrap_or_else(|| name.clone())
    };
    if let Some(unknown) = zero.iter().find(|it| !inputs.contains(it)) {
        let names = inputs.iter().map(String::as_str);
        return Err(SixDofError::no_number("zero", unknown, names));
    }
    let recorded = inputs.iter().filter(|it| !zero.contains(it));
    let recorded: Vec<String> = recorded.map(own).collect();
    let mut data = options.stamped(&recorded, &outputs, progress)?;
    for (place, _) in (inputs.iter().enumerate()).filter(|(_, it)| zero.contains(it)) {
        for run in &mut data.runs {
            let nothing = Track {
                times: vec![0.0],
                values: vec![0.0],
            };
            run.inputs.insert(place, nothing);
        }
    }
    for (place, channel) in channels.iter().enumerate() {
        let name = SIGNALS[*channel].0;
        let sign = match odometry.is_some() && given(name).is_none() {
            true => FIELDS[*channel].1,
            false => 1.0,
        };
        for run in &mut data.runs {
            let values = &mut run.outputs[place].values;
            values.iter_mut().for_each(|it| *it *= sign);
            if matches!(name, "roll" | "pitch") && values.iter().any(|it| it.abs() > TAU) {
                return Err(SixDofError::Degrees(name));
            }
        }
    }
    Ok((data, channels))
}

/// The topic of odometry: the only such topic, or the topic named odom; `None` if the recording has no odometry.
fn odometry(of: &Survey) -> Result<Option<&str>, SixDofError> {
    let all = of.topics.iter().filter(|it| it.type_name == ODOMETRY);
    let all: Vec<&str> = all.map(|it| it.name.as_str()).collect();
    let is_odom = |it: &&&str| it.rsplit('/').next() == Some("odom");
    match &all[..] {
        [] => Ok(None),
        [one] => Ok(Some(one)),
        several => match several.iter().find(is_odom) {
            Some(one) => Ok(Some(one)),
            None => Err(SixDofError::Odometry(several.join(", "))),
        },
    }
}

/// The column of a table, with any unit after its name.
fn column(of: &Survey, name: &str) -> Option<String> {
    let tables = of.topics.iter().filter(|it| it.type_name.is_empty());
    let mut columns = tables.flat_map(|it| &it.fields);
    let is_it = |path: &str| path.split([' ', '[', '(']).next() == Some(name);
    columns.find(|it| is_it(&it.path)).map(|it| it.path.clone())
}

/// The field of a topic that has an input's name and a single number, such as std_msgs/Float64.
fn topic(of: &Survey, name: &str) -> Option<String> {
    let topic = of
        .topics
        .iter()
        .find(|it| it.name.rsplit('/').next() == Some(name))?;
    match &topic.fields[..] {
        [field] => Some(format!("{}:{}", topic.name, field.path)),
        _ => None,
    }
}
