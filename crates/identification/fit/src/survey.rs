//! Every numeric field of a bag, table or log: rate, gaps, range and time history.

use planesman_text::setting;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use planesman_bag::reader::TopicCount;
use planesman_bag::{BagReader, Message, Order, Topic, TopicKind};
use planesman_decode::{Catalogue, CompileError, DecodeError, Decoder, FieldPath, Values};
use planesman_parallel::Progress;
use planesman_signals::{
    self as signals, Change, Clock, Mixture, Publishers, Request, Senders, Source, SourceError,
    StampFindings, StampInspection, Stamps, Timing, ValueInspection,
};
use serde::Serialize;

use crate::data::{DataOptions, reading};
use crate::error::FitError;
use crate::suggestion::suggestion;

/// Maximum number of fields read per topic, and over all topics.
const FIELDS_OF_TOPIC: usize = 1000;
const FIELDS: usize = 20_000;

/// Maximum number of fields whose first samples are stored for inspection.
const INSPECTED: usize = 4000;

/// Maximum number of topics read.
const TOPICS: usize = 1000;

/// A suggested signal must have at least this many samples.
const FEWEST: u64 = 50;

/// Maximum number of message names counted per topic.
const NAMES: usize = 100;

/// Maximum number of points of a time history.
pub const SPARKS: usize = 24;

/// The topics of a bag or table.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Survey {
    /// All topics by name; a table counts as one topic.
    pub topics: Vec<TopicSurvey>,
    /// Everything that could not be read or is not listed, with the reason.
    pub notes: Vec<String>,
    /// A first identification command with alternative signals; `None` if no signals look like an input and an output, or before [`Survey::suggest`].
    pub suggestion: Option<String>,
}

/// A topic and its fields.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TopicSurvey {
    /// Its name.
    pub name: String,
    /// The type of the topic's messages; empty for a table.
    pub type_name: String,
    /// The source of the stamps: header or log.
    pub stamps: String,
    /// Timing of the messages, on a clock corrected for jumps back.
    pub timing: Timing,
    /// Messages per second; for bursts, averaged over the time between bursts.
    pub rate: f64,
    /// Findings about the clock: where it wraps, goes back or restarts, or that its unit may be different.
    pub clock: Vec<String>,
    /// Correction of the stamps that a record would use.
    pub change: Option<Change>,
    /// Share (0 to 1) of intervals shorter than a tenth of the mean; large if messages come in bursts.
    pub bursts: f64,
    /// The topic's numeric fields, in the order of the message.
    pub fields: Vec<FieldSurvey>,
    /// Reason why the topic could not be read, completely or in part.
    pub note: Option<String>,
}

/// A field and its range.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FieldSurvey {
    /// Path of the field in a message, or name of its column.
    pub path: String,
    /// Finite numbers.
    pub count: u64,
    /// Number of values that are NaN or infinite.
    pub not_finite: u64,
    /// Smallest value; 0 if there are no values.
    pub min: f64,
    /// Largest value; 0 if there are no values.
    pub max: f64,
    /// The field's time history: means over segments with equal numbers of values.
    pub means: Vec<f64>,
    /// Corrections of the samples when the field is an output of a record, for example for a slow sensor or for angles that wrap.
    pub changes: Vec<Change>,
    /// Evidence that the field mixes two sources.
    pub mixture: Option<Box<Mixture>>,
}

impl TopicSurvey {
    fn found(&mut self, found: StampFindings) {
        self.clock.extend(found.clock);
        let all = found.timing.samples;
        let refusal = found.timing.refusal(all);
        (self.clock).extend(refusal.filter(|_| found.change.is_none()));
        self.timing = found.timing;
        self.bursts = found.bursts;
        self.rate = found.rate;
        self.change = found.change;
    }
}

/// Surveys the data: all topics, or only topics whose name contains `topic`.
///
/// # Errors
/// Data that cannot be read.
pub fn survey(
    data: &DataOptions,
    topic: Option<&str>,
    progress: &dyn Progress,
) -> Result<Survey, FitError> {
    let source = data.open()?;
    reading(source.bytes(), progress, |told| {
        if let Some(bag) = source.bag() {
            return Ok(of_bag(bag, data.stamp, topic, told));
        }
        let mut parts = source.experiments(&[]);
        if parts.is_empty() {
            parts.push(source);
        }
        let mut all = Survey::default();
        for mut part in parts {
            part.count_rows();
            let one = of_fields(&*part, topic, told)?;
            all.topics.extend(one.topics);
            all.notes.extend(one.notes);
        }
        Ok(all)
    })
}

impl Survey {
    /// Removes and returns the suggestion; this reads the possible signals once more. If there is no suggestion, a note gives the reason.
    ///
    /// # Errors
    /// Data that cannot be read.
    pub fn suggest(&mut self, data: &DataOptions) -> Result<(), FitError> {
        let has_time = data.open()?.has_time();
        let all = &self.topics;
        let is_of_several = |path: &str| {
            let of = |it: &&TopicSurvey| it.fields.iter().any(|it| it.path == path);
            all.iter().filter(of).count() > 1
        };
        let varying = all.iter().flat_map(|topic| {
            let is_table = topic.type_name.is_empty();
            let fields = topic.fields.iter();
            let fields = fields.filter(|it| it.count >= FEWEST && it.min < it.max);
            fields.map(move |it| {
                let is_alone = all.len() == 1 || !is_of_several(&it.path);
                let name = match is_table && is_alone {
                    true => "",
                    false => topic.name.as_str(),
                };
                (name, it.path.as_str())
            })
        });
        match suggestion(varying, data, has_time) {
            Ok(found) => self.suggestion = found,
            Err(reason) => self.notes.push(reason),
        }
        Ok(())
    }
}

/// State of a field while the data is read.
#[derive(Clone, Debug, Default)]
struct Field {
    count: u64,
    not_finite: u64,
    range: Option<(f64, f64)>,
    means: SegmentMeans,
    inspection: ValueInspection,
    /// Whether the field's samples are stored for inspection.
    is_inspected: bool,
}

impl Field {
    fn inspected(place: usize) -> Self {
        Self {
            is_inspected: place < INSPECTED,
            ..Self::default()
        }
    }

    fn take(&mut self, stamp: i64, value: f64) {
        if !value.is_finite() {
            self.not_finite += 1;
            return;
        }
        self.count += 1;
        let (min, max) = self.range.unwrap_or((value, value));
        self.range = Some((min.min(value), max.max(value)));
        self.means.take(value);
        if self.is_inspected {
            self.inspection.take(stamp, value);
        }
    }

    fn survey(self, path: String) -> FieldSurvey {
        let (min, max) = self.range.unwrap_or_default();
        let (changes, mixture) = self.inspection.finish();
        FieldSurvey {
            path,
            count: self.count,
            not_finite: self.not_finite,
            min,
            max,
            means: self.means.means(),
            changes,
            mixture: mixture.map(Box::new),
        }
    }
}

/// A time history of any length, stored as a limited number of means: when the memory is full, neighbouring means are merged.
#[derive(Clone, Debug, Default)]
struct SegmentMeans {
    /// Means of equal numbers of values; only the last mean may have fewer.
    means: Vec<f64>,
    /// Number of values in each mean, and in the last mean.
    each: u64,
    in_last: u64,
}

impl SegmentMeans {
    fn take(&mut self, value: f64) {
        if self.means.is_empty() || self.in_last == self.each {
            if self.means.len() == 2 * SPARKS {
                self.means = self
                    .means
                    .chunks(2)
                    .map(|it| 0.5 * it[0] + 0.5 * it[1])
                    .collect();
                self.each *= 2;
            }
            self.each = self.each.max(1);
            self.means.push(0.0);
            self.in_last = 0;
        }
        self.in_last += 1;
        if let Some(last) = self.means.last_mut() {
            *last += value / self.in_last as f64 - *last / self.in_last as f64;
        }
    }

    fn means(&self) -> Vec<f64> {
        let per_spark = self.means.len().div_ceil(SPARKS).max(1);
        let mean = |it: &[f64]| it.iter().map(|value| value / it.len() as f64).sum();
        self.means.chunks(per_spark).map(mean).collect()
    }
}

/// The reason why messages cannot be read.
#[derive(Clone, Debug, thiserror::Error)]
enum Unreadable {
    /// The messages' schema is not known.
    #[error("{0}")]
    Schema(String),
    /// The messages contain no signals.
    #[error("{0}: the fields of this topic are not listed")]
    NoSignals(&'static str),
    /// The schema does not contain the fields.
    #[error(transparent)]
    Fields(#[from] CompileError),
    /// A message does not fit its schema.
    #[error(transparent)]
    Message(#[from] DecodeError),
    #[error("the stamp is out of range")]
    Stamp,
}

/// Reading plan for messages of one kind. Topics of the same kind share a plan.
struct Plan {
    decoder: Decoder,
    /// The fields, followed by the seconds and nanoseconds of a stamp.
    paths: Vec<FieldPath>,
    has_stamp: bool,
    /// Decoder of the message's name, if the type has one.
    names: Option<Decoder>,
    /// Whether fields were left out because of the limit.
    is_cut: bool,
    /// Whether the plan is for one topic only, because it contains that topic's element names or the members of its JSON objects.
    is_own: bool,
}

impl Plan {
    fn of(bag: &BagReader, clock: Option<Clock>, topic: &Topic) -> Result<Self, Unreadable> {
        if topic.kind.type_name == "rcl_interfaces/msg/ParameterEvent" {
            return Err(Unreadable::NoSignals("changes of parameters"));
        }
        // Topics of a kind share it, each below its own name.
        let types = signals::types(bag, topic).map_err(|error| match error {
            SourceError::Topic { reason, .. } => Unreadable::Schema(reason),
            other => Unreadable::Schema(other.to_string()),
        })?;
        let mut catalogue = Catalogue::of(&types, FIELDS_OF_TOPIC);
        let by_index = catalogue.fields.clone();
        catalogue.fields = signals::by_name(bag, topic, &types, catalogue.fields);
        let is_own = topic.kind.message_encoding == "json" || catalogue.fields != by_index;
        let stamp = types.stamp().filter(|_| clock != Some(Clock::Log));
        // The stamp itself is reported as the topic's timing.
        if let Some(stamp) = &stamp {
            catalogue
                .fields
                .retain(|path| !path.steps.starts_with(&stamp.steps));
        }
        let mut paths = catalogue.fields.clone();
        if let Some(stamp) = &stamp {
            paths.extend(["sec", "nanosec"].map(|name| stamp.field(name)));
        }
        Ok(Self {
            decoder: Decoder::compile(&types, &paths)?,
            paths: catalogue.fields,
            has_stamp: stamp.is_some(),
            names: Decoder::of_names(&types, &FieldPath { steps: Vec::new() }),
            is_cut: catalogue.is_cut,
            is_own,
        })
    }
}

/// State of a topic while the data is read.
struct TopicScan {
    topic: Arc<Topic>,
    /// `None` if the topic's messages cannot be read.
    plan: Option<Rc<Plan>>,
    /// The first fields of the plan.
    fields: Vec<Field>,
    messages: u64,
    refused: u64,
    note: Option<String>,
    /// Inspection of the message stamps, and of the recorder's stamps if messages have their own stamps.
    inspection: StampInspection,
    log_inspection: StampInspection,
    stamps: Stamps,
    publishers: Publishers,
    senders: Senders,
    /// Values of the last message; the memory is reused for the topic's next message.
    values: Values,
    /// Names of the topic's messages with their counts, for the first few names.
    names: BTreeMap<String, u64>,
}

impl TopicScan {
    /// A topic before its first message, with at most `room` fields.
    fn new(topic: &Arc<Topic>, plan: Result<Rc<Plan>, Unreadable>, room: usize) -> Self {
        let mut scan = Self {
            topic: Arc::clone(topic),
            plan: None,
            fields: Vec::new(),
            messages: 0,
            refused: 0,
            note: None,
            inspection: StampInspection::default(),
            log_inspection: StampInspection::default(),
            stamps: Stamps::of(&topic.name),
            publishers: Publishers::default(),
            senders: Senders::default(),
            values: Values::default(),
            names: BTreeMap::new(),
        };
        match plan {
            Ok(plan) => {
                let listed = plan.paths.len().min(room);
                let is_cut = plan.is_cut || listed < plan.paths.len();
                scan.note = is_cut.then(|| format!("only the first {listed} fields are listed"));
                let first = FIELDS - room;
                scan.fields = (first..first + listed).map(Field::inspected).collect();
                scan.plan = Some(plan);
            }
            Err(reason) => scan.note = Some(reason.to_string()),
        }
        scan
    }

    fn take(&mut self, message: &Message) {
        self.messages += 1;
        let (payload, log_time) = (message.payload.as_slice(), message.log_time);
        let publishers = &mut self.publishers;
        let publisher = publishers.of(message.channel, message.sequence, log_time);
        self.senders.take(publisher);
        match self.read(payload, log_time) {
            Ok((own, content)) => {
                if self.stamps.take(own, log_time) {
                    self.inspection.take(own.unwrap_or(log_time), content);
                }
                if own.is_some() {
                    self.log_inspection.take(log_time, content);
                }
            }
            Err(reason) => {
                if self.refused == 0 {
                    self.note = Some(reason.to_string());
                }
                self.refused += 1;
            }
        }
    }

    /// Adds the numbers of a message; returns the message's own stamp and its distinguishing name, if it has them.
    fn read(&mut self, payload: &[u8], log_time: i64) -> Result<(Option<i64>, u64), Unreadable> {
        let values = &mut self.values;
        let Some(plan) = &self.plan else {
            return Ok((None, self.messages.rotate_right(8)));
        };
        // All of the first thousand, then every seventh.
        if let Some(names) = &plan.names
            && (self.messages <= 1000 || self.messages.is_multiple_of(7))
            && names.read(payload, values).is_ok()
            && let [name] = values.names()
        {
            if let Some(count) = self.names.get_mut(name) {
                *count += 1;
            } else if self.names.len() < NAMES {
                self.names.insert(name.clone(), 1);
            }
        }
        plan.decoder.read(payload, values)?;
        let mut content = 0;
        for (index, field) in self.fields.iter_mut().enumerate() {
            if let Some(value) = values.number(index) {
                field.take(log_time, value);
                content = mixed(content, value);
            }
        }
        if !plan.has_stamp {
            return Ok((None, content));
        }
        let stamp = values.nanoseconds(plan.paths.len());
        let stamp = stamp.ok_or(Unreadable::Stamp)?;
        Ok((Some(stamp), content))
    }

    fn survey(self) -> TopicSurvey {
        let note = match (self.note, self.refused) {
            (Some(reason), 0) => Some(reason),
            (Some(reason), refused) => Some(format!(
                "{refused} of {} messages cannot be read. The reason for the first is: {reason}",
                self.messages
            )),
            (None, _) => None,
        };
        // Messages of several, met often: not numbers that count them.
        let looked: u64 = self.names.values().sum();
        let often = |count: &u64| *count > 2 && *count * 100 > looked;
        let names: Vec<&str> = (self.names.iter())
            .filter_map(|(name, count)| often(count).then_some(name.as_str()))
            .collect();
        let several = (names.len() > 1).then(|| {
            let first = names.iter().find(|it| !it.is_empty()).unwrap_or(&"NAME");
            format!(
                "the topic has messages of '{}': '{}:[{first}].FIELD' selects those of one of these",
                names.join("', '"),
                self.topic.name
            )
        });
        let senders = self.senders.in_turn();
        let publishers = senders.first().map(|(first, _)| {
            let counts = senders.iter().map(|it| it.1.to_string());
            format!(
                "the topic has messages of {} publishers, by their channels or numbers ({}): '{}:[publisher={first}].FIELD' selects those of one publisher",
                senders.len(),
                counts.collect::<Vec<_>>().join(", "),
                self.topic.name
            )
        });
        let standing = self.stamps.unfit();
        let clock = match self.stamps.note(Clock::Header) {
            _ if standing.is_some() => standing.clone(),
            note => note,
        };
        let all = [note, several, publishers, clock].into_iter().flatten();
        let all: Vec<String> = all.collect();
        let note = (!all.is_empty()).then(|| all.join("; "));
        let has_stamp = self.plan.as_ref().is_some_and(|plan| plan.has_stamp);
        let is_header = has_stamp && standing.is_none();
        let inspection = match has_stamp && !is_header {
            true => self.log_inspection,
            false => self.inspection,
        };
        let fields = self.plan.map(|plan| {
            let each = plan.paths.iter().zip(self.fields);
            each.map(|(path, field)| field.survey(path.to_string()))
                .collect()
        });
        let mut survey = TopicSurvey {
            name: self.topic.name.clone(),
            type_name: self.topic.kind.type_name.clone(),
            stamps: if is_header { "header" } else { "log" }.to_owned(),
            fields: fields.unwrap_or_default(),
            note,
            ..TopicSurvey::default()
        };
        survey.found(inspection.finish());
        survey
    }
}

/// Adds the next value to a hash of a message's contents.
fn mixed(content: u64, value: f64) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    (content.rotate_left(5) ^ value.to_bits()).wrapping_mul(ODD)
}

fn of_bag(
    bag: &BagReader,
    clock: Option<Clock>,
    wanted: Option<&str>,
    progress: &dyn Fn(u64),
) -> Survey {
    let mut survey = Survey::default();
    let mut scans: Vec<TopicScan> = Vec::new();
    let mut plans: BTreeMap<*const TopicKind, Result<Rc<Plan>, Unreadable>> = BTreeMap::new();
    // By name and type: the same topic in the next file of a split bag.
    let mut places: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut room = FIELDS;
    let mut omitted = 0;
    let mut of_services = 0;
    for TopicCount { topic, .. } in bag.topics() {
        if wanted.is_some_and(|text| !topic.name.contains(text)) {
            continue;
        }
        if is_of_service(&topic.kind.type_name) {
            of_services += 1;
            continue;
        }
        if scans.len() == TOPICS || room == 0 {
            omitted += 1;
            continue;
        }
        let kind = Arc::as_ptr(&topic.kind);
        let plan = match plans.get(&kind) {
            Some(known) => known.clone(),
            None => {
                let plan = Plan::of(bag, clock, topic).map(Rc::new);
                if !plan.as_ref().is_ok_and(|it| it.is_own) {
                    plans.insert(kind, plan.clone());
                }
                plan
            }
        };
        let scan = TopicScan::new(topic, plan, room);
        room -= scan.fields.len();
        places.insert((&topic.name, &topic.kind.type_name), scans.len());
        scans.push(scan);
    }
    survey.notes.extend(bag.renamed().map(str::to_owned));
    if of_services > 0 {
        let s = if of_services == 1 { "" } else { "s" };
        survey.notes.push(format!(
            "{of_services} topic{s} of service events not listed"
        ));
    }
    if omitted > 0 {
        survey.notes.push(format!(
            "{omitted} more topics are not listed; {} lists those whose name contains the given text",
            setting("topic", "TEXT")
        ));
    }
    if bag.omitted() > 0 {
        survey.notes.push(format!(
            "{} more topics are skipped: too many names and types",
            bag.omitted()
        ));
    }
    let place = |topic: &Topic| {
        let key = (topic.name.as_str(), topic.kind.type_name.as_str());
        places.get(&key).copied()
    };
    let messages = bag.messages_of(|topic| place(topic).is_some(), Order::LogTime);
    let broken = signals::each_message(messages, progress, |message| {
        if let Some(scan) = place(&message.topic).and_then(|place| scans.get_mut(place)) {
            scan.take(message);
        }
        Ok(true)
    });
    survey.notes.extend(broken.unwrap_or_default());
    if !bag.completeness().is_whole() {
        survey
            .notes
            .push(format!("the bag is {}", bag.completeness()));
    }
    survey.topics = scans.into_iter().map(TopicScan::survey).collect();
    survey.topics.sort_by(|a, b| a.name.cmp(&b.name));
    survey
}

/// A table row or log message whose values arrive one by one.
#[derive(Clone, Debug, Default)]
struct Row {
    inspection: StampInspection,
    /// Stamp of the current row, the signal added last, and the distinguishing name.
    current: Option<(i64, usize, u64)>,
}

impl Row {
    fn take(&mut self, signal: usize, stamp: i64, value: Option<f64>) {
        let before = match self.current {
            Some((last, of, content)) if last == stamp && signal > of => content,
            _ => {
                self.end();
                0
            }
        };
        let content = mixed(before, value.unwrap_or_default());
        self.current = Some((stamp, signal, content));
    }

    fn end(&mut self) {
        if let Some((stamp, _, content)) = self.current.take() {
            self.inspection.take(stamp, content);
        }
    }
}

/// Surveys the fields of a table or log, in one pass.
fn of_fields(
    source: &dyn Source,
    wanted: Option<&str>,
    told: &dyn Fn(u64),
) -> Result<Survey, FitError> {
    let mut topics = source.topics();
    topics.retain(|it| it.type_name.is_empty() || wanted.is_none_or(|text| it.name.contains(text)));
    let counts: Vec<usize> = topics.iter().map(|it| it.requests.len()).collect();
    let topic_of: Vec<usize> = (counts.iter().enumerate())
        .flat_map(|(at, count)| std::iter::repeat_n(at, *count))
        .collect();
    // Moved: a table may have a million columns.
    let requests = topics.iter_mut().map(|it| std::mem::take(&mut it.requests));
    let requests: Vec<Request> = requests.flatten().collect();
    let mut fields: Vec<Field> = (0..requests.len()).map(Field::inspected).collect();
    let mut rows = vec![Row::default(); topics.len()];
    // Each part of a table has its own rows.
    let are_parts = topics.len() > 1 && topics.iter().all(|it| it.type_name.is_empty());
    let mut take = |signal: usize, stamp, value: Option<f64>| {
        if are_parts && value.is_none() {
            return true;
        }
        if let Some(row) = topic_of.get(signal).and_then(|it| rows.get_mut(*it)) {
            row.take(signal, stamp, value);
        }
        if let (Some(field), Some(value)) = (fields.get_mut(signal), value) {
            field.take(stamp, value);
        }
        true
    };
    let reading = source.read(&requests, &mut take, told);
    let mut reading = reading.map_err(FitError::data)?;
    let mut survey = Survey::default();
    let (mut fields, mut requests) = (fields.into_iter(), requests.into_iter());
    for ((topic, mut row), count) in topics.into_iter().zip(rows).zip(counts) {
        row.end();
        let is_table = topic.type_name.is_empty();
        let name = if is_table { 0 } else { topic.name.len() + 1 };
        let each = requests.by_ref().take(count).zip(fields.by_ref());
        let mut found = TopicSurvey {
            fields: each
                .map(|(mut request, field)| field.survey(request.name.split_off(name)))
                .collect(),
            name: topic.name,
            type_name: topic.type_name.to_owned(),
            stamps: match is_table {
                true => reading.stamps.clone(),
                false => "log".to_owned(),
            },
            ..TopicSurvey::default()
        };
        found.found(row.inspection.finish());
        if found.rate > 0.0 && survey.topics.is_empty() {
            reading.question_unit(found.rate);
        }
        found.clock.append(&mut reading.clock);
        survey.topics.push(found);
    }
    survey.notes = reading.notes;
    Ok(survey)
}

/// Whether the type is that of service events, `PACKAGE/srv/NAME_Event`.
fn is_of_service(type_name: &str) -> bool {
    type_name.ends_with("_Event") && type_name.contains("/srv/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_history_of_any_length_is_drawn_in_a_few_columns() {
        for count in [1, 2, 24, 25, 48, 49, 1000, 100_000] {
            let values: Vec<f64> = (0..count).map(f64::from).collect();
            let mut field = Field::default();
            let times = 0_i64..;
            times
                .zip(&values)
                .for_each(|(at, value)| field.take(at, *value));
            let field = field.survey("x".to_owned());
            let drawn = field.means.len();
            assert!(
                drawn <= SPARKS && drawn >= (count as usize).min(SPARKS / 2),
                "{count}: {drawn}"
            );
            assert!(field.means.is_sorted(), "{count}");
            assert_eq!((field.min, field.max), (0.0, f64::from(count - 1)));
        }
    }
}
