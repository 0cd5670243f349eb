//! Proposes a first identification command for a log: which output to identify from which input. Signal names give the candidates, and the share of
//! an output's variation explained by the input ranks them. A quick fit of the whole record, or of its second half, must then find a usable model.
//! Finally the pair is fitted exactly as the command would fit it; if that model is not usable, the next pair is tried.

use std::collections::BTreeMap;
use std::path::PathBuf;

use planesman_identification::analysis::{CurveChoice, Options, analyse, may_integrate};
use planesman_identification::estimators::Method;
use planesman_identification::frequency::MeasuredResponse;
use planesman_identification::several::{self, searched_part};
use planesman_identification::{Record, Segment, StraightLine};
use planesman_signals::{KeptSource, Request, Role, Source, Trend};
use planesman_text::{option, shell_word};

use crate::data::{DataOptions, Sources};
use crate::fit::fit;
use crate::options::{FitOptions, SignalOptions};
use crate::record::Expected;

/// Words in the names of commands, and in the names of measurements.
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

/// Parts of messages that are not signals of the system. A controller computes its error from an output, so an error is not an input.
const NOT_SIGNALS: [&str; 12] = [
    "error",
    "err",
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

/// Words for input, output, reference and error in the signal names of a control loop; the rest of the name identifies the loop (for example
/// `u_speed`, `y_speed`, `r_speed`).
const LOOP: [&[&str]; 4] = [
    &[
        "u", "cmd", "command", "control", "effort", "input", "actuator",
    ],
    &[
        "y",
        "measured",
        "measurement",
        "meas",
        "feedback",
        "output",
        "actual",
    ],
    &[
        "r",
        "ref",
        "reference",
        "setpoint",
        "sp",
        "desired",
        "target",
        "goal",
    ],
    &["e", "err", "error"],
];

/// Endings of field names that describe the state of a node, or values that a controller computes from an output.
const STATES: [&str; 4] = ["_error", "_limited", "_source", "_valid"];

/// Maximum number of inputs tried, and of outputs tried for each input, chosen by name.
const TRIED: (usize, usize) = (3, 12);
/// If a straight line explains this share of an output's variation, the output is considered a ramp, a counter or a stamp.
const RAMP: f64 = 0.98;
/// Minimum share of an output's variation that the input must explain, so that the pair is proposed.
const LEAST: f64 = 0.1;
/// Maximum number of outputs of an input for which a model is searched.
const MODELLED: usize = 4;
/// Maximum number of pairs that are fitted exactly as the command would fit them; each takes as long as ten quick fits.
const OBEYED: usize = 3;
/// Maximum number of samples read, over all signals.
const MOST_KEPT: usize = 1 << 19;
/// Maximum number of segments of a record that are tried, longest first.
const SEGMENTS: usize = 20;
/// An input counts as steps if it has at least this many samples for each change of value.
const STEPS: usize = 20;
/// A second input is proposed if it removes at least this share of the squared error.
const REMOVED: f64 = 0.2;
/// Minimum share of a second input's variation that the first input must leave unexplained.
const OWN: f64 = 0.2;
/// In records at least this long, s, the second half is also tried alone.
const LONG: f64 = 20.0;

/// A signal by its name, with its rank among inputs or outputs.
type Ranked = ([usize; 2], String);

/// The ways to fit, in the order in which they are tried for all pairs. `Some` orders: output error, the fastest method without bias from coloured
/// noise; `None`: a process model, which needs only a step. The flag selects the second half of the record only, for example if the first half is the
/// transit to the experiment.
const WAYS: [(&[Option<usize>], bool); 3] = [
    (&[Some(2), Some(1)], false),
    (&[None], false),
    (&[Some(2), Some(1)], true),
];

/// Data for trials with pairs of signals.
struct Trial<'d> {
    data: &'d DataOptions,
    /// The signals read so far; `None` if they cannot be read together.
    kept: Option<Vec<Box<dyn Source>>>,
    /// Time at which the record begins, s.
    from: Option<f64>,
    /// Number of pairs that may still be fitted exactly as the command would fit them.
    left: usize,
    /// The first pair that was not proposed, with the reason.
    refusal: Option<String>,
}

/// Inputs and outputs by their names, the most likely first.
fn ranked<'s>(signals: impl Iterator<Item = (&'s str, &'s str)>) -> (Vec<Ranked>, Vec<Ranked>) {
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for (topic, path) in signals.filter(|it| is_of_the_system(it.1)) {
        let rank = |words: &[&str]| {
            let place = |text: &str| words.iter().position(|word| has(text, word));
            let last = words.len();
            let rank = [topic, path].map(|it| place(it).unwrap_or(last));
            (rank != [last, last]).then_some(rank)
        };
        let signal = full_name((topic, path));
        match (rank(&INPUTS), rank(&OUTPUTS)) {
            (Some(rank), _) => inputs.push((rank, signal)),
            (None, Some(rank)) => outputs.push((rank, signal)),
            (None, None) => {}
        }
    }
    inputs.sort_by_key(|it| it.0);
    outputs.sort_by_key(|it| it.0);
    (inputs, outputs)
}

/// The signals of a control loop, found by the name parts in [`LOOP`]; `None` for missing ones.
type NamedLoop = [Option<String>; 4];

/// The control loops for which both an input and an output exist.
fn loops(signals: impl Iterator<Item = String>) -> Vec<NamedLoop> {
    let mut loops: BTreeMap<String, NamedLoop> = BTreeMap::new();
    for signal in signals {
        let name = signal.to_ascii_lowercase();
        let part = |word: &str| LOOP.iter().position(|words| words.contains(&word));
        let words = || name.split(|it: char| !it.is_ascii_alphanumeric());
        let parts: Vec<usize> = words().filter_map(part).collect();
        // The error of an output is an error.
        let Some(last) = parts.iter().copied().max() else {
            continue;
        };
        if last == 3 || parts.iter().all(|it| *it == last) {
            let rest: Vec<&str> = words().filter(|it| part(it).is_none()).collect();
            loops.entry(rest.join(" ")).or_default()[last].get_or_insert(signal);
        }
    }
    let loops = loops.into_values();
    loops
        .filter(|it| it[0].is_some() && it[1].is_some())
        .collect()
}

/// A command that fits the most likely output to the most likely input, followed by the alternatives. Only signals that vary are considered; each has
/// a topic (empty in a table) and a path. `None` if no signals look like an input and an output.
///
/// # Errors
/// The reason why no command is proposed though there are inputs and outputs.
pub(crate) fn suggestion<'s>(
    signals: impl Iterator<Item = (&'s str, &'s str)>,
    data: &DataOptions,
    has_time: bool,
) -> Result<Option<String>, String> {
    let Sources::Files(paths) = &data.sources else {
        return Ok(None);
    };
    let signals: Vec<(&str, &str)> = signals.collect();
    let (mut inputs, mut outputs) = ranked(signals.iter().copied());
    let loops = loops(signals.iter().map(|it| full_name(*it)));
    // Neither a loop's reference nor its error is a signal of the plant.
    let is_beside = |signal: &String| {
        loops
            .iter()
            .any(|it| it[2..].iter().flatten().any(|it| it == signal))
    };
    inputs.retain(|it| !is_beside(&it.1));
    outputs.retain(|it| !is_beside(&it.1));
    let mut tried = data.clone();
    if !has_time {
        // Which model there is does not depend on the unit of time.
        tried.sample_time = tried.sample_time.or(Some(1.0));
    }
    if inputs.is_empty() || outputs.is_empty() {
        return Ok(None);
    }
    let first = |of: &[Ranked], most| of.iter().take(most).map(|it| it.1.clone()).collect();
    let in_a_loop = loops.iter().take(OBEYED).find_map(|it| {
        let [Some(input), Some(output), Some(reference), _] = it else {
            return None;
        };
        let place = |of: &[Ranked], signal: &String| of.iter().position(|it| it.1 == *signal);
        let (at, place) = (place(&inputs, input)?, place(&outputs, output)?);
        has_model(&tried, input, output, reference).then_some((at, place, reference))
    });
    if let Some((at, place, reference)) = in_a_loop {
        inputs[..=at].rotate_right(1);
        outputs[..=place].rotate_right(1);
        let reference = shell_word(reference);
        let options = format!(" --reference {reference}{}", time(data, has_time));
        return Ok(Some(
            command(paths, (&inputs, 1), &outputs, &options)
                + &format!("\n  reference {reference}"),
        ));
    }
    let mut trial = Trial::new(&tried, first(&inputs, TRIED.0), first(&outputs, TRIED.1));
    let found = WAYS.iter().find_map(|(orders, in_second_half)| {
        trial.from = match in_second_half {
            true => Some(trial.half(&inputs[0].1, &outputs)?),
            false => None,
        };
        (0..inputs.len()).take(TRIED.0).find_map(|at| {
            let input = &inputs[at].1;
            let mut going = trial.going_with(input, &outputs);
            let own = loops.iter().find(|it| it[0].as_ref() == Some(input));
            going.sort_by_key(|it| own.is_some_and(|own| own[1].as_ref() != Some(&it.1)));
            let (place, order) = trial.first_usable(input, &going, orders)?;
            going[..=place].rotate_right(1);
            Some((at, going, order))
        })
    });
    let Some((chosen, outputs, order)) = found else {
        let nearest = trial
            .refusal
            .map_or_else(String::new, |it| format!(" ({it})"));
        return Err(format!(
            "no command is proposed, because a quick fit from one input found no usable model between signals with likely names{nearest}. Choose the signals yourself, use several inputs, or choose a {} with an experiment",
            option("window")
        ));
    };
    inputs[..=chosen].rotate_right(1);
    let names: Vec<&str> = inputs.iter().map(|it| it.1.as_str()).collect();
    let joint = trial.joint_inputs(&names, &outputs[0].1);
    // The others keep their order.
    inputs.sort_by_key(|it| !joint.contains(&it.1));
    let mut options = time(data, has_time);
    // A process model has one input.
    if order.is_none() && joint.len() == 1 {
        options += " --method process";
    }
    if let Some(from) = trial.from {
        options += &format!(" --window {from}..");
    }
    Ok(Some(command(
        paths,
        (&inputs, joint.len()),
        &outputs,
        &options,
    )))
}

/// The command that fits the first output to the first `joint` inputs, followed by the alternative signals.
fn command(
    paths: &[PathBuf],
    (inputs, joint): (&[Ranked], usize),
    outputs: &[Ranked],
    options: &str,
) -> String {
    let (first, inputs) = inputs.split_at(joint);
    let first: Vec<String> = first.iter().map(|it| shell_word(&it.1)).collect();
    let output = shell_word(&outputs[0].1);
    let files: Vec<String> = paths
        .iter()
        .map(|it| shell_word(&it.display().to_string()))
        .collect();
    let others = |of: &[Ranked]| {
        let few = of.iter().take(4);
        let names: Vec<String> = few.map(|it| shell_word(&it.1)).collect();
        match names.is_empty() {
            true => String::new(),
            false => format!(" (or {})", names.join(", ")),
        }
    };
    format!(
        "planesman sysid fit {} -i {} -o {output}{options}\n  input {}{}\n  output {output}{}",
        files.join(" "),
        first.join(" -i "),
        first.join(" and "),
        others(inputs),
        others(&outputs[1..])
    )
}

/// Whether a fit with the loop's reference, exactly as the command would fit it, gives a usable model.
fn has_model(data: &DataOptions, input: &str, output: &str, reference: &str) -> bool {
    let signals = SignalOptions {
        data: data.clone(),
        input: input.to_owned(),
        output: output.to_owned(),
        reference: Some(reference.to_owned()),
        ..SignalOptions::default()
    };
    let options = FitOptions {
        signals,
        ..FitOptions::default()
    };
    fit(&options, &()).is_ok_and(|it| it.analysis.verdict.is_usable())
}

/// The signal's name as written in a command: topic (empty in a table) and path.
fn full_name((topic, path): (&str, &str)) -> String {
    match topic {
        "" => path.to_owned(),
        topic => format!("{topic}:{path}"),
    }
}

impl<'d> Trial<'d> {
    fn new(data: &'d DataOptions, inputs: Vec<String>, outputs: Vec<String>) -> Self {
        let signals = [&inputs[..], &outputs].concat();
        let request = |role| move |name| Request { name, role };
        let mut requests: Vec<Request> = inputs.into_iter().map(request(Role::Input)).collect();
        requests.extend(outputs.into_iter().map(request(Role::Output)));
        let keep = |source| KeptSource::new(source, requests.clone(), MOST_KEPT).ok();
        let kept = data.each(&signals).ok().and_then(|sources| {
            let each = sources.into_iter();
            each.map(|it| Some(Box::new(keep(it)?) as Box<dyn Source>))
                .collect()
        });
        Self {
            data,
            kept,
            from: None,
            left: OBEYED,
            refusal: None,
        }
    }

    /// Index of the first output with a usable model, and the order found by a quick fit; outputs whose model may integrate come last.
    fn first_usable(
        &mut self,
        input: &str,
        outputs: &[Ranked],
        orders: &[Option<usize>],
    ) -> Option<(usize, Option<usize>)> {
        let mut integrating = Vec::new();
        for (place, (_, output)) in outputs.iter().take(MODELLED).enumerate() {
            match self.integrates(input, output, orders) {
                Some(Ok((true, order))) => integrating.push((place, order)),
                Some(Ok((false, order))) if self.is_usable(input, output, order) => {
                    return Some((place, order));
                }
                Some(Err(verdict)) => self.refuse(input, output, &verdict),
                Some(Ok(_)) | None => {}
            }
        }
        let mut integrating = integrating.into_iter();
        integrating.find(|(place, order)| self.is_usable(input, &outputs[*place].1, *order))
    }

    /// Whether the proposed command would find a usable model, after a quick fit with this order found one.
    fn is_usable(&mut self, input: &str, output: &str, order: Option<usize>) -> bool {
        // The quick fit of a process model is the command's own.
        if order.is_none() || self.left == 0 {
            return order.is_none();
        }
        self.left -= 1;
        let obeyed = self.obeyed(input, output);
        obeyed
            .map_err(|reason| self.refuse(input, output, &reason))
            .is_ok()
    }

    fn refuse(&mut self, input: &str, output: &str, reason: &str) {
        let refusal = || format!("{input} -> {output}: {reason}");
        self.refusal.get_or_insert_with(refusal);
    }

    /// The first input, and those of the next two inputs that also move the output: together with the first input they simulate it with clearly smaller errors.
    fn joint_inputs(&self, inputs: &[&str], output: &str) -> Vec<String> {
        let (first, others) = inputs.split_first().expect("an input was found");
        let error = |names: &[&str]| {
            let record = shortened(self.record_for_fit(names, output, Trend::None, true)?);
            let found = several::analyse(&record, 0, &several::Options::default()).ok()?;
            let all_count =
                (found.inputs.iter()).all(|it| it.model.is_some() && it.own.share > OWN);
            let left = 1.0 - found.fit? / 100.0;
            all_count.then_some(left * left)
        };
        let mut joint = vec![*first];
        let Some(mut least) = error(&joint) else {
            return vec![(*first).to_owned()];
        };
        for other in others.iter().take(TRIED.0 - 1) {
            let with = [&joint[..], &[*other]].concat();
            if let Some(left) = error(&with).filter(|it| *it < (1.0 - REMOVED) * least) {
                (joint, least) = (with, left);
            }
        }
        joint.into_iter().map(str::to_owned).collect()
    }

    /// The outputs that an input explains, sorted by the explained share, rounded to a tenth. Positions come last, because they integrate everything that
    /// moves the vehicle.
    fn going_with(&self, input: &str, outputs: &[Ranked]) -> Vec<Ranked> {
        let tried = outputs.iter().take(TRIED.1);
        let mut going: Vec<((bool, u8), Ranked)> = tried
            .filter_map(|it| {
                let share = self
                    .linear_share(input, &it.1)
                    .filter(|share| *share >= LEAST)?;
                let is_place = it.1.contains(".position.") || it.1.contains(".translation.");
                Some(((is_place, (10.0 * (1.0 - share)) as u8), it.clone()))
            })
            .collect();
        going.sort_by_key(|it| it.0);
        going.into_iter().map(|it| it.1).collect()
    }

    /// Share (0 to 1) of an output's variation about a straight line that a linear response to the input explains, computed from their coherence
    /// where it is significant. `None` for a ramp or a stamp, and if the signals give no record.
    fn linear_share(&self, input: &str, output: &str) -> Option<f64> {
        let raw = self.record(input, output, Trend::None)?;
        let longest = raw.segments.iter().max_by_key(|it| it.len())?;
        if StraightLine::nearest_to(longest.outputs.first()?).share > RAMP {
            return None;
        }
        let record = self.record(input, output, Trend::Line)?;
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

    /// Whether the pair's model may integrate (for example to a position, which is harder to identify than the rate), and the order found; otherwise
    /// the verdict if no usable model was found. `None` if no fit could be tried.
    fn integrates(
        &self,
        input: &str,
        output: &str,
        orders: &[Option<usize>],
    ) -> Option<Result<(bool, Option<usize>), String>> {
        let record = shortened(self.record(input, output, Trend::None)?);
        let mut refusal = None;
        for order in orders.iter().copied() {
            let method = match order {
                Some(_) => Method::OutputError,
                None if is_of_steps(&record) => Method::Process,
                None => continue,
            };
            let options = Options {
                method,
                order,
                ..Options::default()
            };
            let Ok(analysis) = analyse(&record, &options) else {
                continue;
            };
            if analysis.verdict.is_usable() {
                return Some(Ok((may_integrate(&analysis.estimate), order)));
            }
            refusal.get_or_insert(analysis.verdict.words().to_owned());
        }
        refusal.map(Err)
    }

    /// Fits a pair as the proposed command does, but without static curves: the command accepts a curve only if it simulates better.
    ///
    /// # Errors
    /// The verdict on the model, if it is not usable, or the reason why there is no model; both in words.
    fn obeyed(&self, input: &str, output: &str) -> Result<(), String> {
        let record = self.record_for_fit(&[input], output, Trend::None, true);
        let record = record.ok_or("there is no record to fit")?;
        let options = Options {
            curve: CurveChoice::None,
            ..Options::default()
        };
        let found = analyse(&shortened(record), &options).map_err(|error| error.to_string())?;
        match found.verdict.is_usable() {
            true => Ok(()),
            false => Err(found.verdict.words().to_owned()),
        }
    }

    /// The middle, in whole seconds, of the record of the input and the first output with a common record; `None` for short records and for several
    /// sources.
    fn half(&self, input: &str, outputs: &[Ranked]) -> Option<f64> {
        let [_] = self.kept.as_deref()? else {
            return None;
        };
        let outputs = outputs.iter().take(TRIED.1);
        let duration = { outputs }
            .find_map(|it| self.record(input, &it.1, Trend::None))?
            .duration();
        (duration >= LONG).then(|| (0.5 * duration).round())
    }

    fn record(&self, input: &str, output: &str, detrend: Trend) -> Option<Record> {
        self.record_for_fit(&[input], output, detrend, false)
    }

    /// The record of inputs and an output. If allowed, it is decimated when it is sampled much faster than it moves.
    fn record_for_fit(
        &self,
        inputs: &[&str],
        output: &str,
        detrend: Trend,
        decimate: bool,
    ) -> Option<Record> {
        let (input, others) = inputs.split_first()?;
        let mut signals = SignalOptions {
            data: self.data.clone(),
            input: (*input).to_owned(),
            other_inputs: others.iter().map(|it| (*it).to_owned()).collect(),
            output: output.to_owned(),
            ..SignalOptions::default()
        };
        signals.preparation.detrend = detrend;
        let window = self.from.map(|from| (from, f64::INFINITY));
        signals.grid.window.extend(window);
        let record = match &self.kept {
            Some(kept) => signals.record_of(kept, &signals.grid, Expected::ANY, decimate, &()),
            None => signals.read(&()),
        };
        Some(record.ok()?.resampled.record)
    }
}

/// The longest segments of a record, or the part of the record in which a model is searched.
fn shortened(mut record: Record) -> Record {
    // Each has an offset of its own, which a quick fit of hundreds would seek.
    if record.segments.len() > SEGMENTS {
        let by_length = |it: &Segment| std::cmp::Reverse(it.len());
        record.segments.sort_by_key(by_length);
        record.segments.truncate(SEGMENTS);
    }
    if let Some(part) = searched_part(&record.segments) {
        record.segments = part;
    }
    record
}

/// Whether the input is constant except for a few steps.
fn is_of_steps(record: &Record) -> bool {
    let changes = record.segments.iter().map(|segment| {
        let pairs = segment.inputs[0].windows(2);
        pairs.filter(|it| it[0] != it[1]).count()
    });
    changes.sum::<usize>() * STEPS < record.samples()
}

/// The time options that the data needs.
fn time(data: &DataOptions, has_time: bool) -> String {
    let stamp = data.stamp.map(|it| it.name().to_owned());
    let unit = data.time_unit.map(|it| it.name().to_owned());
    let step = match (data.sample_time, has_time) {
        (None, false) => Some("SECONDS".to_owned()),
        (step, _) => step.map(|it| format!("{it}s")),
    };
    let options = [
        ("stamp", stamp),
        ("time", data.time.as_deref().map(shell_word)),
        ("time-unit", unit),
        ("sample-time", step),
    ];
    let given = options.into_iter();
    let given = given.filter_map(|(name, value)| Some(format!(" --{name} {}", value?)));
    given.collect()
}

/// Whether a field may be a signal of the system, in contrast to a message property or a time.
fn is_of_the_system(path: &str) -> bool {
    let is_time = path.split(['[', '.']).any(|it| {
        let name = it.to_ascii_lowercase();
        name.starts_with("time_") || name.starts_with("timestamp") || name == "timeus"
    });
    if is_time || STATES.iter().any(|it| path.ends_with(it)) {
        return false;
    }
    !NOT_SIGNALS.iter().any(|it| match it.contains('.') {
        true => path.ends_with(it),
        false => path.split(['[', '.']).any(|part| part == *it),
    })
}

/// Whether a name has the word between underscores, slashes and dots, with or without a number after it, or a longer word that begins with it:
/// `thrusters`, `imu0`, `u2`. The word `controller` does not count as `control`.
fn has(name: &str, word: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let mut parts = name.split(|sign: char| !sign.is_ascii_alphanumeric());
    let begins = |part: &str| word.len() > 2 && part.starts_with(word) && part != "controller";
    parts.any(|part| {
        part.trim_end_matches(|sign: char| sign.is_ascii_digit()) == word || begins(part)
    })
}
