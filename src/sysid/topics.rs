//! `planesman sysid topics`: every numeric field of a bag, CSV file or PX4 log: rate, gaps, range and time history.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::Result;
use clap::Parser;
use planesman_bag::reader::TopicCount;
use planesman_bag::{Order, Topic, TopicKind};
use planesman_console::sparkline;
use planesman_decode::{Catalogue, Decoder, FieldPath, Values};
use planesman_identification::stop_point;
use planesman_signals::{
    self as signals, BagSource, Clock, Meter, Reading, Request, Source, Take, Timing, UlogSource,
};
use serde::Serialize;

use super::arguments::DataArgs;
use planesman_console::{Format, Table, terminal, wrapped};

/// Fields of a topic that are looked at, and of all topics together.
const FIELDS_OF_TOPIC: usize = 1000;
const FIELDS: usize = 20_000;

/// Topics that are looked at.
const TOPICS: usize = 1000;

/// Columns of a sparkline.
const SPARKS: usize = 24;

/// The interval of progress reports, in messages.
const TELL: u64 = 4096;

/// List every numeric field of a bag or CSV file, with rate, gaps, range and time history.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid topics")]
pub struct TopicsArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Only topics whose name contains this
    #[arg(long, value_name = "TEXT")]
    topic: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print one table of all fields in this format [default: a list by topic, with each field's course]
    #[arg(long, value_parser = crate::arguments::format(), conflicts_with = "json")]
    format: Option<Format>,
}

/// The topics of a bag or table.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Survey {
    /// Every topic by name; a table is one.
    pub topics: Vec<TopicSurvey>,
    /// Everything that could not be read or is not listed, and why.
    pub notes: Vec<String>,
}

/// A topic and its fields.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TopicSurvey {
    /// Its name.
    pub name: String,
    /// The type of its messages; empty for a table.
    pub type_name: String,
    /// The source of the stamps: header or log.
    pub stamps: String,
    /// How its messages lie in time.
    pub timing: Timing,
    /// Its numeric fields, in the order in which they lie in a message.
    pub fields: Vec<FieldSurvey>,
    /// Why the topic could not be read, whole or in part.
    pub note: Option<String>,
}

/// A field and its range.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FieldSurvey {
    /// Its path in a message, or its column.
    pub path: String,
    /// Finite numbers.
    pub count: u64,
    /// Numbers that are NaN or infinite.
    pub not_finite: u64,
    /// The least; 0 without any.
    pub min: f64,
    /// The greatest; 0 without any.
    pub max: f64,
    /// Its course: means over segments of equally many numbers.
    pub course: Vec<f64>,
}

/// Runs the command and prints what it found.
///
/// # Errors
/// One line: data that cannot be read.
pub fn run(args: &TopicsArgs) -> Result<()> {
    let survey = survey(args)?;
    let text = if args.json {
        serde_json::to_string_pretty(&survey)? + "\n"
    } else if let Some(format) = args.format {
        of_fields(&survey).text(format)
    } else {
        wrapped(&table_within(&survey, terminal().map(usize::from)))
    };
    Ok(planesman_console::print(text)?)
}

/// Looks through the data.
///
/// # Errors
/// As [`run`].
pub fn survey(args: &TopicsArgs) -> Result<Survey> {
    let source = args.data.open()?;
    let bar = args.data.progress_bar(source.bytes());
    let progress = |bytes| {
        bar.set_position(bytes);
        stop_point();
    };
    let survey = match source {
        Source::Bag(bag) => of_bag(&bag, args.topic.as_deref(), &progress),
        Source::Csv(table) => {
            let table = table.counted();
            let name = table.path().display().to_string();
            of_table(name, table.requests(), |requests, take| {
                Ok(table.read(requests, take, &progress)?)
            })?
        }
        Source::Ulog(log) => of_log(&log, args.topic.as_deref(), &progress)?,
        Source::Columns(columns) => {
            let name = "columns".to_owned();
            of_table(name, columns.requests(), |requests, take| {
                Ok(columns.read(requests, take)?)
            })?
        }
    };
    bar.finish_and_clear();
    Ok(survey)
}

/// A field while it is looked at.
#[derive(Clone, Debug, Default)]
struct Field {
    count: u64,
    not_finite: u64,
    range: Option<(f64, f64)>,
    course: Course,
}

impl Field {
    fn take(&mut self, value: f64) {
        if !value.is_finite() {
            self.not_finite += 1;
            return;
        }
        self.count += 1;
        let (min, max) = self.range.unwrap_or((value, value));
        self.range = Some((min.min(value), max.max(value)));
        self.course.take(value);
    }

    fn survey(&self, path: String) -> FieldSurvey {
        let (min, max) = self.range.unwrap_or_default();
        FieldSurvey {
            path,
            count: self.count,
            not_finite: self.not_finite,
            min,
            max,
            course: self.course.means(),
        }
    }
}

/// A long course in few numbers: when there is no room, two neighbours become one.
#[derive(Clone, Debug, Default)]
struct Course {
    /// Means of equally many values, but for the last: it may be of fewer.
    means: Vec<f64>,
    /// Values in each mean, and in the last.
    each: u64,
    in_last: u64,
}

impl Course {
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

/// How messages of one kind are read. Topics of a kind share it.
struct Plan {
    decoder: Decoder,
    /// The fields; seconds and nanoseconds of a stamp stand behind them.
    paths: Vec<FieldPath>,
    has_stamp: bool,
    /// Whether there are more fields.
    is_cut: bool,
}

impl Plan {
    fn of(topic: &Topic, clock: Option<Clock>) -> Result<Self, String> {
        let types = signals::types(topic).map_err(|error| error.to_string())?;
        let mut catalogue = Catalogue::of(&types, FIELDS_OF_TOPIC);
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
            decoder: Decoder::compile(&types, &paths).map_err(|error| error.to_string())?,
            paths: catalogue.fields,
            has_stamp: stamp.is_some(),
            is_cut: catalogue.is_cut,
        })
    }
}

/// A topic while it is looked at.
struct Look {
    topic: Arc<Topic>,
    /// None when its messages cannot be read.
    plan: Option<Rc<Plan>>,
    /// The first of the plan's.
    fields: Vec<Field>,
    messages: u64,
    refused: u64,
    note: Option<String>,
    meter: Meter,
}

impl Look {
    /// A topic before its first message, and at most `room` of its fields.
    fn at(topic: &Arc<Topic>, plan: Result<Rc<Plan>, String>, room: usize) -> Self {
        let mut look = Self {
            topic: Arc::clone(topic),
            plan: None,
            fields: Vec::new(),
            messages: 0,
            refused: 0,
            note: None,
            meter: Meter::default(),
        };
        match plan {
            Ok(plan) => {
                let listed = plan.paths.len().min(room);
                let is_cut = plan.is_cut || listed < plan.paths.len();
                look.note = is_cut.then(|| format!("only its first {listed} fields are listed"));
                look.fields = vec![Field::default(); listed];
                look.plan = Some(plan);
            }
            Err(reason) => look.note = Some(reason),
        }
        look
    }

    fn take(&mut self, payload: &[u8], log_time: i64, values: &mut Values) {
        self.messages += 1;
        match self.read(payload, log_time, values) {
            Ok(stamp) => self.meter.take(stamp),
            Err(reason) => {
                if self.refused == 0 {
                    self.note = Some(reason);
                }
                self.refused += 1;
            }
        }
    }

    /// Takes the numbers of a message; returns its stamp.
    fn read(&mut self, payload: &[u8], log_time: i64, values: &mut Values) -> Result<i64, String> {
        let Some(plan) = &self.plan else {
            return Ok(log_time);
        };
        plan.decoder
            .read(payload, values)
            .map_err(|error| error.to_string())?;
        for (index, field) in self.fields.iter_mut().enumerate() {
            if let Some(value) = values.number(index) {
                field.take(value);
            }
        }
        if !plan.has_stamp {
            return Ok(log_time);
        }
        signals::nanoseconds(values, plan.paths.len())
            .ok_or_else(|| "its stamp is out of range".to_owned())
    }

    fn survey(self) -> TopicSurvey {
        let note = match (self.note, self.refused) {
            (Some(reason), 0) => Some(reason),
            (Some(reason), refused) => Some(format!(
                "{refused} of {} messages cannot be read; the first: {reason}",
                self.messages
            )),
            (None, _) => None,
        };
        let is_header = self.plan.as_ref().is_some_and(|plan| plan.has_stamp);
        let fields = self.plan.map(|plan| {
            let each = plan.paths.iter().zip(&self.fields);
            each.map(|(path, field)| field.survey(path.to_string()))
                .collect()
        });
        TopicSurvey {
            name: self.topic.name.clone(),
            type_name: self.topic.kind.type_name.clone(),
            stamps: if is_header { "header" } else { "log" }.to_owned(),
            timing: self.meter.timing(),
            fields: fields.unwrap_or_default(),
            note,
        }
    }
}

fn of_bag(source: &BagSource, wanted: Option<&str>, progress: &dyn Fn(u64)) -> Survey {
    let bag = source.bag();
    let mut survey = Survey::default();
    let mut looks: Vec<Look> = Vec::new();
    let mut plans: BTreeMap<*const TopicKind, Result<Rc<Plan>, String>> = BTreeMap::new();
    // By name and type: the same topic in the next file of a split bag.
    let mut places: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut room = FIELDS;
    let mut omitted = 0;
    for TopicCount { topic, .. } in bag.topics() {
        if wanted.is_some_and(|text| !topic.name.contains(text)) {
            continue;
        }
        if looks.len() == TOPICS || room == 0 {
            omitted += 1;
            continue;
        }
        let plan = plans
            .entry(Arc::as_ptr(&topic.kind))
            .or_insert_with(|| Plan::of(topic, source.clock()).map(Rc::new));
        let look = Look::at(topic, plan.clone(), room);
        room -= look.fields.len();
        places.insert((&topic.name, &topic.kind.type_name), looks.len());
        looks.push(look);
    }
    if omitted > 0 {
        survey.notes.push(format!(
            "{omitted} further topics are not listed; --topic TEXT lists those whose name contains it"
        ));
    }
    if bag.omitted() > 0 {
        survey.notes.push(format!(
            "{} further topics are skipped: too many names and types",
            bag.omitted()
        ));
    }
    let place = |topic: &Topic| {
        let key = (topic.name.as_str(), topic.kind.type_name.as_str());
        places.get(&key).copied()
    };
    let mut messages = bag.messages_of(|topic| place(topic).is_some(), Order::File);
    let mut values = Values::default();
    let mut count = 0_u64;
    while let Some(message) = messages.next() {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                survey.notes.push(error.to_string());
                break;
            }
        };
        count += 1;
        if count.is_multiple_of(TELL) {
            progress(messages.bytes_read());
        }
        if let Some(look) = place(&message.topic).and_then(|place| looks.get_mut(place)) {
            look.take(&message.payload, message.log_time, &mut values);
        }
    }
    if !bag.completeness().is_whole() {
        survey
            .notes
            .push(format!("the bag is {}", bag.completeness()));
    }
    survey.topics = looks.into_iter().map(Look::survey).collect();
    survey.topics.sort_by(|a, b| a.name.cmp(&b.name));
    survey
}

fn of_log(log: &UlogSource, wanted: Option<&str>, progress: &dyn Fn(u64)) -> Result<Survey> {
    let is_wanted = |name: &&String| wanted.is_none_or(|text| name.contains(text));
    let names = log.topics().keys().filter(is_wanted);
    let topics: Vec<(&String, Vec<Request>)> =
        names.map(|name| (name, log.requests(name))).collect();
    let requests: Vec<Request> = topics.iter().flat_map(|it| it.1.clone()).collect();
    let (fields, meters, reading) = looked_at(&requests, |requests, take| {
        Ok(log.read(requests, take, progress)?)
    })?;
    let mut survey = Survey {
        topics: Vec::new(),
        notes: reading.notes,
    };
    let mut first = 0;
    for (name, requests) in topics {
        let here = first..first + requests.len();
        first = here.end;
        let path = |request: &Request| request.name[name.len() + 1..].to_owned();
        let each = fields[here.clone()].iter().zip(&requests);
        survey.topics.push(TopicSurvey {
            name: name.clone(),
            type_name: "ULog".to_owned(),
            stamps: "log".to_owned(),
            timing: meters
                .get(here.start)
                .map_or_else(Timing::default, Meter::timing),
            fields: each
                .map(|(field, request)| field.survey(path(request)))
                .collect(),
            note: None,
        });
    }
    Ok(survey)
}

/// The fields and the stamps of each request.
fn looked_at(
    requests: &[Request],
    read: impl FnOnce(&[Request], &mut Take<'_>) -> Result<Reading>,
) -> Result<(Vec<Field>, Vec<Meter>, Reading)> {
    let mut fields = vec![Field::default(); requests.len()];
    let mut meters = vec![Meter::default(); requests.len()];
    let mut take = |signal: usize, stamp, value| {
        if let Some(meter) = meters.get_mut(signal) {
            meter.take(stamp);
        }
        if let (Some(field), Some(value)) = (fields.get_mut(signal), value) {
            field.take(value);
        }
        true
    };
    let reading = read(requests, &mut take)?;
    Ok((fields, meters, reading))
}

fn of_table(
    name: String,
    requests: Vec<Request>,
    read: impl FnOnce(&[Request], &mut Take<'_>) -> Result<Reading>,
) -> Result<Survey> {
    let (fields, meters, reading) = looked_at(&requests, read)?;
    let fields = fields.iter().zip(requests);
    Ok(Survey {
        topics: vec![TopicSurvey {
            name,
            type_name: String::new(),
            stamps: reading.stamps,
            timing: meters.first().map_or_else(Timing::default, Meter::timing),
            fields: fields
                .map(|(field, request)| field.survey(request.name))
                .collect(),
            note: None,
        }],
        notes: reading.notes,
    })
}

/// Every field in a table.
fn of_fields(survey: &Survey) -> Table {
    let mut table = Table::new(["signal", "rate, Hz", "count", "not finite", "min", "max"]);
    for topic in &survey.topics {
        for field in &topic.fields {
            let signal = match topic.type_name.as_str() {
                "" => field.path.clone(),
                _ => format!("{}:{}", topic.name, field.path),
            };
            table.row([
                signal,
                format!("{:.3}", topic.timing.rate()),
                field.count.to_string(),
                field.not_finite.to_string(),
                short(field.min),
                short(field.max),
            ]);
        }
    }
    table
}

/// Columns of a line but for path and time history.
const NUMBERS: usize = 43;

/// The survey as text, as wide as it needs.
#[must_use]
pub fn table(survey: &Survey) -> String {
    table_within(survey, None)
}

/// The same within a width: with narrower time histories, and numbers below their path where both do not fit.
fn table_within(survey: &Survey, width: Option<usize>) -> String {
    let mut text = String::new();
    for topic in &survey.topics {
        text += &head(topic);
        let longest = |lines: &[[String; 5]]| {
            let paths = lines.iter().map(|line| line[0].chars().count());
            paths.max().unwrap_or(0)
        };
        let mut lines = lines(&topic.fields, 1);
        let mut paths = longest(&lines);
        if let Some(width) = width
            && paths + NUMBERS + SPARKS > width
        {
            lines = self::lines(&topic.fields, 2);
            paths = paths.min(width.saturating_sub(NUMBERS + SPARKS / 2));
        }
        for [path, count, min, max, course] in &lines {
            let path = match path.chars().count() > paths {
                true => format!("{path}\n  {:paths$}", ""),
                false => format!("{path:paths$}"),
            };
            let line = format!("  {path}  {count:>9}  {min:>12}  {max:>12}  {course}");
            text += &line;
            text.push('\n');
        }
    }
    if survey.topics.is_empty() {
        text += "no topics\n";
    }
    for note in &survey.notes {
        text += &format!("note: {note}\n");
    }
    text
}

fn head(topic: &TopicSurvey) -> String {
    let timing = &topic.timing;
    let mut text = topic.name.clone();
    if !topic.type_name.is_empty() {
        text += &format!("  {}", topic.type_name);
    }
    text += &format!(
        "  {} at {:.3} Hz (stamps: {}), jitter {:.3} ms",
        timing.samples,
        timing.rate(),
        topic.stamps,
        timing.jitter * 1e3
    );
    if timing.gaps > 0 {
        text += &format!(
            ", {} gaps, the longest {:.3} s",
            timing.gaps, timing.longest
        );
    }
    for (count, what) in [
        (timing.duplicates, "duplicates"),
        (timing.late, "going back in time"),
    ] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text.push('\n');
    if let Some(note) = &topic.note {
        text += &format!("  note: {note}\n");
    }
    text
}

/// Path, count, least, greatest, course. Elements of a list that hold one and the same number
/// throughout share a line. Of the course so many neighbours are one.
fn lines(fields: &[FieldSurvey], neighbours: usize) -> Vec<[String; 5]> {
    let list_of = |field: &FieldSurvey| {
        let path: FieldPath = field.path.parse().ok()?;
        path.in_list()
    };
    let mut lines = Vec::new();
    let mut rest = fields;
    while let Some((first, others)) = rest.split_first() {
        let same = |other: &&FieldSurvey| {
            let lists = (list_of(first).map(|it| it.0), list_of(other).map(|it| it.0));
            let numbers = |it: &FieldSurvey| (it.count, it.not_finite, it.min, it.max);
            lists.0.is_some()
                && lists.0 == lists.1
                && first.min == first.max
                && numbers(first) == numbers(other)
        };
        let followers = others.iter().take_while(same).count();
        rest = &others[followers..];
        // Elements that no message had.
        if first.count + first.not_finite == 0 && list_of(first).is_some_and(|(_, at)| at > 0) {
            continue;
        }
        let path = match list_of(first) {
            Some((list, at)) if followers > 0 => format!("{list}[{at}..{}]", at + followers),
            _ => first.path.clone(),
        };
        let count = match first.not_finite {
            0 => first.count.to_string(),
            bad => format!("{} (+{bad} not finite)", first.count),
        };
        lines.push(if first.count == 0 {
            [path, count, String::new(), String::new(), String::new()]
        } else {
            [
                path,
                count,
                short(first.min),
                short(first.max),
                if first.min == first.max {
                    "constant".to_owned()
                } else {
                    let of = |it: &[f64]| it.iter().map(|v| v / it.len() as f64).sum();
                    let course: Vec<f64> = first.course.chunks(neighbours).map(of).collect();
                    sparkline(&course)
                },
            ]
        });
    }
    lines
}

/// A number in at most twelve characters.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if value == value.trunc() && magnitude < 1e11 {
        format!("{value}")
    } else if (1e-3..1e7).contains(&magnitude) {
        format!("{value:.5}")
    } else {
        format!("{value:.4e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(path: &str, values: &[f64]) -> FieldSurvey {
        let mut field = Field::default();
        values.iter().for_each(|value| field.take(*value));
        field.survey(path.to_owned())
    }

    #[test]
    fn a_course_of_any_length_is_drawn_in_a_few_columns() {
        for count in [1, 2, 24, 25, 48, 49, 1000, 100_000] {
            let values: Vec<f64> = (0..count).map(f64::from).collect();
            let field = field("x", &values);
            let drawn = field.course.len();
            assert!(
                drawn <= SPARKS && drawn >= (count as usize).min(SPARKS / 2),
                "{count}: {drawn}"
            );
            assert!(field.course.is_sorted(), "{count}");
            assert_eq!((field.min, field.max), (0.0, f64::from(count - 1)));
        }
    }

    #[test]
    fn elements_that_never_move_share_a_line() {
        let fields = [
            field("c[0]", &[0.0, 0.0]),
            field("c[1]", &[0.0, 0.0]),
            field("c[2]", &[1.0, 2.0]),
            field("c[3]", &[]),
            field("d", &[f64::NAN, 1.0]),
        ];
        let lines = lines(&fields, 1);
        let paths: Vec<&str> = lines.iter().map(|line| line[0].as_str()).collect();
        assert_eq!(paths, ["c[0..1]", "c[2]", "d"]);
        assert!(lines[2][1].contains("1 not finite"));
    }

    #[test]
    fn lines_stay_within_the_width_of_a_terminal() {
        let values: Vec<f64> = (0..500).map(|k| f64::from(k).sin() * 1e-5).collect();
        let mut survey = Survey::default();
        for path in [
            "z",
            "pose.pose.position.z",
            "pose.pose.orientation.and.a.name.longer.than.that",
        ] {
            survey.topics.push(TopicSurvey {
                name: "/auv/odom".to_owned(),
                fields: vec![field(path, &values), field("short", &values)],
                ..TopicSurvey::default()
            });
        }
        let text = table_within(&survey, Some(80));
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        assert!(text.contains("longer.than.that\n"), "{text}");
        // Elsewhere as wide as it needs.
        assert!(table(&survey).contains("longer.than.that  "));
    }
}
