//! Checks that a signal always describes the same thing: the frame, joint or motor of its numbers, from message to message.

use std::collections::BTreeMap;

use planesman_decode::{Decoder, FieldPath, Name, NameKind, Values};

use crate::error::{Result, SourceError};
use crate::signal::Signal;

/// Maximum number of names stored, and listed.
const MOST_NAMES: usize = 1000;
const LISTED: usize = 6;

/// This many changes of a name, or one change in this many messages, may be a renamed frame. More changes mean two publishers, or two elements that
/// change places.
const RENAMED: u64 = 2;
const SELDOM: u64 = 1000;

/// If numbers distinguish things, or lists have no names: a change in at least every n-th message means different things, and there are at most n things.
/// A number that only counts up does not identify a thing.
const EVERY: u64 = 10;
const MOST_NUMBERS: usize = 32;

/// The things that a signal's numbers described.
#[derive(Debug, Default)]
pub(crate) struct Identity {
    messages: u64,
    /// The nesting levels, from the message inwards.
    levels: Vec<Level>,
}

/// A message or an element on the path to the number.
#[derive(Debug, Default)]
struct Level {
    /// The number of path steps to this nesting level.
    steps: usize,
    last: Name,
    changes: u64,
    /// Number of messages for each name, except the current run of messages with the last name.
    names: BTreeMap<Name, u64>,
    since: u64,
}

impl Identity {
    /// Records what the message with number `index` describes.
    pub(crate) fn take(&mut self, decoder: &Decoder, index: usize, values: &Values) {
        self.messages += 1;
        for (place, (steps, name)) in decoder.identity(index, values).enumerate() {
            let is_damaged = |sign: char| sign.is_control() || sign == char::REPLACEMENT_CHARACTER;
            if name.text.contains(is_damaged) {
                // A damaged message's.
                continue;
            }
            let Some(level) = self.levels.get_mut(place) else {
                self.levels.push(Level {
                    steps,
                    last: name.clone(),
                    changes: 0,
                    names: BTreeMap::from([(name.clone(), 0)]),
                    since: 1,
                });
                continue;
            };
            if level.last == *name {
                level.since += 1;
                continue;
            }
            if let Some(count) = level.names.get_mut(&level.last) {
                *count += level.since;
            }
            level.changes += 1;
            level.since = 1;
            level.last.clone_from(name);
            if level.names.len() < MOST_NAMES && !level.names.contains_key(name) {
                level.names.insert(name.clone(), 0);
            }
        }
    }

    /// A note about a changed name, if the change may be legitimate.
    ///
    /// # Errors
    /// If the numbers alternate between things; the message lists the signals to choose from.
    pub(crate) fn judge(&self, signal: &Signal) -> Result<Option<String>> {
        let often = |count: u64| count > RENAMED && count.saturating_mul(SELDOM) > self.messages;
        for level in self.levels.iter().filter(|it| it.changes > 0) {
            // A name that is met once is a message's number, or damage.
            let count = |name: &Name, before: u64| match *name == level.last {
                true => before + level.since,
                false => before,
            };
            let known = level.names.iter();
            let known = known.filter(|(name, before)| often(count(name, **before)));
            let known: Vec<&Name> = known.map(|(name, _)| name).collect();
            let kind = known.first().map(|it| it.kind);
            // Names of several kinds are names.
            let kind = kind.filter(|kind| known.iter().all(|it| it.kind == *kind));
            let kind = kind.unwrap_or_default();
            let most = match kind {
                NameKind::Named => MOST_NAMES,
                NameKind::Numbered => MOST_NUMBERS,
                NameKind::Counted => 2,
            };
            let is_seldom =
                kind != NameKind::Named && level.changes.saturating_mul(EVERY) <= self.messages;
            let names: Vec<&str> = known.iter().map(|it| it.text.as_str()).collect();
            if names.len() < 2 || level.names.len() > most || is_seldom {
                continue;
            }
            if !often(level.changes) {
                return Ok(Some(format!(
                    "{signal}: the name in the messages changed within the data: '{}'",
                    names.join("', '")
                )));
            }
            return Err(SourceError::Request(level.refusal(signal, &names, kind)));
        }
        Ok(None)
    }
}

impl Level {
    fn refusal(&self, signal: &Signal, names: &[&str], kind: NameKind) -> String {
        let path = signal.path();
        let what = match self.steps {
            0 => "the messages are".to_owned(),
            steps => format!("{} is", path.first(steps)),
        };
        let more = names.len().saturating_sub(LISTED);
        let few = &names[..names.len() - more];
        let mut turns = few.join(", now of ");
        if more > 0 {
            turns += &format!(" and {more} more");
        }
        let changes = self.changes;
        if kind == NameKind::Counted {
            return format!(
                "{signal}: the list now has {}, with {changes} changes, and no names: two publishers share {}, or the numbers change their meaning; give each publisher a separate topic ('ros2 run topic_tools relay', or a remap), because no message names its publisher",
                few.join(", now "),
                signal.topic()
            );
        }
        let chosen = few.iter().filter(|it| !it.is_empty()).map(|name| {
            let last = |name: &str| name.rsplit("->").next().map(str::to_owned);
            let is_alone = names.iter().filter(|it| last(it) == last(name)).count() == 1;
            let short = last(name).filter(|_| is_alone);
            let path: FieldPath = path.choosing(self.steps, short.as_deref().unwrap_or(name));
            format!("'{}:{path}'", signal.topic())
        });
        format!(
            "{signal}: {what} now of {turns}, with {changes} changes, so the signal mixes several sources. Choose one: {}",
            chosen.collect::<Vec<_>>().join(" or ")
        )
    }
}
