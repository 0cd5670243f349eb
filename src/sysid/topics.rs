//! `planesman sysid topics`: lists every numeric field of a bag, table or log with rate, gaps, range and time history.

use anyhow::Result;
use clap::Parser;
use planesman_console::{Format, Table, sparkline, terminal, wrapped};
use planesman_decode::FieldPath;
use planesman_fit::{DataOptions, FieldSurvey, SPARKS, Survey, TopicSurvey, survey};
use planesman_signals::hertz;

use super::arguments::DataArgs;

/// List every numeric field of a bag or CSV file, with rate, gaps, range and time history.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid topics")]
pub struct TopicsArgs {
    #[command(flatten)]
    data: DataArgs,
    /// List only topics whose name contains this text
    #[arg(long, value_name = "TEXT")]
    topic: Option<String>,
    /// Also list constant fields
    #[arg(long)]
    all: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print one table of all fields in this format [default: a list by topic, with the time history of each field]
    #[arg(long, value_parser = crate::arguments::format(), conflicts_with = "json")]
    format: Option<Format>,
}

/// Runs the command and prints the list.
///
/// # Errors
/// Data that cannot be read.
pub fn run(args: &TopicsArgs) -> Result<()> {
    let data = DataOptions::from(&args.data);
    let mut survey = survey(&data, args.topic.as_deref(), &*args.data.progress())?;
    survey.suggest(&data)?;
    let text = if args.json {
        serde_json::to_string_pretty(&survey)? + "\n"
    } else if let Some(format) = args.format {
        of_fields(&survey).text(format)
    } else {
        wrapped(&table(&survey, args.all, terminal().map(usize::from)))
    };
    Ok(planesman_console::print(text)?)
}

/// All fields as one table.
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
                hertz(topic.rate),
                field.count.to_string(),
                field.not_finite.to_string(),
                short(field.min),
                short(field.max),
            ]);
        }
    }
    table
}

/// Width of a line's columns, without path and time history.
const NUMBERS: usize = 43;

/// The proposed command, the notes, then the fields of each topic; constant fields are only counted, unless `all` is set. If `width` is too
/// small, time histories become narrower, then numbers go below their path.
#[must_use]
pub fn table(survey: &Survey, all: bool, width: Option<usize>) -> String {
    let mut text = String::new();
    if let Some(suggestion) = &survey.suggestion {
        text += &format!("try: {suggestion}\n");
    }
    for note in &survey.notes {
        text += &format!("note: {note}\n");
    }
    let fields = survey.topics.iter().map(|it| it.fields.len());
    match fields.sum() {
        0 if survey.topics.is_empty() => text += "no topics\n",
        fields => {
            let topics = survey.topics.len();
            let s = if topics == 1 { "" } else { "s" };
            text += &format!(
                "\n{topics} topic{s}, {fields} numeric fields.\nColumns: field, samples, minimum, maximum, time history\n"
            );
        }
    }
    for topic in &survey.topics {
        text += &head(topic);
        let is_listed = |it: &&FieldSurvey| all || it.min != it.max || it.not_finite > 0;
        let listed: Vec<&FieldSurvey> = topic.fields.iter().filter(is_listed).collect();
        let longest = |lines: &[[String; 5]]| {
            let paths = lines.iter().map(|line| line[0].chars().count());
            paths.max().unwrap_or(0)
        };
        let mut lines = lines(&listed, 1);
        let mut paths = longest(&lines);
        if let Some(width) = width
            && paths + NUMBERS + SPARKS > width
        {
            lines = self::lines(&listed, 2);
            paths = paths.min(width.saturating_sub(NUMBERS + SPARKS / 2));
        }
        for [path, count, min, max, history] in &lines {
            let path = match path.chars().count() > paths {
                true => format!("{path}\n  {:paths$}", ""),
                false => format!("{path:paths$}"),
            };
            let line = format!("  {path}  {count:>9}  {min:>12}  {max:>12}  {history}");
            text += &line;
            text.push('\n');
        }
        match topic.fields.len() - listed.len() {
            0 => {}
            1 => text += "  1 constant field (--all)\n",
            constant => text += &format!("  {constant} constant fields (--all)\n"),
        }
    }
    text
}

/// Share of short intervals above which a topic counts as bursty.
const BURSTS: f64 = 0.2;

/// Maximum number of fields listed in a note.
const CHANGED: usize = 6;

fn head(topic: &TopicSurvey) -> String {
    let timing = &topic.timing;
    let mut text = topic.name.clone();
    if !topic.type_name.is_empty() {
        text += &format!("  {}", topic.type_name);
    }
    let in_bursts = topic.bursts > BURSTS;
    text += &format!(
        "  {} at {} Hz (stamps: {})",
        timing.samples,
        hertz(topic.rate),
        topic.stamps
    );
    if timing.jitter >= 1e-6 {
        text += &format!(", jitter {:.3} ms", timing.jitter * 1e3);
    }
    if in_bursts {
        text += &format!(
            ", in bursts ({:.0} % of the intervals are shorter than a tenth of the mean interval)",
            100.0 * topic.bursts
        );
    }
    if timing.gaps > 0 {
        text += &format!(
            ", {} gaps, the longest {:.3} s",
            timing.gaps, timing.longest
        );
    }
    for (count, what) in [
        (timing.duplicates, "duplicates"),
        (timing.late, "stamps that go back in time"),
    ] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text.push('\n');
    for found in &topic.clock {
        text += &format!("  clock: {found}\n");
    }
    if let Some(note) = &topic.note {
        text += &format!("  note: {note}\n");
    }
    if let Some(change) = &topic.change {
        text += &format!("  note: {change}\n");
    }
    for (change, fields) in changed(&topic.fields) {
        text += &format!("  note: {fields}: {change}\n");
    }
    text
}

/// The notes on changed fields: the names of the first fields, and the change.
fn changed(fields: &[FieldSurvey]) -> Vec<(String, String)> {
    let mut changes: Vec<(String, Vec<&str>)> = Vec::new();
    for field in fields {
        let told = field.changes.iter().map(ToString::to_string);
        for told in told.chain(field.mixture.as_ref().map(ToString::to_string)) {
            match changes.iter_mut().find(|it| it.0 == told) {
                Some((_, names)) => names.push(&field.path),
                None => changes.push((told, vec![&field.path])),
            }
        }
    }
    let listed = |(told, names): (String, Vec<&str>)| {
        let few = names[..names.len().min(CHANGED)].join(", ");
        let listed = match names.len().saturating_sub(CHANGED) {
            0 => few,
            more => format!("{few} and {more} more"),
        };
        (told, listed)
    };
    changes.into_iter().map(listed).collect()
}

/// Path, count, minimum, maximum, time history. Elements of a list share a line if all of them contain one constant number. `neighbours`
/// points of the history are merged into one.
fn lines(fields: &[&FieldSurvey], neighbours: usize) -> Vec<[String; 5]> {
    let list_of = |field: &FieldSurvey| {
        let path: FieldPath = field.path.parse().ok()?;
        path.in_list()
    };
    let mut lines = Vec::new();
    let mut rest = fields;
    while let Some((first, others)) = rest.split_first() {
        let same = |other: &&&FieldSurvey| {
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
        let is_within = first.path.contains("].");
        let is_behind = list_of(first).is_some_and(|(_, at)| at > 0);
        if first.count + first.not_finite == 0 && (is_within || is_behind) {
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
                    let means: Vec<f64> = first.means.chunks(neighbours).map(of).collect();
                    sparkline(&means)
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
        let finite = values.iter().copied().filter(|it| it.is_finite());
        let count = finite.clone().count();
        FieldSurvey {
            path: path.to_owned(),
            count: count as u64,
            not_finite: (values.len() - count) as u64,
            min: finite.clone().reduce(f64::min).unwrap_or(0.0),
            max: finite.clone().reduce(f64::max).unwrap_or(0.0),
            means: finite.take(SPARKS).collect(),
            changes: Vec::new(),
            mixture: None,
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
        let fields: Vec<&FieldSurvey> = fields.iter().collect();
        let lines = lines(&fields, 1);
        let paths: Vec<&str> = lines.iter().map(|line| line[0].as_str()).collect();
        assert_eq!(paths, ["c[0..1]", "c[2]", "d"]);
        assert!(lines[2][1].contains("1 not finite"));
    }

    #[test]
    fn lines_stay_within_the_width_of_a_terminal() {
        let values: Vec<f64> = (0..500).map(|k| libm::sin(f64::from(k)) * 1e-5).collect();
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
        let text = table(&survey, false, Some(80));
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        assert!(text.contains("longer.than.that\n"), "{text}");
        // Elsewhere as wide as it needs.
        let wide = table(&survey, false, None);
        assert!(wide.contains("longer.than.that  "));
    }
}
