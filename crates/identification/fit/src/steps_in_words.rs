//! An unrecorded input described in words: `12V from 0.1s`, `0 to 12V at 0.1s`, `5 from 1s, 0 from 4s`.
//!
//! ```text
//! INPUT = STEP {, STEP}
//! STEP  = [VALUE [UNIT] to] VALUE [UNIT] (from | at) TIME [s | ms | min | h ...]
//! ```
//! The input is held from each time to the next. The input is 0 before the first time, unless a value precedes the word `to`. Times are in seconds
//! from the output's first sample, the same as for `--window`.

use planesman_identification::{LONGEST_PAST, Record};
use planesman_signals::{PreparedRecord, TimeUnit};

use crate::error::RuleError;

/// Maximum number of steps.
const MOST_STEPS: usize = 1000;

/// An input in words.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepsInWords {
    /// The text as given.
    text: String,
    /// The value before the first step.
    before: f64,
    /// Increasing times, s, each with the value from then on.
    steps: Vec<(f64, f64)>,
    /// The unit; empty if the text gives no unit.
    unit: String,
}

impl StepsInWords {
    /// Parses the words. `None` if the text is the name of a signal, that is, does not begin with a number followed by words.
    pub(crate) fn read(text: &str) -> Option<Result<Self, RuleError>> {
        let mut words = text.split_whitespace();
        let begins = number(words.next()?).is_some_and(|(_, rest)| !rest.contains(':'));
        let is_one = begins && words.next().is_some();
        is_one.then(|| Words::new(text).steps())
    }

    /// Whether the input begins at or before the output's first sample, so that the output is at rest before.
    pub(crate) fn is_from_rest(&self) -> bool {
        self.steps.first().is_some_and(|(time, _)| *time <= 0.0)
    }

    /// The mean from one time to another, s.
    fn mean(&self, from: f64, to: f64) -> f64 {
        let next = self.steps.iter().skip(1).map(|it| it.0);
        let ends = next.chain([f64::INFINITY]);
        let pieces = self.steps.iter().zip(ends);
        let first = self.steps.first().map_or(to, |it| it.0);
        let held = |begin: f64, end: f64| (end.min(to) - begin.max(from)).max(0.0);
        let sum = pieces.map(|((begin, value), end)| value * held(*begin, end));
        let sum: f64 = sum.sum::<f64>() + self.before * held(f64::NEG_INFINITY, first);
        sum / (to - from)
    }

    /// Inserts this input as the first input of a record.
    pub(crate) fn put_into(&self, prepared: &mut PreparedRecord) {
        let resampled = &mut prepared.resampled;
        let span = resampled.outputs.first().and_then(|it| it.timing.span);
        let origin = span.map_or(0, |(first, _)| first);
        let record: &mut Record = &mut resampled.record;
        let step = record.sample_time;
        record.inputs.insert(0, self.text.clone());
        for segment in &mut record.segments {
            let start = segment.start.saturating_sub(origin) as f64 * 1e-9;
            let at = |k: i64| {
                // An instant that rounding moved by less than a thousandth of an interval is the step's own.
                let from = start + (k as f64 + 1e-3) * step;
                self.mean(from, from + step)
            };
            let count = segment.len();
            let past = count.min(LONGEST_PAST) as i64;
            segment.past.insert(0, (-past..0).map(at).collect());
            segment
                .inputs
                .insert(0, (0..count as i64).map(at).collect());
        }
        let unit = Some(self.unit.as_str()).filter(|it| !it.is_empty());
        let value = |it: f64| unit.map_or_else(|| it.to_string(), |unit| format!("{it} {unit}"));
        let steps = self.steps.iter();
        let steps: Vec<String> = steps
            .map(|(time, to)| format!("{} from {time} s", value(*to)))
            .collect();
        let output = resampled
            .record
            .outputs
            .first()
            .cloned()
            .unwrap_or_default();
        prepared.reading.notes.push(format!(
            "the input is described in words, not recorded: {} before, {}; times start at the first sample of {output}{}",
            value(self.before),
            steps.join(", "),
            match self.is_from_rest() {
                true => ", which was at rest until that time",
                false => "",
            }
        ));
        if let Some(unit) = unit {
            let named = format!("{} [{unit}]", self.text);
            prepared.reading.columns.insert(self.text.clone(), named);
        }
    }
}

/// The number at the beginning of the text, and the rest.
fn number(text: &str) -> Option<(f64, &str)> {
    let is_of_one = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let end = text.find(|c| !is_of_one(c)).unwrap_or(text.len());
    // The longest that is one: `5e` is 5 and a unit.
    (1..=end).rev().find_map(|end| {
        let value: f64 = text[..end].parse().ok()?;
        value.is_finite().then_some((value, &text[end..]))
    })
}

/// Words to be parsed from the left.
struct Words<'a> {
    text: &'a str,
    rest: &'a str,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            rest: text.trim_start(),
        }
    }

    fn steps(mut self) -> Result<StepsInWords, RuleError> {
        let mut found = StepsInWords {
            text: self.text.trim().to_owned(),
            before: 0.0,
            steps: Vec::new(),
            unit: String::new(),
        };
        loop {
            let mut place = self.rest;
            let mut value = self.value(&mut found.unit)?;
            if self.word("to") {
                match found.steps.last() {
                    None => found.before = value,
                    Some((_, last)) if *last == value => {}
                    Some((_, last)) => {
                        return Err(self.refusal(
                            place,
                            &format!("{last}, the value of the input before this step"),
                        ));
                    }
                }
                value = self.value(&mut found.unit)?;
            }
            if !self.word("from") && !self.word("at") {
                return Err(self.refusal(self.rest, "'from' or 'at' and a time"));
            }
            place = self.rest;
            let time = self.time()?;
            if found.steps.last().is_some_and(|(last, _)| *last >= time) {
                return Err(self.refusal(place, "a time later than the previous one"));
            }
            found.steps.push((time, value));
            match self.rest.strip_prefix(',') {
                _ if found.steps.len() > MOST_STEPS => {
                    return Err(self.refusal(place, &format!("at most {MOST_STEPS} steps")));
                }
                Some(rest) => self.rest = rest.trim_start(),
                None if self.rest.is_empty() => return Ok(found),
                None => return Err(self.refusal(self.rest, "a comma or the end of the text")),
            }
        }
    }

    fn refusal(&self, place: &str, expected: &str) -> RuleError {
        let before = self.text.len() - place.len();
        RuleError::NotAnInput {
            place: self.text[..before].chars().count() + 1,
            expected: expected.to_owned(),
        }
    }

    /// Returns the text after a word, if that word is next.
    fn behind(&self, word: &str) -> Option<&'a str> {
        let rest = self.rest.strip_prefix(word)?;
        rest.starts_with(char::is_whitespace)
            .then(|| rest.trim_start())
    }

    /// Consumes an expected word if it is next.
    fn word(&mut self, word: &str) -> bool {
        let rest = self.behind(word);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// The text up to the next blank or comma.
    fn unit(&mut self) -> &'a str {
        let is_end = |c: char| c.is_whitespace() || c == ',';
        let end = self.rest.find(is_end).unwrap_or(self.rest.len());
        let unit = &self.rest[..end];
        self.rest = self.rest[end..].trim_start();
        unit
    }

    fn number(&mut self, expected: &str) -> Result<f64, RuleError> {
        let (value, rest) = number(self.rest).ok_or_else(|| self.refusal(self.rest, expected))?;
        self.rest = rest;
        Ok(value)
    }

    /// A value, with the unit that all values share.
    fn value(&mut self, common: &mut String) -> Result<f64, RuleError> {
        let value = self.number("a value")?;
        let is_apart = self.rest.starts_with(char::is_whitespace);
        self.rest = self.rest.trim_start();
        let is_keyword = ["to", "from", "at"]
            .into_iter()
            .any(|it| self.behind(it).is_some());
        if is_apart && is_keyword {
            return Ok(value);
        }
        let place = self.rest;
        let unit = self.unit();
        if !unit.is_empty() && !common.is_empty() && unit != common {
            return Err(self.refusal(place, &format!("the unit {common} of the earlier value")));
        }
        if common.is_empty() {
            unit.clone_into(common);
        }
        Ok(value)
    }

    /// A time in seconds.
    fn time(&mut self) -> Result<f64, RuleError> {
        let value = self.number("a time")?;
        let place = self.rest;
        let unit = match self.rest.trim_start() {
            rest if rest.is_empty() || rest.starts_with(',') => {
                self.rest = rest;
                TimeUnit::S
            }
            rest => {
                self.rest = rest;
                let unit = self.unit();
                TimeUnit::named(unit).ok_or_else(|| {
                    self.refusal(place, "a unit of time (for example s, ms, min or h)")
                })?
            }
        };
        let nanoseconds = unit.in_nanoseconds(value);
        let nanoseconds = nanoseconds.ok_or_else(|| self.refusal(place, "a shorter time"))?;
        Ok(nanoseconds as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<StepsInWords, String> {
        let read = StepsInWords::read(text).expect("words");
        read.map_err(|refusal| refusal.to_string())
    }

    #[test]
    fn words_are_the_steps_that_they_say() {
        type Case<'a> = (&'a str, f64, &'a [(f64, f64)], &'a str);
        let cases: [Case<'_>; 8] = [
            ("12V from 0.1s", 0.0, &[(0.1, 12.0)], "V"),
            (" 12 V from 0.1 s", 0.0, &[(0.1, 12.0)], "V"),
            ("0 to 12V at 0.1s", 0.0, &[(0.1, 12.0)], "V"),
            ("12 to -24 V at 5", 12.0, &[(5.0, -24.0)], "V"),
            ("5 from 1s, 0 from 4s", 0.0, &[(1.0, 5.0), (4.0, 0.0)], ""),
            ("1e-3m/s from 250ms", 0.0, &[(0.25, 1e-3)], "m/s"),
            (
                "30 % from 1 min, 30 to 60% at 2 min",
                0.0,
                &[(60.0, 30.0), (120.0, 60.0)],
                "%",
            ),
            ("2 atm at -1s", 0.0, &[(-1.0, 2.0)], "atm"),
        ];
        for (text, before, steps, unit) in cases {
            let found = read(text).unwrap();
            assert_eq!(
                (found.before, &found.steps[..], found.unit.as_str()),
                (before, steps, unit),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_no_step_is_refused_at_its_place_and_a_name_is_a_name() {
        for (text, place, expected) in [
            ("12V form 0.1s", 5, "'from' or 'at'"),
            ("12V from x", 10, "a time"),
            ("12V from 0.1 parsec", 13, "a unit of time"),
            (
                "5 from 4s, 0 from 1s",
                19,
                "a time later than the previous one",
            ),
            ("5V from 1s, 0A from 4s", 14, "the unit V"),
            ("5 from 1s, 4 to 0 at 4s", 12, "5, the value of the input"),
            ("5 from 1s; 0 from 4s", 9, "a unit of time"),
            ("5 from 1s, ", 12, "a value"),
            ("5 from 1e300 d", 13, "a shorter time"),
            ("5 from 1s 0 from 4s", 11, "a comma"),
        ] {
            let refusal = read(text).unwrap_err();
            let at = format!("at character {place}");
            assert!(
                refusal.contains(&at) && refusal.contains(expected),
                "{text}: {refusal}"
            );
            assert!(refusal.contains("12V from 0.1s"), "{refusal}");
        }
        for name in [
            "u",
            "cmd:data",
            "12V",
            "motor voltage from 2",
            "",
            "/7/cmd from",
            "7:a b",
        ] {
            assert!(StepsInWords::read(name).is_none(), "{name}");
        }
    }

    #[test]
    fn a_step_within_an_interval_acts_for_the_rest_of_it() {
        let steps = read("12V from 0.13s, 2 from 0.5").unwrap();
        for (from, expected) in [(0.0, 0.0), (0.1, 8.4), (0.2, 12.0), (0.5, 2.0), (9.0, 2.0)] {
            let found = steps.mean(from, from + 0.1);
            assert!((found - expected).abs() < 1e-9, "{from}: {found}");
        }
    }
}
