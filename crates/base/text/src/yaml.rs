//! Parses foreign YAML of limited depth and size.
//!
//! The parser's time grows with the square of the nesting depth of braces and brackets and of the number of declared tags, and it expands aliases
//! wherever they occur: a file of a megabyte could take minutes, or all memory. So a scanner without these problems first checks the text, and
//! refuses texts beyond limits that handwritten files never reach.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

use saphyr_parser::{Event, Parser, Tag};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_yaml_ng::Value;

/// Largest nesting depth of lists and mappings; this project's own files nest at most five deep.
const DEPTH: usize = 64;

/// Largest number of values after expanding aliases: more than the largest accepted text can contain without aliases.
const VALUES: usize = 1_000_000;

/// Largest total length of values, tags and keys after expanding aliases, bytes: more than the largest accepted text without aliases.
const BYTES: usize = 16 * crate::LARGEST as usize;

/// Largest number of directives (`%YAML`, `%TAG`).
const DIRECTIVES: usize = 16;

/// Number of braces and brackets that cannot nest too deep.
const HARMLESS: usize = 256;

/// The reason why a text is refused.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Lists and mappings nest too deep.
    #[error("lists and mappings nest more than {DEPTH} deep at line {0}")]
    Deep(usize),
    /// Expanded aliases give too many values.
    #[error("the file has more than {VALUES} values with its aliases expanded, from line {0} on")]
    Large(usize),
    /// Expanded aliases give too much text.
    #[error(
        "the file has more than {BYTES} bytes of text with its aliases expanded, from line {0} on"
    )]
    Long(usize),
    /// Too many directives.
    #[error("the file has more than {DIRECTIVES} directives")]
    Directives,
    /// Invalid YAML.
    #[error("{0}")]
    Scan(String),
    /// Invalid YAML, or YAML of another form.
    #[error("{0}")]
    Parse(String),
}

/// A value that violates the rule of its field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {value} refused: {rule}")]
pub struct Refusal {
    /// Path of the field, such as `oil.return` or `fins[0].area`.
    pub field: String,
    /// Value as written in the file; empty if the field is missing.
    pub value: String,
    /// Description of the accepted values.
    pub rule: String,
}

impl Refusal {
    /// Refusal of a field in `text` whose value is read as a `T`.
    #[must_use]
    pub fn at<T: DeserializeOwned + Display>(text: &str, field: &str, rule: &str) -> Self {
        Self {
            field: field.to_owned(),
            value: value_at::<T>(text, field).map_or(String::new(), |value| value.to_string()),
            rule: rule.to_owned(),
        }
    }
}

/// Value at a path, such as `oil.return` or `fins[0].area`; `None` if it does not exist or is not a `T`.
fn value_at<T: DeserializeOwned>(text: &str, path: &str) -> Option<T> {
    let mut value: &Value = &from_str(text).ok()?;
    for key in path.replace('[', ".[").split('.') {
        value = match key.strip_prefix('[').and_then(|it| it.strip_suffix(']')) {
            Some(place) => value.get(place.parse::<usize>().ok()?)?,
            None => value.get(key)?,
        };
    }
    T::deserialize(value).ok()
}

impl From<serde_yaml_ng::Error> for Error {
    fn from(error: serde_yaml_ng::Error) -> Self {
        Self::Parse(error.to_string())
    }
}

/// Parses a YAML text.
///
/// # Errors
/// [`Error`]: a text beyond the limits, invalid YAML, or not a `T`.
pub fn from_str<'de, T: Deserialize<'de>>(text: &'de str) -> Result<T, Error> {
    check(text)?;
    serde_yaml_ng::from_str(text).map_err(|error| Error::Parse(explained(error.to_string(), text)))
}

/// Position of a scalar or alias in a text: its keys (list indices as `[0]`), and its bytes.
pub type Place = (Vec<String>, Range<usize>);

/// All scalars and aliases that are values, in the order of the text.
///
/// # Errors
/// [`Error`]: a text beyond the limits, or invalid YAML.
pub fn scalars(text: &str) -> Result<Vec<Place>, Error> {
    /// A list with its next index, or a mapping with the key of the next value.
    enum Level {
        List(usize),
        Mapping(Option<String>),
    }
    check(text)?;
    let bytes: Vec<usize> = text
        .char_indices()
        .map(|it| it.0)
        .chain([text.len()])
        .collect();
    let byte = |index: usize| bytes.get(index).copied().unwrap_or(text.len());
    let mut levels: Vec<Level> = Vec::new();
    let mut found = Vec::new();
    let mut bytes_of_paths = 0_usize;
    for event in Parser::new_from_str(text) {
        let (event, at) = event.map_err(|error| Error::Scan(error.to_string()))?;
        let level = levels.last_mut();
        match event {
            Event::Scalar(key, ..) if matches!(level, Some(Level::Mapping(None))) => {
                levels.pop();
                levels.push(Level::Mapping(Some(key.into_owned())));
                continue;
            }
            Event::Scalar(..) | Event::Alias(..) => {
                let path = levels.iter().map(|it| match it {
                    Level::List(place) => format!("[{place}]"),
                    Level::Mapping(key) => key.clone().unwrap_or_default(),
                });
                let path: Vec<String> = path.collect();
                // A long key stands in the path of each value below it.
                bytes_of_paths += path.iter().map(String::len).sum::<usize>();
                if bytes_of_paths > BYTES {
                    return Err(Error::Long(at.start.line()));
                }
                found.push((path, byte(at.start.index())..byte(at.end.index())));
            }
            Event::SequenceStart(..) => {
                levels.push(Level::List(0));
                continue;
            }
            Event::MappingStart(..) => {
                levels.push(Level::Mapping(None));
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => drop(levels.pop()),
            _ => continue,
        }
        // A value is complete.
        match levels.last_mut() {
            Some(Level::List(place)) => *place += 1,
            Some(Level::Mapping(key)) => *key = None,
            None => {}
        }
    }
    Ok(found)
}

/// A text with replacements at some ranges, which must be in order and not overlap.
pub fn edited(text: &str, edits: impl IntoIterator<Item = (Range<usize>, String)>) -> String {
    let (mut new, mut from) = (String::with_capacity(text.len()), 0);
    for (place, word) in edits {
        new += &text[from..place.start];
        new += &word;
        from = place.end;
    }
    new + &text[from..]
}

/// Error text of a parser without names of Rust types; explains a tab used as indentation.
fn explained(mut reason: String, text: &str) -> String {
    for (names, words) in [
        (
            &["usize", "u64", "u32", "u16", "u8", "i64", "i32"][..],
            "a whole number",
        ),
        (&["f64", "f32"], "a number"),
    ] {
        for name in names {
            let (typed, plain) = (format!(", expected {name}"), format!(", expected {words}"));
            if let Some(place) = reason.find(&typed)
                && !reason[place + typed.len()..].starts_with(char::is_alphanumeric)
            {
                reason.replace_range(place..place + typed.len(), &plain);
            }
        }
    }
    let is_indented_by_tab = |line: &str| {
        let indent = line.len() - line.trim_start().len();
        line[..indent].contains('\t')
    };
    match text.lines().position(is_indented_by_tab) {
        Some(line) if reason.contains("cannot start any token") => {
            format!(
                "line {} is indented with a tab, but YAML allows only spaces",
                line + 1
            )
        }
        _ => reason,
    }
}

/// Size after expanding aliases: number of values, bytes of text.
type Size = [usize; 2];

/// Sum of two sizes.
fn sum(one: Size, [values, bytes]: Size) -> Size {
    [one[0].saturating_add(values), one[1].saturating_add(bytes)]
}

/// Scans the text and refuses it if it is beyond the limits.
fn check(text: &str) -> Result<(), Error> {
    let directives = text.lines().filter(|line| line.starts_with('%')).count();
    if directives > DIRECTIVES {
        return Err(Error::Directives);
    }
    // Of anchored values that are not complete: the anchor, and what came before.
    let mut open: Vec<(usize, Size)> = Vec::new();
    let mut unfolded: BTreeMap<usize, Size> = BTreeMap::new();
    let mut size = [0, 0];
    for event in Parser::new_from_str(text) {
        let (event, at) = match event {
            Ok(event) => event,
            // The parser proper has the last word on what YAML is, where it can do no harm.
            Err(_) if is_harmless(text) => return Ok(()),
            Err(error) => return Err(Error::Scan(explained(error.to_string(), text))),
        };
        let line = at.start.line();
        let before = size;
        let tagged = |tag: &Option<Cow<'_, Tag>>, text: &str| {
            let tag = tag
                .as_ref()
                .map_or(0, |it| it.handle.len() + it.suffix.len());
            sum(before, [1, tag + text.len()])
        };
        match event {
            Event::Scalar(text, _, anchor, tag) => {
                size = tagged(&tag, &text);
                unfolded.insert(anchor, [1, size[1] - before[1]]);
            }
            Event::Alias(anchor) => {
                size = sum(size, unfolded.get(&anchor).copied().unwrap_or([1, 0]));
            }
            Event::SequenceStart(anchor, tag) | Event::MappingStart(anchor, tag) => {
                size = tagged(&tag, "");
                open.push((anchor, before));
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if let Some((anchor, [values, bytes])) = open.pop() {
                    unfolded.insert(anchor, [size[0] - values, size[1] - bytes]);
                }
            }
            _ => {}
        }
        if open.len() > DEPTH {
            return Err(Error::Deep(line));
        }
        if size[0] > VALUES {
            return Err(Error::Large(line));
        }
        if size[1] > BYTES {
            return Err(Error::Long(line));
        }
    }
    Ok(())
}

/// Whether the text has no anchors, no tags of its own, and too few braces and brackets to nest deep.
fn is_harmless(text: &str) -> bool {
    let count = |signs: &[u8]| text.bytes().filter(|byte| signs.contains(byte)).count();
    count(b"&") == 0 && !text.contains("%TAG") && count(b"[{") <= HARMLESS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        from_str::<Value>(text).expect_err("refused").to_string()
    }

    #[test]
    fn a_refusal_has_no_names_of_types() {
        let refused = from_str::<BTreeMap<String, u64>>("count: 0.5\n").expect_err("no count");
        let text = refused.to_string();
        assert!(text.contains("expected a whole number"), "{text}");
        let refused = from_str::<BTreeMap<String, f64>>("flow: [1]\n").expect_err("no number");
        let text = refused.to_string();
        assert!(text.contains("expected a number"), "{text}");
    }

    #[test]
    fn what_people_write_is_taken() {
        let text = "%YAML 1.1\n---\n# a comment\na: {b: [1, 2], c: \"}\"}\nd: &x [1]\ne: *x\n...\n";
        let value: Value = from_str(text).expect("taken");
        assert_eq!(value["e"], value["d"]);
        let list = format!("[{}]", "{a: 1}, ".repeat(20_000));
        let value: Vec<Value> = from_str(&list).expect("taken");
        assert_eq!(value.len(), 20_000);
    }

    #[test]
    fn each_scalar_is_found_where_it_stands() {
        let text =
            "a: {b: [1.5, 2 m], \"c\": -3}  # é\nd:\n  - [4, 5]\n  - e: &x 6   # six\n  - *x\n";
        let found = scalars(text).expect("YAML");
        let found: Vec<(String, &str)> = found
            .iter()
            .map(|(path, at)| (path.join("."), text[at.clone()].trim_end()))
            .collect();
        let expected = [
            ("a.b.[0]", "1.5"),
            ("a.b.[1]", "2 m"),
            ("a.c", "-3"),
            ("d.[0].[0]", "4"),
            ("d.[0].[1]", "5"),
            ("d.[1].e", "&x 6"),
            ("d.[2]", "*x"),
        ];
        let expected = expected.map(|(path, value)| (path.to_owned(), value));
        assert_eq!(found, expected);
    }

    #[test]
    fn a_reason_is_said_once_and_a_tab_is_called_a_tab() {
        #[derive(Debug, Deserialize)]
        struct Named {
            #[serde(rename = "name")]
            _name: String,
        }
        let missing = from_str::<Named>("a: 1").expect_err("no name");
        assert_eq!(missing.to_string(), "missing field `name`");
        assert!(std::error::Error::source(&missing).is_none());
        let tab = refusal("a:\n\tb: 1\n");
        assert_eq!(
            tab,
            "line 2 is indented with a tab, but YAML allows only spaces"
        );
    }

    #[test]
    fn what_is_made_to_hurt_is_refused_before_it_is_parsed() {
        for (case, text) in planesman_testing::hostile::yaml() {
            let error = from_str::<Value>(&text).expect_err(case);
            // The scanner itself stops where it must look far ahead.
            let is_deep = matches!(error, Error::Deep(_) | Error::Scan(_));
            assert!(is_deep || !case.starts_with("deep"), "{case}: {error}");
            let says = match case {
                "aliases of aliases" | "one alias many times" => "1000000 values",
                "a long text many times" | "a long tag many times" | "a long key many times" => {
                    "16777216 bytes"
                }
                "many tags" => "directives",
                _ => "",
            };
            assert!(error.to_string().contains(says), "{case}: {error}");
        }
    }

    #[test]
    fn a_long_key_above_many_values_has_no_places() {
        let text = format!("{}: [{}]", "k".repeat(1000), "1, ".repeat(50_000));
        assert!(from_str::<Value>(&text).is_ok());
        assert!(matches!(scalars(&text), Err(Error::Long(_))));
    }

    #[test]
    fn what_only_the_scanner_refuses_is_left_to_the_parser() {
        let value: Value = from_str("a: \"two\nlines\"").expect("YAML 1.1");
        assert_eq!(value["a"], "two lines");
        let deep = format!("a: \"two\nlines\"\nb: {}", "[".repeat(1000));
        assert!(from_str::<Value>(&deep).is_err());
    }
}
