//! The signals of a recording: odometry of a bag, or columns with the names of `six-dof fly --out`.

use std::f64::consts::TAU;

use planesman_equations::{Run, Track};
use planesman_fit::{StampedRuns, Survey, survey};
use planesman_parallel::Progress;
use planesman_signals::Unwrap;
use planesman_vehicle::six_dof::rotation;

use crate::error::SixDofError;
use crate::options::{Axes, SixDofOptions};
use crate::signals::SIGNALS;

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

/// Names of the four numbers of a quaternion, the scalar first.
const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];

/// A signal with a factor and an offset, written `SIGNAL*FACTOR+OFFSET`.
#[derive(Clone, Debug, PartialEq)]
struct Scaled {
    signal: String,
    factor: f64,
    offset: f64,
}

impl Scaled {
    fn plain(signal: String) -> Self {
        Self {
            signal,
            factor: 1.0,
            offset: 0.0,
        }
    }

    /// From its text; a signal that is known by the whole text has no factor.
    fn parsed(text: &str, is_known: &dyn Fn(&str) -> bool) -> Self {
        let mut of = Self::plain(text.to_owned());
        if is_known(text) {
            return of;
        }
        let parted = |text: &str, signs: &[char]| {
            let at = text.rfind(signs).filter(|at| *at > 0)?;
            // The sign of an exponent belongs to its number.
            let at = match text[..at].ends_with(['e', 'E']) {
                true => text[..at].rfind(signs).filter(|at| *at > 0)?,
                false => at,
            };
            let number: f64 = text[at..]
                .trim_start_matches(['*', '/'])
                .trim()
                .parse()
                .ok()?;
            let sign = text.as_bytes()[at];
            Some((text[..at].trim().to_owned(), number, sign))
        };
        if let Some((rest, number, _)) =
            parted(&of.signal, &['+', '-']).filter(|it| !it.0.ends_with('*'))
        {
            (of.signal, of.offset) = (rest, number);
        }
        if let Some((rest, number, sign)) = parted(&of.signal, &['*', '/']) {
            let factor = if sign == b'/' { 1.0 / number } else { number };
            (of.signal, of.factor) = (rest, factor);
        }
        of
    }
}

/// The signals of a recording by the names of the vehicle's inputs and of [`SIGNALS`].
struct Names<'a> {
    survey: &'a Survey,
    odometry: Option<&'a str>,
    given: Vec<(String, Scaled)>,
}

impl Names<'_> {
    fn given(&self, name: &str) -> Option<&Scaled> {
        let of = self.given.iter().find(|it| it.0 == name);
        of.map(|it| &it.1)
    }

    fn column(&self, name: &str) -> Option<Scaled> {
        let given = self.given(name).cloned();
        given.or_else(|| column(self.survey, name).map(Scaled::plain))
    }

    fn input(&self, name: &str) -> Scaled {
        let own = self.column(name);
        own.or_else(|| topic(self.survey, name).map(Scaled::plain))
            .unwrap_or_else(|| Scaled::plain(name.to_owned()))
    }

    /// The signal of the motion, with the sign that converts it to north, east, down and forward, starboard, keel.
    fn motion(&self, channel: usize, axes: Axes) -> Option<Scaled> {
        let (name, unit) = SIGNALS[channel];
        if self.given(name).is_none()
            && let Some(topic) = self.odometry
        {
            let (field, sign) = FIELDS[channel];
            let mut of = Scaled::plain(format!("{topic}:{field}"));
            of.factor = sign;
            return Some(of);
        }
        let mut of = self.column(name)?;
        let mut by = if axes.left_up { FIELDS[channel].1 } else { 1.0 };
        if unit.starts_with("rad") && (axes.degrees || of.signal.contains("[deg")) {
            by *= 1f64.to_radians();
        }
        (of.factor, of.offset) = (by * of.factor, by * of.offset);
        Some(of)
    }
}

/// The runs of a recording, and the signals ([`SIGNALS`]) of its outputs.
///
/// # Errors
/// If the data cannot be read, lacks signals, or has angles in degrees.
pub(super) fn read(
    options: &SixDofOptions,
    inputs: &[String],
    progress: &dyn Progress,
) -> Result<(StampedRuns, Vec<usize>), SixDofError> {
    let mut fit = options.data.clone();
    // Differences of angles are taken the shorter way; unwrapped ones would tell nothing of their unit.
    fit.signals.grid.unwrap = Unwrap::No;
    let (zero, axes) = (&options.zero, options.axes);
    let found = survey(&fit.signals.data, None, progress)?;
    let names = Names {
        odometry: odometry(&found)?,
        given: given(&found, &options.signals, inputs)?,
        survey: &found,
    };
    let all = (0..SIGNALS.len()).filter_map(|it| Some((it, names.motion(it, axes)?)));
    let (mut channels, mut outputs): (Vec<usize>, Vec<Scaled>) = all.unzip();
    let attitude = QUATERNION.map(|it| names.column(it));
    let quaternion: Vec<Scaled> = match channels.iter().any(|it| (3..6).contains(it)) {
        true => Vec::new(),
        false => attitude.into_iter().flatten().collect(),
    };
    let has_quaternion = quaternion.len() == QUATERNION.len();
    let of_motion = outputs.len();
    if has_quaternion {
        outputs.extend(quaternion);
    }
    if outputs.is_empty() {
        return Err(SixDofError::NoMotion(SIGNALS.map(|it| it.0).join(", ")));
    }
    outputs.extend(options.mask.clone().map(Scaled::plain));
    if let Some(unknown) = zero.iter().find(|it| !inputs.contains(it)) {
        let names = inputs.iter().map(String::as_str);
        return Err(SixDofError::no_number("zero", unknown, names));
    }
    let recorded = inputs.iter().filter(|it| !zero.contains(it));
    let recorded: Vec<Scaled> = recorded.map(|it| names.input(it)).collect();
    let signals = |of: &[Scaled]| of.iter().map(|it| it.signal.clone()).collect::<Vec<_>>();
    let mut data = fit.stamped(&signals(&recorded), &signals(&outputs), progress)?;
    for run in data.runs.iter_mut().chain(&mut data.validation) {
        let tracks = run.inputs.iter_mut().zip(&recorded);
        for (track, of) in tracks.chain(run.outputs.iter_mut().zip(&outputs)) {
            if *of != Scaled::plain(of.signal.clone()) {
                let values = &mut track.values;
                values
                    .iter_mut()
                    .for_each(|it| *it = of.factor * *it + of.offset);
            }
        }
        for (place, _) in (inputs.iter().enumerate()).filter(|(_, it)| zero.contains(it)) {
            let nothing = Track {
                times: vec![0.0],
                values: vec![0.0],
            };
            run.inputs.insert(place, nothing);
        }
        if options.mask.is_some() {
            masked(run);
        }
        if has_quaternion {
            let parts = run.outputs.split_off(of_motion);
            run.outputs.extend(angles(&parts, axes));
        }
        for (channel, track) in channels.iter().zip(&run.outputs) {
            let name = SIGNALS[*channel].0;
            let is_angle = matches!(name, "roll" | "pitch");
            if is_angle && track.values.iter().any(|it| it.abs() > TAU) {
                return Err(SixDofError::Degrees(name));
            }
        }
    }
    if has_quaternion {
        channels.extend([3, 4, 5]);
    }
    Ok((data, channels))
}

/// The signals that were named, each with an input's or a signal's name.
fn given(
    survey: &Survey,
    texts: &[String],
    inputs: &[String],
) -> Result<Vec<(String, Scaled)>, SixDofError> {
    let names = || {
        let own = SIGNALS.map(|it| it.0).into_iter().chain(QUATERNION);
        inputs.iter().map(String::as_str).chain(own)
    };
    let is_known = |signal: &str| {
        let mut fields = survey.topics.iter().flat_map(|topic| {
            let name = |path: &str| match topic.type_name.as_str() {
                "" => path.to_owned(),
                _ => format!("{}:{path}", topic.name),
            };
            topic.fields.iter().map(move |it| name(&it.path))
        });
        fields.any(|it| it == signal)
    };
    let mut given = Vec::new();
    for text in texts {
        let named = text.split_once('=').map(|it| (it.0.trim(), it.1.trim()));
        let named = named.filter(|it| names().any(|name| name == it.0));
        let (name, signal) =
            named.ok_or_else(|| SixDofError::no_number("signal", text, names()))?;
        given.push((name.to_owned(), Scaled::parsed(signal, &is_known)));
    }
    Ok(given)
}

/// Leaves out the samples of all outputs where the last one, the mask, is 0, and the mask.
fn masked(run: &mut Run) {
    let Some(mask) = run.outputs.pop() else {
        return;
    };
    for track in &mut run.outputs {
        let pairs = track.times.iter().zip(&track.values);
        let kept = pairs.filter(|it| mask.at(*it.0) != 0.0);
        let (times, values) = kept.map(|it| (*it.0, *it.1)).unzip();
        *track = Track { times, values };
    }
}

/// Roll, pitch and yaw of a quaternion's four tracks, which share their stamps.
fn angles(parts: &[Track], axes: Axes) -> [Track; 3] {
    let times = parts[0].times.clone();
    let mut values = [Vec::new(), Vec::new(), Vec::new()];
    for (k, time) in times.iter().enumerate() {
        let at = |part: usize| {
            parts[part]
                .values
                .get(k)
                .copied()
                .unwrap_or_else(|| parts[part].at(*time))
        };
        let sign = if axes.left_up { -1.0 } else { 1.0 };
        let q = rotation::normalised([at(0), at(1), sign * at(2), sign * at(3)]);
        let found = rotation::euler(q);
        (0..3).for_each(|i| values[i].push(found[i]));
    }
    values.map(|values| Track {
        times: times.clone(),
        values,
    })
}

/// The topic of odometry: the only one, or the one named odom; `None` if the recording has none.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_may_have_a_factor_and_an_offset() {
        let of = |text: &str| Scaled::parsed(text, &|it| it == "motor-1");
        let expected = |signal: &str, factor, offset| Scaled {
            signal: signal.to_owned(),
            factor,
            offset,
        };
        assert_eq!(of("pwm_1*0.0025-3.75"), expected("pwm_1", 0.0025, -3.75));
        assert_eq!(
            of("/joy:axes[1] * -40"),
            expected("/joy:axes[1]", -40.0, 0.0)
        );
        assert_eq!(of("rpm/60"), expected("rpm", 1.0 / 60.0, 0.0));
        assert_eq!(of("u*1e-3+2"), expected("u", 1e-3, 2.0));
        assert_eq!(of("motor-1"), expected("motor-1", 1.0, 0.0));
        assert_eq!(of("speed"), expected("speed", 1.0, 0.0));
    }
}
