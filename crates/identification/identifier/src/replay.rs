//! Replays a bag's messages to the identifier, in the order in which the node received them; or a record's samples.
//!
//! The samples are sorted by their stamps before use ([`planesman_signals::Aligner`]), so the replayed estimates equal those that the node
//! published from the same messages. If the bag contains the node's own `model` topic, every published estimate is compared. The estimates
//! also show when the node was frozen, released or reset; the replay does the same after the same sample.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use planesman_bag::reader::ReadError;
use planesman_bag::{BagReader, Order, Topic};
use planesman_identification::{Input, Record};
use planesman_linear::digits::{significant, with_interval};
use planesman_linear::{Complex, pole_text};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::{Message, cdr};
use planesman_signals as signals;

use crate::pair::{Change, FIRST, Pair, Scheduled};
use crate::{Error, Identifier, IdentifierParameters, Jump, Sample, TopicReader};

/// Reasons why a bag cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// Invalid parameters.
    #[error(transparent)]
    Parameters(#[from] Error),
    /// A bag that cannot be read.
    #[error(transparent)]
    Bag(#[from] ReadError),
    /// A bag without a signal.
    #[error("bag '{}': no messages on the topic of {signal}; it has {topics}{}", bag.display(),
        reason.as_ref().map_or_else(String::new, |it| format!(" ({it})")))]
    NoSignal {
        /// The bag.
        bag: PathBuf,
        /// The signal.
        signal: String,
        /// The bag's topics.
        topics: String,
        /// The error in the first refused message.
        reason: Option<String>,
    },
}

/// The result of a replay.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The estimate of each pair at the end of the bag, in the order of pairs.
    pub estimates: Vec<ModelEstimate>,
    /// The detected jumps, each with its pair's name.
    pub jumps: Vec<(String, Jump)>,
    /// Comparison with the estimates that the node published live; `None` if the bag has none.
    pub live: Option<Comparison>,
    /// Number of messages without a finite number for a signal, and the error in the first.
    pub refused: Option<(usize, String)>,
    /// The reason why the bag is incomplete, if it is.
    pub incomplete: Option<String>,
}

/// Comparison of replayed and published estimates by stamp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Number of estimates with the same stamp.
    pub compared: usize,
    /// Number of published estimates without a replayed one.
    pub missing: usize,
    /// The largest difference of a coefficient, relative to the largest coefficient of its kind.
    pub largest_difference: f64,
}

/// The identity of an estimate: its pair, how often time had gone back, its stamp, and its number of samples.
type Key = (String, u32, i64, u64);

fn key(estimate: &ModelEstimate) -> Key {
    (
        estimate.name.clone(),
        estimate.restarts,
        estimate.header.stamp.nanos(),
        estimate.samples,
    )
}

/// Receives each estimate that is due, with its pair's current state.
pub type OnEstimate<'a> = dyn FnMut(&ModelEstimate, &Pair) + 'a;

/// Replays a record with one input and one output as the first pair, with the record's sampling interval. The inputs are held over each interval.
/// Two consecutive segments are separated by a gap.
///
/// # Errors
/// If parameters are invalid.
pub fn replay_record(
    record: &Record,
    parameters: &IdentifierParameters,
    on_estimate: &mut OnEstimate<'_>,
) -> Result<Replay, ReplayError> {
    let parameters = IdentifierParameters {
        sample_time: record.sample_time,
        first_moment: false,
        resample: false,
        ..parameters.clone()
    };
    let mut pair = Pair::new(FIRST.to_owned(), &parameters)?;
    let (mut jumps, mut stamp) = (Jumps::default(), Time::default());
    let mut told = |due: Vec<ModelEstimate>, pair: &Pair| {
        jumps.note(pair);
        for mut estimate in due {
            name_signals(&mut estimate, record);
            on_estimate(&estimate, pair);
        }
    };
    for segment in &record.segments {
        let signals = segment.inputs.first().zip(segment.outputs.first());
        let samples = signals.into_iter().flat_map(|(u, y)| u.iter().zip(y));
        for (k, (input, output)) in samples.enumerate() {
            let since = k as f64 * record.sample_time * 1e9;
            stamp = Time::from_nanos(segment.start + since.round() as i64);
            let sample = Sample {
                input: Some(Input::held(*input)),
                output: Some(*output),
                ..Sample::default()
            };
            told(pair.on_sample(stamp.clone(), &sample), &pair);
        }
    }
    told(pair.finish(), &pair);
    let mut estimate = pair.estimate(stamp);
    name_signals(&mut estimate, record);
    Ok(Replay {
        estimates: vec![estimate],
        jumps: jumps.found,
        live: None,
        refused: None,
        incomplete: None,
    })
}

/// Sets the names of the record's signals in the estimate.
fn name_signals(estimate: &mut ModelEstimate, record: &Record) {
    estimate.input = record.inputs.join(", ");
    estimate.output = record.outputs.join(", ");
}

/// The jumps of several pairs, in the order of detection.
#[derive(Default)]
struct Jumps {
    found: Vec<(String, Jump)>,
    /// The last jump of each pair.
    last: BTreeMap<String, Jump>,
}

impl Jumps {
    fn note(&mut self, pair: &Pair) {
        if let Some(jump) = pair.jump()
            && self.last.get(pair.name()) != Some(&jump)
        {
            self.last.insert(pair.name().to_owned(), jump);
            self.found.push((pair.name().to_owned(), jump));
        }
    }
}

/// Replays the bag.
///
/// # Errors
/// If parameters are invalid, or the bag cannot be read or lacks a signal.
pub fn replay(
    path: &Path,
    parameters: &IdentifierParameters,
    on_estimate: &mut OnEstimate<'_>,
) -> Result<Replay, ReplayError> {
    let mut identifier = Identifier::new(parameters)?;
    let mut jumps = Jumps::default();
    let bag = BagReader::open(path)?;
    for (name, scheduled) in changes(&bag) {
        identifier.schedule(&name, scheduled);
    }
    let has_models = bag.topics().iter().any(|it| is_of_models(&it.topic));
    let mut live = has_models.then(EstimateComparator::default);
    let mut refused = Refused::default();
    let mut damage = None;
    let mut seen: BTreeSet<String> = BTreeSet::new();
    // By the topic's address, which is kept beside it; without a reader for messages of another type.
    let mut readers: BTreeMap<usize, (Arc<Topic>, Option<TopicReader>)> = BTreeMap::new();
    let mut last = Time::default();
    for message in bag.messages(Order::File) {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                damage = Some(error.to_string());
                break;
            }
        };
        let topic = message.topic.name.as_str();
        if is_of_models(&message.topic) {
            match cdr::from_bytes(&message.payload) {
                Ok(estimate) => live.iter_mut().for_each(|it| it.published(&estimate)),
                Err(error) => refused.note(topic, &error.to_string()),
            }
        }
        if !identifier.concerns(topic) {
            continue;
        }
        let key = Arc::as_ptr(&message.topic) as usize;
        let (_, reader) = match readers.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let reader = reader_of(&identifier, &bag, &message.topic);
                let reader = reader.map_err(|reason| refused.note(topic, &reason)).ok();
                new.insert((Arc::clone(&message.topic), reader))
            }
        };
        let Some(reader) = reader else {
            refused.count += 1;
            continue;
        };
        if !seen.contains(topic) {
            seen.insert(topic.to_owned());
        }
        let sent = Time::from_nanos(message.publish_time);
        let outcome = identifier.on_payload(reader, &sent, &message.payload);
        last = outcome.stamp.unwrap_or(last);
        tell(&identifier, &outcome.estimates, &mut jumps, on_estimate);
        if let Some(live) = &mut live {
            let again = outcome.estimates.iter();
            again.for_each(|again| live.replayed(again));
        }
        for reason in outcome.refused {
            refused.note(topic, &reason);
        }
    }
    let rest = identifier.finish();
    tell(&identifier, &rest, &mut jumps, on_estimate);
    if let Some(live) = &mut live {
        rest.iter().for_each(|again| live.replayed(again));
    }
    for pair in identifier.pairs() {
        for signal in [&pair.config().input, &pair.config().output] {
            if !seen.iter().any(|topic| signal.is_on(topic)) {
                return Err(ReplayError::NoSignal {
                    bag: path.to_owned(),
                    signal: signal.to_string(),
                    topics: signals::topics(&bag),
                    reason: refused.first,
                });
            }
        }
    }
    let pairs = identifier.pairs().iter();
    let whole = bag.completeness().is_whole();
    Ok(Replay {
        estimates: pairs.map(|pair| pair.estimate(last.clone())).collect(),
        jumps: jumps.found,
        live: live.and_then(EstimateComparator::finish),
        refused: refused.first.map(|first| (refused.count, first)),
        incomplete: damage.or_else(|| (!whole).then(|| bag.completeness().to_string())),
    })
}

fn reader_of(
    identifier: &Identifier,
    bag: &BagReader,
    topic: &Topic,
) -> Result<TopicReader, String> {
    let types = signals::types(bag, topic).map_err(|it| it.to_string())?;
    let reader = identifier.reader(&topic.name, &types);
    reader.map_err(|it| it.to_string())
}

/// Records jumps of the pairs, and passes on their estimates.
fn tell(
    identifier: &Identifier,
    due: &[ModelEstimate],
    jumps: &mut Jumps,
    on_estimate: &mut OnEstimate<'_>,
) {
    for estimate in due {
        if let Some(pair) = identifier.pair(&estimate.name) {
            jumps.note(pair);
            on_estimate(estimate, pair);
        }
    }
}

/// Refused messages.
#[derive(Default)]
struct Refused {
    count: usize,
    first: Option<String>,
}

impl Refused {
    fn note(&mut self, topic: &str, reason: &str) {
        self.count += 1;
        self.first
            .get_or_insert_with(|| format!("{topic}: {reason}"));
    }
}

/// Whether a node published its estimates on this topic.
fn is_of_models(topic: &Topic) -> bool {
    topic.kind.type_name == ModelEstimate::TYPE_NAME && topic.name.ends_with("/model")
}

/// The changes made to the node while it learnt: its estimates show when it was frozen, released and reset.
fn changes(bag: &BagReader) -> Vec<(String, Scheduled)> {
    struct Before {
        frozen: bool,
        samples: u64,
        restarts: u32,
    }
    let mut changes = Vec::new();
    let mut last: BTreeMap<String, Before> = BTreeMap::new();
    // What ends the bag early, or does not decode, is reported by the second reading.
    let messages = bag.messages_of(is_of_models, Order::File).flatten();
    for message in messages {
        let Ok(estimate) = cdr::from_bytes::<ModelEstimate>(&message.payload) else {
            continue;
        };
        let now = Before {
            frozen: estimate.frozen,
            samples: estimate.samples,
            restarts: estimate.restarts,
        };
        let before = last.insert(estimate.name.clone(), now);
        let mut note = |change| {
            let scheduled = Scheduled {
                restarts: estimate.restarts,
                stamp: estimate.header.stamp.nanos(),
                change,
            };
            changes.push((estimate.name.clone(), scheduled));
        };
        let was_frozen = before.as_ref().is_some_and(|before| before.frozen);
        if estimate.frozen != was_frozen {
            note(Change::Freeze(estimate.frozen));
        }
        let forgotten = before.is_some_and(|before| {
            before.samples > 0 && before.restarts == estimate.restarts && estimate.samples == 0
        });
        if forgotten {
            note(Change::Reset);
        }
    }
    changes
}

/// An estimate's coefficients: a, b, c.
type Coefficients = [Vec<f64>; 3];

fn coefficients(estimate: &ModelEstimate) -> Coefficients {
    [&estimate.a, &estimate.b, &estimate.c].map(Clone::clone)
}

/// Replayed and published estimates that wait for their counterpart. An estimate is removed once its counterpart has arrived, so the memory does not
/// grow if all estimates in the bag have a counterpart.
#[derive(Default)]
struct EstimateComparator {
    comparison: Option<Comparison>,
    published: BTreeMap<Key, Coefficients>,
    replayed: BTreeMap<Key, Coefficients>,
    /// By pair: the last replayed estimate with a counterpart, in case that is published again.
    met: BTreeMap<String, (Key, Coefficients)>,
}

impl EstimateComparator {
    fn published(&mut self, live: &ModelEstimate) {
        let (key, live) = (key(live), coefficients(live));
        if let Some(again) = self.replayed.remove(&key) {
            self.compare(key, again, &live);
        } else if let Some((_, again)) = self.met.get(&key.0).filter(|(met, _)| *met == key) {
            let again = again.clone();
            self.compare(key, again, &live);
        } else {
            self.published.insert(key, live);
        }
    }

    fn replayed(&mut self, again: &ModelEstimate) {
        let (key, again) = (key(again), coefficients(again));
        match self.published.remove(&key) {
            Some(live) => self.compare(key, again, &live),
            None => drop(self.replayed.insert(key, again)),
        }
    }

    fn compare(&mut self, key: Key, again: Coefficients, live: &Coefficients) {
        let comparison = self.comparison.get_or_insert_default();
        comparison.compared += 1;
        for (ours, theirs) in again.iter().zip(live) {
            let difference = relative_difference(ours, theirs);
            comparison.largest_difference = comparison.largest_difference.max(difference);
        }
        self.met.insert(key.0.clone(), (key, again));
    }

    /// The comparison; `None` if nothing was published.
    fn finish(self) -> Option<Comparison> {
        let missing = self.published.len();
        match self.comparison {
            None if missing == 0 => None,
            comparison => Some(Comparison {
                missing,
                ..comparison.unwrap_or_default()
            }),
        }
    }
}

/// The largest difference between two lists, relative to their largest element; infinite if they differ in length.
fn relative_difference(ours: &[f64], theirs: &[f64]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::INFINITY;
    }
    let size = theirs.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
    let difference = ours
        .iter()
        .zip(theirs)
        .fold(0.0_f64, |max, (a, b)| max.max((a - b).abs()));
    if difference == 0.0 {
        0.0
    } else {
        difference / size
    }
}

/// The estimate as text.
#[must_use]
pub fn text(model: &ModelEstimate) -> String {
    let list = |values: &[f64]| {
        values
            .iter()
            .map(|v| significant(*v, 9))
            .collect::<Vec<_>>()
            .join("  ")
    };
    let poles = |re: &[f64], im: &[f64]| {
        re.iter()
            .zip(im)
            .map(|(re, im)| pole_text(Complex::new(*re, *im), 5))
            .collect::<Vec<_>>()
            .join("  ")
    };
    let mut text = format!(
        "{} -> {}, {}, order {}, {} s, {} rows{}\n",
        model.input,
        model.output,
        model.estimator,
        model.order,
        model.sample_time,
        model.samples,
        if model.frozen { ", frozen" } else { "" }
    );
    let physical = model.physical_names.iter().zip(&model.physical_values);
    for ((name, value), deviation) in physical.zip(&model.physical_deviations) {
        text += &format!("{name:<10}{}\n", with_interval(*value, *deviation));
    }
    text += &format!("a        {}\n", list(&model.a));
    text += &format!("b        {}\n", list(&model.b));
    if !model.c.is_empty() {
        text += &format!("c        {}\n", list(&model.c));
    }
    if model.bias != 0.0 {
        text += &format!("bias     {:.9}\n", model.bias);
    }
    text += &format!("z poles  {}\n", poles(&model.poles_re, &model.poles_im));
    text += &format!(
        "s poles  {}  1/s\n",
        poles(&model.s_poles_re, &model.s_poles_im)
    );
    if model.has_steady_state_gain {
        text += &format!("steady-state gain  {:.6}\n", model.steady_state_gain);
    }
    text += &format!("fit      {:.3} %, one step ahead\n", model.fit);
    text += &if model.valid {
        "valid\n".to_owned()
    } else {
        format!("not valid: {}\n", model.reason)
    };
    text
}
