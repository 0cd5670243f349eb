//! Format of a log line as in `rcutils`: `RCUTILS_CONSOLE_OUTPUT_FORMAT`, `RCUTILS_COLORIZED_OUTPUT`.

use std::time::Duration;

use jiff::{Timestamp, tz::TimeZone};
use log::Level;

/// Default format.
const DEFAULT: &str = "[{severity}] [{time}] [{name}]: {message}";

/// A part of the format.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(String),
    Severity,
    Name,
    Message,
    FunctionName,
    FileName,
    LineNumber,
    Time,
    TimeAsNanoseconds,
    DateTimeWithMs,
}

impl Part {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "severity" => Self::Severity,
            "name" => Self::Name,
            "message" => Self::Message,
            "function_name" => Self::FunctionName,
            "file_name" => Self::FileName,
            "line_number" => Self::LineNumber,
            "time" => Self::Time,
            "time_as_nanoseconds" => Self::TimeAsNanoseconds,
            "date_time_with_ms" => Self::DateTimeWithMs,
            _ => return None,
        })
    }
}

/// Data of a log line.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    pub(crate) level: Level,
    /// The logger's name.
    pub(crate) name: &'a str,
    pub(crate) message: String,
    /// The Rust module; the function's name is not available.
    pub(crate) function: &'a str,
    pub(crate) file: &'a str,
    pub(crate) line: u32,
    pub(crate) since_1970: Duration,
}

/// Format of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Format(Vec<Part>);

impl Default for Format {
    fn default() -> Self {
        Self::new(DEFAULT)
    }
}

impl Format {
    /// Parses a format. Unknown tokens are kept as text.
    pub(crate) fn new(text: &str) -> Self {
        let mut parts = Vec::new();
        let mut plain = String::new();
        let mut rest = text;
        while let Some(first) = rest.chars().next() {
            let token = rest
                .strip_prefix('{')
                .and_then(|inside| inside.split_once('}'))
                .and_then(|(name, after)| Some((Part::named(name)?, after)));
            if let Some((part, after)) = token {
                parts.push(Part::Text(std::mem::take(&mut plain)));
                parts.push(part);
                rest = after;
            } else if let Some((control, after)) = escaped(rest) {
                plain.push(control);
                rest = after;
            } else {
                plain.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
        parts.push(Part::Text(plain));
        Self(parts)
    }

    /// The line, without its end.
    pub(crate) fn line(&self, entry: &Entry<'_>) -> String {
        self.0.iter().map(|part| written(part, entry)).collect()
    }
}

/// Character for a backslash and a letter at the beginning of `text`, and the remaining text.
fn escaped(text: &str) -> Option<(char, &str)> {
    let rest = text.strip_prefix('\\')?;
    let control = match rest.chars().next()? {
        'a' => '\x07',
        'b' => '\x08',
        'n' => '\n',
        'r' => '\r',
        't' => '\t',
        _ => return None,
    };
    Some((control, &rest[1..]))
}

fn written(part: &Part, entry: &Entry<'_>) -> String {
    let time = entry.since_1970;
    match part {
        Part::Text(text) => text.clone(),
        Part::Severity => severity(entry.level).to_owned(),
        Part::Name => entry.name.to_owned(),
        Part::Message => entry.message.clone(),
        Part::FunctionName => entry.function.to_owned(),
        Part::FileName => entry.file.to_owned(),
        Part::LineNumber => entry.line.to_string(),
        Part::Time => format!("{}.{:09}", time.as_secs(), time.subsec_nanos()),
        Part::TimeAsNanoseconds => time.as_nanos().to_string(),
        Part::DateTimeWithMs => {
            let seconds = i64::try_from(time.as_secs()).unwrap_or_default();
            let at = Timestamp::new(seconds, 0).unwrap_or_default();
            let local = at.to_zoned(TimeZone::system());
            format!(
                "{}.{:03}",
                local.strftime("%Y-%m-%d %H:%M:%S"),
                time.subsec_millis()
            )
        }
    }
}

fn severity(level: Level) -> &'static str {
    match level {
        Level::Error => "ERROR",
        Level::Warn => "WARN",
        Level::Info => "INFO",
        Level::Debug | Level::Trace => "DEBUG",
    }
}

/// The line with terminal codes for the colour of its severity.
pub(crate) fn colored(line: &str, level: Level) -> String {
    let color = match level {
        Level::Error => "\x1b[31m",
        Level::Warn => "\x1b[33m",
        Level::Info => "\x1b[0m",
        Level::Debug | Level::Trace => "\x1b[32m",
    };
    format!("{color}{line}\x1b[0m")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry() -> Entry<'static> {
        Entry {
            level: Level::Warn,
            name: "auv.plant_sim",
            message: "careful".to_owned(),
            function: "plant_sim::node",
            file: "node.rs",
            line: 7,
            since_1970: Duration::new(1_700_000_000, 12_345_678),
        }
    }

    #[test]
    fn a_line_has_the_form_that_is_set() {
        let line = |format: &str| Format::new(format).line(&entry());
        assert_eq!(
            Format::default().line(&entry()),
            "[WARN] [1700000000.012345678] [auv.plant_sim]: careful"
        );
        assert_eq!(
            line("{severity}|{function_name}|{file_name}:{line_number}"),
            "WARN|plant_sim::node|node.rs:7"
        );
        assert_eq!(line("{time_as_nanoseconds}"), "1700000000012345678");
        assert!(line("{date_time_with_ms}").ends_with(":20.012"));
        assert_eq!(
            line(r"{unknown} {severity \t{name}"),
            "{unknown} {severity \tauv.plant_sim"
        );
        assert_eq!(line(""), "");
    }

    #[test]
    fn a_severity_has_its_colour() {
        assert_eq!(colored("careful", Level::Warn), "\x1b[33mcareful\x1b[0m");
    }
}
