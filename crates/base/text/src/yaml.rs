//! YAML of others, parsed within bounds.
//!
//! The parser proper takes time as the square of how deep braces and brackets nest and of how many tags are declared, and unfolds
//! what aliases refer to wherever they stand: a file of a megabyte can so take minutes, or all memory. So the text
//! is first passed over by a scanner that does none of that, and refused where it goes beyond what people write.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

use saphyr_parser::{Event, Parser, Tag};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_yaml_ng::Value;

/// How deep lists and mappings may nest; the deepest of this project's own files nests five deep.
const DEPTH: usize = 64;

/// How many values there may be once aliases are unfolded: more than the largest text that is read can write out.
const VALUES: usize = 1_000_000;

/// How many bytes of text the values may have once aliases are unfolded, tags and keys among them: more than the largest text
/// that is read, even without its aliases.
const BYTES: usize = 16 * crate::LARGEST as usize;

/// Directives (`%YAML`, `%TAG`) that a text may begin with.
const DIRECTIVES: usize = 16;

/// Braces and brackets that cannot nest too deep even if all of them did.
const HARMLESS: usize = 256;

/// Why a text is no YAML that is taken.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Lists and mappings nest deeper than anybody writes.
    #[error("lists and mappings nest more than {DEPTH} deep at line {0}")]
    Deep(usize),
    /// Aliases unfold to more than anybody writes.
    #[error("it unfolds to more than {VALUES} values at line {0}")]
    Large(usize),
    /// Aliases unfold to more text than anybody writes.
    #[error("it unfolds to more than {BYTES} bytes of text at line {0}")]
    Long(usize),
    /// More directives than anybody writes.
    #[error("it has more than {DIRECTIVES} directives")]
    Directives,
    /// No YAML.
    #[error("{0}")]
    Scan(String),
    /// No YAML, or not of the form that is wanted.
    #[error("{0}")]
    Parse(String),
}

/// A value that breaks the rule of its field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {value} refused: {rule}")]
pub struct Refusal {
    /// The field's path: `oil.return`, `fins[0].area`.
    pub field: String,
    /// The value as the file has it; empty where the field is missing.
    pub value: String,
    /// The values that are accepted.
    pub rule: String,
}

impl Refusal {
    /// The refusal of a field in `text` that is read as a `T`.
    #[must_use]
    pub fn at<T: DeserializeOwned + Display>(text: &str, field: &str, rule: &str) -> Self {
        Self {
            field: field.to_owned(),
            value: value_at::<T>(text, field).map_or(String::new(), |value| value.to_string()),
            rule: rule.to_owned(),
        }
    }
}

/// The value at a path, as `oil.return` or `fins[0].area`; `None` if the path leads nowhere or the value is not a `T`.
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

/// The value that a YAML text describes.
///
/// # Errors
/// [`Error`]: a text beyond the bounds, no YAML, or one that is no `T`.
pub fn from_str<'de, T: Deserialize<'de>>(text: &'de str) -> Result<T, Error> {
    check(text)?;
    serde_yaml_ng::from_str(text).map_err(|error| Error::Parse(explained(error.to_string(), text)))
}

/// Where a scalar or alias stands in a text: the keys that lead to it (a place in a list as `[0]`), and its bytes.
pub type Place = (Vec<String>, Range<usize>);

/// Every scalar or alias that is a value, in the order of the text.
///
/// # Errors
/// [`Error`]: a text beyond the bounds, or no YAML.
pub fn scalars(text: &str) -> Result<Vec<Place>, Error> {
    /// A list with its next place, or a mapping with the key whose value comes next.
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

/// A text with other words at some places, which are in their order and do not overlap.
pub fn edited(text: &str, edits: impl IntoIterator<Item = (Range<usize>, String)>) -> String {
    let (mut new, mut from) = (String::with_capacity(text.len()), 0);
    for (place, word) in edits {
        new += &text[from..place.start];
        new += &word;
        from = place.end;
    }
    new + &text[from..]
}

/// The reason of a parser, without names of Rust's types; where it stumbles over a tab, in words.
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
            format!("line {} is indented by a tab; YAML takes spaces", line + 1)
        }
        _ => reason,
    }
}

/// What values unfold to: their number, and the bytes of their text.
type Size = [usize; 2];

/// The sum.
fn sum(one: Size, [values, bytes]: Size) -> Size {
    [one[0].saturating_add(values), one[1].saturating_add(bytes)]
}

/// Passes over the text and refuses what is beyond the bounds.
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
        assert_eq!(tab, "line 2 is indented by a tab; YAML takes spaces");
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
