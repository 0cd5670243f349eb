//! Result of comparing two recordings.

use std::collections::BTreeMap;

use planesman_decode::Types;
use planesman_decode::difference::{Value, differences};

use crate::diff::options::{DiffError, Options, WALL_TIME};
use crate::diff::pairing::{Key, Outcome, Pairing, Waiting};
use crate::diff::recording::{Item, Recording, TopicOf};
use crate::diff::rules::{Rule, RuleError};

/// Result of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// The recordings' names.
    pub names: [String; 2],
    /// Whether the topics are columns of tables.
    pub is_table: bool,
    /// Notes on the recordings that affect the result, for example that one is cut off.
    pub notes: Vec<String>,
    /// The earliest difference.
    pub first: Option<First>,
    /// All topics of either recording.
    pub topics: Vec<TopicResult>,
}

/// Result of one topic.
#[derive(Clone, Debug, Default)]
pub struct TopicResult {
    /// The topic, or the column of a table.
    pub name: String,
    /// The reason why the topic is not compared; empty if it is compared.
    pub left_out: &'static str,
    /// Number of messages in A and in B.
    pub messages: [u64; 2],
    /// Pairs with the same bytes or values.
    pub equal: u64,
    /// Equal pairs that differ within a tolerance, or only in ignored fields.
    pub within: u64,
    /// Pairs with a difference.
    pub different: u64,
    /// Number of messages that only A contains, and that only B contains.
    pub alone: [u64; 2],
    /// Repeated messages, with the same stamp and bytes as an earlier message; they do not count as a difference.
    pub repeated: u64,
    /// Pairs whose order differs among messages of the same or the next stamps; this does not count as a difference.
    pub reordered: u64,
    /// The reason why the messages are not decoded; empty if they are decoded.
    pub not_decoded: String,
    /// Fields with differences; `rates[]` for all elements of a list.
    pub fields: BTreeMap<String, FieldResult>,
}

/// Differences of one field.
#[derive(Clone, Debug, Default)]
pub struct FieldResult {
    /// Number of messages or elements that differ.
    pub different: u64,
    /// Largest difference of numbers.
    pub largest: Option<Largest>,
    /// Largest magnitude of the differing values.
    magnitude: f64,
}

/// Largest difference of a field.
#[derive(Clone, Debug)]
pub struct Largest {
    /// The field, with the index of a list's element.
    pub place: String,
    /// B less A.
    pub difference: f64,
    /// The values in A and in B.
    pub values: [Value; 2],
    /// Stamp of the message, ns.
    pub stamp: Option<i64>,
}

/// The first difference.
#[derive(Clone, Debug)]
pub struct First {
    /// The topic, or the column of a table.
    pub topic: String,
    /// Stamp of the message, ns; `None` for a topic without stamps.
    pub stamp: Option<i64>,
    /// Number of the message in its topic, from 1.
    pub number: u64,
    /// Number of earlier messages of the topic that are equal.
    pub equal_before: u64,
    /// What differs.
    pub what: What,
}

/// Kind of a difference.
#[derive(Clone, Debug)]
pub enum What {
    /// A field with its two values; for a column of a table the field is empty.
    Field(String, [Value; 2]),
    /// Different bytes of messages that cannot be decoded, with the reason.
    Bytes(String),
    /// A message that only A (0) or B (1) contains.
    Alone(usize),
}

impl TopicResult {
    /// Whether there is no difference.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        !self.left_out.is_empty() || self.different == 0 && self.alone == [0, 0]
    }

    /// The field with the largest difference relative to its own magnitude.
    #[must_use]
    pub fn worst(&self) -> Option<(&str, &FieldResult)> {
        let fields = self.fields.iter().map(|(name, it)| (name.as_str(), it));
        fields.max_by(|a, b| a.1.relative().total_cmp(&b.1.relative()))
    }
}

impl FieldResult {
    /// Largest difference relative to the largest magnitude of the differing values; negative for a field that is not a number.
    #[must_use]
    pub fn relative(&self) -> f64 {
        let largest = self.largest.as_ref();
        largest.map_or(-1.0, |it| match it.difference.abs() {
            // Zeros of both signs.
            0.0 => 0.0,
            size if size.is_nan() => f64::INFINITY,
            size => size / self.magnitude,
        })
    }

    fn take(&mut self, place: String, a: Value, b: Value, stamp: Option<i64>) {
        self.different += 1;
        let Some((in_a, in_b)) = a.number().zip(b.number()) else {
            return;
        };
        let difference = match (&a, &b) {
            (Value::Integer(a), Value::Integer(b)) => (b - a) as f64,
            _ => in_b - in_a,
        };
        for number in [in_a, in_b].into_iter().filter(|it| it.is_finite()) {
            self.magnitude = self.magnitude.max(number.abs());
        }
        // A number beside one that is none differs more than any.
        let size = |it: f64| if it.is_nan() { f64::INFINITY } else { it.abs() };
        let known = self.largest.as_ref();
        if known.is_none_or(|it| size(difference) > size(it.difference)) {
            self.largest = Some(Largest {
                place,
                difference,
                values: [a, b],
                stamp,
            });
        }
    }
}

impl Comparison {
    /// Whether there is no difference.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.topics.iter().all(TopicResult::is_equal)
    }
}

/// A topic during the comparison.
struct Topic<'r> {
    types: Option<&'r Types>,
    /// The types differ, so no message is equal.
    is_mismatch: bool,
    is_keyed: bool,
    /// Whether the topic is a column of a table.
    is_table: bool,
    pairing: Pairing,
    ignored: Vec<&'r Rule>,
    tolerances: Vec<(&'r Rule, f64)>,
    result: TopicResult,
}

/// State of a comparison.
pub(crate) struct Comparing<'r> {
    topics: Vec<Topic<'r>>,
    /// Index of each recording's topics among all topics.
    places: [Vec<usize>; 2],
    /// Number of messages read from each recording.
    numbers: [u64; 2],
    /// The first difference, by time and by its place in the recording.
    first: Option<((Key, u64), First)>,
    notes: Vec<String>,
    names: [String; 2],
    /// Payload bytes of messages without a partner so far.
    pub(crate) waiting: usize,
}

impl<'r> Comparing<'r> {
    pub(crate) fn new(
        recordings: &'r [Recording; 2],
        options: &'r Options<'_>,
    ) -> Result<Self, DiffError> {
        let mut comparing = Self {
            topics: Vec::new(),
            places: [Vec::new(), Vec::new()],
            numbers: [0; 2],
            first: None,
            notes: Vec::new(),
            names: [0, 1].map(|side| recordings[side].name.clone()),
            waiting: 0,
        };
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        for (side, recording) in recordings.iter().enumerate() {
            for of in &recording.topics {
                let place = *names.entry(&of.name).or_insert(comparing.topics.len());
                if place == comparing.topics.len() {
                    let topic = Topic::new(of, recording.is_table, options);
                    comparing.topics.push(topic);
                } else if !comparing.places[side].contains(&place) {
                    comparing.topics[place].join(of, options);
                }
                comparing.places[side].push(place);
                let result = &mut comparing.topics[place].result;
                if !result.left_out.is_empty() {
                    result.messages[side] = of.messages;
                }
            }
        }
        comparing.check(options)?;
        for side in [0, 1] {
            for (place, topic) in comparing.topics.iter_mut().enumerate() {
                if !comparing.places[side].contains(&place) {
                    topic.pairing.end(side);
                }
            }
        }
        Ok(comparing)
    }

    /// Checks that each rule matches a topic or field.
    fn check(&self, options: &Options<'_>) -> Result<(), RuleError> {
        let names = self.topics.iter().map(|it| it.result.name.as_str());
        let has_field = |topic: &str, field: &str| {
            let topic = self.topics.iter().find(|it| it.result.name == topic);
            topic.is_some_and(|it| it.types.is_none_or(|types| types.has_field(field)))
        };
        let tolerances = options.tolerances.iter().map(|it| &it.rule);
        for rule in tolerances.chain(&options.ignored) {
            rule.check(names.clone(), has_field)?;
        }
        Ok(())
    }

    /// The topics of a recording that are compared.
    pub(crate) fn wanted(&self, side: usize) -> Vec<bool> {
        let places = self.places[side].iter();
        places
            .map(|it| self.topics[*it].result.left_out.is_empty())
            .collect()
    }

    /// Takes the next message of a recording. Returns 1 if the other recording also has its topic.
    pub(crate) fn push(&mut self, side: usize, item: Item, now: &mut Key) -> u64 {
        let place = self.places[side][item.topic];
        let topic = &mut self.topics[place];
        self.numbers[side] += 1;
        if let Some(stamp) = item.stamp.filter(|_| topic.is_keyed) {
            *now = topic.pairing.key(side, stamp);
        }
        topic.result.messages[side] += 1;
        let bytes = item.payload.len();
        let message = Waiting {
            key: *now,
            number: self.numbers[side],
            payload: item.payload,
            is_late: false,
        };
        topic.pairing.push(side, message);
        self.waiting += bytes;
        self.advance(place);
        u64::from(self.places[1 - side].contains(&place))
    }

    pub(crate) fn end(&mut self, side: usize) {
        for place in 0..self.topics.len() {
            self.topics[place].pairing.end(side);
            self.advance(place);
        }
    }

    pub(crate) fn note(&mut self, side: usize, notes: Vec<String>) {
        let name = ["A", "B"][side];
        let notes = notes.into_iter().map(|it| format!("{name}: {it}"));
        self.notes.extend(notes);
    }

    fn advance(&mut self, place: usize) {
        let (first, waiting) = (&mut self.first, &mut self.waiting);
        let topic = &mut self.topics[place];
        let mut pairing = std::mem::take(&mut topic.pairing);
        pairing.advance(&mut |outcome| {
            let (at, bytes) = match outcome {
                Outcome::Pair { a, b, .. } => (a, a.payload.len() + b.payload.len()),
                Outcome::Only { message, .. } => (message, message.payload.len()),
            };
            *waiting = waiting.saturating_sub(bytes);
            let (equal, different) = (topic.result.equal, topic.result.different);
            let before = equal + different + topic.result.alone[0];
            if let Some(what) = topic.judge(outcome) {
                let order = (at.key, at.number);
                if first.as_ref().is_none_or(|it| order < it.0) {
                    let found = First {
                        topic: topic.result.name.clone(),
                        stamp: topic.stamp(at),
                        number: before + 1,
                        equal_before: equal,
                        what,
                    };
                    *first = Some((order, found));
                }
            }
        });
        topic.pairing = pairing;
    }

    pub(crate) fn finish(self) -> Comparison {
        Comparison {
            names: self.names,
            is_table: self.topics.iter().any(|it| it.is_table),
            notes: self.notes,
            first: self.first.map(|it| it.1),
            topics: self.topics.into_iter().map(|it| it.result).collect(),
        }
    }
}

impl<'r> Topic<'r> {
    fn new(of: &'r TopicOf, is_table: bool, options: &'r Options<'_>) -> Self {
        let ignored = || options.ignored.iter().filter(|it| it.is_of(&of.name));
        let is_of_wall_time = WALL_TIME.iter().any(|it| of.name.ends_with(it));
        let left_out = match ignored().any(|it| it.field().is_none()) {
            true => "ignored",
            false if is_of_wall_time && !options.all => "wall time",
            false => "",
        };
        let tolerances = options.tolerances.iter();
        let is_keyed = of.is_stamped && !options.by_index;
        Self {
            types: of.types.as_ref().ok(),
            is_mismatch: false,
            is_keyed,
            is_table,
            pairing: Pairing::new(is_keyed),
            ignored: ignored().collect(),
            tolerances: tolerances
                .filter(|it| it.rule.is_of(&of.name))
                .map(|it| (&it.rule, it.within))
                .collect(),
            result: TopicResult {
                name: of.name.clone(),
                left_out,
                not_decoded: of.types.as_ref().err().cloned().unwrap_or_default(),
                ..TopicResult::default()
            },
        }
    }

    /// Adds the other recording's topic of the same name.
    fn join(&mut self, other: &'r TopicOf, options: &Options<'_>) {
        let is_keyed = self.is_keyed && other.is_stamped && !options.by_index;
        self.is_keyed = is_keyed;
        self.pairing = Pairing::new(is_keyed);
        let Err(reason) = &other.types else {
            if let (Some(own), Ok(types)) = (self.types, &other.types)
                && own.hash() != types.hash()
            {
                self.is_mismatch = true;
                self.types = None;
                self.result.not_decoded = match own.root() == types.root() {
                    true => format!("the definitions of {} differ", own.root()),
                    false => format!("its type is {} in A, {} in B", own.root(), types.root()),
                };
            }
            return;
        };
        self.types = None;
        self.result.not_decoded.clone_from(reason);
    }

    fn stamp(&self, message: &Waiting) -> Option<i64> {
        self.is_keyed.then_some(message.key.stamp)
    }

    /// Counts an outcome. Returns the difference, if any.
    fn judge(&mut self, outcome: &Outcome) -> Option<What> {
        match outcome {
            Outcome::Only {
                is_repeat: true, ..
            } => {
                self.result.repeated += 1;
                None
            }
            Outcome::Only { side, .. } => {
                self.result.alone[*side] += 1;
                Some(What::Alone(*side))
            }
            Outcome::Pair {
                a,
                b,
                is_same,
                is_reordered,
            } => {
                self.result.reordered += u64::from(*is_reordered);
                let what = match *is_same && !self.is_mismatch {
                    true => None,
                    false => self.compare(a, b),
                };
                match &what {
                    None => self.result.equal += 1,
                    Some(_) => self.result.different += 1,
                }
                what
            }
        }
    }

    /// Compares the fields of two messages with different bytes.
    fn compare(&mut self, a: &Waiting, b: &Waiting) -> Option<What> {
        let Some(types) = self.types else {
            return Some(What::Bytes(self.result.not_decoded.clone()));
        };
        let stamp = self.stamp(a);
        let (mut first, mut is_within) = (None, false);
        let payloads = [&a.payload[..], &b.payload[..]];
        let compared = differences(types, payloads, &mut |place, a, b| {
            let (at, of_list) = (place.to_string(), place.of_list());
            let is_its = |rule: &Rule| rule.holds(&at, &of_list);
            let bounds = self.tolerances.iter().filter(|it| is_its(it.0));
            if self.ignored.iter().any(|it| is_its(it))
                || bounds.clone().any(|it| values_equal_within(&a, &b, it.1))
            {
                is_within = true;
                return;
            }
            if first.is_none() {
                let field = if self.is_table { "" } else { &at };
                first = Some(What::Field(field.to_owned(), [a.clone(), b.clone()]));
            }
            let field = self.result.fields.entry(of_list).or_default();
            field.take(at, a, b, stamp);
        });
        if let Err(reason) = compared {
            return Some(What::Bytes(reason.to_string()));
        }
        self.result.within += u64::from(is_within && first.is_none());
        first
    }
}

/// Whether two values differ by at most a tolerance; NaN equals NaN.
fn values_equal_within(a: &Value, b: &Value, tolerance: f64) -> bool {
    if matches!((a, b), (Value::Length(_), _) | (_, Value::Length(_))) {
        return false;
    }
    match a.number().zip(b.number()) {
        Some((a, b)) if a.is_nan() && b.is_nan() => true,
        Some((a, b)) => (a - b).abs() <= tolerance,
        None => false,
    }
}
